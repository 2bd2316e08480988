/* SPDX-License-Identifier: Apache-2.0 */
/* Light of the clouds in the air around them: what they scatter into it, and what they hide of sky and ground.
 *
 * Kept at the points of a lattice over the clouds and around them, from the ground to above their tops, as the change
 * of the actinic flux ∫ L dω from above and from below against clear air. It is a mean over the lattice's cells outside
 * of the clouds, interpolated, and fades out towards the sides; between clouds that repeat without end it repeats. The
 * light of fires goes on beyond, as a power of the distance.
 * Depends on what the multiple scattering depends on and on the ground; not on the camera.
 */
#ifndef NP_CACHES_LIT_AIR_H
#define NP_CACHES_LIT_AIR_H

#include "caches/gather_air.h"
#include "caches/ground_light.h"

/* Change by the clouds of the actinic flux from each hemisphere, W m⁻² nm⁻¹. */
typedef struct np_lit_air_value {
  np_spectrum upper;  /* hidden sky, and light that clouds scatter down */
  np_spectrum hidden; /* the part of `upper` that clear air has and the place lacks, 0 or less */
  np_spectrum lower;  /* hidden ground, light that clouds scatter up, and the ground's loss or gain of light */
  np_spectrum beam;   /* light that comes from burning clouds beside both */
  float sun_hidden;   /* share of the light around the sun that hills hide */
  np_vec3 way;        /* mean of the beam's directions, towards the clouds: of length 1 where there is but one */
} np_lit_air_value;

/* Number of levels, and of points along a side of one, to which rounding may add one. */
enum { NP_LIT_AIR_LEVELS = 9, NP_LIT_AIR_POINTS_MAX = 14 };

/* Actinic flux of the clear air's light and the ground's from each hemisphere, without the sun's, W m⁻² nm⁻¹. */
typedef struct np_clear_flux {
  np_spectrum upper, lower;
} np_clear_flux;

typedef struct np_lit_air {
  neph_context *context; /* borrowed */
  int32_t size[2];       /* points of a level */
  bool is_of_fire;
  np_dvec3 fire;    /* middle of its light */
  np_spectrum fall; /* a fire's light falls off as the distance to the power of −fall beyond the lattice */
  double origin_m[2], spacing_m;
  np_light_period period[2];         /* along x and y, from the first point on; a length of 0: light does not repeat */
  np_transport_fold fold;            /* tiles of which the points cover one; a period of 0: none */
  double level_m[NP_LIT_AIR_LEVELS]; /* heights, ascending */
  np_clear_flux clear[NP_LIT_AIR_LEVELS];
  np_lit_air_value *points; /* x fastest, then y, then the level */
} np_lit_air;

static inline size_t np_lit_air_count_points(const np_lit_air *light) {
  return (size_t)light->size[0] * (size_t)light->size[1] * NP_LIT_AIR_LEVELS;
}

/* Computes the lattice, with the ground lit by `ground_light`. On failure `*out` is empty. */
neph_result np_lit_air_build(neph_context *context, const np_cloud_gather *gather, const np_ground_light *ground_light,
                             np_monitor *monitor, np_lit_air *out);

/* Hills that count, and what is known of them. */
typedef struct np_hill_reach {
  np_dvec3 eye;
  double distance_m;   /* distance from the eye along x and y */
  bool is_shade_known; /* another lattice has what air lacks in their shade */
  bool is_coarse;      /* points are twice as far apart */
} np_hill_reach;

/* Computes the lattice over hills for the world's camera sky, without clouds: the change by what hills hide of sky and
 * ground, shine and shade. `*out` is empty on failure, and where no hill counts. */
neph_result np_lit_air_build_among_hills(neph_context *context, const np_world *world,
                                         const np_sun_optical_depths *depths, const np_hill_reach *reach,
                                         np_monitor *monitor, np_lit_air *out);
void np_lit_air_clear(np_lit_air *light);

/* Save the lattice on disk, and load it. False: the entry is too short. */
void np_lit_air_save(const np_lit_air *light, np_cache_entry *entry);
bool np_lit_air_load(neph_context *context, np_cache_entry *entry, np_lit_air *out);

/* The clear air's flux, which the change is to, at a height. */
np_clear_flux np_lit_air_get_clear(const np_lit_air *light, double height_m);

np_lit_air_value np_lit_air_get(const np_lit_air *light, np_dvec3 position);

/* Change by it of the air's light along a ray of a gather from a point (gather_air.h). */
np_spectrum np_lit_air_along(const np_lit_air *light, const np_gather_air *air, np_vec3 towards, np_dvec3 point,
                             const np_gather_ray *ray, double offset);

/* Distance from clouds whose tops are at a height above the ground beyond which their light on the air is left out. */
double np_lit_air_get_reach(double height_m, bool is_of_fire);

#endif
