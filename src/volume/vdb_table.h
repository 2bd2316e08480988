/* SPDX-License-Identifier: Apache-2.0 */
/* The door to OpenVDB: a module of C functions, loaded on first need. vdb_shim.cpp is the only C++ of nephos. */
#ifndef NP_VOLUME_VDB_TABLE_H
#define NP_VOLUME_VDB_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include "volume/sparse_grid.h"

#ifdef __cplusplus
extern "C" {
#endif

#define NP_VDB_MODULE_VERSION 11u

/* Name of the module's file and of the function in it. */
#define NP_VDB_MODULE_FILE "nephos_vdb.so"
#define NP_VDB_MODULE_FUNCTION "nephos_vdb_module"

typedef struct np_vdb_file np_vdb_file; /* an open file: its grids' headers */

/* One message for the caller to report; the shim never logs by itself. Empty: a callback failed, and has said why. */
typedef struct np_vdb_error {
  neph_result result;
  char message[480];
} np_vdb_error;

typedef struct np_vdb_grid_info {
  const char *name;       /* valid while the file is open */
  const char *value_type; /* "float", "vec3s", "ptdataidx32", … */
  const char *grid_class; /* "fog volume", "level set", "unknown", … */
  const char *creator; /* the grid's; else the file's; "": none */
  size_t owner; /* index of the grid that stores its voxels; itself, but for an instance */
  int is_half_on_disk;
  int is_scalar; /* float, half or double: np_vdb_module.read takes it, */
  int is_count;  /* whole numbers or marks, that is 0 or 1: so it does, */
  int is_vector; /* three floats, halves or doubles: so it does, component by component */
  int is_level_set;
  int is_affine; /* transform is neither a frustum nor singular */
  double index_to_world[3][4];
  np_frustum frustum;
} np_vdb_grid_info;

/* The size of any grid, from its topology. */
typedef struct np_vdb_grid_size {
  int32_t active_min[3], active_max[3]; /* index box, both ends inside it; max below min when nothing is active */
  uint64_t active_voxel_count;
  uint64_t tree_bytes; /* once its leaves are read; without the attributes of points */
} np_vdb_grid_size;

/* Positions of the parts of a grid in a file. */
typedef struct np_vdb_grid_place {
  int64_t descriptor, begin, topology;
  int64_t buffers; /* known once the tree has been checked */
} np_vdb_grid_place;

/* A file whose header and grids' headers have been checked: all that is read comes through it. */
typedef struct np_vdb_source {
  void *user;
  int64_t size;
  uint32_t format_version, library_version[2];
  int64_t metadata; /* position of the file's own */
  size_t grid_count;
  const np_vdb_grid_place *places;
  /* Both report why they fail. `check_tree` is called before a tree, or its topology alone, is read; buffers of points
   * it cannot check, and they must not be read. */
  neph_result (*read)(void *user, int64_t position, void *out, size_t count);
  neph_result (*check_tree)(void *user, size_t index, int is_half);
} np_vdb_source;

/* The grids that one is read from: of several, in lattices of which the first one's is taken, the sum. */
typedef struct np_vdb_request {
  const size_t *indices;
  size_t count;
  int component;           /* of a vector, 0 to 2; else 0 */
  int is_density;          /* wanted: else one grid is read as it stands */
  double level_set_voxels; /* depth at which a level set, which must be one of floats, is 1, and above which it rises
                              from 0 at its surface */
} np_vdb_request;

/* Destination of a grid that is read: functions of sparse_grid.h, handed over because a loaded module cannot link to
 * them.
 */
typedef struct np_vdb_sink {
  np_sparse_grid *grid; /* initialised, empty */
  neph_result (*reserve)(np_sparse_grid *, size_t leaf_count, size_t tile_count);
  np_leaf *(*add_leaf)(np_sparse_grid *, const int32_t origin[3]);
  np_tile *(*add_tile)(np_sparse_grid *, const int32_t origin[3], int32_t edge, float value, bool is_active);
} np_vdb_sink;

/* Changes to a grid that is copied. */
typedef enum np_vdb_mark {
  NP_VDB_KEEP,
  NP_VDB_MAKE_FINITE, /* of floats, doubles and vectors of them: NaN and infinity become 0 */
  NP_VDB_MEND_VALUES, /* of numbers: those that are not finite, negative or subnormal become 0, but infinity, where it
                         is active, the largest of the others */
  NP_VDB_MEND_DENSITY /* the same; the background becomes 0, and the class fog volume */
} np_vdb_mark;

/* The mark of a grid, and what it changed. */
typedef struct np_vdb_mending {
  np_vdb_mark mark;
  uint64_t value_count;
  bool has_new_background, has_new_class;
} np_vdb_mending;

/* Asked during long work; non-zero stops it with NEPH_ERROR_CANCELLED. */
typedef int (*np_vdb_cancel_fn)(void *user);

typedef struct np_vdb_attribute {
  const char *name, *text; /* `text` NULL: a number */
  double number;
} np_vdb_attribute;

typedef struct np_vdb_write_grid {
  const np_sparse_grid *grid;
  int is_half;
  const np_vdb_attribute *attributes;
  size_t attribute_count;
  const np_sparse_grid *y, *z; /* NULL: a scalar, a fog volume; else `grid` is the x of a velocity, and these its other
                                  components, of the same leaves, without tiles */
  int is_invariant;            /* a vector's components are no direction: they are those of a colour */
} np_vdb_write_grid;

/* Functions that can fail return a neph_result, the same as in `error`, and throw nothing. */
typedef struct np_vdb_module {
  uint32_t version; /* NP_VDB_MODULE_VERSION, checked before anything else is used */

  /* Tries to decompress a chunk, its length before it, to `count` bytes. */
  neph_result (*try_chunk)(uint32_t compression, const void *chunk, size_t chunk_bytes, size_t count);

  /* Reads the headers of a file's grids. `source` and `cancel` are asked until the file is closed. Its trees are read
   * by `thread_count` threads; files are written by the calling one. */
  neph_result (*open)(const np_vdb_source *source, unsigned thread_count, np_vdb_cancel_fn cancel, void *cancel_user,
                      np_vdb_file **out_file, np_vdb_error *error);
  void (*close)(np_vdb_file *file); /* NULL is allowed */
  size_t (*count)(const np_vdb_file *file);
  void (*describe)(const np_vdb_file *file, size_t index, np_vdb_grid_info *out_info);

  /* Visits a grid's metadata as text. */
  neph_result (*visit_metadata)(const np_vdb_file *file, size_t index,
                                void (*visit)(void *user, const char *name, const char *text), void *user,
                                np_vdb_error *error);

  /* Reads a scalar grid, their sum, or one component of a vector: transform, background, leaves, and tiles that differ
   * from an inactive background. Frustums are read as they are stored: `describe` has their map. */
  neph_result (*read)(np_vdb_file *file, const np_vdb_request *request, const np_vdb_sink *sink,
                      uint64_t *out_tree_bytes, np_vdb_error *error);

  /* Reads any grid's topology, and tells its size. */
  neph_result (*measure)(np_vdb_file *file, size_t index, np_vdb_grid_size *out_size, np_vdb_error *error);

  /* OpenVDB's own checks of a grid of floats or doubles as a fog volume: `visit` gets a text for each that it fails. */
  neph_result (*diagnose)(np_vdb_file *file, size_t index, void (*visit)(void *user, const char *text), void *user,
                          np_vdb_error *error);

  /* Writes all grids and metadata of a file to `path`, which is a temporary name, mended as `mendings` say, one a grid,
   * which get their outcomes. Grids of points are refused. */
  neph_result (*mend)(np_vdb_file *file, np_vdb_mending *mendings, const char *path, np_vdb_error *error);

  /* Writes grids to `path`, which is a temporary name: the caller renames it. */
  neph_result (*write)(const char *path, const np_vdb_write_grid *grids, size_t count, np_vdb_cancel_fn cancel,
                       void *cancel_user, np_vdb_error *error);

  /* OpenVDB's own trilinear BoxSampler at index positions, for tests and benchmarks. */
  neph_result (*sample)(const np_sparse_grid *grid, size_t count, const double *positions, float *out_values,
                        np_vdb_error *error);

  /* Reads a grid by OpenVDB alone, unchecked, and forgets it, for benchmarks. */
  neph_result (*read_alone)(np_vdb_file *file, size_t index, np_vdb_error *error);
} np_vdb_module;

/* The only exported symbol of nephos_vdb.so. */
NEPH_API const np_vdb_module *nephos_vdb_module(void);

#ifdef __cplusplus
}
#endif

#endif
