/* SPDX-License-Identifier: Apache-2.0 */
/* Interface to OpenVDB: a table of C functions in a module, loaded on first need. vdb_shim.cpp is the only C++ of
 * nephos. */
#ifndef NP_VOLUME_VDB_TABLE_H
#define NP_VOLUME_VDB_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include "volume/sparse_grid.h"

#ifdef __cplusplus
extern "C" {
#endif

#define NP_VDB_MODULE_VERSION 16u

/* Blind data of a .nvdb grid that hold the metadata of a .vdb grid: names and texts, each ended by a zero byte. */
#define NP_NVDB_ATTRIBUTES_NAME "nephos:metadata"

/* File name of the module, and name of its exported function. */
#define NP_VDB_MODULE_FILE "nephos_vdb.so"
#define NP_VDB_MODULE_FUNCTION "nephos_vdb_module"

typedef struct np_vdb_file np_vdb_file; /* an open file and the headers of its grids */

/* One message for the caller to report; the shim never logs by itself. Empty: a callback failed and has logged the
 * reason. */
typedef struct np_vdb_error {
  neph_result result;
  char message[480];
} np_vdb_error;

typedef struct np_vdb_grid_info {
  const char *name;       /* valid while the file is open */
  const char *value_type; /* "float", "vec3s", "ptdataidx32", … */
  const char *grid_class; /* "fog volume", "level set", "unknown", … */
  const char *creator;    /* creator of the grid, else of the file; "": none */
  size_t owner;           /* index of the grid that stores the voxels; for an instance another grid */
  int is_half_on_disk;
  int is_scalar; /* float, half or double: readable by np_vdb_module.read */
  int is_count;  /* integers or masks (0 or 1): readable as well */
  int is_vector; /* three floats, halves or doubles: readable by component */
  int is_level_set;
  int is_affine; /* its transform is neither a frustum nor singular */
  double index_to_world[3][4];
  np_frustum frustum;
} np_vdb_grid_info;

/* Size of any grid, from its topology. */
typedef struct np_vdb_grid_size {
  int32_t active_min[3], active_max[3]; /* index box, both ends inclusive; max below min if no voxel is active */
  uint64_t active_voxel_count;
  uint64_t tree_bytes; /* memory of the tree with its leaves; without the attributes of points */
} np_vdb_grid_size;

/* File positions of the parts of a grid. */
typedef struct np_vdb_grid_place {
  int64_t descriptor, begin, topology;
  /* Valid after the tree was checked: the position of the values in the file; those of each leaf in OpenVDB's order,
   * and the end of the last, NULL where leaves hold no values. */
  int64_t buffers;
  size_t leaf_count;
  const int64_t *leaves;
} np_vdb_grid_place;

/* A file whose header and grid headers are checked: all reads go through it. */
typedef struct np_vdb_source {
  void *user;
  int64_t size;
  uint32_t format_version, library_version[2];
  int64_t metadata; /* position of the file's metadata */
  size_t grid_count;
  const np_vdb_grid_place *places;
  /* All log their failures. `read_apart` may be called from any thread, beside all others. `check_tree` is called
   * before a tree or its topology is read. It cannot check buffers of points, which must not be read. */
  neph_result (*read)(void *user, int64_t position, void *out, size_t count);
  neph_result (*read_apart)(void *user, int64_t position, void *out, size_t count);
  neph_result (*check_tree)(void *user, size_t index, int is_half);
} np_vdb_source;

/* Grids to read. Several are summed, on the lattice of the first. */
typedef struct np_vdb_request {
  const size_t *indices;
  size_t count;
  int component;           /* component of a vector, 0 to 2; else 0 */
  int is_density;          /* 1: read as a density; 0: read one grid with its values unchanged */
  double level_set_voxels; /* depth below the surface of a level set, in voxels, at which density reaches 1; level sets
                              must be floats */
} np_vdb_request;

/* A grid that is a density, or a part of one. */
typedef struct np_vdb_addend {
  const np_sparse_grid *grid;
  int is_affine, is_level_set; /* is_level_set: the class says so */
} np_vdb_addend;

/* Destination of a grid: functions of sparse_grid.h, passed because a loaded module cannot link to them. */
typedef struct np_vdb_sink {
  np_sparse_grid *grid; /* initialised and empty */
  neph_result (*reserve)(np_sparse_grid *, size_t leaf_count, size_t tile_count);
  np_leaf *(*add_leaf)(np_sparse_grid *, const int32_t origin[3]);
  np_leaf *(*add_leaves)(np_sparse_grid *, size_t count);
  np_tile *(*add_tile)(np_sparse_grid *, const int32_t origin[3], int32_t edge, float value, bool is_active);
} np_vdb_sink;

/* Repairs of a grid that is copied. */
typedef enum np_vdb_mark {
  NP_VDB_KEEP,
  NP_VDB_MAKE_FINITE, /* floats, doubles and their vectors: NaN and infinity become 0 */
  NP_VDB_MEND_VALUES, /* scalars: non-finite, negative and subnormal values become 0; active infinity becomes the
                         largest valid value */
  NP_VDB_MEND_DENSITY /* NP_VDB_MEND_VALUES, and a background of 0 and the class fog volume */
} np_vdb_mark;

/* The repair of a grid, and its outcome. */
typedef struct np_vdb_mending {
  np_vdb_mark mark;
  uint64_t value_count;
  bool has_new_background, has_new_class;
} np_vdb_mending;

/* Polled during long work; non-zero stops it with NEPH_ERROR_CANCELLED. */
typedef int (*np_vdb_cancel_fn)(void *user);

typedef struct np_vdb_attribute {
  const char *name, *text; /* name of the attribute, and its text; text NULL: a number */
  double number;
} np_vdb_attribute;

typedef struct np_vdb_write_grid {
  const np_sparse_grid *grid;
  int is_half;
  const np_vdb_attribute *attributes;
  size_t attribute_count;
  const np_sparse_grid *y, *z; /* NULL: a scalar fog volume; else, with `grid` as x, the components of a velocity with
                                  equal leaves and tiles */
  int is_invariant;            /* the vector is a colour, not a direction: transforms leave it unchanged */
  const char *grid_class;      /* class as np_vdb_grid_info names it; NULL: a fog volume, none of a vector */
} np_vdb_write_grid;

/* Functions that can fail return the neph_result that is also in `error`; they throw nothing. */
typedef struct np_vdb_module {
  uint32_t version; /* NP_VDB_MODULE_VERSION, checked before anything else is used */

  /* Tries to decompress a chunk, which follows its length, to `count` bytes. */
  neph_result (*try_chunk)(uint32_t compression, const void *chunk, size_t chunk_bytes, size_t count);

  /* Reads the headers of a file's grids. `source` and `cancel` must stay valid until the file is closed. `thread_count`
   * threads read trees. */
  neph_result (*open)(const np_vdb_source *source, unsigned thread_count, np_vdb_cancel_fn cancel, void *cancel_user,
                      np_vdb_file **out_file, np_vdb_error *error);
  void (*close)(np_vdb_file *file); /* NULL is allowed */
  size_t (*count)(const np_vdb_file *file);
  void (*describe)(const np_vdb_file *file, size_t index, np_vdb_grid_info *out_info);

  /* Visits a grid's metadata as text. */
  neph_result (*visit_metadata)(const np_vdb_file *file, size_t index,
                                void (*visit)(void *user, const char *name, const char *text), void *user,
                                np_vdb_error *error);

  /* Reads a scalar grid, a sum of grids, or one component of a vector: transform, background, leaves, and tiles that
   * differ from an inactive background. Frustum grids are read as stored: `describe` returns their map. */
  neph_result (*read)(np_vdb_file *file, const np_vdb_request *request, const np_vdb_sink *sink,
                      uint64_t *out_tree_bytes, np_vdb_error *error);

  /* Makes the density that a request of .vdb grids would, from grids of another format. */
  neph_result (*combine)(const np_vdb_addend *addends, size_t count, double level_set_voxels, unsigned thread_count,
                         np_vdb_cancel_fn cancel, void *cancel_user, const np_vdb_sink *sink, uint64_t *out_tree_bytes,
                         np_vdb_error *error);

  /* Decompresses the first `count` bytes of a chunk of a .nvdb file, of Blosc or of zlib. */
  neph_result (*unpack)(int is_blosc, const void *packed, size_t packed_bytes, void *out, size_t count,
                        np_vdb_error *error);

  /* Reads the topology of any grid and returns its size. */
  neph_result (*measure)(np_vdb_file *file, size_t index, np_vdb_grid_size *out_size, np_vdb_error *error);

  /* Runs OpenVDB's own checks of fog volumes on a grid of floats or doubles: `visit` gets a message for each failed
   * check. */
  neph_result (*diagnose)(np_vdb_file *file, size_t index, void (*visit)(void *user, const char *text), void *user,
                          np_vdb_error *error);

  /* Copies all grids and metadata of a file to `path`, a temporary name, with one repair of `mendings` for each grid,
   * which also receives the outcome. Grids of points are refused. */
  neph_result (*mend)(np_vdb_file *file, np_vdb_mending *mendings, const char *path, np_vdb_error *error);

  /* Writes grids to `path`, a temporary name that the caller renames, as .vdb or, where `is_nano`, as .nvdb, on
   * `thread_count` threads. */
  neph_result (*write)(const char *path, const np_vdb_write_grid *grids, size_t count, int is_nano,
                       unsigned thread_count, np_vdb_cancel_fn cancel, void *cancel_user, np_vdb_error *error);

  /* OpenVDB's own trilinear BoxSampler at index positions, for tests and benchmarks. */
  neph_result (*sample)(const np_sparse_grid *grid, size_t count, const double *positions, float *out_values,
                        np_vdb_error *error);

  /* Reads a grid by OpenVDB alone, unchecked, and discards it, for benchmarks. */
  neph_result (*read_alone)(np_vdb_file *file, size_t index, np_vdb_error *error);
} np_vdb_module;

/* The only exported symbol of nephos_vdb.so. */
NEPH_API const np_vdb_module *nephos_vdb_module(void);

#ifdef __cplusplus
}
#endif

#endif
