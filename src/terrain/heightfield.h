/* SPDX-License-Identifier: Apache-2.0 */
/* A grid of elevations, and the position of each sample on the planet. */
#ifndef NP_TERRAIN_HEIGHTFIELD_H
#define NP_TERRAIN_HEIGHTFIELD_H

#include <nephos/terrain.h>

#include "core/disk_cache.h"
#include "core/math.h"
#include "core/parallel.h"
#include "terrain/field_chart.h"

enum { NP_HEIGHTFIELD_SAMPLES_MAX = 16385 }; /* along each side */

enum { NP_FIELD_MARGIN_MAX = 128 };

/* Samples added on each side of the file's, at increasing distances from its border. */
typedef struct np_field_margin {
  unsigned count, padding;                  /* 0: none */
  double cell_east_m, cell_north_m;         /* spacing of the file's samples */
  double offset_m[NP_FIELD_MARGIN_MAX + 1]; /* distance of the k-th added sample from the border; 0 for the border
                                               itself */
} np_field_margin;

typedef struct np_geographic {
  double latitude_rad, longitude_rad;
} np_geographic;

/* Samples lie at even steps of longitude and latitude: of the planet for .hgt; for pictures and procedural fields of a
 * graticule whose equator and meridian cross in the middle of the field, so that steps are arcs of equal length. Those
 * of a grid in a map projection lie where its chart says. */
typedef struct np_heightfield {
  unsigned width, height;     /* samples from west to east, from south to north, margins counted; at least 2 */
  float *elevation_m;         /* height above the sphere; the southern row first, each from west to east */
  double west_rad, south_rad; /* position of the file's south-western sample */
  double step_east_rad, step_north_rad; /* steps between samples; with a chart: arcs of a cell in its middle */
  bool has_place;                       /* whether the angles are true longitudes and latitudes */
  bool has_chart;                       /* positions follow from `chart`, in a world with its origin at `origin` */
  np_geographic origin;
  np_field_chart chart; /* chart of positions among the file's samples */
  np_field_margin margin;
  size_t void_count;                      /* samples without a value in the file, filled from their surroundings */
  float elevation_min_m, elevation_max_m; /* range in the file, before any blending */
} np_heightfield;

/* Reads a file by its name's ending; a name with * or ? means all matching files, side by side. `desc` has the
 * properties that a file does not state. On failure `out_field` is empty. */
neph_result np_heightfield_load(neph_context *context, np_monitor *monitor, const char *path,
                                const neph_terrain_desc *desc, np_heightfield *out_field);

/* Refuses a field whose middle is so far from the description's place that it would be invisible. */
neph_result np_heightfield_check_distance(neph_context *context, const neph_terrain_desc *desc, double distance_m);

/* Refuses a field by its middle, as np_heightfield_check_distance does; without a place in the description every field
 * passes. */
neph_result np_heightfield_check_middle(neph_context *context, const neph_terrain_desc *desc, np_geographic middle);

/* Checks by names, sizes or headers alone whether files are a height field, and computes its samples from west to east
 * and from south to north after loading. */
neph_result np_heightfield_check(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                 unsigned out_size[2]);

/* Whether GDAL reads files of a name. */
bool np_heightfield_is_raster(const char *path);
neph_result np_heightfield_load_raster(neph_context *context, np_monitor *monitor, const char *path,
                                       const neph_terrain_desc *desc, np_heightfield *out_field);
neph_result np_heightfield_check_raster(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                        unsigned out_size[2]);

/* Load and check files without a header, .r16 and .raw. */
neph_result np_heightfield_load_raw(neph_context *context, np_monitor *monitor, const char *path,
                                    const neph_terrain_desc *desc, np_heightfield *out_field);
neph_result np_heightfield_check_raw(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                     unsigned out_size[2]);

/* Properties of a raster from its header. */
typedef struct np_raster_summary {
  char format[40], sample_type[20], crs[120], unit[40]; /* unit "": none stated */
  bool has_place;                                       /* otherwise terrain.width lays it around the scene's place */
  size_t file_count;
} np_raster_summary;

neph_result np_heightfield_describe_raster(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                           np_raster_summary *out_summary);

/* Height from the 8-bit samples of a colour, 0 to 255. */
float np_height_decode_color(neph_height_encoding encoding, float red, float green, float blue);

/* Ridged mountains from noise, of elevations 0 to relief. The same bits for any thread count and instruction set. */
neph_result np_heightfield_make_ridges(neph_context *context, np_monitor *monitor, const neph_ridges_desc *ridges,
                                       const neph_terrain_desc *desc, np_heightfield *out_field);

/* An empty field in the shape of a picture, centred on its own graticule. */
neph_result np_heightfield_create_flat(neph_context *context, unsigned width, unsigned height,
                                       const neph_terrain_desc *desc, np_heightfield *out_field);

/* Saves a field on disk. */
void np_heightfield_save_to_cache(const np_heightfield *field, np_cache_entry *entry);

/* Loads a saved field; false, with `*out_field` empty, where the entry is too short. */
bool np_heightfield_load_from_cache(np_cache_entry *entry, np_heightfield *out_field);

/* Frees the samples. A zeroed field is allowed. */
void np_heightfield_destroy(neph_context *context, np_heightfield *field);

/* Fills NaN samples from their surroundings, counts them, and computes the range of the others. Fails when no sample
 * has a value, or one is beyond ±100 km. */
neph_result np_heightfield_finish(neph_context *context, const char *path, np_heightfield *field);

/* Joins the border to the planet beyond it. A border at sea level only needs a fade. */
neph_result np_heightfield_join_sphere(neph_context *context, neph_terrain_edge edge, double planet_radius_m,
                                       np_heightfield *field);

/* Elevation on the triangles that rays hit (each cell is split from its south-eastern to its north-western corner);
 * positions outside are clamped to the edge. */
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

/* World position at a latitude and longitude. */
np_dvec3 np_globe_to_world(const np_globe *globe, double latitude_rad, double longitude_rad, double elevation_m);

/* Number of the file's samples along each side, and a position in units of samples; outside [0, last] it lies in the
 * margin. */
unsigned np_heightfield_get_core_width(const np_heightfield *field);
unsigned np_heightfield_get_core_height(const np_heightfield *field);
np_field_position np_heightfield_get_core_position(const np_heightfield *field, np_field_position position);

/* The middle of the file's samples; with a chart, the origin of its world. */
np_geographic np_heightfield_get_middle(const np_heightfield *field);

/* Terms of a position that depend on a column alone, and on a row alone. */
typedef struct np_field_column {
  np_globe_angle meridian;
  np_chart_basis basis;
} np_field_column;

typedef struct np_field_row {
  np_globe_angle parallel;
  np_chart_row chart;
} np_field_row;

np_field_column np_heightfield_get_column(const np_heightfield *field, const np_globe *globe, double column);
np_field_row np_heightfield_get_row(const np_heightfield *field, double row);

/* World position of a point above a place of the field. */
np_dvec3 np_heightfield_place(const np_heightfield *field, const np_globe *globe, const np_field_row *row,
                              const np_field_column *column, double elevation_m);
np_dvec3 np_heightfield_to_world(const np_heightfield *field, const np_globe *globe, np_field_position position,
                                 double elevation_m);

/* Place in the field of the ground at a world x, y, on the near half of the planet; false beyond the field. */
bool np_heightfield_locate(const np_heightfield *field, const np_globe *globe, double x_m, double y_m,
                           np_field_position *out_position);

#endif
