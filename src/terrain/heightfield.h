/* SPDX-License-Identifier: Apache-2.0 */
/* A grid of elevations, and where on the planet each stands. */
#ifndef NP_TERRAIN_HEIGHTFIELD_H
#define NP_TERRAIN_HEIGHTFIELD_H

#include <nephos/terrain.h>

#include "core/disk_cache.h"
#include "core/math.h"
#include "core/parallel.h"

enum { NP_HEIGHTFIELD_SAMPLES_MAX = 16385 }; /* along each side */

/* Samples lie at even steps of longitude and latitude: of the planet for .hgt; for pictures and procedural fields of a
 * graticule whose equator and meridian cross in the middle of the field, so that steps are arcs of equal length. */
typedef struct np_heightfield {
  unsigned width, height; /* samples from west to east, from south to north; 2 to NP_HEIGHTFIELD_SAMPLES_MAX */
  float *elevation_m;     /* above the sphere; the southern row first, each from west to east */
  double west_rad, south_rad;
  double step_east_rad, step_north_rad;
  bool has_place;                         /* whether the angles are true longitudes and latitudes */
  size_t void_count;                      /* samples the file had no value for, filled from around them */
  float elevation_min_m, elevation_max_m; /* as in the file, before any blending */
} np_heightfield;

/* Position in a height field: samples east of the western column and north of the southern row. */
typedef struct np_field_position {
  double column, row;
} np_field_position;

/* Reads .hgt, .exr or .png by the name's ending. `desc` gives width and radius of pictures, and the range of PNG.
 * On failure nothing is left in `out_field`. */
neph_result np_heightfield_load(neph_context *context, np_monitor *monitor, const char *path,
                                const neph_terrain_desc *desc, np_heightfield *out_field);

/* Whether a file is a height field, by its name, size or header alone. */
neph_result np_heightfield_check(neph_context *context, const char *path);

/* Ridged mountains from noise, of elevations 0 to relief. The same bits for any thread count and instruction set. */
neph_result np_heightfield_make_ridges(neph_context *context, np_monitor *monitor, const neph_ridges_desc *ridges,
                                       const neph_terrain_desc *desc, np_heightfield *out_field);

/* An empty field of a picture's shape, centred on its own graticule. */
neph_result np_heightfield_create_flat(neph_context *context, unsigned width, unsigned height,
                                       const neph_terrain_desc *desc, np_heightfield *out_field);

/* Keeps a field on disk. */
void np_heightfield_save_to_cache(const np_heightfield *field, np_cache_entry *entry);

/* One that was kept; false, with nothing left, where the entry holds less than that. */
bool np_heightfield_load_from_cache(np_cache_entry *entry, np_heightfield *out_field);

/* Frees the samples. A zeroed field is allowed. */
void np_heightfield_destroy(neph_context *context, np_heightfield *field);

/* Fills samples that are NaN from those around them, counts them, and finds the range of the others. Fails when no
 * sample has a value, or one is beyond ±100 km. */
neph_result np_heightfield_finish(neph_context *context, const char *path, np_heightfield *field);

/* Bends the outer 5 % of the field's width down (or up) to the sphere. */
void np_heightfield_blend_to_sphere(np_heightfield *field);

/* Elevation on the triangles that rays meet (each cell is split from its south-eastern to its north-western corner);
 * positions outside are taken at the edge. */
double np_heightfield_get_elevation(const np_heightfield *field, np_field_position position);

/* The world's frame on the planet: its origin at a latitude and longitude at sea level. */
typedef struct np_globe {
  double radius_m;
  double latitude_rad, longitude_rad;
  double sin_latitude, cos_latitude;
} np_globe;

np_globe np_globe_make(double radius_m, double latitude_rad, double longitude_rad);

/* Sine and cosine of a latitude, or of a longitude from the globe's own. */
typedef struct np_globe_angle {
  double sin, cos;
} np_globe_angle;

static inline np_globe_angle np_globe_angle_make(double angle_rad) {
  return (np_globe_angle){sin(angle_rad), cos(angle_rad)};
}

/* World position of a point above (or below) the sphere, on a parallel and a meridian. */
static inline np_dvec3 np_globe_place(const np_globe *globe, np_globe_angle parallel, np_globe_angle meridian,
                                      double elevation_m) {
  const double radius = globe->radius_m + elevation_m, to_meridian = parallel.cos * meridian.cos;
  return np_dvec3_make(radius * parallel.cos * meridian.sin,
                       radius * (globe->cos_latitude * parallel.sin - globe->sin_latitude * to_meridian),
                       radius * (globe->sin_latitude * parallel.sin + globe->cos_latitude * to_meridian) -
                           globe->radius_m);
}

/* The same by latitude and longitude. */
np_dvec3 np_globe_to_world(const np_globe *globe, double latitude_rad, double longitude_rad, double elevation_m);

/* Place in the field of the ground at a world x, y, on the near half of the planet; false beyond the field. */
bool np_heightfield_locate(const np_heightfield *field, const np_globe *globe, double x_m, double y_m,
                           np_field_position *out_position);

#endif
