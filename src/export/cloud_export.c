/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of a scene as files of their own: read or baked as for a picture, put in their places, in 1/m. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "export/export_fields.h"
#include "plan/georeference.h"
#include "plan/plan.h"
#include "plan/reference_frame.h"
#include "render/renderer_stores.h"
#include "scene/cloud_file.h"
#include "scene/scene_eval.h"
#include "stages/cloud_bake.h"
#include "volume/volume_levels.h"

typedef struct cloud_export {
  const neph_scene *scene; /* the scene in the frame */
  unsigned index;
  const np_scene_cloud *cloud;
  np_stores *stores;
  int frame;
  const neph_export_desc *desc;
  const char *path;
  np_monitor *monitor;
  np_cloud_file source;
  np_sparse_grid grid;
  np_grid_domain domain; /* domain of a model's file */
  np_placement placement;
  np_anchor anchor;
  np_export_fields fields;
  neph_exported_cloud out;
} cloud_export;

/* ---- Source ---- */

/* Share of an export's time that a bake takes. */
static const double bake_part = 0.7;

/* A name beside the target that no file has. NULL: out of memory. */
static char *name_source(const cloud_export *e) {
  neph_context *context = e->scene->context;
  char *path = NULL;
  unsigned number = 0;
  do {
    char mark[48];
    np_print(mark, sizeof mark, "bake-%ld-%u", (long)getpid(), number++);
    np_alloc_free(context, path);
    path = np_volume_name_beside(context, e->path, mark);
  } while (path && np_file_exists(path));
  return path;
}

/* Bakes a cloud to a file beside the target, of the same format. */
static neph_result bake_source(cloud_export *e) {
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  bake.file_precision = NEPH_PRECISION_FLOAT;
  bake.progress = np_monitor_relay;
  bake.progress_user = e->monitor;
  e->source.path = name_source(e);
  if (!e->source.path) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_part(e->monitor, np_monitor_whole, 0.0, bake_part);
  const neph_result result =
      np_cloud_bake_to_file(e->scene, e->index, e->frame, &bake, NP_BAKE_LEVELS_NONE, e->source.path);
  np_monitor_set_part(e->monitor, np_monitor_whole, bake_part, 1.0);
  return result;
}

static neph_result obtain_source(cloud_export *e) {
  return e->cloud->is_baked ? bake_source(e) : np_cloud_file_get(e->scene->context, e->cloud, e->frame, &e->source);
}

static void release_source(cloud_export *e) {
  if (e->cloud->is_baked && e->source.path) (void)unlink(e->source.path);
  np_alloc_free(e->scene->context, e->source.path);
}

/* ---- Place ---- */

/* Bounds of the voxels, which reach half an edge beyond their samples. */
static void compute_bounds(const np_affine *index_to_world, const neph_volume *volume, neph_exported_cloud *out) {
  double *low = out->bounds_min_m, *high = out->bounds_max_m;
  for (int corner = 0; corner < 8; corner++) {
    double index[3];
    for (int a = 0; a < 3; a++) index[a] = corner >> a & 1 ? volume->active_max[a] + 0.5 : volume->active_min[a] - 0.5;
    const np_dvec3 p = np_affine_point(index_to_world, np_dvec3_make(index[0], index[1], index[2]));
    const double at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++) low[a] = corner ? fmin(low[a], at[a]) : at[a];
    for (int a = 0; a < 3; a++) high[a] = corner ? fmax(high[a], at[a]) : at[a];
  }
}

static neph_result place(cloud_export *e, neph_volume *volume) {
  bool is_known;
  neph_volume_load_desc load = np_cloud_file_describe_load(e->cloud);
  const np_frame_cloud of = {
      &e->stores->inputs.references, e->scene, e->index, e->source.number, volume, &load, e->monitor};
  np_georeference georeference;
  neph_result result = np_reference_frame_get_anchor(&of, &e->anchor, &is_known);
  if (!result) result = np_scene_check_cloud_unit(e->scene, e->index, e->source.path, volume->extinction_per_value);
  if (!result) result = np_georeference_apply(e->scene, e->cloud, volume, &e->anchor.file_to_world, &georeference);
  if (!result) result = np_placement_make(e->cloud, &e->anchor, volume, e->monitor, &e->placement);
  if (!result) compute_bounds(&e->placement.index_to_world, volume, &e->out);
  return result;
}

/* ---- Values ---- */

/* The extinction that a value of 1 in the file is. */
static double choose_scale(const cloud_export *e, double value_max) {
  int exponent = 0;
  if (e->desc->precision == NEPH_PRECISION_FLOAT) return 1.0;
  (void)frexp((double)e->placement.world.extinction_per_value * value_max, &exponent);
  return ldexp(1.0, exponent - 1);
}

static void scale_values(np_sparse_grid *grid, float factor) {
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) grid->leaves[i].values[n] *= factor;
  for (size_t i = 0; i < grid->tile_count; i++) grid->tiles[i].value *= factor;
}

static neph_result rename_grid(np_sparse_grid *grid) {
  char *name = np_alloc_text(grid->context, "density");
  if (!name) return NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(grid->context, grid->name);
  grid->name = name;
  return NEPH_OK;
}

/* Writes each level of detail, a complete cloud, into a file of its own: programs that load all grids of a file would
 * add the levels. */
static neph_result save_levels(cloud_export *e, const np_vdb_write_grid *as) {
  neph_context *context = e->scene->context;
  np_sparse_grid levels[2] = {{0}}; /* the level before, and the level derived from it */
  neph_result result = NEPH_OK;
  for (unsigned k = 1; !result && k < e->desc->level_count; k++) {
    np_sparse_grid *grid = &levels[k % 2];
    np_sparse_grid_clear(grid);
    result = np_sparse_grid_halve(k > 1 ? &levels[1 - k % 2] : &e->grid, e->grid.name, grid);
    char *path = np_volume_name_level(context, e->path, k);
    np_vdb_write_grid output = *as;
    output.grid = grid;
    if (!path) result = NEPH_ERROR_OUT_OF_MEMORY;
    if (!result) result = np_volume_save_grids(context, path, &output, 1, e->monitor);
    np_alloc_free(context, path);
  }
  for (int i = 0; i < 2; i++) np_sparse_grid_clear(&levels[i]);
  return result;
}

static neph_result save(cloud_export *e, double value_max) {
  np_sparse_grid *grid = &e->grid;
  neph_result result = rename_grid(grid);
  if (result) return result;
  e->out.is_half = e->desc->precision == NEPH_PRECISION_HALF;
  e->out.extinction_per_value = choose_scale(e, value_max);
  scale_values(grid, (float)((double)e->placement.world.extinction_per_value / e->out.extinction_per_value));
  grid->index_to_world = e->placement.index_to_world;
  char corners[2][32];
  const np_grid_domain *domain = &e->domain;
  np_print(corners[0], sizeof corners[0], "[%d, %d]", (int)domain->min[0], (int)domain->min[1]);
  np_print(corners[1], sizeof corners[1], "[%d, %d]", (int)domain->max[0], (int)domain->max[1]);
  const np_vdb_attribute attributes[] = {{.name = "units", .text = "1/m"},
                                         {.name = "nephos:extinction_per_value", .number = e->out.extinction_per_value},
                                         {.name = "nephos:domain_min", .text = corners[0]},
                                         {.name = "nephos:domain_max", .text = corners[1]}};
  enum { ALL = sizeof attributes / sizeof *attributes, WITHOUT_DOMAIN = 2 };
  np_vdb_write_grid outputs[1 + NP_EXPORT_FIELDS_MAX] = {{.grid = grid,
                                                          .is_half = e->out.is_half,
                                                          .attributes = attributes,
                                                          .attribute_count = domain->is_known ? ALL : WITHOUT_DOMAIN}};
  const size_t count = 1 + np_export_fields_list(&e->fields, e->out.is_half, outputs + 1);
  e->out.fields = np_export_fields_get_kinds(&e->fields);
  result = np_volume_save_grids(e->scene->context, e->path, outputs, count, e->monitor);
  outputs[0].attribute_count = WITHOUT_DOMAIN; /* levels are of other voxels */
  return result ? result : save_levels(e, &outputs[0]);
}

static neph_result load_fields(cloud_export *e) {
  const np_export_source source = {e->cloud, e->source.path, &e->anchor.file_to_world, e->monitor};
  return e->cloud->is_baked ? NEPH_OK : np_export_fields_load(e->scene->context, &source, &e->fields);
}

static neph_result place_and_save(cloud_export *e) {
  neph_volume *volume = NULL;
  neph_result result =
      np_volume_create_from_grid(e->scene->context, &e->grid, NEPH_PRECISION_FLOAT, e->monitor, &volume);
  if (result) return result;
  e->out.is_empty = !(volume->value_max > 0.0f);
  if (!e->out.is_empty) result = place(e, volume);
  if (!result && !e->out.is_empty) result = load_fields(e);
  if (!result && !e->out.is_empty) result = save(e, (double)volume->value_max);
  np_export_fields_clear(&e->fields);
  neph_volume_release(volume);
  return result;
}

static neph_result read_domain(cloud_export *e, const neph_volume_load_desc *load) {
  np_grid_header header;
  const neph_result result =
      np_volume_read_header(e->scene->context, e->source.path, load, np_cloud_file_get_sequence(e->cloud), &header);
  if (!result) e->domain = header.domain;
  return result;
}

static neph_result run(cloud_export *e) {
  neph_context *context = e->scene->context;
  bool has_content = false;
  neph_result result = obtain_source(e);
  if (!result && !e->source.path) np_cloud_file_warn(context, e->cloud, e->frame, &e->source);
  if (!result && e->source.path) {
    const neph_volume_load_desc load = np_cloud_file_describe_load(e->cloud);
    result = np_volume_load_grid(context, e->source.path, &load, np_cloud_file_get_sequence(e->cloud), &e->grid,
                                 &has_content);
    if (!result && has_content && !e->cloud->is_baked) result = read_domain(e, &load);
    if (!result && np_wait_is_cancelled(context, e->monitor)) result = NEPH_ERROR_CANCELLED;
  }
  e->out.is_empty = !has_content;
  if (!result && has_content) result = place_and_save(e);
  np_sparse_grid_clear(&e->grid);
  release_source(e);
  return result;
}

/* ---- Entry ---- */

static neph_result check(const neph_scene *scene, unsigned index, const neph_export_desc *desc) {
  if (index >= scene->cloud_count)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "export: cloud %u is not one of %u", index,
                   scene->cloud_count);
  if (scene->clouds[index].volume)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "export: cloud %s is a volume that a call has added, must be of a file or baked",
                   scene->clouds[index].name);
  if (scene->clouds[index].places)
    np_log(scene->context, NEPH_LOG_WARNING,
           "export: cloud %s: one copy is written, with its pivot at the origin; its places are in %s",
           scene->clouds[index].name, scene->clouds[index].places);
  if (desc->level_count < 1 || desc->level_count > NEPH_BAKE_LEVELS_MAX)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "export: level_count is %u, must be in [1, %d]",
                   desc->level_count, NEPH_BAKE_LEVELS_MAX);
  return np_scene_check(scene);
}

static neph_result export_in_frame(cloud_export *e) {
  const neph_export_desc *desc = e->desc;
  np_monitor monitor;
  e->cloud = &e->scene->clouds[e->index];
  e->monitor = &monitor;
  e->out.name = e->cloud->name;
  e->out.path = e->path;
  e->out.frame = e->frame;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, e->scene->context, desc->progress, desc->progress_user);
  const neph_result result = desc->is_dry_run ? np_inputs_open_cloud(e->scene, e->index, e->frame) : run(e);
  np_float_mode_leave(mode);
  return result;
}

/* Exports from the stores of a renderer; `renderer` NULL: results of other frames are unknown. */
static neph_result export_from_stores(cloud_export *e, neph_renderer *renderer) {
  np_stores own = {.results = NULL};
  e->stores = &own;
  neph_result result = renderer ? np_renderer_borrow(renderer, e->scene, &e->stores) : NEPH_OK;
  if (result) return result;
  result = export_in_frame(e);
  if (renderer) np_renderer_give_back(renderer);
  np_stores_clear(e->scene->context, &own);
  return result;
}

neph_result neph_scene_export_cloud(const neph_scene *scene, unsigned cloud_index, int frame,
                                    const neph_export_desc *desc, const char *path, neph_exported_cloud *out_cloud) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), path, out_cloud)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_export_desc defaults = NEPH_EXPORT_DESC_DEFAULT;
  static const neph_exported_cloud empty = NEPH_EXPORTED_CLOUD_DEFAULT;
  neph_export_desc d;
  neph_scene at;
  cloud_export e = {.scene = &at, .index = cloud_index, .frame = frame, .desc = &d, .path = path, .out = empty};
  neph_result result = np_desc_read(scene->context, "neph_export_desc", &defaults, sizeof d, desc, &d);
  if (!result) result = check(scene, cloud_index, &d);
  if (!result) result = np_scene_eval_bakes(scene, frame, &at);
  if (result) return result;
  result = export_from_stores(&e, d.renderer);
  np_scene_eval_clear(&at);
  return result ? result : np_desc_write(scene->context, "neph_exported_cloud", &e.out, sizeof e.out, out_cloud);
}
