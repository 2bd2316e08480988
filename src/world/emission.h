/* SPDX-License-Identifier: Apache-2.0 */
/* What glows in the clouds: black bodies of a temperature that varies from place to place.
 *
 * A glow emits j = κ·B(λ, T), per volume, direction and wavelength (W m⁻³ sr⁻¹ nm⁻¹), with B Planck's law and κ in 1/m
 * by Kirchhoff's law what the glowing matter absorbs. Either that is the cloud itself, κ = (1−ϖ)·σ; or it is a flame
 * with a grid of its own, whose κ counts for emission alone, so that there is light where there is no cloud.
 *
 * For next-event estimation each glow is a grid of even lamps: one is drawn by its power, a point in it evenly, and
 * what counts is the direction to that point; all that glows along it is then added up (Simon, Hanika, Zirr and
 * Dachsbacher 2017, "Line Integration for Rendering Heterogeneous Emissive Volumes"). The density of such a direction
 * is what the lamps along it make together: Σ p·(s₁³ − s₀³)/3, with p the density of a point in a lamp and s the
 * distances at which the ray enters and leaves it.
 */
#ifndef NP_WORLD_EMISSION_H
#define NP_WORLD_EMISSION_H

#include "core/random.h"
#include "optics/black_body.h"
#include "volume/bricks.h"

typedef struct np_glow {
  const np_bricks *bricks; /* κ is proportional to their value: a flame's, or the cloud's own */
  np_affine world_to_index, index_to_world;
  np_spectrum absorption_per_value; /* 1/m where the value is 1, times the glow's strength */
  const np_bricks *temperature;     /* NULL: `offset_k` everywhere */
  np_affine world_to_temperature;
  float kelvin_per_value, offset_k;
} np_glow;

/* The lamps of a glow: cells of a lattice in its index space. */
typedef struct np_lamps {
  double low[3]; /* index position of the first cell's corner */
  double edge;   /* of a cell, in voxels */
  int32_t size[3];
  float *density; /* of each cell, z fastest: of a point drawn in it, 1/m³; NULL: no lamps */
} np_lamps;

/* A lamp that may be drawn. */
typedef struct np_lamp {
  unsigned glow;
  uint32_t cell;
  double cumulative; /* share of the power in this lamp and those before it */
} np_lamp;

typedef struct np_emission {
  neph_context *context; /* borrowed */
  np_black_body black_body;
  unsigned glow_count;
  np_glow *glows;
  np_lamps *lamps; /* of each glow */
  size_t lamp_count;
  np_lamp *list;
  np_spectrum power_w_sr_nm; /* ∫ j dV */
} np_emission;

/* Takes a copy of the glows, whose grids must outlive it, and lists their lamps by power. On failure nothing is left.
 */
neph_result np_emission_build(neph_context *context, const np_glow *glows, unsigned count,
                              const double wavelength_nm[NP_BAND_COUNT], np_monitor *monitor, np_emission *out);
void np_emission_clear(np_emission *emission);

static inline float np_glow_temperature(const np_glow *glow, np_dvec3 position) {
  if (!glow->temperature) return glow->offset_k;
  const np_dvec3 index = np_affine_point(&glow->world_to_temperature, position);
  return glow->offset_k + glow->kelvin_per_value * np_bricks_sample(glow->temperature, index);
}

/* j at a position where the glow's bricks hold `value`. */
static inline np_spectrum np_glow_eval(const np_emission *emission, const np_glow *glow, np_dvec3 position,
                                       float value) {
  if (!(value > 0.0f)) return np_spectrum_grey(0.0f);
  const np_spectrum body = np_black_body_eval(&emission->black_body, np_glow_temperature(glow, position));
  return np_spectrum_scale(np_spectrum_multiply(glow->absorption_per_value, body), value);
}

/* Mean j over a box of the world, by the midpoint rule, two points to a voxel and six at most along each axis. */
np_spectrum np_emission_average(const np_emission *emission, np_dvec3 low, np_dvec3 size);

/* A point drawn for its light, `u` in [0, 1) choosing the lamp; false where there is none. */
bool np_emission_draw(const np_emission *emission, double u, np_random *random, np_dvec3 *out_position);

/* Density per solid angle of the direction from `origin` to a drawn point. */
float np_emission_direction_density(const np_emission *emission, np_dvec3 origin, np_vec3 direction);

#endif
