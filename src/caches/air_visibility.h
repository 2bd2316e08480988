/* SPDX-License-Identifier: Apache-2.0 */
/* Visibility of the sun in the air before the camera: rays through a grid of pixels, in cells that lie as squares of
 * the distance, with means over look-ups of the sun optical-depth volume and of the terrain, spread over the cells and
 * over the sun's disk by a low-discrepancy sequence. It depends on clouds, terrain, sun and camera. */
#ifndef NP_CACHES_AIR_VISIBILITY_H
#define NP_CACHES_AIR_VISIBILITY_H

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

size_t np_air_rays_count(const np_air_rays *rays);

/* Direction of a node, whose indices may lie between nodes. */
np_vec3 np_air_rays_get_direction(const np_air_rays *rays, float i, float j);

/* Distance of a plane, the first at the end of the first cell. */
double np_air_rays_get_plane(double reach_m, int plane);

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

#endif
