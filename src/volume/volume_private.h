/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of a volume, and functions beyond the public API for bake, scene and rendering. */
#ifndef NP_VOLUME_VOLUME_PRIVATE_H
#define NP_VOLUME_VOLUME_PRIVATE_H

#include <stdatomic.h>

#include "volume/bricks.h"
#include "volume/sparse_grid.h"
#include "volume/vdb_table.h"

struct neph_volume {
  atomic_size_t references;
  neph_context *context; /* retained */
  char *name;
  np_affine index_to_world, world_to_index;
  np_bricks bricks;
  struct np_tint *tint;                 /* NULL: no colours, sizes of droplets or levels of detail */
  int32_t active_min[3], active_max[3]; /* index box of the active samples, both ends inclusive */
  float value_min, value_max;           /* range of the active samples */
  double extinction_per_value;          /* extinction of a value of 1 in 1/m, as the file states it; 0: not stated */
  uint64_t active_voxel_count, grid_bytes;
  bool is_halved; /* voxels are twice as long as in the file */
};

neph_context *np_volume_get_context(const neph_volume *volume);

/* Sets the interpolation of a volume that is not shared yet, with its levels and colours. NULL is allowed. */
void np_volume_set_interpolation(neph_volume *volume, neph_interpolation interpolation);

/* Whether a path ends as a file of grids does, ".vdb" or ".nvdb". */
bool np_volume_has_ending(const char *path);

/* neph_volume_load for a scene: for an empty grid, and for a file of a sequence without its density, `*out_volume` is
 * NULL, with a warning. `sequence` is the pattern of the files; NULL: a single file, which must have the density. */
neph_result np_volume_load_density(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                   const char *sequence, neph_volume **out_volume);

/* Reads the density grid of a volume. The caller clears it, after a failure too. */
neph_result np_volume_load_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                const char *sequence, np_sparse_grid *out_grid, bool *out_has_content);

/* Role of a grid, by the scene's keys or by the grid's name and kind. */
typedef enum np_grid_role {
  NP_GRID_DENSITY, /* named "density" in any case, or, if none is, a scalar fog volume */
  NP_GRID_FIELD,   /* another scalar, such as a temperature: not negative, any background */
  NP_GRID_VECTOR,  /* a velocity, a colour, or one of their components: any finite number */
  NP_GRID_OTHER    /* level sets, points, and unused grids */
} np_grid_role;

/* Box along x and y of the domain of a model, of which active voxels may be a part: indices, both ends inclusive. */
typedef struct np_grid_domain {
  bool is_known;
  int32_t min[2], max[2];
} np_grid_domain;

/* Header of a grid, without its values. */
typedef enum np_grid_state { NP_GRID_MISSING, NP_GRID_EMPTY, NP_GRID_FILLED } np_grid_state;

typedef struct np_grid_header {
  np_grid_state state;
  np_affine index_to_world;
  bool has_box; /* the box is stated: OpenVDB writes it, other programs may not */
  int32_t active_min[3], active_max[3];
  double voxel_count;          /* active voxels, tiles by the voxels that they cover; 0: not stated */
  unsigned level, level_count; /* level of detail; level_count 0: not part of several */
  double extinction_per_value; /* extinction of a value of 1 in 1/m, as the file states it; 0: not stated */
  np_grid_domain domain;       /* domain that the file states */
  char name[64];               /* truncated if longer */
} np_grid_header;

/* Reads the header of the grid that np_volume_load_density would load; fails if the file or the grid is missing, or its
 * kind is refused. Of several grids the first one that is not empty is described. NP_GRID_MISSING: a file of a sequence
 * lacks the grid. */
neph_result np_volume_read_header(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                  const char *sequence, np_grid_header *out_header);

/* Warns of a file of a sequence that lacks the density (NP_GRID_MISSING), with a list of its grids. */
void np_volume_warn_of_absence(neph_context *context, const char *cloud, const char *path,
                               const neph_volume_load_desc *desc, const char *sequence);

/* Reads the header of a grid that is not a density. `required_by` is the scene key that requires it; NULL: optional,
 * and NP_GRID_MISSING says that it is not there. */
neph_result np_volume_read_field_header(neph_context *context, const char *path, const char *grid,
                                        const char *required_by, np_grid_header *out_header);

/* Loads a grid named by `desc` that is not a density: any background is valid. `*out_volume` is NULL for an empty grid,
 * with a warning, and for an optional grid that is missing; `out_is_in_file` says which, and may be NULL if the grid is
 * required. All else as in neph_volume_load. */
neph_result np_volume_load_field(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                 const char *required_by, bool *out_is_in_file, neph_volume **out_volume);

/* Reads the grid of a field; empty if it is optional and missing. The caller clears it, after a failure too. */
neph_result np_volume_load_field_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                      const char *required_by, np_sparse_grid *out_grid, bool *out_has_content);

/* Roles of the vector grids beside the density. */
typedef enum np_vector_role {
  NP_VECTOR_VELOCITY, /* vel, v or velocity: file lengths a second */
  NP_VECTOR_COLOR,    /* Cd, color or albedo: factor on the cloud's albedo */
  NP_VECTOR_EMISSION  /* Ce, emission or emit: radiance per metre */
} np_vector_role;

typedef struct np_vector_request {
  np_vector_role role;
  const char *name; /* name of one vector grid, or common prefix of three scalars; NULL: the usual names */
  neph_import_policy policy;
} np_vector_request;

/* Reads the three components of a vector, sorted, from one vector grid or three scalars. If `name` is NULL and none of
 * the usual names exists, `*out_is_found` is false. The caller clears the grids, whatever the outcome. */
neph_result np_volume_load_vector(neph_context *context, const char *path, const np_vector_request *request,
                                  np_monitor *monitor, np_sparse_grid out_vector[3], bool *out_is_found);

/* Reads the velocities of a cloud, three grids for each level of detail, the finest first; `out_grids` has room for the
 * most levels. `*out_level_count` is 0 if the file has no velocity. */
neph_result np_volume_load_velocities(neph_context *context, const char *path, const np_vector_request *request,
                                      np_monitor *monitor, np_sparse_grid *out_vectors, unsigned *out_level_count);

/* Searches a vector without reading its values. */
neph_result np_volume_search_vector(neph_context *context, const char *path, np_vector_role role, const char *name,
                                    bool *out_is_found);

/* Builds a volume from a grid of valid values: finite, not negative, background 0. The caller clears the grid, even if
 * it is consumed. `monitor` may be NULL. */
neph_result np_volume_create_from_grid(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                                       np_monitor *monitor, neph_volume **out_volume);

/* Creates a volume that repeats by the periods of `desc`, which count the grid's voxels, from a grid of valid values
 * with some active voxels. Periods that are no whole number of voxels, or less than the domain or else the box of
 * active voxels, are refused. A domain that does not hold them all is passed over. */
neph_result np_volume_create_repeating(const np_sparse_grid *grid, const neph_volume_load_desc *desc,
                                       const np_grid_domain *domain, np_monitor *monitor, neph_volume **out_volume);

/* Creates a volume of a grid with periods in voxels, multiples of 8 (np_bricks_build), whose active samples, of one
 * period, lie in `extent`. */
neph_result np_volume_create_periodic(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                                      const int32_t period[2], const np_grid_extent *extent, np_monitor *monitor,
                                      neph_volume **out_volume);

/* Writes grids as fog volumes to a .vdb file, which appears complete or not at all. Each grid carries its attributes,
 * its creator and its hash (`nephos:hash`). `monitor` may be NULL. */
neph_result np_volume_save_grids(neph_context *context, const char *path, const np_vdb_write_grid *grids, size_t count,
                                 np_monitor *monitor);

/* Largest integral of the value along world-vertical lines, in value·metres, for a volume placed by `index_to_world`.
 * The lines pass through the samples of the middle layer of the active box, extended to the box's vertical projection.
 * The trilinear field is integrated exactly along each line. */
neph_result np_volume_get_column_max(const neph_volume *volume, const np_affine *index_to_world, np_monitor *monitor,
                                     double *out_value_m);

/* World box around a box of index positions. */
void np_volume_bound_box(const np_affine *affine, const int32_t low[3], const int32_t high[3], double out_min[3],
                         double out_max[3]);

/* Table of the module, loaded on first need. On failure the message lists the paths tried. */
neph_result np_vdb_module_get(neph_context *context, const np_vdb_module **out_module);

/* Saves a volume to a cache entry, and loads it; NULL if the entry is not a valid volume. */
struct np_cache_entry;
void np_volume_save_to_cache(const neph_volume *volume, struct np_cache_entry *entry);
neph_result np_volume_load_from_cache(neph_context *context, struct np_cache_entry *entry, neph_volume **out_volume);

/* Whether the module of np_vdb_module_get can be loaded; logs nothing. */
bool np_vdb_module_is_present(neph_context *context);

#endif
