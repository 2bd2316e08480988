/* SPDX-License-Identifier: Apache-2.0 */
/* Rays against a terrain, for world and integrators. The planet's sphere beyond it is not part of it.
 *
 * Rays have a double origin anywhere, even in orbit, and a unit direction. Embree finds the facet in floats about the
 * field's own middle; distances are then met with that facet in double, so that a hit lies within a micrometre or so of
 * the facet's plane. Nothing is skipped near the origin: a ray that starts on the ground must be lifted off it first,
 * by NP_TERRAIN_LIFT_M along the normal, which is more than the float vertices' and origins' rounding (4 mm at 60 km
 * from the middle, lateral) on any slope.
 */
#ifndef NP_TERRAIN_TERRAIN_PRIVATE_H
#define NP_TERRAIN_TERRAIN_PRIVATE_H

#include <nephos/terrain.h>

#include "core/context_private.h"
#include "core/math.h"
#include "core/parallel.h"
#include "core/spectrum.h"
#include "terrain/heightfield.h"

#define NP_TERRAIN_LIFT_M 0.05

typedef struct np_terrain_hit {
  double distance; /* along the ray, m */
  np_vec3 normal;  /* unit, smooth, facing up; of a mesh, facing the ray's origin */
  np_vec3 facet;   /* unit, of the triangle, facing as `normal` does */
  np_vec3 rise;    /* offset from the facet to the curved surface of the smooth normals, m */
  bool is_of_mesh; /* hit is on a mesh, and has a point in place of a position */
  np_field_position position;
  np_dvec3 point; /* point in the world */
} np_terrain_hit;

/* Footprint over which land cover has its mean. */
#define NP_TERRAIN_WIDE ((float)INFINITY)

neph_context *np_terrain_get_context(const neph_terrain *terrain);

/* Planet radius and ground albedo of the description. */
double np_terrain_get_planet_radius_m(const neph_terrain *terrain);
const double *np_terrain_get_ground_albedo(const neph_terrain *terrain);

/* Whether the albedo differs from place to place (ground_cover.h). */
bool np_terrain_has_cover(const neph_terrain *terrain);

/* Albedo at a hit, in a scene's reference bands; of land cover, over a footprint in metres. */
void np_terrain_eval_albedo(const neph_terrain *terrain, const np_terrain_hit *hit, float footprint_m,
                            float out_albedo[3]);

/* Roughness of the ground (world/ground_brdf.h); 0: Lambert's law. */
float np_terrain_get_roughness(const neph_terrain *terrain);

/* Mean of the albedo over the field, or over a lone mesh, seen from above. */
const double *np_terrain_get_mean_albedo(const neph_terrain *terrain);

/* Mean of the albedo over all land around, weighted as the air above the field has light from it. */
const double *np_terrain_get_air_albedo(const neph_terrain *terrain);

/* Creates the ground of a field, whose ownership it takes in any case, and of the description's mesh. `is_joined`: the
 * field is joined to the sphere already. A field without samples: the mesh alone. */
neph_result np_terrain_create_from_field(neph_context *context, np_heightfield *field, const neph_terrain_desc *desc,
                                         bool is_joined, np_monitor *monitor, neph_terrain **out_terrain);

/* Distance between samples of the field; 0 where there is a mesh alone. */
double np_terrain_get_cell_m(const neph_terrain *terrain);

/* The terrain's field, joined to the sphere; without samples: none. */
const np_heightfield *np_terrain_get_field(const neph_terrain *terrain);

/* Nearest ground along a ray within `distance_max`, from above or below; safe from any number of threads. */
bool np_terrain_intersect(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max,
                          np_terrain_hit *out_hit);

/* Whether any ground lies within `distance_max`. */
bool np_terrain_is_occluded(const neph_terrain *terrain, np_dvec3 origin, np_vec3 direction, double distance_max);

/* World box of the ground. */
void np_terrain_get_bounds(const neph_terrain *terrain, np_dvec3 *out_min, np_dvec3 *out_max);

/* World rectangle around the file's samples, without the margin, and the mesh. */
void np_terrain_get_core(const neph_terrain *terrain, double out_low[2], double out_high[2]);

/* Whether (x, y) lies over the height field: outside it, the sphere is the ground. */
bool np_terrain_covers(const neph_terrain *terrain, double x_m, double y_m);

/* Latitude and longitude of the world origin, given or the file's centre; false when the field has no position. */
bool np_terrain_get_place(const neph_terrain *terrain, double *out_latitude_rad, double *out_longitude_rad);

/* Lowest and highest ground of the field, and of the corners of a mesh's box, m above the sphere. */
double np_terrain_get_elevation_min_m(const neph_terrain *terrain);
double np_terrain_get_elevation_max_m(const neph_terrain *terrain);

#endif
