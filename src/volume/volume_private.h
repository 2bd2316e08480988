/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of a volume, and what bake, scene and render need of it beyond the public calls. */
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
  struct np_tint *tint;                 /* NULL: it has no colours, or is not to show them */
  int32_t active_min[3], active_max[3]; /* index box of the active samples, both ends inside it */
  float value_min, value_max;           /* over the active samples */
  double extinction_per_value;          /* 1/m, as its file states it; 0: it does not */
  uint64_t active_voxel_count, grid_bytes;
  bool is_halved; /* voxels are twice as long as its file's */
};

neph_context *np_volume_get_context(const neph_volume *volume);

/* As neph_volume_load, but a grid that holds nothing makes `*out_volume` NULL, with a warning; so does a file of a
 * sequence without its density. `sequence` is the pattern of its files; NULL: a file by itself, which
 * must have it. */
neph_result np_volume_load_density(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                   const char *sequence, neph_volume **out_volume);

/* The grid that such a volume is made of. The caller clears it, whatever the outcome. */
neph_result np_volume_load_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                const char *sequence, np_sparse_grid *out_grid, bool *out_has_content);

/* Purposes of grids: those that a scene gives them, or else those of their names and kinds. */
typedef enum np_grid_role {
  NP_GRID_DENSITY, /* "density", in letters of either case, or, where none is so called, any scalar of fog */
  NP_GRID_FIELD,   /* another scalar, such as a temperature: not negative, and of any background */
  NP_GRID_VECTOR,  /* a velocity, a colour, or a component of one: any finite number */
  NP_GRID_OTHER    /* level sets, points, and what is not used */
} np_grid_role;

/* Description of a grid by the file's header. */
typedef enum np_grid_state { NP_GRID_MISSING, NP_GRID_EMPTY, NP_GRID_FILLED } np_grid_state;

typedef struct np_grid_header {
  np_grid_state state;
  np_affine index_to_world;
  bool has_box; /* written down: OpenVDB does, others need not */
  int32_t active_min[3], active_max[3];
  double voxel_count;          /* active ones, tiles with all that they fill; 0: not written down */
  unsigned level, level_count; /* of detail; 0: it is in none */
  double extinction_per_value; /* 1/m, as the file states it; 0: it does not */
  char name[64];               /* as much of it as fits */
} np_grid_header;

/* Opens a file and finds a grid in it, as np_volume_load_density does, without reading its values; fails where loading
 * would for want of a file or a grid, or for a grid's kind. Of several grids the first that holds anything is
 * described; NP_GRID_MISSING: a file of a sequence lacks it. */
neph_result np_volume_read_header(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                  const char *sequence, np_grid_header *out_header);

/* Warns of a file of a sequence that lacks the density, NP_GRID_MISSING, with the grids that it has. */
void np_volume_warn_of_absence(neph_context *context, const char *cloud, const char *path,
                               const neph_volume_load_desc *desc, const char *sequence);

/* The header of a grid that is no density. `required_by` is the key of the scene for which it must be there; NULL: it
 * need not, and NP_GRID_MISSING says that it is not. */
neph_result np_volume_read_field_header(neph_context *context, const char *path, const char *grid,
                                        const char *required_by, np_grid_header *out_header);

/* Reads a grid, named by `desc`, that is no density: where it ends it may have any value, and one that holds nothing,
 * which draws a warning, or that is not required and not in the file, makes `*out_volume` NULL. `out_is_in_file` tells
 * which, and may be NULL where the grid is required. All else as neph_volume_load. */
neph_result np_volume_load_field(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                 const char *required_by, bool *out_is_in_file, neph_volume **out_volume);

/* The grid of such a field; nothing where it is not required, and not in the file. The caller clears it, whatever the
 * outcome. */
neph_result np_volume_load_field_grid(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                      const char *required_by, np_sparse_grid *out_grid, bool *out_has_content);

/* Vectors that a file has beside its density. */
typedef enum np_vector_role {
  NP_VECTOR_VELOCITY, /* vel, v or velocity: lengths of the file a second */
  NP_VECTOR_COLOR,    /* Cd, color or albedo: the share of the cloud's albedo */
  NP_VECTOR_EMISSION  /* Ce, emission or emit: radiance a metre */
} np_vector_role;

typedef struct np_vector_request {
  np_vector_role role;
  const char *name; /* of the grid, or of three before what they end in; NULL: the usual ones */
  neph_import_policy policy;
} np_vector_request;

/* Reads a vector, three components, sorted: a grid of vectors, or three of floats. Without a name, and where none of
 * the usual ones is there, `*out_is_found` is false. The caller clears the grids, whatever the outcome. */
neph_result np_volume_load_vector(neph_context *context, const char *path, const np_vector_request *request,
                                  np_monitor *monitor, np_sparse_grid out_vector[3], bool *out_is_found);

/* The velocities of a cloud: of levels of detail those of each file, three grids a level, from the finest on; there is
 * room for as many as there may be. `*out_level_count` is 0 where there are none. */
neph_result np_volume_load_velocities(neph_context *context, const char *path, const np_vector_request *request,
                                      np_monitor *monitor, np_sparse_grid *out_vectors, unsigned *out_level_count);

/* The same without its values. */
neph_result np_volume_search_vector(neph_context *context, const char *path, np_vector_role role, const char *name,
                                    bool *out_is_found);

/* Builds a volume from a grid whose values are a cloud's: finite, not negative, background 0. The grid stays the
 * caller's, to be cleared at least where it is consumed. `monitor` may be NULL. */
neph_result np_volume_create_from_grid(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                                       np_monitor *monitor, neph_volume **out_volume);

/* Writes grids as fog volumes to a .vdb file, which appears complete or not at all. Each grid carries its attributes,
 * its creator and its fingerprint (`nephos:hash`). `monitor` may be NULL. */
neph_result np_volume_save_grids(neph_context *context, const char *path, const np_vdb_write_grid *grids, size_t count,
                                 np_monitor *monitor);

/* The largest integral of the value over world-vertical lines, in value·metres, for a volume placed by
 * `index_to_world`. The lines pass through the samples of the middle layer of the active box, and as far around it as
 * its shadow reaches; the trilinear field is integrated exactly along each. */
neph_result np_volume_get_column_max(const neph_volume *volume, const np_affine *index_to_world, np_monitor *monitor,
                                     double *out_value_m);

/* Box around a box of index positions mapped to the world. */
void np_volume_bound_box(const np_affine *affine, const int32_t low[3], const int32_t high[3], double out_min[3],
                         double out_max[3]);

/* The table of the module, loaded on first need; fails with a message that says where it was looked for. */
neph_result np_vdb_module_get(neph_context *context, const np_vdb_module **out_module);

/* Keeps a volume on disk, and takes it from there; NULL where the entry holds less than one. */
struct np_cache_entry;
void np_volume_save_to_cache(const neph_volume *volume, struct np_cache_entry *entry);
neph_result np_volume_load_from_cache(neph_context *context, struct np_cache_entry *entry, neph_volume **out_volume);

/* Whether np_vdb_module_get has it to give; logs nothing. */
bool np_vdb_module_is_present(neph_context *context);

#endif
