/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain: height fields on the curved planet. Immutable and shared once made. */
#ifndef NEPHOS_TERRAIN_H
#define NEPHOS_TERRAIN_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct neph_terrain neph_terrain;

/** Position and material of a height field. */
typedef struct neph_terrain_desc {
  size_t struct_size;
  double planet_radius_m;    /**< heights stand on this sphere; > 0 (default 6360 km) */
  bool has_place;            /**< whether latitude and longitude are given (default false: the file's centre) */
  double latitude_rad;       /**< of the world origin, −π/2 to π/2 (default 0) */
  double longitude_rad;      /**< of the world origin (default 0) */
  double width_m;            /**< along x, of pictures and procedural fields; > 0 (default 30 km) */
  double height_min_m;       /**< elevation of value 0 in PNG; EXR is in metres (default 0) */
  double height_max_m;       /**< elevation of value 1 in PNG (default 2000) */
  double ground_albedo[3];   /**< Lambert, 0 to 1 (default 0.2 each) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_terrain_desc;

#define NEPH_TERRAIN_DESC_DEFAULT                                                                                      \
  {                                                                                                                    \
    .struct_size = sizeof(neph_terrain_desc), .planet_radius_m = 6360000.0, .has_place = false, .latitude_rad = 0,     \
    .longitude_rad = 0, .width_m = 30000.0, .height_min_m = 0, .height_max_m = 2000.0,                                 \
    .ground_albedo = {0.2, 0.2, 0.2}, .progress = NULL, .progress_user = NULL                                          \
  }

/** Reads SRTM .hgt (a name that starts with the corner), 16-bit grey PNG, or EXR of one channel (or Y or Z beside one
 * other), and builds the ray-tracing structure. */
NEPH_API neph_result neph_terrain_load(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                       neph_terrain **out_terrain) NEPH_NODISCARD;

typedef struct neph_ridges_desc {
  size_t struct_size;
  uint64_t seed;         /**< any (default 1) */
  unsigned sample_count; /**< samples along each side, 2 to 16385 (default 1025) */
  double relief_m;       /**< from valleys to summits; ≥ 0 (default 1400) */
  double ridge_m;        /**< spacing of the largest ridges; > 0 (default 9 km) */
} neph_ridges_desc;

#define NEPH_RIDGES_DESC_DEFAULT                                                                                       \
  { .struct_size = sizeof(neph_ridges_desc), .seed = 1, .sample_count = 1025, .relief_m = 1400.0, .ridge_m = 9000.0 }

/** Makes ridged mountains from noise, so that a scene needs no file. */
NEPH_API neph_result neph_terrain_create_ridges(neph_context *context, const neph_ridges_desc *ridges,
                                                const neph_terrain_desc *desc,
                                                neph_terrain **out_terrain) NEPH_NODISCARD;

/** Another reference to the same terrain. */
NEPH_API neph_terrain *neph_terrain_retain(neph_terrain *terrain);

/** Gives one reference back. NULL is allowed. */
NEPH_API void neph_terrain_release(neph_terrain *terrain);

/** Elevation of the ground above sea level at a world x, y; 0 beyond the terrain. */
NEPH_API double neph_terrain_get_elevation_m(const neph_terrain *terrain, double x_m, double y_m);

/** Size, spacing, range, voids and place of a height field as text, to be freed with neph_text_destroy. */
NEPH_API neph_result neph_terrain_describe_file(neph_context *context, const char *path, neph_text_format format,
                                                char **out_text) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
