/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain: height fields on the curved planet. Immutable and shared. */
#ifndef NEPHOS_TERRAIN_H
#define NEPHOS_TERRAIN_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct neph_terrain neph_terrain;

/** Ground beyond the border of a height field. A border at sea level fades, except for NEPH_TERRAIN_EDGE_WALL. */
typedef enum neph_terrain_edge {
  NEPH_TERRAIN_EDGE_INFINITE, /**< land continues at the border's height, and descends behind the horizon */
  NEPH_TERRAIN_EDGE_FADE,     /**< heights fade to the sphere over the outer 5 % of the field's width */
  NEPH_TERRAIN_EDGE_WALL      /**< heights are the file's up to the border, from which a wall leads to the sphere */
} neph_terrain_edge;

/** Unit of the heights in a file. */
typedef enum neph_height_unit {
  NEPH_HEIGHT_UNIT_FILE, /**< the file's unit; metres where it names none */
  NEPH_HEIGHT_UNIT_METRE,
  NEPH_HEIGHT_UNIT_FOOT,          /**< 0.3048 m */
  NEPH_HEIGHT_UNIT_US_SURVEY_FOOT /**< 1200/3937 m */
} neph_height_unit;

/** Meaning of the samples in a file. */
typedef enum neph_height_encoding {
  NEPH_HEIGHT_ENCODING_VALUES,      /**< heights */
  NEPH_HEIGHT_ENCODING_TERRAIN_RGB, /**< 8-bit colours: −10000 m + 0.1 m·(65536·R + 256·G + B) */
  NEPH_HEIGHT_ENCODING_TERRARIUM    /**< 8-bit colours: 256·R + G + B/256 − 32768 m */
} neph_height_encoding;

/** Samples of a file that has no header (.r16, .raw). */
typedef enum neph_raw_type {
  NEPH_RAW_TYPE_UINT16, /**< the range from height_min_m to height_max_m */
  NEPH_RAW_TYPE_INT16,  /**< m */
  NEPH_RAW_TYPE_FLOAT32 /**< m */
} neph_raw_type;

/** Axis of a mesh's file that points up. With y, its −z is north. */
typedef enum neph_mesh_up {
  NEPH_MESH_UP_FILE, /**< the format's axis: y in glTF; formats without one are refused */
  NEPH_MESH_UP_Y,
  NEPH_MESH_UP_Z
} neph_mesh_up;

/** Point of a mesh that stands at its position. */
typedef enum neph_mesh_pivot {
  NEPH_MESH_PIVOT_BASE,   /**< middle of the bottom of its box */
  NEPH_MESH_PIVOT_CENTER, /**< middle of its box */
  NEPH_MESH_PIVOT_ORIGIN  /**< [0, 0, 0] of its file */
} neph_mesh_pivot;

/** Normals of a mesh. */
typedef enum neph_mesh_normals {
  NEPH_MESH_NORMALS_SMOOTH, /**< the file's; where it has none, means of the triangles about each vertex */
  NEPH_MESH_NORMALS_FLAT    /**< normals of each triangle */
} neph_mesh_normals;

/** Albedo by climate: vegetation, fields, sand, rock and snow by height, slope, aspect and noise. */
typedef enum neph_ground_cover {
  NEPH_GROUND_COVER_NONE,      /**< ground_albedo or albedo_image */
  NEPH_GROUND_COVER_TEMPERATE, /**< meadows, fields and forests; rock above */
  NEPH_GROUND_COVER_ALPINE,    /**< forests to 1250 m, scree and rock, snow from 1700 m */
  NEPH_GROUND_COVER_DESERT,    /**< sand and gravel, dark rock on slopes */
  NEPH_GROUND_COVER_SAVANNA    /**< dry grass with trees */
} neph_ground_cover;

/** Triangles from a file that Assimp reads (.gltf, .glb, .obj, .ply, .stl, .fbx, .dae). Nodes may place one mesh many
 * times: its triangles are stored once. Both sides are ground; holes are open. */
typedef struct neph_mesh_desc {
  size_t struct_size;
  neph_mesh_up up;           /**< default NEPH_MESH_UP_FILE */
  double unit_m;             /**< length of the file's unit; > 0 (default 1) */
  double rotation_rad;       /**< rotation about the vertical, counter-clockwise seen from above (default 0) */
  bool has_position;         /**< whether position_m is given (default false: coordinates are the world's) */
  double position_m[3];      /**< world point at which the pivot stands (default 0) */
  neph_mesh_pivot pivot;     /**< default NEPH_MESH_PIVOT_BASE */
  neph_mesh_normals normals; /**< default NEPH_MESH_NORMALS_SMOOTH */
} neph_mesh_desc;

#define NEPH_MESH_DESC_DEFAULT                                                                                         \
  {                                                                                                                    \
    .struct_size = sizeof(neph_mesh_desc), .up = NEPH_MESH_UP_FILE, .unit_m = 1.0, .rotation_rad = 0,                  \
    .has_position = false, .position_m = {0, 0, 0}, .pivot = NEPH_MESH_PIVOT_BASE, .normals = NEPH_MESH_NORMALS_SMOOTH \
  }

/** Position and material of a height field, of a mesh, or of both. */
typedef struct neph_terrain_desc {
  size_t struct_size;
  double planet_radius_m;         /**< heights stand on this sphere; > 0 (default 6360 km) */
  bool has_place;                 /**< whether latitude and longitude are given (default false: the file's centre) */
  double latitude_rad;            /**< latitude of the world origin, −π/2 to π/2 (default 0) */
  double longitude_rad;           /**< longitude of the world origin (default 0) */
  double width_m;                 /**< width along x of pictures and procedural fields; > 0 (default 30 km) */
  bool has_width;                 /**< whether width_m is given: georeferenced files refuse one (default false) */
  double height_min_m;            /**< elevation of value 0 in PNG and raw; EXR is in metres (default 0) */
  double height_max_m;            /**< elevation of full scale in PNG and raw (default 2000) */
  neph_terrain_edge edge;         /**< default NEPH_TERRAIN_EDGE_INFINITE */
  const char *crs;                /**< coordinate system in place of the file's: EPSG:32611, WKT, PROJ (default NULL) */
  neph_height_unit unit;          /**< unit of heights (default NEPH_HEIGHT_UNIT_FILE) */
  neph_height_encoding encoding;  /**< default NEPH_HEIGHT_ENCODING_VALUES */
  unsigned raw_size[2];           /**< samples along x and y of a file without header (default 0: none given) */
  neph_raw_type raw_type;         /**< default NEPH_RAW_TYPE_UINT16 */
  bool raw_is_big_endian;         /**< high bytes first (default false) */
  double ground_albedo[3];        /**< Lambert, 0 to 1 (default 0.2 each) */
  const char *albedo_image;       /**< PNG (sRGB) or EXR (linear) in place of ground_albedo, north up, over the field
                                       (default NULL) */
  bool has_rock;                  /**< rock on steep slopes (default false) */
  double rock_albedo[3];          /**< 0 to 1 (default 0.13, 0.12, 0.11) */
  double rock_slope_rad;          /**< slope above which rock lies bare, 0 to π/2 (default 35°) */
  bool has_snow;                  /**< snow on high ground (default false) */
  double snow_albedo[3];          /**< 0 to 1 (default 0.86, 0.88, 0.9) */
  double snow_level_m;            /**< elevation above which snow lies (default 1500) */
  double snow_slope_rad;          /**< slope above which none stays, 0 to π/2 (default 50°) */
  neph_progress_fn progress;      /**< default NULL */
  void *progress_user;            /**< default NULL */
  const char *mesh_file;          /**< triangles beside the height field (default NULL) */
  const neph_mesh_desc *mesh;     /**< NULL: the default (default NULL) */
  neph_ground_cover ground_cover; /**< in place of ground_albedo and albedo_image; its surface is rough (default
                                       NEPH_GROUND_COVER_NONE) */
} neph_terrain_desc;

#define NEPH_TERRAIN_DESC_DEFAULT                                                                                      \
  {                                                                                                                    \
    .struct_size = sizeof(neph_terrain_desc), .planet_radius_m = 6360000.0, .has_place = false, .latitude_rad = 0,     \
    .longitude_rad = 0, .width_m = 30000.0, .has_width = false, .height_min_m = 0, .height_max_m = 2000.0,             \
    .edge = NEPH_TERRAIN_EDGE_INFINITE, .crs = NULL, .unit = NEPH_HEIGHT_UNIT_FILE,                                    \
    .encoding = NEPH_HEIGHT_ENCODING_VALUES, .raw_size = {0, 0}, .raw_type = NEPH_RAW_TYPE_UINT16,                     \
    .raw_is_big_endian = false, .ground_albedo = {0.2, 0.2, 0.2}, .albedo_image = NULL, .has_rock = false,             \
    .rock_albedo = {0.13, 0.12, 0.11}, .rock_slope_rad = 0.6108652381980153, .has_snow = false,                        \
    .snow_albedo = {0.86, 0.88, 0.9}, .snow_level_m = 1500.0, .snow_slope_rad = 0.8726646259971648, .progress = NULL,  \
    .progress_user = NULL, .mesh_file = NULL, .mesh = NULL, .ground_cover = NEPH_GROUND_COVER_NONE                     \
  }

/** Reads a height field and builds the ray-tracing structure: SRTM .hgt (a name that starts with the corner), 16-bit
 * grey PNG, EXR of one channel (or Y or Z beside one other), .r16 or .raw, or, by GDAL, GeoTIFF and other georeferenced
 * rasters. A name with * or ? stands for all files that fit, side by side. */
NEPH_API neph_result neph_terrain_load(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                       neph_terrain **out_terrain) NEPH_NODISCARD;

typedef struct neph_ridges_desc {
  size_t struct_size;
  uint64_t seed;         /**< any (default 1) */
  unsigned sample_count; /**< samples along each side, 2 to 16385 (default 1025) */
  double relief_m;       /**< height of summits above valleys; ≥ 0 (default 1400) */
  double ridge_m;        /**< spacing of the largest ridges; > 0 (default 9 km) */
} neph_ridges_desc;

#define NEPH_RIDGES_DESC_DEFAULT                                                                                       \
  { .struct_size = sizeof(neph_ridges_desc), .seed = 1, .sample_count = 1025, .relief_m = 1400.0, .ridge_m = 9000.0 }

/** Makes ridged mountains from noise, so that a scene needs no file. */
NEPH_API neph_result neph_terrain_create_ridges(neph_context *context, const neph_ridges_desc *ridges,
                                                const neph_terrain_desc *desc,
                                                neph_terrain **out_terrain) NEPH_NODISCARD;

/** Makes a terrain of the triangles of desc->mesh_file alone. The planet's sphere stays the ground wherever it lies
 * above them. A picture of the albedo spreads over the mesh's box. */
NEPH_API neph_result neph_terrain_load_mesh(neph_context *context, const neph_terrain_desc *desc,
                                            neph_terrain **out_terrain) NEPH_NODISCARD;

/** Another reference to the same terrain. */
NEPH_API neph_terrain *neph_terrain_retain(neph_terrain *terrain);

/** Gives one reference back. NULL is allowed. */
NEPH_API void neph_terrain_release(neph_terrain *terrain);

/** Elevation above sea level of the ground at a world x, y, of a mesh its highest; 0 beyond the terrain. */
NEPH_API double neph_terrain_get_elevation_m(const neph_terrain *terrain, double x_m, double y_m);

/** Size, spacing, range, voids and place of a height field as text, to be freed with neph_text_destroy. */
NEPH_API neph_result neph_terrain_describe_file(neph_context *context, const char *path, neph_text_format format,
                                                char **out_text) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
