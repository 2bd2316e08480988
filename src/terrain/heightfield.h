/* SPDX-License-Identifier: Apache-2.0 */
/* A grid of elevations, and where on the planet each stands. */
#ifndef NP_TERRAIN_HEIGHTFIELD_H
#define NP_TERRAIN_HEIGHTFIELD_H

#include <nephos/terrain.h>

#include "core/disk_cache.h"
#include "core/math.h"
#include "core/parallel.h"
#include "terrain/field_chart.h"

enum { NP_HEIGHTFIELD_SAMPLES_MAX = 16385 }; /* along each side */

enum { NP_FIELD_MARGIN_MAX = 128 };

/* Samples added around those of the file, on each side, at distances from its border that grow from one to the next. */
typedef struct np_field_margin {
  unsigned count, padding;                  /* 0: none */
  double cell_east_m, cell_north_m;         /* spacing of the file's samples */
  double offset_m[NP_FIELD_MARGIN_MAX + 1]; /* of the k-th added sample; 0 for the border itself */
} np_field_margin;

typedef struct np_geographic {
  double latitude_rad, longitude_rad;
} np_geographic;

/* Samples lie at even steps of longitude and latitude: of the planet for .hgt; for pictures and procedural fields of a
 * graticule whose equator and meridian cross in the middle of the field, so that steps are arcs of equal length. Those
 * of a grid in a map projection lie where its chart says. */
typedef struct np_heightfield {
  unsigned width, height;     /* samples from west to east, from south to north, margins counted; at least 2 */
  float *elevation_m;         /* above the sphere; the southern row first, each from west to east */
  double west_rad, south_rad; /* of the file's south-western sample */
  double step_east_rad, step_north_rad; /* with a chart: arcs as long as a cell in its middle */
  bool has_place;                       /* whether the angles are true longitudes and latitudes */
  bool has_chart;                       /* places are those of `chart`, in a world whose place is `origin` */
  np_geographic origin;
  np_field_chart chart; /* of positions among the file's samples */
  np_field_margin margin;
  size_t void_count;                      /* samples the file had no value for, filled from around them */
  float elevation_min_m, elevation_max_m; /* as in the file, before any blending */
} np_heightfield;

/* Reads a file by its name's ending; a name with * or ? stands for all that fit, side by side. `desc` gives what a file
 * does not say of itself. On failure nothing is left in `out_field`. */
neph_result np_heightfield_load(neph_context *context, np_monitor *monitor, const char *path,
                                const neph_terrain_desc *desc, np_heightfield *out_field);

/* Refuses a field whose middle is as far from the description's place as nothing of it would be seen. */
neph_result np_heightfield_check_distance(neph_context *context, const neph_terrain_desc *desc, double distance_m);

/* The same, by the middle; a description without a place lets every field pass. */
neph_result np_heightfield_check_middle(neph_context *context, const neph_terrain_desc *desc, np_geographic middle);

/* Whether files are a height field, by their names, sizes or headers alone, and the samples from west to east and from
 * south to north that a load of them gives. */
neph_result np_heightfield_check(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                 unsigned out_size[2]);

/* Rasters by GDAL; whether it reads files of a name. */
bool np_heightfield_is_raster(const char *path);
neph_result np_heightfield_load_raster(neph_context *context, np_monitor *monitor, const char *path,
                                       const neph_terrain_desc *desc, np_heightfield *out_field);
neph_result np_heightfield_check_raster(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                        unsigned out_size[2]);

/* Files without a header, .r16 and .raw. */
neph_result np_heightfield_load_raw(neph_context *context, np_monitor *monitor, const char *path,
                                    const neph_terrain_desc *desc, np_heightfield *out_field);
neph_result np_heightfield_check_raw(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                     unsigned out_size[2]);

/* A raster as its header has it. */
typedef struct np_raster_summary {
  char format[40], sample_type[20], crs[120], unit[40]; /* unit "": none stated */
  bool has_place;                                       /* else terrain.width lays it around the scene's place */
  size_t file_count;
} np_raster_summary;

neph_result np_heightfield_describe_raster(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                           np_raster_summary *out_summary);

/* The height that a colour of 8-bit samples, 0 to 255, stands for. */
float np_height_decode_color(neph_height_encoding encoding, float red, float green, float blue);

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

/* Joins the border to the planet beyond it. A border at sea level needs no more than a fade. */
neph_result np_heightfield_join_sphere(neph_context *context, neph_terrain_edge edge, double planet_radius_m,
                                       np_heightfield *field);

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

/* Samples of the file along each side, and a position counted among them: beyond 0 and the last in the margin. */
unsigned np_heightfield_get_core_width(const np_heightfield *field);
unsigned np_heightfield_get_core_height(const np_heightfield *field);
np_field_position np_heightfield_get_core_position(const np_heightfield *field, np_field_position position);

/* The middle of the file's samples; with a chart, the place of its world. */
np_geographic np_heightfield_get_middle(const np_heightfield *field);

/* The share of a column, and of a row, in the places along it. */
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
