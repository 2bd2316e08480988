/* SPDX-License-Identifier: Apache-2.0 */
/* Procedural clouds: parameters in everyday words, baked to a volume. */
#ifndef NEPHOS_CLOUD_H
#define NEPHOS_CLOUD_H

#include <nephos/terrain.h>
#include <nephos/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Model of the shape of a cloud. */
typedef enum neph_cloud_model {
  NEPH_CLOUD_MODEL_CELLS,    /**< cells that tower over a flat base: Perlin-Worley billows, Worley erosion, curl */
  NEPH_CLOUD_MODEL_SLAB,     /**< a sheet with soft edges, of value noise: cheap, for decks, veils and streaks */
  NEPH_CLOUD_MODEL_HERO,     /**< one cloud in the middle of the field, otherwise like thermals: needs no weather map */
  NEPH_CLOUD_MODEL_THERMALS, /**< cumulus: thermals over a flat base, heaps of balls that stand on each other */
  NEPH_CLOUD_MODEL_FOG,      /**< fills the ground below its top: fog, and stratus in valleys */
  NEPH_CLOUD_MODEL_LENSES,   /**< stacked lenses on the waves of a ridge in the wind: lenticularis */
  NEPH_CLOUD_MODEL_TRAILS,   /**< contrails: lines behind aircraft, which age and spread */
  NEPH_CLOUD_MODEL_DECK,     /**< closed cells and rolls with narrow gaps: stratocumulus */
  NEPH_CLOUD_MODEL_STREAKS   /**< heads of ice, with fall streaks that the skew draws out to hooks: cirrus */
} neph_cloud_model;

/** Convection cells, tens of kilometres wide, that group clouds. */
typedef enum neph_cloud_cells {
  NEPH_CLOUD_CELLS_NONE,
  NEPH_CLOUD_CELLS_OPEN,  /**< clouds along the walls of cells with clear hearts */
  NEPH_CLOUD_CELLS_CLOSED /**< cloudy hearts, parted by narrow clear walls */
} neph_cloud_cells;

/** Quantity that a picture gives for each place, as a value from 0 to 1. Coverage is that value; each other quantity is
 * the description's value times it. */
typedef enum neph_cloud_map_quantity {
  NEPH_CLOUD_MAP_COVERAGE,      /**< the coverage itself: 0 is clear sky, 1 is closed */
  NEPH_CLOUD_MAP_TYPE,          /**< share of the type */
  NEPH_CLOUD_MAP_BASE,          /**< base, raised by this share of the thickness; tops stay below the field's top */
  NEPH_CLOUD_MAP_THICKNESS,     /**< share of the thickness */
  NEPH_CLOUD_MAP_PRECIPITATION, /**< share of the precipitation */
  NEPH_CLOUD_MAP_AGE,           /**< share of the age of thermals */
  NEPH_CLOUD_MAP_QUANTITY_COUNT
} neph_cloud_map_quantity;

enum { NEPH_CLOUD_PROFILE_POINTS = 5, NEPH_CLOUD_TRAILS_MAX = 64, NEPH_CLOUD_PARTS = 3 };

/** Height of the ground above the sphere, in metres, at a place of the world; called from several threads at once. */
typedef double (*neph_height_fn)(void *user, double x_m, double y_m);

/** A point of a shape, with the radius that the shape has there. */
typedef struct neph_cloud_point {
  double x_m, y_m, z_m; /**< position relative to the middle of the field's base; ±1e6 */
  double radius_m;      /**< > 0 and ≤ 1e6 */
} neph_cloud_point;

/** A list of points, alone or joined to curves. */
typedef struct neph_cloud_points {
  const neph_cloud_point *points; /**< borrowed */
  size_t count;                   /**< ≤ NEPH_CLOUD_POINTS_MAX */
  const size_t *ends;             /**< curves: number of points up to the end of each, rising to `count`, borrowed */
  size_t curve_count;             /**< 0: the points are not joined to curves */
} neph_cloud_points;

enum { NEPH_CLOUD_POINTS_MAX = 100000 };

/** A shape in place of a cloud's thermals, on which its billows stand: the union of all its members. It is cut below
 * the base. */
typedef struct neph_cloud_shape {
  neph_cloud_points spheres;  /**< (default none) */
  neph_cloud_points curves;   /**< Catmull-Rom splines through points, tapered by their radii (default none) */
  const char *mesh_file;      /**< closed mesh, read by Assimp, borrowed; NULL: none (default NULL) */
  neph_mesh_up mesh_up;       /**< default NEPH_MESH_UP_FILE */
  bool has_mesh_unit;         /**< whether mesh_unit_m is given: otherwise the mesh is scaled to fill the field (default
                                   false) */
  double mesh_unit_m;         /**< length of the file's unit; > 0 (default 1) */
  double mesh_rotation_rad;   /**< rotation about the vertical, counter-clockwise seen from above (default 0) */
  double mesh_position_m[3];  /**< position of the middle of the mesh's bottom, relative to the middle of the field's
                                   base (default 0) */
  const char *height_map;     /**< EXR or PNG of tops, from 0 to 1, borrowed; NULL: none (default NULL) */
  const char *height_channel; /**< channel of the height map, borrowed; NULL: its first (default NULL) */
  bool has_height_size;       /**< whether height_size_m is given: otherwise the map fills the field (default false) */
  double height_size_m[2];    /**< size of the height map along x and y; > 0 (default 8 km × 8 km) */
  bool has_height;            /**< whether height_m is given: otherwise white is the top of the field, less room for
                                   billows (default false) */
  double height_m;            /**< height of white above the base; > 0 (default 1200) */
} neph_cloud_shape;

/** Values of pixels over the ground, by rows. Positions count in pixels, with 0 in the centre of the first column and
 * row. */
typedef struct neph_cloud_raster {
  unsigned width, height;    /**< pixels, 1 to 32768 */
  const float *values;       /**< width × height, NaN where there is no datum; NULL: no raster */
  double min_m[2], max_m[2]; /**< box of the world, x and y, that the nodes span */
  unsigned node_count[2];    /**< nodes along x and y, 2 to 1024 */
  const double *node_pixels; /**< column and row at each node, by rows from min_m; bilinear between nodes */
} neph_cloud_raster;

/** A measured field of clouds. */
typedef struct neph_cloud_measurement {
  neph_cloud_raster optical_depth; /**< vertical optical depth, the mean of a pixel; ≥ 0 */
  neph_cloud_raster top_m;         /**< altitude of cloud tops above sea level; without values: none */
  double threshold;                /**< optical depth below which the sky counts as clear; ≥ 0 */
  void *owner;                     /**< memory that `unload` releases */
} neph_cloud_measurement;

/** Reads a measured field; a failed call leaves nothing to release. */
typedef neph_result (*neph_cloud_measurement_load_fn)(void *user, neph_context *context,
                                                      neph_cloud_measurement *out_measurement);

/** Releases the memory of a field that neph_cloud_measurement_load_fn has read. */
typedef void (*neph_cloud_measurement_unload_fn)(void *user, neph_context *context,
                                                 neph_cloud_measurement *measurement);

/** A source of a measured field, read when a cloud is built. */
typedef struct neph_cloud_measurement_source {
  const char *name; /**< name of the field in messages */
  const char *id;   /**< identity of the field in files and keys of caches */
  neph_cloud_measurement_load_fn load;
  neph_cloud_measurement_unload_fn unload; /**< NULL: nothing needs to be released */
  void *user;                              /**< passed to both */
} neph_cloud_measurement_source;

/** A procedural cloud: a weather map, a height profile, and noise, by its model. Altitudes are above sea level. */
typedef struct neph_cloud_desc {
  size_t struct_size;
  uint64_t seed;           /**< any (default 0) */
  double extent_m[2];      /**< size along x and y, centred on `center_m`; > 0 (default 8 km × 8 km) */
  double center_m[2];      /**< centre of the field (default 0, 0) */
  double base_altitude_m;  /**< altitude of the flat cloud base (default 1200) */
  double thickness_m;      /**< height of the highest top above the base; > 0 (default 1200) */
  double voxel_m;          /**< edge of a voxel; > 0 (default 20) */
  double coverage;         /**< fraction of the sky covered, 0 to 1; unused where a picture gives it (default 0.35) */
  double cell_m;           /**< typical spacing of cloud cells; > 0 (default 1800) */
  double type;             /**< 0 humilis (flat), 1 congestus (tall): lower and raise tops (default 0.5) */
  double billow_m;         /**< size of the largest billows; > 0 (default 450) */
  double billowiness;      /**< height of billows above the shape, 0 to 1; a slab has none (default 0.5) */
  double erosion;          /**< depth of the detail carved into the shape, 0 to 1 (default 0.4) */
  double wispiness;        /**< depth of wisps in flanks and base, 0 to 1; the model cells has them at the base alone
                                (default 0.3) */
  double turbulence;       /**< curl distortion of detail and weather map, 0 to 1 (default 0.3) */
  double skew_m[2];        /**< displacement of the top against the base by wind, x and y (default 0, 0) */
  double extinction_per_m; /**< extinction in the core of the cloud; > 0 (default 0.06) */
  neph_cloud_model model;  /**< (default NEPH_CLOUD_MODEL_CELLS) */
  unsigned sublayers;      /**< sheets that lie over each other in a slab, 1 to 16 (default 1) */
  double softness;         /**< softness of edges: 0 is crisp, 1 fades over the whole cloud (default 0) */
  double stretch;          /**< stretch of a slab's pattern along the wind, or x in calm, 1 to 100 (default 1) */
  double anvil;            /**< spread of the tops of the largest cells, 0 to 1 (default 0) */
  double precipitation;    /**< rain below the base: 1 reaches sea level, less evaporates, 0 to 1 (default 0) */
  bool has_profile;        /**< `profile` replaces the profile that `type` chooses (default false) */
  /** Strength, relative to the largest cell, at which a cell reaches 0, ¼, ½, ¾ and 1 of the thickness: 0 to 1, never
   * falling (default 0, 0.06, 0.25, 0.56, 1, a dome). */
  double profile[NEPH_CLOUD_PROFILE_POINTS];
  double wind_m_s[2];   /**< wind that moves the clouds through the extent, x and y; ±200 (default 0, 0) */
  double time_s;        /**< time since the seed's own moment; ±1e6 (default 0) */
  double lifetime_s;    /**< period in which a cell grows and decays, and its billows turn over; > 0 (default 2400) */
  const char *map_file; /**< EXR or PNG to lay over the landscape, borrowed; NULL: none (default NULL) */
  /** The picture's channel for each quantity, borrowed; NULL: not from the picture (default all NULL). */
  const char *map_channels[NEPH_CLOUD_MAP_QUANTITY_COUNT];
  bool has_map_size;    /**< map_size_m is the size of the picture, not the extent (default false) */
  double map_size_m[2]; /**< size of the picture along x and y, centred like the field; > 0 (default 8 km × 8 km) */
  bool is_map_tiling;   /**< the picture repeats; otherwise its border values extend beyond it (default false) */
  double age;           /**< age: thermals from crisp, 0, to dissolving, 1; trails from fresh to spread (default 0.5) */
  bool has_winds;       /**< wind_speed_m_s and wind_direction_rad carry the cloud above its base (default false) */
  /** Wind at 0, ¼, ½, ¾ and 1 of the thickness: speed, 0 to 200, and the azimuth that it blows from (default 0; 3π/2,
   * the west). */
  double wind_speed_m_s[NEPH_CLOUD_PROFILE_POINTS], wind_direction_rad[NEPH_CLOUD_PROFILE_POINTS];
  neph_cloud_shape shape;                  /**< shape of the models hero and thermals (default none) */
  double billow_amounts[NEPH_CLOUD_PARTS]; /**< thermals: factors on billowiness at tops, flanks, base; 0 to 2 (1) */
  double billow_frequencies[NEPH_CLOUD_PARTS]; /**< thermals: frequencies of the largest billows at tops, flanks, base;
                                                    1 to 8 (default 1) */
  double wisp_amounts[NEPH_CLOUD_PARTS];       /**< factors on wispiness at tops, flanks, base; 0 to 2 (default 0, 0.5,
                                                    1) */
  const char *name;             /**< name of this description in messages, borrowed; NULL: cloud (default NULL) */
  neph_height_fn ground_height; /**< height of the ground below the field; NULL: unknown (default NULL) */
  void *ground_user;            /**< passed to ground_height (default NULL) */
  const char *ground_id; /**< identity of the ground in files and keys of caches, borrowed; NULL: a hash of its heights
                              (default NULL) */
  double ground_lift;    /**< bases rise by this share of the ground's height above its lowest point, 0 to 1 (default
                              0) */
  double ground_cover;   /**< preference for high ground, 1, or for low ground, −1; 0: none (default 0) */
  unsigned trails;       /**< number of trails, 1 to NEPH_CLOUD_TRAILS_MAX; the first crosses the middle (default 1) */
  double trail_direction_rad; /**< azimuth towards which the first trail goes; ±7 (default π/2, the east) */
  /** Distance from its middle up to which the field repeats without a seam in a scene, as tiles of width `extent_m`.
   * All lattices go into a tile a whole number of times and voxels a multiple of eight times; their sizes are rounded
   * accordingly. 0 to 1e6; 0: the field ends at its extent (default 0). Only for the models cells, slab, thermals, deck
   * and streaks, square and in the middle, without a picture, ground, shape or precipitation; the tile's x runs along a
   * wind that blows along neither axis, and a scene turns it back. */
  double repeat_m;
  /** Alignment of clouds: 0 is loose groups, 1 is streets and rolls along the wind, or x in calm, 2·`cell_m` apart; for
   * the models cells, slab, thermals and deck (default 0). */
  double streets;
  neph_cloud_cells cells_kind; /**< kind of convection cells; for the models cells, slab, thermals and deck (default
                                    NEPH_CLOUD_CELLS_NONE) */
  double cells_size_m;         /**< mean distance between centres of convection cells; > 0; in nature 10 to 40 km
                                    (default 12 km) */
  double wisp_frequencies[NEPH_CLOUD_PARTS]; /**< thermals: frequencies of wisps at tops, flanks, base; 1 to 8 (default
                                                  1) */
  /** Measured field that gives coverage, optical depth and tops in place of a picture and of `extinction_per_m`:
   * columns of the model are scaled until each pixel has its optical depth. Borrowed; NULL: none (default NULL). */
  const neph_cloud_measurement_source *measurement;
} neph_cloud_desc;

#define NEPH_CLOUD_DESC_DEFAULT                                                                                        \
  {                                                                                                                    \
    .struct_size = sizeof(neph_cloud_desc), .seed = 0, .extent_m = {8000, 8000}, .center_m = {0, 0},                   \
    .base_altitude_m = 1200, .thickness_m = 1200, .voxel_m = 20, .coverage = 0.35, .cell_m = 1800, .type = 0.5,        \
    .billow_m = 450, .billowiness = 0.5, .erosion = 0.4, .wispiness = 0.3, .turbulence = 0.3, .skew_m = {0, 0},        \
    .extinction_per_m = 0.06, .model = NEPH_CLOUD_MODEL_CELLS, .sublayers = 1, .softness = 0, .stretch = 1,            \
    .anvil = 0, .precipitation = 0, .has_profile = false, .profile = {0, 0.06, 0.25, 0.56, 1}, .wind_m_s = {0, 0},     \
    .time_s = 0, .lifetime_s = 2400, .map_file = NULL, .map_channels = {NULL}, .has_map_size = false,                  \
    .map_size_m = {8000, 8000}, .is_map_tiling = false, .age = 0.5, .has_winds = false,                                \
    .wind_speed_m_s = {0, 0, 0, 0, 0},                                                                                 \
    .wind_direction_rad = {4.71238898038468986, 4.71238898038468986, 4.71238898038468986, 4.71238898038468986,         \
                           4.71238898038468986},                                                                       \
    .shape = {.mesh_unit_m = 1, .height_size_m = {8000, 8000}, .height_m = 1200}, .billow_amounts = {1, 1, 1},         \
    .billow_frequencies = {1, 1, 1}, .wisp_amounts = {0, 0.5, 1}, .wisp_frequencies = {1, 1, 1}, .streets = 0,         \
    .cells_kind = NEPH_CLOUD_CELLS_NONE, .cells_size_m = 12000, .name = NULL, .ground_height = NULL,                   \
    .ground_user = NULL, .ground_id = NULL, .ground_lift = 0, .ground_cover = 0, .trails = 1,                          \
    .trail_direction_rad = 1.57079632679489662, .repeat_m = 0, .measurement = NULL                                     \
  }

/** Fills a description from a named preset ("cumulus_mediocris", …); fails listing the names there are.
 *
 * @param out_desc  starts from NEPH_CLOUD_DESC_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_cloud_get_preset(neph_context *context, const char *name,
                                           neph_cloud_desc *out_desc) NEPH_NODISCARD;

/** Extinction of a cloud's model at points of the world, the function that a bake samples.
 *
 * @param cloud            NULL for the defaults. Octaves of detail finer than two of its voxels are left out.
 * @param planet_radius_m  altitudes follow this sphere; 1e3 to 1e9.
 * @param positions_m      count × 3 world coordinates.
 * @param out_extinction_per_m  count values; the same bits for any thread count and instruction set.
 */
NEPH_API neph_result neph_cloud_eval(neph_context *context, const neph_cloud_desc *cloud, double planet_radius_m,
                                     size_t count, const double *positions_m,
                                     float *out_extinction_per_m) NEPH_NODISCARD;

/** No limit in neph_bake_desc.memory_max_bytes. */
#define NEPH_MEMORY_UNLIMITED UINT64_MAX

enum { NEPH_BAKE_LEVELS_MAX = 8, NEPH_BAKE_LODS_MAX = 6, NEPH_BAKE_ERROR_RAYS = 10000 };

/** Differences between a bake and its model: extinction at points, optical depth along rays. */
typedef struct neph_bake_loss {
  double density_rms_per_m, density_max_per_m;
  double depth_rms, depth_max;
} neph_bake_loss;

/** Error of one level of detail, at the points and along the segments of rays within its cells. */
typedef struct neph_bake_lod_error {
  double voxel_m;                      /**< edge of a voxel of this level */
  uint64_t ray_count, point_count;     /**< rays and points that meet the model's cloud within this level */
  double density_rms_per_m, depth_rms; /**< rms extinction and optical depth of the model within this level */
  neph_bake_loss total;                /**< error by all causes */
} neph_bake_lod_error;

/** Error of a bake against direct evaluation of its model with all detail, along NEPH_BAKE_ERROR_RAYS random lines
 * through the cloud's box. Lines are uniform in position and direction, and are sampled in steps of half a voxel; the
 * grid is trilinear between voxels. Sums of squares are divided by the number of points or rays that meet the model's
 * cloud. A bake with levels of detail is measured on the same rays, in steps of half of its smallest voxel; each point
 * is looked up in the level that holds it. */
typedef struct neph_bake_error {
  size_t struct_size;
  uint64_t ray_count;       /**< rays that meet the model's cloud */
  uint64_t point_count;     /**< points within the model's cloud */
  double density_rms_per_m; /**< rms extinction of the model at these points */
  double depth_rms;         /**< rms optical depth of the model along these rays */
  neph_bake_loss voxel;     /**< error by the size of voxels: detail and sampling together */
  neph_bake_loss detail;    /**< error by the octaves that are too fine for the voxels, and by the edge softened to
                                 them */
  neph_bake_loss sampling;  /**< the rest of `voxel`: trilinear interpolation */
  neph_bake_loss half;      /**< error by half precision in the file */
  neph_bake_loss pruning;
  neph_bake_loss total;                         /**< error by all causes together */
  size_t lod_count;                             /**< number of levels of detail; 0: a bake without */
  neph_bake_lod_error lods[NEPH_BAKE_LODS_MAX]; /**< error of each level, the finest first */
} neph_bake_error;

#define NEPH_BAKE_ERROR_DEFAULT                                                                                        \
  { .struct_size = sizeof(neph_bake_error) }

typedef struct neph_bake_desc {
  size_t struct_size;
  double planet_radius_m;        /**< altitudes follow this sphere; > 0 (default 6360 km) */
  neph_precision precision;      /**< precision of the volume in memory (default NEPH_PRECISION_HALF) */
  neph_precision file_precision; /**< precision of values in a file (default NEPH_PRECISION_FLOAT) */
  double prune_per_m;            /**< smaller extinction is left out; ≥ 0 (default 0) */
  unsigned level_count;          /**< grids in a file, each with voxels twice as long as the one before: "density",
                                      "density_2", "density_4", …; 1 to NEPH_BAKE_LEVELS_MAX (default 1) */
  bool has_velocity;             /**< adds a grid "vel" to a file: velocity in m/s by which wind and growth move the
                                      extinction, at its active voxels; the wind elsewhere (default false) */
  neph_bake_error *error;        /**< receives the error of the file of neph_cloud_bake_file, starting from
                                      NEPH_BAKE_ERROR_DEFAULT; NULL (default): not measured */
  bool has_region;               /**< bakes only the box from region_min_m to region_max_m (default false) */
  double region_min_m[3];        /**< corner of the region in the world (default 0, 0, 0) */
  double region_max_m[3];        /**< opposite corner, greater in each coordinate (default 0, 0, 0) */
  unsigned lod_count; /**< number of voxel sizes: voxel_m near the viewer, 2, 4, … times that farther away, none
                           above an eighth of the thickness. Each place is stored at one size, and all sizes
                           sample one model; 1 to NEPH_BAKE_LODS_MAX; values above 1 require a level_count of 1
                           (default 1) */
  double lod_viewer_min_m[3]; /**< box of the world that holds all viewers (default 0, 0, 0) */
  double lod_viewer_max_m[3]; /**< opposite corner of the box, no less in any coordinate (default 0, 0, 0) */
  double lod_angle_rad;       /**< largest angle of a voxel as seen from the viewer, while there is a smaller size; > 0
                                   (default 0.002) */
  uint64_t memory_max_bytes;  /**< a bake that may need more is refused, as is one that may need more than the
                                   machine has (default NEPH_MEMORY_UNLIMITED) */
  neph_progress_fn progress;  /**< default NULL */
  void *progress_user;        /**< default NULL */
} neph_bake_desc;

#define NEPH_BAKE_DESC_DEFAULT                                                                                         \
  {                                                                                                                    \
    .struct_size = sizeof(neph_bake_desc), .planet_radius_m = 6360000.0, .precision = NEPH_PRECISION_HALF,             \
    .file_precision = NEPH_PRECISION_FLOAT, .prune_per_m = 0, .level_count = 1, .has_velocity = false, .error = NULL,  \
    .has_region = false, .region_min_m = {0, 0, 0}, .region_max_m = {0, 0, 0}, .lod_count = 1,                         \
    .lod_viewer_min_m = {0, 0, 0}, .lod_viewer_max_m = {0, 0, 0}, .lod_angle_rad = 0.002,                              \
    .memory_max_bytes = NEPH_MEMORY_UNLIMITED, .progress = NULL, .progress_user = NULL                                 \
  }

/** Bakes a cloud to a volume whose values are extinction in 1/m. The same bits for any thread count and level. */
NEPH_API neph_result neph_cloud_bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                     neph_volume **out_volume) NEPH_NODISCARD;

/** Bakes a cloud straight to a file, .vdb or .nvdb by its ending: a fog volume of extinction in 1/m, with its
 * parameters, seed and hash. In a .nvdb values of half precision are rounded to half and stored as floats.
 *
 * With desc->lod_count above 1 each place is stored in one of several files, one file for each size of voxels:
 * "cloud.lod1.vdb", "cloud.lod2.vdb", … beside "cloud.vdb", the smallest. neph_volume_load reads all of them as one
 * volume by the name of the first. Region, velocity and error apply to all files together; files of adjacent regions
 * have the voxels of the whole, level by level. */
NEPH_API neph_result neph_cloud_bake_file(neph_context *context, const neph_cloud_desc *cloud,
                                          const neph_bake_desc *desc, const char *name,
                                          const char *path) NEPH_NODISCARD;

/** Rebakes a file of neph_cloud_bake_file from the parameters in it, and compares.
 *
 * @param out_is_same  whether its grids hold the same voxels and values, bit for bit.
 */
NEPH_API neph_result neph_cloud_verify_file(neph_context *context, const char *path, neph_progress_fn progress,
                                            void *progress_user, bool *out_is_same) NEPH_NODISCARD;

/** Layout of the picture of a weather map from above that neph_cloud_save_map writes. Boxes are in world x and y. */
typedef struct neph_map_picture {
  size_t struct_size;
  unsigned panel_count;               /**< number of panels, side by side from the left, one for each quantity of the
                                           map */
  unsigned panel_width, panel_height; /**< pixels */
  unsigned gap;                       /**< pixels between two panels */
  double pixel_m;                     /**< edge of a pixel */
  double panel_min_m[2], panel_max_m[2];
  double field_min_m[2], field_max_m[2];     /**< box of the field, which is outlined in red */
  double painted_min_m[2], painted_max_m[2]; /**< box of the map's picture, or of one repetition where it repeats */
  const char *quantities[NEPH_CLOUD_MAP_QUANTITY_COUNT]; /**< quantity of each panel; valid for ever */
} neph_map_picture;

#define NEPH_MAP_PICTURE_DEFAULT                                                                                       \
  { .struct_size = sizeof(neph_map_picture) }

/** Writes a PNG of a cloud's weather map from above, north up: the picture where the wind has carried it at the cloud's
 * time, in grey or a hue, the value v as 255·v of sRGB, dimmed beyond the field. A blue line shows where a picture
 * ends that does not repeat.
 *
 * @param cloud        one with a map_file and no shape.
 * @param path         NULL: the map is read, and nothing is written.
 * @param out_picture  starts from NEPH_MAP_PICTURE_DEFAULT; NULL is allowed.
 */
NEPH_API neph_result neph_cloud_save_map(neph_context *context, const neph_cloud_desc *cloud, const char *path,
                                         neph_map_picture *out_picture) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
