/* SPDX-License-Identifier: Apache-2.0 */
/* Shadows of clouds and hills in the air before the camera.
 *
 * Sky and aerial perspective come from tables of a clear sky. What clouds and hills take from them is the sunlight that
 * the air would have scattered once: with I(t) the table's in-scatter of that order up to a distance t and V the
 * visibility of the sun,
 *
 *     lost(t) = ∫ (1 − V) dI
 *
 * V is a matter of places alone. It is found along rays through a grid of pixels, in cells that lie as squares of the
 * distance, as means over look-ups of the sun optical-depth volume and of the terrain, spread over the cells and over
 * the sun's disk by a low-discrepancy sequence. From it each packet of wavelengths makes the share lost(t)/I(t), which
 * is smooth even where I is not, as at the horizon, and is what is read in between rays. A ray that ends at a hill
 * counts little for what lies behind that hill.
 *
 * The disk is half a degree wide, so that edges of shadows which are seen along their sides are as wide: rays a quarter
 * of a degree apart show them all.
 *
 * Light that the air scatters more often is that without clouds, changed by what clouds scatter into the air, hide of
 * sky and ground and keep from the ground, where that is known (caches/lit_air.h), as if it came evenly from either
 * hemisphere. That can be more than they take. What haze scatters nearly straight on counts as not scattered: it lacks
 * what the first order lacks behind it and on its way from the sun.
 *
 * Visibility depends on clouds, terrain, sun and camera; what is lost on the camera's sky too.
 */
#ifndef NP_CACHES_AIR_SHADOW_H
#define NP_CACHES_AIR_SHADOW_H

#include "caches/lit_air.h"
#include "caches/sun_optical_depth.h"

/* Numbers of cells along a ray, and of planes at which shares are stored: at the ends of cells, at two, four and eight
 * times the last end, and at infinity. */
enum { NP_AIR_SHADOW_CELLS = 48, NP_AIR_SHADOW_PLANES = NP_AIR_SHADOW_CELLS + 4 };

/* A camera ray for queries of its air: from the eye, through a place of the film in pixels. */
typedef struct np_view_ray {
  np_dvec3 eye;
  np_vec3 direction;
  float film[2];
  const np_sky_ray *sky_ray; /* in the camera's sky; NULL: each query starts one */
} np_view_ray;

/* Projection that is not a plane: direction through a place of its film. */
typedef struct np_air_film {
  const void *camera; /* borrowed */
  np_vec3 (*get_direction)(const void *camera, float x, float y);
  float spacing; /* spacing of nodes in pixels */
} np_air_film;

/* Rays through the nodes of a grid over the picture. The direction of node (i, j) is forward + (i − middle[0])·right +
 * (j − middle[1])·down, or is defined by the film. Nodes have the indices of the whole picture, also where a part of it
 * is stored. */
typedef struct np_air_rays {
  np_air_film film; /* `camera` NULL: a plane */
  np_dvec3 origin;
  np_vec3 forward, right, down;
  float middle[2];
  int32_t begin[2], end[2];             /* range of stored nodes */
  int32_t whole_begin[2], whole_end[2]; /* range of nodes of the whole picture */
} np_air_rays;

/* Shadow casters, and air that clouds light: boxes of the world. */
typedef struct np_air_casters {
  unsigned count;
  np_dvec3 low[2], high[2];
  bool has_lit, is_lit_by_fire; /* light of fires counts where the sun's does not */
  np_dvec3 lit_low, lit_high;
} np_air_casters;

/* Mean visibility of the sun in each cell of each ray. */
typedef struct np_air_visibility {
  neph_context *context; /* borrowed */
  np_air_rays rays;
  double reach_m;  /* distance at which the last cell ends */
  float *seen;     /* visibilities: nodes × NP_AIR_SHADOW_CELLS */
  float *ground_m; /* distance at which the ray of each node ends; infinite: none */
} np_air_visibility;

/* Computes visibilities for the world's light and its camera sky, which limits the distance. The same bits for any
 * number of threads, and for a node whatever others are stored. On failure `*out` is empty. */
neph_result np_air_visibility_build(neph_context *context, const np_world *world, const np_sun_optical_depths *depths,
                                    const np_air_rays *rays, const np_air_casters *casters, np_monitor *monitor,
                                    np_air_visibility *out);
void np_air_visibility_clear(np_air_visibility *visibility);

/* Unit of stored shares: shadowed light in three bands over the light of the first order. The value represents a share
 * of 1. */
#define NP_AIR_SHADOW_UNIT 65535.0f

typedef struct np_air_shadow {
  neph_context *context;                       /* borrowed */
  const np_air_visibility *visibility;         /* borrowed */
  uint16_t (*visible_fraction)[NP_BAND_COUNT]; /* nodes × NP_AIR_SHADOW_PLANES, in NP_AIR_SHADOW_UNITs */
  np_spectrum *added; /* radiance that clouds and hills add to the air, as many; NULL: it is unknown */
} np_air_shadow;

/* Computes lost light for the world's camera sky; with the change of the air's light by clouds, `lit_air`, and by
 * hills, `among_hills`, of which either may be NULL. */
neph_result np_air_shadow_build(const np_air_visibility *visibility, const np_world *world, const np_lit_air *lit_air,
                                const np_lit_air *among_hills, np_monitor *monitor, np_air_shadow *out);
void np_air_shadow_clear(np_air_shadow *shadow);

/* Mean share of the first order that is lost along the nodes' rays. */
double np_air_shadow_measure(const np_air_shadow *shadow);

/* Change of the air's light up to a distance. */
typedef struct np_air_change {
  np_spectrum lost_share; /* share of the first order's in-scatter that is lost */
  np_spectrum added;      /* radiance; below 0 where clouds hide more light from the air than they give it */
} np_air_change;

/* Infinity is allowed. */
np_air_change np_air_shadow_get(const np_air_shadow *shadow, const np_view_ray *view, double distance_m);

#endif
