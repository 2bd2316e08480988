/* SPDX-License-Identifier: Apache-2.0 */
/* Procedural clouds: parameters in the words people use, baked to a volume. */
#ifndef NEPHOS_CLOUD_H
#define NEPHOS_CLOUD_H

#include <nephos/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What grows: a weather map of cells, a height profile, Perlin-Worley billows, Worley erosion, curl distortion.
 * Altitudes are above sea level. */
typedef struct neph_cloud_desc {
  size_t struct_size;
  uint64_t seed;             /**< any (default 0) */
  double extent_m[2];        /**< size along x and y, centred on `center_m`; > 0 (default 8 km × 8 km) */
  double center_m[2];        /**< of the field (default 0, 0) */
  double base_altitude_m;    /**< of the flat cloud base (default 1200) */
  double thickness_m;        /**< from base to the highest top; > 0 (default 1200) */
  double voxel_m;            /**< edge of a voxel; > 0 (default 20) */
  double coverage;           /**< fraction of the sky covered, 0 to 1 (default 0.35) */
  double cell_m;             /**< typical spacing of cloud cells; > 0 (default 1800) */
  double type;               /**< 0 humilis (flat), 1 congestus (tall): lower and raise tops (default 0.5) */
  double billow_m;           /**< size of the largest billows; > 0 (default 450) */
  double erosion;            /**< how far detail eats into the shape, 0 to 1 (default 0.4) */
  double wispiness;          /**< share of wispy rather than billowy detail at the base, 0 to 1 (default 0.3) */
  double turbulence;         /**< curl distortion of the detail, 0 to 1 (default 0.3) */
  double skew_m[2];          /**< displacement of the top against the base by wind, x and y (default 0, 0) */
  double extinction_per_m;   /**< in the core of the cloud; > 0 (default 0.06) */
} neph_cloud_desc;

#define NEPH_CLOUD_DESC_DEFAULT                                                                                        \
  {                                                                                                                    \
    .struct_size = sizeof(neph_cloud_desc), .seed = 0, .extent_m = {8000, 8000}, .center_m = {0, 0},                   \
    .base_altitude_m = 1200, .thickness_m = 1200, .voxel_m = 20, .coverage = 0.35, .cell_m = 1800, .type = 0.5,        \
    .billow_m = 450, .erosion = 0.4, .wispiness = 0.3, .turbulence = 0.3, .skew_m = {0, 0}, .extinction_per_m = 0.06   \
  }

/** Fills a description from a named preset ("cumulus_mediocris", …); fails listing the names there are. */
NEPH_API neph_result neph_cloud_get_preset(neph_context *context, const char *name,
                                           neph_cloud_desc *out_desc) NEPH_NODISCARD;

typedef struct neph_bake_desc {
  size_t struct_size;
  double planet_radius_m;    /**< altitudes follow this sphere; > 0 (default 6360 km) */
  neph_precision precision;  /**< of the volume in memory (default NEPH_PRECISION_HALF) */
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
} neph_bake_desc;

#define NEPH_BAKE_DESC_DEFAULT                                                                                         \
  {                                                                                                                    \
    .struct_size = sizeof(neph_bake_desc), .planet_radius_m = 6360000.0, .precision = NEPH_PRECISION_HALF,             \
    .progress = NULL, .progress_user = NULL                                                                            \
  }

/** Bakes a cloud to a volume whose values are extinction in 1/m. The same bits for any thread count and level. */
NEPH_API neph_result neph_cloud_bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                     neph_volume **out_volume) NEPH_NODISCARD;

/** Bakes a cloud straight to a .vdb file: a fog volume of extinction in 1/m, with its parameters, seed and hash. */
NEPH_API neph_result neph_cloud_bake_file(neph_context *context, const neph_cloud_desc *cloud,
                                          const neph_bake_desc *desc, const char *name,
                                          const char *path) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
