/* SPDX-License-Identifier: Apache-2.0 */
/* Volumes: scalar fields on voxel grids, read from .vdb and .nvdb files, created from arrays, or baked. Immutable and
 * shared. */
#ifndef NEPHOS_VOLUME_H
#define NEPHOS_VOLUME_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/** One scalar grid with its transform: a FloatGrid of class fog volume in OpenVDB. */
typedef struct neph_volume neph_volume;

/** Precision of samples in memory. */
typedef enum neph_precision {
  NEPH_PRECISION_HALF, /**< 16 bits beside a power of two per volume: relative error ≤ 2⁻¹¹ */
  NEPH_PRECISION_FLOAT /**< 32 bits */
} neph_precision;

/** Policy for values that a cloud cannot have: NaN, infinite, negative beyond rounding. */
typedef enum neph_import_policy {
  NEPH_IMPORT_REFUSE, /**< fail, naming grid, voxel and count */
  NEPH_IMPORT_REPAIR  /**< take them as 0, counted in a warning */
} neph_import_policy;

/** Value between the samples of a grid. */
typedef enum neph_interpolation {
  NEPH_INTERPOLATION_LINEAR, /**< trilinear */
  NEPH_INTERPOLATION_NEAREST /**< the nearest sample's, so that a step from sample to sample stays sharp */
} neph_interpolation;

/** Map from a file's values v to a density: gain · max(v + offset, 0)^gamma where v > low_cut, else 0. */
typedef struct neph_volume_ramp {
  double low_cut, offset, gain, gamma; /**< default 0, 0, 1, 1: v; low_cut and gain ≥ 0, gamma > 0 */
} neph_volume_ramp;

/** Handling of a time step that a file has not. */
typedef enum neph_step_beyond {
  NEPH_STEP_REFUSE, /**< fail, naming the steps of the file */
  NEPH_STEP_EMPTY,  /**< no cloud, with a warning */
  NEPH_STEP_HOLD,   /**< the nearest step */
  NEPH_STEP_LOOP    /**< steps repeat */
} neph_step_beyond;

/** The field of an atmospheric model in a NetCDF file. Names of variables are NULL for those of the model's convention
 * or of the CF conventions, "none" for no such variable. */
typedef struct neph_volume_model {
  const char *variable;    /**< liquid water: a mixing ratio or a content; default NULL */
  const char *ice;         /**< ice: a mixing ratio or a content; default NULL */
  const char *radius;      /**< effective radius of the droplets; default NULL */
  const char *number;      /**< number of droplets in a volume or in a mass of air; default NULL */
  double r_eff_m;          /**< effective radius of the droplets; default 0: the file's, or that of their number, or
                                10 um */
  double ice_r_eff_m;      /**< effective radius of the ice; default 0: the file's, or 30 um */
  double number_per_m3;    /**< number of droplets in a volume, from which their size follows; default 0: the file's */
  double dispersion;       /**< cube of the droplets' mean volume radius over that of their effective radius, 0 to 1;
                                default 0.8, over the sea */
  double spacing_m;        /**< height of a voxel; default 0: that of even levels, else of the thinnest level */
  double step;             /**< time step, from 1; default 1 */
  neph_step_beyond beyond; /**< default NEPH_STEP_REFUSE */
} neph_volume_model;

typedef struct neph_volume_load_desc {
  size_t struct_size;
  const char *grid;          /**< name of a grid of numbers or marks, in letters of either case where none is just so,
                                  "name[1]" for the second of that name, or "name + other" for the sum of up to 16;
                                  NULL (default): "density" if there is one, else the only fog volume of floats */
  neph_precision precision;  /**< default NEPH_PRECISION_HALF */
  neph_import_policy policy; /**< default NEPH_IMPORT_REFUSE */
  double level_set_voxels;   /**< voxels below its surface at which a level set is 1, rising from 0 at it; default 0:
                                  level sets are refused */
  neph_volume_ramp ramp;
  neph_progress_fn progress; /**< default NULL */
  void *progress_user;       /**< default NULL */
  bool is_halved;            /**< voxels are twice as long, each the mean of eight; with levels of detail, the finest
                                  level is merged into the next (default false) */
  neph_interpolation interpolation; /**< default NEPH_INTERPOLATION_LINEAR */
  double repeat_m[2];    /**< period along x and along y, in metres of the file: a whole number of its voxels, at least
                              the box of its active voxels; NEPH_REPEAT_FILE: that box; 0 (default): no repetition */
  double repeat_voxel_m; /**< length of the largest voxel edge by which repeat_m is measured; 0 (default): the file's */
  double repeat_reach_m[2]; /**< distance from the first voxel to which it repeats either way along x and along y, at
                               least one period, in metres of the file; 0 (default): without end */
  neph_volume_model model;  /**< reading of NetCDF files */
} neph_volume_load_desc;

#define NEPH_REPEAT_FILE (-1.0)

#define NEPH_VOLUME_LOAD_DESC_DEFAULT                                                                                  \
  {                                                                                                                    \
    .struct_size = sizeof(neph_volume_load_desc), .grid = NULL, .precision = NEPH_PRECISION_HALF,                      \
    .policy = NEPH_IMPORT_REFUSE, .level_set_voxels = 0.0, .ramp = {0.0, 0.0, 1.0, 1.0}, .progress = NULL,             \
    .progress_user = NULL, .is_halved = false, .interpolation = NEPH_INTERPOLATION_LINEAR, .repeat_m = {0.0, 0.0},     \
    .repeat_voxel_m = 0.0, .repeat_reach_m = {0.0, 0.0}, .model = {                                                    \
      .dispersion = 0.8,                                                                                               \
      .step = 1.0                                                                                                      \
    }                                                                                                                  \
  }

/** Reads one grid of a .vdb, .nvdb or .nc file. For a bake with levels of detail it also reads the files beside it that
 * hold the other levels.
 *
 * @param desc        NULL for the defaults.
 * @param out_volume  one reference, for the caller; NULL on failure.
 */
NEPH_API neph_result neph_volume_load(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                      neph_volume **out_volume) NEPH_NODISCARD;

/** Reads one grid of a .vdb or .nvdb file that stands in memory, or of NanoVDB grids as nanovdb::GridHandle::data() has
 * them, one behind the other. They are checked as files are, and may stand at any address.
 *
 * @param bytes       byte_count of them, which no other thread changes during the call; copied.
 * @param desc        NULL for the defaults.
 * @param out_volume  one reference, for the caller; NULL on failure. The first of several levels of detail is refused.
 */
NEPH_API neph_result neph_volume_load_memory(neph_context *context, const void *bytes, size_t byte_count,
                                             const neph_volume_load_desc *desc,
                                             neph_volume **out_volume) NEPH_NODISCARD;

typedef struct neph_volume_dense_desc {
  size_t struct_size;
  const char *name;                 /**< default "density" */
  unsigned size[3];                 /**< samples along i, j, k; each ≥ 1 */
  const float *values;              /**< size[0]·size[1]·size[2] of them, i fastest; finite, ≥ 0; copied */
  double index_to_world[3][4];      /**< affine, invertible: index (i, j, k, 1) to metres; sample i sits at index i */
  bool is_periodic_x;               /**< repeats along i (default false) */
  bool is_periodic_y;               /**< repeats along j (default false) */
  neph_precision precision;         /**< default NEPH_PRECISION_HALF */
  neph_interpolation interpolation; /**< default NEPH_INTERPOLATION_LINEAR */
} neph_volume_dense_desc;

#define NEPH_VOLUME_DENSE_DESC_DEFAULT                                                                                 \
  {                                                                                                                    \
    .struct_size = sizeof(neph_volume_dense_desc), .name = "density", .size = {0, 0, 0}, .values = NULL,               \
    .index_to_world = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .is_periodic_x = false, .is_periodic_y = false,      \
    .precision = NEPH_PRECISION_HALF, .interpolation = NEPH_INTERPOLATION_LINEAR                                       \
  }

/** Makes a volume from an array; outside it the value is 0. */
NEPH_API neph_result neph_volume_create_dense(neph_context *context, const neph_volume_dense_desc *desc,
                                              neph_volume **out_volume) NEPH_NODISCARD;

typedef struct neph_volume_sparse_desc {
  size_t struct_size;
  const char *name;            /**< default "density" */
  size_t sample_count;         /**< ≥ 1 */
  const int32_t *coordinates;  /**< sample_count × 3: index i, j, k of each sample, no two alike; copied */
  const float *values;         /**< sample_count of them; finite, ≥ 0; copied */
  double index_to_world[3][4]; /**< affine, invertible: index (i, j, k, 1) to metres; sample i sits at index i */
  neph_precision precision;    /**< default NEPH_PRECISION_HALF */
} neph_volume_sparse_desc;

#define NEPH_VOLUME_SPARSE_DESC_DEFAULT                                                                                \
  {                                                                                                                    \
    .struct_size = sizeof(neph_volume_sparse_desc), .name = "density", .sample_count = 0, .coordinates = NULL,         \
    .values = NULL, .index_to_world = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .precision = NEPH_PRECISION_HALF     \
  }

/** Makes a volume from samples in any order; places without a sample hold 0. Samples of 0 that are left out change the
 * volume's bounds alone. */
NEPH_API neph_result neph_volume_create_sparse(neph_context *context, const neph_volume_sparse_desc *desc,
                                               neph_volume **out_volume) NEPH_NODISCARD;

/** Another reference to the same volume. */
NEPH_API neph_volume *neph_volume_retain(neph_volume *volume);

/** Gives one reference back. NULL is allowed. */
NEPH_API void neph_volume_release(neph_volume *volume);

typedef struct neph_volume_info {
  size_t struct_size;
  const char *name;                        /**< name of the grid; valid as long as the volume */
  double index_to_world[3][4];             /**< index to metres */
  double bounds_min_m[3], bounds_max_m[3]; /**< world box of the active samples */
  uint64_t active_voxel_count;             /**< active voxels of the authored grid, those in tiles included */
  float value_min, value_max;              /**< over the active samples */
  uint64_t grid_bytes;                     /**< memory of the authored grid */
  uint64_t brick_bytes;                    /**< memory of the bricks that the renderer reads */
  uint64_t brick_count;
} neph_volume_info;

#define NEPH_VOLUME_INFO_DEFAULT                                                                                       \
  { .struct_size = sizeof(neph_volume_info) }

/** Contents of a volume.
 *
 * @param out_info  starts from NEPH_VOLUME_INFO_DEFAULT; unchanged on failure, which is that of its struct_size alone.
 */
NEPH_API neph_result neph_volume_get_info(const neph_volume *volume, neph_volume_info *out_info) NEPH_NODISCARD;

/** Trilinear samples.
 *
 * @param positions_m  count × 3 world coordinates.
 * @param out_values   count values in the file's unit; 0 outside.
 */
NEPH_API void neph_volume_sample(const neph_volume *volume, size_t count, const double *positions_m, float *out_values);

/** Describes every grid of a .vdb, .nvdb or .nc file: class, type, transform, bounds in metres, value range, active
 * voxels, memory as a tree and as bricks, metadata.
 *
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_volume_describe_file(neph_context *context, const char *path, neph_text_format format,
                                               char **out_text) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
