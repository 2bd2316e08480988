/* SPDX-License-Identifier: Apache-2.0 */
/* Description of a file of grids: the statistics of each grid, as text or as JSON. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/json.h"
#include "volume/frustum.h"
#include "volume/volume_file.h"

enum { NAME_COLUMNS = 13 };

/* Statistics of the voxels that a grid shares with its instances. */
typedef struct tree_measures {
  bool is_known;
  np_vdb_grid_size size;
  bool is_active;  /* any voxel is active */
  bool has_values; /* a scalar: the range below is set */
  float value_min, value_max;
  bool has_bricks;          /* a finite scalar: bricks were built, in half */
  np_frustum_facts frustum; /* uses the transform of the grid that stores the voxels; levels 0: not a frustum */
  uint64_t brick_count, brick_bytes;
} tree_measures;

typedef struct portrait {
  np_vdb_grid_info info;
  tree_measures tree;
  double bounds_min_m[3], bounds_max_m[3], voxel_m[3];
} portrait;

/* ---- Measuring ---- */

static bool is_finite(const np_sparse_grid *grid) {
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      if (!isfinite(grid->leaves[i].values[n])) return false;
  for (size_t i = 0; i < grid->tile_count; i++)
    if (!isfinite(grid->tiles[i].value)) return false;
  return isfinite(grid->background);
}

static neph_result measure_bricks(const np_sparse_grid *grid, np_monitor *monitor, tree_measures *tree) {
  np_bricks bricks;
  if (!is_finite(grid)) return NEPH_OK;
  neph_result result = np_bricks_build(grid->context, grid, NEPH_PRECISION_HALF, NULL, monitor, &bricks);
  if (result) return result;
  tree->has_bricks = true;
  tree->brick_count = bricks.brick_count;
  tree->brick_bytes = np_bricks_get_bytes(&bricks);
  np_bricks_clear(&bricks);
  return NEPH_OK;
}

static neph_result measure_frustum(np_sparse_grid *grid, tree_measures *tree) {
  return tree->is_active && is_finite(grid) ? np_frustum_measure(grid, &tree->frustum) : NEPH_OK;
}

static neph_result measure_scalar(const np_volume_file *file, size_t index, np_monitor *monitor, tree_measures *tree) {
  np_sparse_grid grid = {0};
  np_grid_extent extent;
  neph_result result = np_volume_file_read(file, index, &grid, &tree->size.tree_bytes);
  if (!result) {
    tree->has_values = tree->is_active = np_sparse_grid_measure(&grid, &extent);
    memcpy(tree->size.active_min, extent.min, sizeof extent.min);
    memcpy(tree->size.active_max, extent.max, sizeof extent.max);
    tree->value_min = extent.value_min;
    tree->value_max = extent.value_max;
    tree->size.active_voxel_count = np_sparse_grid_count_active(&grid);
    result = grid.frustum.is_enabled ? measure_frustum(&grid, tree) : measure_bricks(&grid, monitor, tree);
  }
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result measure_other(const np_volume_file *file, size_t index, tree_measures *tree) {
  const neph_result result = np_volume_file_measure(file, index, &tree->size);
  tree->is_active = !result && tree->size.active_voxel_count > 0;
  return result;
}

/* Describes one grid. `trees` has an element for each grid and caches the measurements. */
static neph_result measure_portrait(const np_volume_file *file, size_t index, np_monitor *monitor, tree_measures *trees,
                                    portrait *p) {
  p->info = np_volume_file_describe(file, index);
  tree_measures *tree = &trees[p->info.owner];
  neph_result result = NEPH_OK;
  if (!tree->is_known)
    result = p->info.is_scalar ? measure_scalar(file, index, monitor, tree) : measure_other(file, index, tree);
  if (result) return result;
  tree->is_known = true;
  p->tree = *tree;
  np_affine affine;
  memcpy(affine.m, p->info.index_to_world, sizeof affine.m);
  if (p->info.frustum.is_enabled)
    np_frustum_bound_box(&p->info.frustum, tree->size.active_min, tree->size.active_max, p->bounds_min_m,
                         p->bounds_max_m);
  else
    np_volume_bound_box(&affine, tree->size.active_min, tree->size.active_max, p->bounds_min_m, p->bounds_max_m);
  for (int a = 0; a < 3; a++)
    p->voxel_m[a] = np_dvec3_length(np_dvec3_make(affine.m[0][a], affine.m[1][a], affine.m[2][a]));
  return NEPH_OK;
}

/* ---- Lines ---- */

/* Prints a text without control characters of terminals. */
static void print_text(FILE *out, const char *text, int width) {
  int length = 0;
  for (; text[length]; length++) {
    const unsigned char c = (unsigned char)text[length];
    fputc((c < ' ' && c != '\n') || c == 127 ? '?' : c, out);
  }
  fprintf(out, "%*s", width > length ? width - length : 0, "");
}

static void print_metadata_line(void *out, const char *name, const char *text) {
  fprintf(out, "    ");
  print_text(out, name, NAME_COLUMNS);
  fputc(' ', out);
  print_text(out, text, 0);
  fputc('\n', out);
}

static void print_bytes(FILE *out, uint64_t bytes) {
  if (bytes < 1000000)
    fprintf(out, "%.1f kB", (double)bytes * 1e-3);
  else
    fprintf(out, "%.1f MB", (double)bytes * 1e-6);
}

static void print_transform(FILE *out, const portrait *p) {
  if (!p->info.is_affine) {
    fprintf(out, "  transform     %s\n", p->info.frustum.is_enabled ? "frustum" : "singular");
    if (p->tree.frustum.level_count)
      fprintf(out, "  voxel         %.4g × %.4g × %.4g to %.4g × %.4g × %.4g m\n", p->tree.frustum.edges[0][0],
              p->tree.frustum.edges[0][1], p->tree.frustum.edges[0][2], p->tree.frustum.edges[1][0],
              p->tree.frustum.edges[1][1], p->tree.frustum.edges[1][2]);
    return;
  }
  fprintf(out, "  voxel         %.6g × %.6g × %.6g m\n", p->voxel_m[0], p->voxel_m[1], p->voxel_m[2]);
  for (int row = 0; row < 3; row++) {
    const double *m = p->info.index_to_world[row];
    fprintf(out, "%s[%12.6g %12.6g %12.6g %12.6g ]\n", row ? "                " : "  index→world   ", m[0], m[1], m[2],
            m[3]);
  }
}

static bool has_bounds(const portrait *p) { return p->info.is_affine || p->info.frustum.is_enabled; }

static void print_content(FILE *out, const portrait *p) {
  const int32_t *low = p->tree.size.active_min, *high = p->tree.size.active_max;
  if (!p->tree.is_active) {
    fprintf(out, "  active        nothing\n");
    return;
  }
  fprintf(out, "  active        %llu voxels, index (%d, %d, %d) to (%d, %d, %d)\n",
          (unsigned long long)p->tree.size.active_voxel_count, low[0], low[1], low[2], high[0], high[1], high[2]);
  if (has_bounds(p))
    fprintf(out, "  bounds        (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m\n", p->bounds_min_m[0], p->bounds_min_m[1],
            p->bounds_min_m[2], p->bounds_max_m[0], p->bounds_max_m[1], p->bounds_max_m[2]);
  if (p->tree.has_values)
    fprintf(out, "  values        %.6g to %.6g\n", (double)p->tree.value_min, (double)p->tree.value_max);
}

static void print_memory(FILE *out, const portrait *p) {
  fprintf(out, "  memory        tree ");
  print_bytes(out, p->tree.size.tree_bytes);
  if (p->tree.frustum.level_count) {
    fprintf(out, ", even voxels of %u level%s ", p->tree.frustum.level_count,
            p->tree.frustum.level_count > 1 ? "s" : "");
    print_bytes(out, (uint64_t)p->tree.frustum.bytes);
    if (!p->tree.frustum.fits) fprintf(out, ", more than a file of its size may take");
  } else if (p->tree.has_bricks) {
    fprintf(out, ", bricks ");
    print_bytes(out, p->tree.brick_bytes);
    fprintf(out, " (%llu of halves)", (unsigned long long)p->tree.brick_count);
  } else if (p->info.is_scalar) {
    fprintf(out, ", no bricks: not all values are finite");
  }
  fprintf(out, "\n");
}

static neph_result print_grid(FILE *out, const np_volume_file *file, size_t index, const portrait *p) {
  fprintf(out, "grid '");
  print_text(out, p->info.name, 0);
  fprintf(out, "'\n  class         %s\n  type          %s%s\n", p->info.grid_class, p->info.value_type,
          p->info.is_half_on_disk ? ", half on disk" : "");
  if (p->info.creator[0]) {
    fprintf(out, "  creator       ");
    print_text(out, p->info.creator, 0);
    fputc('\n', out);
  }
  print_transform(out, p);
  print_content(out, p);
  print_memory(out, p);
  fprintf(out, "  metadata\n");
  return np_volume_file_visit_metadata(file, index, print_metadata_line, out);
}

/* ---- JSON ---- */

static void put_metadata(void *json, const char *name, const char *text) { np_json_put_text(json, name, text); }

static void put_content(np_json *json, const portrait *p) {
  np_json_put_integer(json, "active_voxels", (int64_t)p->tree.size.active_voxel_count);
  if (!p->tree.is_active) return;
  double low[3], high[3];
  for (int a = 0; a < 3; a++) {
    low[a] = p->tree.size.active_min[a];
    high[a] = p->tree.size.active_max[a];
  }
  np_json_put_reals(json, "index_min", low, 3);
  np_json_put_reals(json, "index_max", high, 3);
  if (has_bounds(p)) {
    np_json_put_reals(json, "bounds_min_m", p->bounds_min_m, 3);
    np_json_put_reals(json, "bounds_max_m", p->bounds_max_m, 3);
  }
  if (!p->tree.has_values) return;
  np_json_put_real(json, "value_min", (double)p->tree.value_min);
  np_json_put_real(json, "value_max", (double)p->tree.value_max);
}

static neph_result put_grid(np_json *json, const np_volume_file *file, size_t index, const portrait *p) {
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "name", p->info.name);
  np_json_put_text(json, "class", p->info.grid_class);
  np_json_put_text(json, "type", p->info.value_type);
  np_json_put_bool(json, "half_on_disk", p->info.is_half_on_disk);
  np_json_put_text(json, "creator", p->info.creator);
  np_json_put_bool(json, "affine", p->info.is_affine);
  if (p->info.is_affine) {
    np_json_put_reals(json, "voxel_m", p->voxel_m, 3);
    np_json_put_reals(json, "index_to_world", &p->info.index_to_world[0][0], 12);
  }
  put_content(json, p);
  np_json_put_integer(json, "tree_bytes", (int64_t)p->tree.size.tree_bytes);
  if (p->tree.has_bricks) {
    np_json_put_integer(json, "brick_count", (int64_t)p->tree.brick_count);
    np_json_put_integer(json, "brick_bytes", (int64_t)p->tree.brick_bytes);
  }
  np_json_begin_object(json, "metadata");
  const neph_result result = np_volume_file_visit_metadata(file, index, put_metadata, json);
  np_json_end(json);
  np_json_end(json);
  return result;
}

/* ---- The file ---- */

typedef struct describe_job {
  neph_context *context;
  const char *path;
  np_monitor *monitor;
  np_json *json; /* NULL: text goes to the other member */
  FILE *out;
} describe_job;

static neph_result describe_grids(const describe_job *job, const np_volume_file *file) {
  const size_t count = np_volume_file_count(file);
  tree_measures *trees = np_alloc(job->context, count, sizeof *trees);
  neph_result result = trees ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  portrait p;
  for (size_t i = 0; i < count && !result; i++) {
    result = measure_portrait(file, i, job->monitor, trees, &p);
    if (!result) result = job->json ? put_grid(job->json, file, i, &p) : print_grid(job->out, file, i, &p);
  }
  np_alloc_free(job->context, trees);
  return result;
}

static neph_result run_describe(void *user) {
  const describe_job *job = user;
  np_volume_file file;
  neph_result result = np_volume_file_open(job->context, job->path, NULL, job->monitor, &file);
  if (result) return result;
  size_t count = np_volume_file_count(&file);
  if (job->out) fprintf(job->out, "%s: %zu %s\n", job->path, count, count == 1 ? "grid" : "grids");
  result = describe_grids(job, &file);
  np_volume_file_close(&file);
  return result;
}

static neph_result describe_as_json(describe_job *job, char **out_text) {
  job->json = np_json_create(job->context);
  if (!job->json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_text(job->json, "file", job->path);
  np_json_begin_array(job->json, "grids");
  neph_result result = np_parallel_run(job->context, job->monitor, run_describe, job);
  np_json_end(job->json);
  if (!result) return np_json_finish(job->json, out_text);
  np_json_destroy(job->json);
  return result;
}

static neph_result describe_as_lines(describe_job *job, char **out_text) {
  char *lines = NULL;
  size_t size = 0;
  job->out = open_memstream(&lines, &size);
  neph_result result = job->out ? np_parallel_run(job->context, job->monitor, run_describe, job) : NEPH_OK;
  bool is_written = job->out && !fclose(job->out);
  if (!result && !is_written)
    result = np_fail(job->context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory: no room for text");
  if (!result) {
    *out_text = np_alloc_text(job->context, lines);
    if (!*out_text) result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  free(lines);
  return result;
}

neph_result neph_volume_describe_file(neph_context *context, const char *path, neph_text_format format,
                                      char **out_text) {
  if (NP_LACKS_OUT(context, out_text, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_monitor monitor;
  *out_text = NULL;
  np_monitor_start(&monitor, context, NULL, NULL);
  describe_job job = {.context = context, .path = path, .monitor = &monitor};
  return format == NEPH_TEXT_JSON ? describe_as_json(&job, out_text) : describe_as_lines(&job, out_text);
}
