/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan.h"

#include <string.h>

#include "atmosphere/sphere_map.h"
#include "atmosphere/stars.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "image/image_private.h"
#include "optics/phase_table.h"
#include "plan/placement.h"
#include "plan/reference_frame.h"
#include "scene/cloud_file.h"
#include "scene/cloud_map.h"
#include "terrain/ground_cover.h"
#include "volume/volume_private.h"
#include "volume/volume_sizes.h"

/* ---- Tables and pictures ---- */

static neph_result open_phase_table(const neph_scene *scene, const np_scene_cloud *cloud) {
  np_phase_table table;
  if (cloud->phase_source.kind != NEPH_PHASE_TABLE) return NEPH_OK;
  neph_result result = np_phase_table_load(scene->context, cloud->phase_table, &table);
  if (!result) np_phase_table_clear(&table);
  return result;
}

static neph_result open_stars(const neph_scene *scene) {
  if (!scene->stars.is_enabled || !scene->stars.catalogue) return NEPH_OK;
  np_star_catalogue stars;
  neph_result result = np_star_catalogue_load(scene->context, scene->stars.catalogue, scene->stars.faintest, &stars);
  if (!result) np_star_catalogue_clear(&stars);
  return result;
}

static neph_result open_picture(const neph_scene *scene, const char *path) {
  unsigned size[2];
  return path ? np_image_read_size(scene->context, path, size) : NEPH_OK;
}

static neph_result open_star_map(const neph_scene *scene) {
  return scene->stars.map ? np_sphere_map_check(scene->context, "stars.map", scene->stars.map) : NEPH_OK;
}

static neph_result open_moon_map(const neph_scene *scene) {
  return scene->moon.map ? np_sphere_map_check(scene->context, "moon.map", scene->moon.map) : NEPH_OK;
}

static neph_result open_cloud_tables(const neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    const bool is_made = cloud->is_baked || cloud->volume;
    result = open_phase_table(scene, cloud);
    if (!result && is_made) result = open_picture(scene, cloud->bake.map_file);
    if (!result && is_made) result = np_cloud_map_check(scene->context, cloud);
    if (!result && is_made) result = open_picture(scene, cloud->bake.shape.height_map);
  }
  return result;
}

static neph_result open_terrain(const neph_scene *scene) {
  const np_terrain_source source = np_scene_terrain_get_source(&scene->terrain);
  const np_terrain_row *row = &np_terrain_rows[source.kind];
  const char *image = scene->terrain.albedo_image;
  const neph_terrain_desc desc = np_scene_terrain_get_desc(&scene->terrain);
  unsigned size[2];
  neph_result result = row->check ? row->check(scene->context, &source, &desc, size) : NEPH_OK;
  if (!result && scene->terrain.mesh_file && !scene->terrain.given)
    result = np_terrain_check_mesh(scene->context, &desc);
  return result || !image ? result : np_ground_cover_check_image(scene->context, image);
}

/* ---- Clouds ---- */

/* One file of a sequence, or of a cloud. */
typedef struct cloud_file {
  const neph_scene *scene;
  unsigned index;
  const char *path;
} cloud_file;

/* A scalar grid of a cloud's file, which must be there where a key requires it. */
static neph_result open_field(const cloud_file *file, const char *grid, const char *required_by) {
  neph_context *context = file->scene->context;
  np_grid_header header;
  if (!grid) return NEPH_OK;
  neph_result result = np_volume_read_field_header(context, file->path, grid, required_by, &header);
  if (!result && header.state == NP_GRID_EMPTY)
    np_log(context, NEPH_LOG_WARNING, "%s: grid '%s' is empty: it has no active voxels", file->path, grid);
  return result;
}

/* Opens the grids of colours and velocities; grids that the scene names are required. */
static neph_result open_vectors(const cloud_file *file, const np_file_use *use, bool *out_has_emission) {
  neph_result result = NEPH_OK;
  *out_has_emission = false;
  for (unsigned v = 0; v < use->vector_count && !result; v++) {
    const np_vector_request *wanted = &use->vectors[v];
    bool is_found = false;
    if (wanted->name || wanted->role == NP_VECTOR_EMISSION)
      result = np_volume_search_vector(file->scene->context, file->path, wanted->role, wanted->name, &is_found);
    *out_has_emission = *out_has_emission || (is_found && wanted->role == NP_VECTOR_EMISSION);
  }
  return result;
}

static neph_result open_fields(const cloud_file *file) {
  const np_scene_cloud *cloud = &file->scene->clouds[file->index];
  const np_scene_emission *emission = &cloud->emission;
  const np_file_use use = np_cloud_file_describe_use(file->scene, cloud);
  bool has_colors;
  neph_result result = open_vectors(file, &use, &has_colors);
  const bool is_temperature_required = emission->temperature || !has_colors;
  if (!result) result = open_field(file, use.fields[0], is_temperature_required ? NP_TEMPERATURE_KEY : NULL);
  if (!result) result = open_field(file, use.fields[1], emission->flame ? NP_FLAME_KEY : NULL);
  return result ? result : open_field(file, use.fields[2], cloud->sizes ? NP_SIZES_KEY : NULL);
}

static neph_result open_density(const cloud_file *file, np_grid_state *out_state) {
  const np_scene_cloud *cloud = &file->scene->clouds[file->index];
  neph_result result = np_scene_check_cloud_file(file->scene, file->index, file->path);
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  const char *sequence = np_cloud_file_get_sequence(cloud);
  np_grid_header header = {.state = *out_state};
  if (!result) result = np_volume_read_header(file->scene->context, file->path, &load, sequence, &header);
  *out_state = header.state;
  if (!result && header.state == NP_GRID_FILLED)
    result = np_scene_check_cloud_unit(file->scene, file->index, file->path, header.extinction_per_value);
  if (!result && header.state == NP_GRID_MISSING)
    np_volume_warn_of_absence(file->scene->context, cloud->name, file->path, &load, sequence);
  if (!result && *out_state == NP_GRID_EMPTY)
    np_log(file->scene->context, NEPH_LOG_WARNING, "%s: cloud %s is empty: its grid has no active voxels", file->path,
           cloud->name);
  return result;
}

/* Opens the file of a frame. A frame without a file counts as empty in a sequence. */
static neph_result open_frame(const neph_scene *scene, unsigned index, int frame, double *out_number,
                              np_grid_state *out_state) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  np_cloud_file of_frame;
  *out_state = NP_GRID_EMPTY;
  neph_result result = np_cloud_file_get(scene->context, cloud, frame, &of_frame);
  if (!result && !of_frame.path) np_cloud_file_warn(scene->context, cloud, frame, &of_frame);
  const cloud_file file = {scene, index, of_frame.path};
  if (!result && file.path) result = open_density(&file, out_state);
  if (!result && file.path) result = open_fields(&file);
  np_alloc_free(scene->context, of_frame.path);
  *out_number = of_frame.number;
  return result;
}

neph_result np_inputs_open_cloud(const neph_scene *scene, unsigned index, int frame) {
  np_grid_state state;
  double number;
  return scene->clouds[index].is_baked ? NEPH_OK : open_frame(scene, index, frame, &number, &state);
}

static neph_result open_reference(const neph_scene *scene, unsigned index) {
  char *path = np_frame_name_make(scene->context, scene->clouds[index].vdb, scene->clouds[index].reference_frame);
  const cloud_file file = {scene, index, path};
  np_grid_state state = NP_GRID_EMPTY;
  neph_result result = path ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && !np_file_exists(path))
    result = np_fail(scene->context, NEPH_ERROR_NOT_FOUND,
                     "clouds[%u].reference_frame is %.10g, must be the number of a file that is there: %s is not",
                     index, scene->clouds[index].reference_frame, path);
  if (!result) result = open_density(&file, &state);
  np_alloc_free(scene->context, path);
  if (result || state == NP_GRID_FILLED) return result;
  return np_reference_frame_fail_empty(scene, index, scene->clouds[index].reference_frame);
}

static bool is_reference_given(const np_scene_cloud *cloud) {
  return cloud->has_reference_frame || np_scene_cloud_goes_by_all(cloud);
}

void neph_scene_warn_of_tasks(const neph_scene *scene) {
  for (unsigned i = 0; scene && i < scene->cloud_count; i++)
    if (np_reference_is_used(&scene->clouds[i]) && !is_reference_given(&scene->clouds[i]))
      np_log(scene->context, NEPH_LOG_WARNING,
             "cloud %s: each task places and scales its sequence by the first of its own frames that holds anything, "
             "unless clouds[%u].reference_frame is a frame, or all",
             scene->clouds[i].name, i);
}

/* A frame rendered by another task may depend on another file. */
static void warn_of_choice(const neph_scene *scene, unsigned index, np_reference *reference) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  if (is_reference_given(cloud) || !reference->has_frame || reference->is_told) return;
  reference->is_told = true;
  np_log(scene->context, NEPH_LOG_WARNING,
         "cloud %s: frame %.10g, the first asked for that holds anything, places and scales all of its sequence: tasks "
         "that begin with another frame will place it otherwise, unless clouds[%u].reference_frame is a frame, or all",
         cloud->name, reference->number, index);
}

/* Notes the file that a sequence depends on, by the headers; none while all frames so far are empty. `filled` is
 * the number of the frame's own; NULL: it is empty. */
static neph_result update_reference(const neph_scene *scene, unsigned index, const double *filled,
                                    np_input_store *store) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  if (!np_reference_is_used(cloud)) return NEPH_OK;
  np_reference *reference;
  neph_result result = np_references_get(&store->references, scene, index, &reference);
  if (result) return result;
  if (!reference->has_frame && filled) {
    reference->has_frame = true;
    reference->number = *filled;
  }
  warn_of_choice(scene, index, reference);
  return cloud->has_reference_frame ? open_reference(scene, index) : NEPH_OK;
}

static neph_result open_cloud(const neph_scene *scene, unsigned index, int frame, np_input_store *store) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  np_grid_state state;
  double number;
  if (cloud->is_baked || cloud->volume) return NEPH_OK;
  const neph_result result = open_frame(scene, index, frame, &number, &state);
  return result ? result : update_reference(scene, index, state == NP_GRID_FILLED ? &number : NULL, store);
}

/* ---- All ---- */

static neph_result (*const openers[])(const neph_scene *scene) = {open_terrain, open_stars, open_star_map,
                                                                  open_moon_map, open_cloud_tables};

/* Opens all, whatever fails, so that all errors are reported at once; a missing file is reported once. */
neph_result np_inputs_open(const neph_scene *scene, int frame, np_input_store *store) {
  neph_result first = neph_scene_check_files(scene);
  const bool are_there = !first;
  for (size_t i = 0; i < sizeof openers / sizeof *openers && are_there; i++) {
    const neph_result result = openers[i](scene);
    if (!first) first = result;
  }
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const neph_result result = open_cloud(scene, i, frame, store);
    if (!first) first = result;
  }
  return first;
}
