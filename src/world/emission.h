/* SPDX-License-Identifier: Apache-2.0 */
/* Emission of the clouds: black bodies of a temperature that varies from place to place, or light as a grid has it.
 *
 * An emitter emits j = κ·B(λ, T), per volume, direction and wavelength (W m⁻³ sr⁻¹ nm⁻¹), with B Planck's law and κ in
 * 1/m by Kirchhoff's law the absorption of the emitting matter. Either that is the cloud itself, κ = (1−ϖ)·σ; or it is
 * a flame with a grid of its own, whose κ counts for emission alone, so that there is light where there is no cloud. Of
 * a grid of colours each component is an emitter whose j is the value times one spectrum.
 *
 * For next-event estimation each emitter is a grid of even cells: one is drawn by its power, a point in it evenly, and
 * what counts is the direction to that point; all emission along it is then added up (Simon, Hanika, Zirr and
 * Dachsbacher 2017, "Line Integration for Rendering Heterogeneous Emissive Volumes"). The density of such a direction
 * is the sum over the cells along it: Σ p·(s₁³ − s₀³)/3, with p the density of a point in a cell and s the
 * distances at which the ray enters and leaves it.
 */
#ifndef NP_WORLD_EMISSION_H
#define NP_WORLD_EMISSION_H

#include "core/random.h"
#include "optics/black_body.h"
#include "volume/bricks.h"

/* Emitters of a cloud beside its own matter: a flame, and red, green and blue. */
enum { NP_EMITTER_FLAME = 8, NP_EMITTER_COLOR, NP_CLOUD_EMITTERS_MAX = NP_EMITTER_COLOR + 3 };

typedef struct np_emitter {
  /* bricks to whose values the absorption κ is proportional: the flame's or the cloud's density */
  const np_bricks *bricks;
  np_affine world_to_index, index_to_world;
  np_spectrum absorption_per_value; /* absorption where the value is 1, in 1/m, times the emitter's strength; without a
                                       body, its j */
  bool has_no_body;                 /* emission does not depend on the temperature */
  const np_bricks *temperature;     /* NULL: `offset_k` everywhere */
  np_affine world_to_temperature;
  float kelvin_per_value, offset_k;
  unsigned number;  /* index of its cloud in the scene */
  unsigned part;    /* part of the cloud whose density it uses; NP_EMITTER_FLAME and above: separate grids */
  bool is_held_out; /* invisible to the camera */
} np_emitter;

/* Grid of an emitter: cells of a lattice in its index space. */
typedef struct np_emitter_grid {
  double low[3]; /* index position of the first cell's corner */
  double edge;   /* edge of a cell in voxels */
  int32_t size[3];
  float *density; /* density of a point sampled in each cell, z fastest, in 1/m³; NULL: no cells */
} np_emitter_grid;

/* A cell that can be sampled. */
typedef struct np_emitter_cell {
  unsigned emitter;
  uint32_t cell;
  double cumulative; /* share of the power in this cell and all cells before it */
} np_emitter_cell;

typedef struct np_emission {
  neph_context *context; /* borrowed */
  np_black_body black_body;
  unsigned emitter_count;
  np_emitter *emitters;
  np_emitter_grid *grids; /* grid of each emitter */
  size_t cell_count;
  np_emitter_cell *list;
  np_spectrum power_w_sr_nm; /* ∫ j dV */
} np_emission;

/* Copies the emitters, whose grids must outlive the emission, and lists their cells by power. On failure `*out` is
 * empty.
 */
neph_result np_emission_build(neph_context *context, const np_emitter *emitters, unsigned count,
                              const np_black_body *body, np_monitor *monitor, np_emission *out);
void np_emission_clear(np_emission *emission);

static inline float np_emitter_temperature(const np_emitter *emitter, np_dvec3 position) {
  if (!emitter->temperature) return emitter->offset_k;
  const np_dvec3 index = np_affine_point(&emitter->world_to_temperature, position);
  return emitter->offset_k + emitter->kelvin_per_value * np_bricks_sample(emitter->temperature, index);
}

/* j at a position where the emitter's bricks have the value `value`. */
static inline np_spectrum np_emitter_eval(const np_emission *emission, const np_emitter *emitter, np_dvec3 position,
                                          float value) {
  if (!(value > 0.0f)) return np_spectrum_grey(0.0f);
  if (emitter->has_no_body) return np_spectrum_scale(emitter->absorption_per_value, value);
  const np_spectrum body = np_black_body_eval(&emission->black_body, np_emitter_temperature(emitter, position));
  return np_spectrum_scale(np_spectrum_multiply(emitter->absorption_per_value, body), value);
}

/* j of all emitters at a position. */
np_spectrum np_emission_eval(const np_emission *emission, np_dvec3 position);

/* Mean of j over a box of the world, by the midpoint rule, two points to a voxel and six at most along each axis. */
np_spectrum np_emission_average(const np_emission *emission, np_dvec3 low, np_dvec3 size);

/* Samples a point in proportion to its light; `u` in [0, 1) chooses the cell; false where there is no emission. */
bool np_emission_draw(const np_emission *emission, double u, np_random *random, np_dvec3 *out_position);

/* Density per solid angle with which np_emission_draw samples the direction from `origin`. */
float np_emission_direction_density(const np_emission *emission, np_dvec3 origin, np_vec3 direction);

#endif
