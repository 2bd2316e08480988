/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of the cloud module: a description becomes a weather map, both become a density model, and a bake samples
 * it. Lengths are metres; x and y count from the field's centre, heights from the cloud base. */
#ifndef NP_CLOUD_CLOUD_PRIVATE_H
#define NP_CLOUD_CLOUD_PRIVATE_H

#include <nephos/cloud.h>
#include <nephos/image.h>

#include "cloud/balls.h"
#include "core/parallel.h"
#include "core/text.h"
#include "noise/noise.h"
#include "volume/sparse_grid.h"

/* Streams of random numbers that share a description's seed; their order is part of what a seed means. */
typedef enum np_cloud_stream {
  NP_CLOUD_STREAM_CELLS,
  NP_CLOUD_STREAM_SMALL_CELLS,
  NP_CLOUD_STREAM_SWIRL,
  NP_CLOUD_STREAM_GROUPS,
  NP_CLOUD_STREAM_BASE,
  NP_CLOUD_STREAM_CURL,
  NP_CLOUD_STREAM_DETAIL, /* one more for each octave */
  NP_CLOUD_STREAM_SHEET = 32,
  NP_CLOUD_STREAM_RAIN,
  NP_CLOUD_STREAM_THERMALS,
  NP_CLOUD_STREAM_FILLERS,
  NP_CLOUD_STREAM_SCRAPS,
  NP_CLOUD_STREAM_FLOOR,
  NP_CLOUD_STREAM_WISPS,
  NP_CLOUD_STREAM_STREETS = 24,
  NP_CLOUD_STREAM_MESOSCALE,
  NP_CLOUD_STREAM_MESOSCALE_X,
  NP_CLOUD_STREAM_MESOSCALE_Y,
  NP_CLOUD_STREAM_ANVIL_LOBES,
  NP_CLOUD_STREAM_ANVIL_EDDIES,
  NP_CLOUD_STREAM_ANVIL_GROUPS,
  NP_CLOUD_STREAM_SHELVES,
  NP_CLOUD_STREAM_BILLOWS = 40, /* one more for each level */
  NP_CLOUD_STREAM_PATCHES = 48, /* the same */
  NP_CLOUD_STREAM_WARP = 56     /* one more for each octave */
} np_cloud_stream;

/* ---- Descriptions: cloud_desc.c ---- */

/* Start of messages: "clouds[0].bake". */
static inline const char *np_cloud_desc_name(const neph_cloud_desc *desc) { return desc->name ? desc->name : "cloud"; }

/* Copies a caller's description (NULL: the defaults) and checks every field. */
neph_result np_cloud_desc_read(neph_context *context, const neph_cloud_desc *desc, neph_cloud_desc *out_desc);

/* The description, and what of the bake decides values, as JSON, to be freed with np_alloc_free. */
neph_result np_cloud_desc_to_json(neph_context *context, const neph_cloud_desc *desc, const neph_bake_desc *bake,
                                  char **out_text);

/* Reads such JSON; `file` is where it was found, for messages. The descriptions are still to be checked. */
neph_result np_cloud_desc_from_json(neph_context *context, const char *file, const char *text,
                                    neph_cloud_desc *out_desc, neph_bake_desc *bake);

/* Those who look at levels of detail: a box that holds all, and the angle that a voxel may span before a smaller size
 * is taken. */
typedef struct np_lod_viewers {
  double min_m[3], max_m[3], angle_rad;
} np_lod_viewers;

/* The coarsest of so many levels, from voxel_m on, whose voxels span no more than the angle, seen from the nearest of
 * the viewers at the nearest point of a box; a fixed order of sums and roots, the same bits everywhere. */
unsigned np_lod_choose(const np_lod_viewers *viewers, unsigned count, double voxel_m, const double low_m[3],
                       const double high_m[3]);

/* Levels of detail that a bake has: those asked for whose voxels the cloud is thick enough for. */
unsigned np_bake_count_levels(const neph_cloud_desc *desc, const neph_bake_desc *bake);

/* Frees the texts of a description that np_cloud_desc_from_json read. */
void np_cloud_desc_clear(neph_context *context, neph_cloud_desc *desc);

/* ---- Presets: presets.c ---- */

bool np_cloud_has_preset(const char *name);

/* Their names, parted by ", ". */
void np_cloud_list_presets(np_text *out);

/* ---- A picture as weather map: weather_picture.c ---- */

/* Shares in [0, 1] of what the description says of coverage, type, thickness and precipitation; and of the thickness,
 * by which a base lies higher. */
typedef struct np_weather_picture {
  neph_image *image;                                  /* NULL: none */
  const float *values[NEPH_CLOUD_MAP_QUANTITY_COUNT]; /* in the image; NULL: not from the picture */
  double size_m[2];
  bool is_tiling; /* else its border goes on beyond it */
} np_weather_picture;

/* Weather map of a description; empty without a picture. */
neph_result np_weather_picture_load(neph_context *context, const neph_cloud_desc *desc,
                                    np_weather_picture *out_picture);

/* The height map of a shape, as the thickness. */
neph_result np_weather_picture_load_heights(neph_context *context, const neph_cloud_shape *shape,
                                            np_weather_picture *out_picture);
void np_weather_picture_clear(np_weather_picture *picture); /* a zeroed picture is allowed */

/* Bilinear; of a quantity that the picture has. The picture's middle lies at 0, 0, its first row in the north. */
float np_weather_picture_sample(const np_weather_picture *picture, neph_cloud_map_quantity quantity, double x_m,
                                double y_m);

const char *np_cloud_map_quantity_get_name(neph_cloud_map_quantity quantity);

/* Hash of the file's bytes. */
neph_result np_cloud_map_hash(neph_context *context, const char *file, char out_hex[33]);

/* ---- Landscape: landscape.c ---- */

enum { NP_LANDSCAPE_BLOCK = 256 };

typedef struct np_landscape {
  const np_noise_table *noise;
  neph_cloud_model model;
  uint64_t seed;
  double cell_m, lives;
  double drift[2];      /* of the air, in cell spacings */
  float half_extent[2]; /* of the field, in cell spacings */
  float radius_m; /* a lone cell is a − r²/radius²: its outline at waterline t is a circle of radius·√(a − t) */
  float shore_depth, sheet_shrink, anvil, swirl;
  float heading[2], shear[2]; /* unit vectors; `shear` is 0 without skew */
  float streets, cells_size;  /* mesoscale.c; the latter in cell spacings */
  neph_cloud_cells cells_kind;
  int32_t period, sheet_period; /* cells in a field that repeats, and those of a sheet along the wind; 0: it ends */
} np_landscape;

typedef struct np_landscape_out {
  float *height, *anvil; /* `anvil`: NULL, or of cells only */
  double *air_x_m, *air_y_m;
} np_landscape_out;

/* At the description's time. */
np_landscape np_landscape_make(const np_noise_table *noise, const neph_cloud_desc *desc);

/* At most NP_LANDSCAPE_BLOCK positions. */
void np_landscape_eval(const np_landscape *land, size_t count, const float *x_m, const float *y_m,
                       const np_landscape_out *out);

/* Whether a picture says the coverage, and the coverage of what it leaves open: 1 with such a picture. */
bool np_cloud_desc_maps_coverage(const neph_cloud_desc *desc);
double np_cloud_desc_get_coverage(const neph_cloud_desc *desc);

/* Along the wind, or along x in a calm. */
void np_cloud_desc_compute_heading(const neph_cloud_desc *desc, float out_heading[2]);

/* ---- Weather map: weather_map.c ---- */

enum { NP_WEATHER_QUANTILES = 256 };

/* The landscape in texels. A waterline through it, chosen by the coverage, parts cloud from sky. A second landscape, of
 * the largest cells alone and wider, holds the anvils. */
typedef struct np_weather_map {
  neph_context *context; /* borrowed */
  int32_t size[2];       /* texels along x, y */
  float origin_m[2];     /* of the first texel */
  float step_m, radius_m;
  bool is_periodic;                             /* else the border's values go on beyond it */
  float lowest, highest;                        /* over all texels, above their levels */
  float *values;                                /* x fastest */
  float *anvils;                                /* NULL: none */
  float *levels;                                /* heights at which a picture's clouds begin; NULL: 0 */
  float *planes[NEPH_CLOUD_MAP_QUANTITY_COUNT]; /* from a picture; NULL: not */
  float *ground_m;                              /* above the base altitude; NULL: it has no part */
  float ground_low_m, ground_high_m;
  float quantiles[NP_WEATHER_QUANTILES + 1]; /* of the landscape, when a picture says the coverage */
  double coverage;                           /* of the whole field, wanted */
} np_weather_map;

typedef struct np_interval {
  float low, high;
} np_interval;

/* The map at the description's time. `start` is that of time 0, whose quantiles are kept; NULL: this is it. */
neph_result np_weather_map_build(neph_context *context, const neph_cloud_desc *desc, const np_weather_picture *picture,
                                 const np_weather_map *start, np_monitor *monitor, np_weather_map *out_map);
void np_weather_map_clear(np_weather_map *map); /* a zeroed map is allowed */

/* In memory. */
double np_weather_map_count_bytes(const np_weather_map *map);

/* Bilinear value of `values`, `anvils` or a plane; beyond it the border's value, or the map again. */
float np_weather_map_sample(const np_weather_map *map, const float *values, float x_m, float y_m);

/* Every sample in the rectangle lies within, but for rounding. */
np_interval np_weather_map_get_range(const np_weather_map *map, const float *values, const float min_m[2],
                                     const float max_m[2]);

/* ---- The model ---- */

enum { NP_CLOUD_OCTAVES_MAX = 6, NP_CLOUD_BLOCK = NP_LEAF_SIZE };

typedef struct np_cloud_octave {
  np_noise_lattice lattice;
  float frequency_per_m;
  float amplitude;          /* in units of depth, see cloud_density.c */
  float mean;               /* of the noise */
  float gain_max, loss_max; /* the most that this octave and all finer ones add to depth, and take from it */
} np_cloud_octave;

/* ---- Wind by height: cloud_wind.c ---- */

/* By axis: metres that the wind of each height of the profile carries air off while it rises through a layer, and those
 * that it has been carried off there. */
typedef struct np_cloud_wind {
  float gain_m[NEPH_CLOUD_PROFILE_POINTS][2], at_m[NEPH_CLOUD_PROFILE_POINTS][2], gain_max_m[2];
  float lag_per_m[2]; /* of rain, times the square of its way below the base */
  bool has_shift;     /* else columns are upright */
} np_cloud_wind;

enum { NP_THERMAL_WARPS = 3 };

/* Noises on thermals, in metres. */
typedef struct np_thermal_noises {
  float billow_m; /* of the largest billows: the description's, or less in a small field */
  np_noise_lattice warp[NP_THERMAL_WARPS], floor, wisps;
  float warp_size_m[NP_THERMAL_WARPS], warp_m[NP_THERMAL_WARPS]; /* root mean square of each component */
  float warp_max_m;                                              /* of all, a length */
  unsigned wisp_octaves;
  float wisp_size_m, fray_m;
  float wisp_m[NEPH_CLOUD_PARTS], wisp_max_m; /* depth of wisps at tops, flanks and base */
  float wisp_fineness[NEPH_CLOUD_PARTS];      /* octaves by which they are finer there */
  float floor_m, floor_size_m;                /* mean height of the base above the lowest, and size of its noise */
  float crisp_m, soft_m;                      /* edges, young and old */
  float gain_max_m, loss_max_m;               /* the most that noise moves the surface out and in */
  float fray_gain_max_m, fray_loss_max_m;     /* of those, by fraying */
  float reach_max_m;                          /* of gain and wisps, outwards */
} np_thermal_noises;

/* Noises of the kinds with a shape of their own (cloud_kinds.h). */
typedef struct np_kind_noises {
  np_noise_lattice coarse, medium, fine;
  float fine_m, edge_m; /* size of the fine noise; softness of the surface */
  unsigned fine_octaves;
} np_kind_noises;

/* A contrail: its direction, the offset of its line from the field's middle, and its age where it is oldest. */
typedef struct np_trail {
  float along[2], offset_m, half_m, age, width_max_m;
  float drop; /* of its level, in thicknesses */
} np_trail;

np_trail np_trail_make(const neph_cloud_desc *desc, unsigned index);

typedef struct np_cloud_model {
  neph_cloud_desc desc; /* its voxel is the grain: the bake's, or a whole part of it */
  unsigned sample_count; /* grains over the height of a voxel, of which a value is the mean */
  np_weather_map map;
  const np_noise_table *noise;
  float waterline;                 /* of the map */
  double covered;                  /* share of the field's sky, by the best waterline of all that were tried */
  float depth_scale, depth_offset; /* map value to depth: 0 at the outline, 1 in the heart of the largest cell */
  float slope_per_m;               /* of depth, at the outline of the largest cell */
  float edge;                      /* depth over which extinction rises from nothing to the core's */
  np_cloud_octave base, detail[NP_CLOUD_OCTAVES_MAX];
  unsigned detail_count, sheet_octave_count;
  float detail_gain_max, base_gain_max; /* largest that noise adds to depth */
  float detail_loss_max;                /* … and detail takes from it */
  float base_ramp_inverse;              /* of the share of a column over which its base thickens */
  np_noise_lattice curl, rain;
  float curl_frequency_per_m, curl_distance_m;
  float drift_m[2], turnover; /* of the air since time 0, and of the billows, in their own size */
  float heading[2];
  float rain_depth_m; /* below the lowest base */
  double lives_per_s;
  np_ball_heap balls;   /* of thermals and their billows; none in other models */
  np_shape_grid *shape; /* of a mesh or a height map; NULL: none */
  np_thermal_noises thermals;
  np_cloud_wind wind;
  np_kind_noises kind;
  np_trail trails[NEPH_CLOUD_TRAILS_MAX];
  bool is_empty; /* coverage 0 */
} np_cloud_model;

/* Builds the map, and sets its waterline so that the covered fraction of the sky is what was asked for: cloud_model.c.
 */
neph_result np_cloud_model_build(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                 np_cloud_model *out_model);
void np_cloud_model_clear(np_cloud_model *model); /* a zeroed model is allowed */

/* The model with detail down to this share of its grain, as far as that needs no other balls and no other waterline;
 * the model lends it all that is to be cleared. */
np_cloud_model np_cloud_model_refine(const np_cloud_model *model, double share);

/* Sine and cosine of an angle, the same on every machine. */
void np_cloud_compute_direction(double angle_rad, double out_sine_cosine[2]);

np_cloud_wind np_cloud_wind_make(const neph_cloud_desc *desc);

/* Displacement of the air at a height by the profile of the wind alone, and by the skew too. */
void np_cloud_wind_carry(const np_cloud_model *model, float height_m, float out_m[2]);
void np_cloud_wind_shift(const np_cloud_model *model, float height_m, float out_m[2]);

/* Every such displacement between two heights, along each axis. */
void np_cloud_wind_bound(const np_cloud_model *model, float low_m, float high_m, np_interval out_m[2]);

/* ---- Columns: what is known before any noise, and bounds of it: cloud_column.c ---- */

typedef struct np_cloud_column {
  float x_m, y_m;        /* where it stands at the base: freed from the skew */
  float strength, anvil; /* of the tower and of the anvil, in depth: 1 in the heart of the largest cell */
  float base_m, thickness_m, type, rain, age; /* of this column; `rain` is a share */
} np_cloud_column;

/* The column that runs through a position of the field. */
np_cloud_column np_cloud_column_compute(const np_cloud_model *model, float x_m, float y_m, float height_m);

/* Share of the column's thickness that it reaches. */
float np_cloud_column_compute_top(const np_cloud_model *model, const np_cloud_column *column);

/* A column at a height, before noise. */
typedef struct np_cloud_state {
  float depth, share; /* `share`: of the column's own thickness, from its base */
  float relief;       /* share of the noise's amplitude */
  float ice;          /* share of the anvil */
} np_cloud_state;

np_cloud_state np_cloud_column_eval(const np_cloud_model *model, const np_cloud_column *column, float height_m);

/* Strength of rain at a height below the column's base, in [0, 1]. */
float np_cloud_column_eval_rain(const np_cloud_model *model, const np_cloud_column *column, float height_m);

typedef struct np_cloud_box {
  float min_m[3], max_m[3]; /* x, y, height */
} np_cloud_box;

/* True only if there is no cloud anywhere in the box; costs no noise. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box);

/* ---- Density: cloud_density.c ---- */

/* Positions to evaluate, at most NP_CLOUD_BLOCK of them. */
typedef struct np_cloud_points {
  size_t count;
  const float *x_m, *y_m, *height_m;
} np_cloud_points;

/* Extinction in 1/m, the mean over the height of a voxel. It depends on the position alone: not on neighbours, threads
 * or kernels. */
void np_cloud_model_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

/* Extinction at the positions themselves. */
void np_cloud_model_eval_points(const np_cloud_model *model, const np_cloud_points *points,
                                float *out_extinction_per_m);

/* ---- Grain: cloud_grain.c ---- */

/* Size of detail that a model is built for in coarse voxels, before these are cut evenly. */
double np_cloud_compute_grain_m(const neph_cloud_desc *desc);

/* Number of grains over the height of the description's voxel: 1 where its own size loses nothing. */
unsigned np_cloud_grain_count(const neph_cloud_desc *desc);

/* The description that a model was built from. */
neph_cloud_desc np_cloud_model_get_desc(const np_cloud_model *model);

/* ---- Bake: bake.c ---- */

/* Evaluates the model on a grid named `name`. On failure the grid is left cleared. */
neph_result np_cloud_bake_grid(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               const char *name, np_monitor *monitor, np_sparse_grid *out_grid);

/* Warns of what a bake in the description's voxels would lose. */
neph_result np_cloud_check_voxel(neph_context *context, const neph_cloud_desc *cloud);

/* Copies a caller's description (NULL: the defaults) and checks it. */
neph_result np_cloud_bake_desc_read(neph_context *context, const neph_bake_desc *desc, neph_bake_desc *out_desc);

/* Whether a file was baked from this cloud for this planet and in these levels of detail, as its nephos:params say, and
 * all levels are there; it may have been pruned, or be of a region. Files without parameters, not ours, are taken to
 * be. */
neph_result np_cloud_file_is_current(neph_context *context, const char *path, const neph_cloud_desc *cloud,
                                     const neph_bake_desc *bake, bool *out_is_current);

#endif
