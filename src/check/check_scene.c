/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of a scene with all its files: inputs are opened as a render opens them, then read and checked by the rules of
 * their kinds, and clouds are checked in their places. */
#include "check/check_scene.h"

#include <nephos/files.h>

#include "check/check_heights.h"
#include "check/check_mesh.h"
#include "check/check_volume.h"
#include "cloud/bake_loss.h"
#include "cloud/measured_map.h"
#include "cloud/weather_picture.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "core/given.h"
#include "core/text.h"
#include "plan/georeference.h"
#include "plan/plan.h"
#include "plan/reference_frame.h"
#include "render/render_calls.h"
#include "scene/cloud_file.h"
#include "scene/cloud_places.h"
#include "scene/scene_eval.h"
#include "stages/stores.h"
#include "terrain/heightfield_files.h"
#include "volume/volume_private.h"

typedef struct scene_check {
  neph_check *check;
  const neph_scene *scene; /* in the frame */
  np_stores *stores;
  const char *name;
  int frame;
  np_camera camera;
  neph_terrain *terrain; /* owned; NULL: none */
} scene_check;

/* ---- Inputs ---- */

/* Opens all inputs by making a plan, whose messages become findings. */
static neph_result check_plan(const scene_check *c) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  char *text = NULL;
  neph_result result = neph_check_set_file(c->check, c->name);
  if (!result) result = neph_scene_get_render_desc(c->scene, &desc);
  desc.frame = c->frame;
  if (!result) result = np_render_explain(c->scene, &desc, c->stores, NEPH_TEXT_PLAIN, &text);
  neph_text_destroy(c->check->context, text);
  return np_check_pass(result);
}

/* Adds an output by its name in the frame, and checks whether it can be written. A bake that is there is only read.
 * `pattern` NULL: none. */
static neph_result add_output(const scene_check *c, neph_files *files, const char *key, const char *pattern,
                              bool is_bake) {
  if (!pattern) return NEPH_OK;
  char *path = np_frame_name_make(c->check->context, pattern, c->frame);
  neph_result result = path ? neph_files_add(files, NEPH_FILE_WRITTEN, key, path) : NEPH_ERROR_OUT_OF_MEMORY;
  const bool is_read = is_bake && path && np_file_exists(path);
  if (!result && !is_read) result = np_check_pass(np_file_check_target(c->check->context, path));
  np_alloc_free(c->check->context, path);
  return result;
}

/* Adds the outputs. The first render also writes baked clouds. */
static neph_result add_outputs(const scene_check *c, neph_files *files) {
  const np_scene_output *output = &c->scene->output;
  const struct {
    const char *key, *pattern;
  } rows[] = {{"output.image", output->image}, {"output.preview", output->preview}, {"output.deep", output->deep}};
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < sizeof rows / sizeof *rows; i++)
    result = add_output(c, files, rows[i].key, rows[i].pattern, false);
  for (unsigned i = 0; !result && i < c->scene->cloud_count; i++) {
    char key[32];
    np_print(key, sizeof key, "clouds[%u].vdb", i);
    if (c->scene->clouds[i].is_baked) result = add_output(c, files, key, c->scene->clouds[i].vdb, true);
  }
  return result;
}

/* Checks whether an output overwrites another or an input, or cannot be written. */
static neph_result check_outputs(const scene_check *c) {
  neph_files *files;
  neph_result result = neph_files_create(c->check->context, &files);
  if (!result) result = add_outputs(c, files);
  if (!result) result = neph_files_add_scene(files, c->scene);
  if (!result) result = neph_files_check(files);
  neph_files_destroy(files);
  return np_check_pass(result);
}

static neph_result check_preview(const scene_check *c) {
  const np_scene_output *output = &c->scene->output;
  if (!output->preview || output->has_beauty) return NEPH_OK;
  return np_check_pass(np_fail(c->check->context, NEPH_ERROR_INVALID_ARGUMENT,
                               "output.preview %s shows R, G and B, and output.beauty: false leaves them out",
                               output->preview));
}

/* Whether terrain files exist; the plan reports missing ones. */
static bool has_terrain_files(const np_scene_terrain *terrain) {
  const char *heights = terrain->heightfield, *mesh = terrain->mesh_file;
  return (!heights || np_height_files_is_pattern(heights) || np_file_exists(heights)) &&
         (!mesh || np_file_exists(mesh));
}

static neph_result check_terrain(scene_check *c) {
  const np_scene_terrain *terrain = &c->scene->terrain;
  const np_terrain_source source = np_scene_terrain_get_source(terrain);
  const neph_terrain_desc desc = np_scene_terrain_get_desc(terrain);
  if (terrain->given || terrain->kind == NP_TERRAIN_NONE) {
    c->terrain = neph_terrain_retain(terrain->given);
    return NEPH_OK;
  }
  if (!has_terrain_files(terrain)) return NEPH_OK;
  neph_result result = terrain->heightfield ? np_check_heights(c->check, terrain->heightfield, &desc) : NEPH_OK;
  if (!result && terrain->mesh_file) result = np_check_mesh(c->check, terrain->mesh_file, &terrain->mesh);
  if (!result) result = neph_check_set_file(c->check, c->name);
  if (!result) result = np_terrain_create(c->check->context, &source, &desc, &c->terrain);
  return np_check_pass(result);
}

/* ---- Clouds ---- */

/* Adds findings about a cloud's place and size. */
static void add_placement(const scene_check *c, const np_scene_cloud *cloud, const np_placement *placement) {
  static const np_rule bounds = {"cloud.bounds", NEPH_SEVERITY_NOTE, NULL};
  const bool has_planet = c->scene->environment.has_planet;
  np_dvec3 low, high;
  np_cloud_places_bound(cloud, placement->bounds_min, placement->bounds_max, &low, &high);
  const np_placement_view view = {&c->camera, has_planet ? c->scene->atmosphere.planet_radius_m : 0.0, c->terrain};
  np_placement_fault faults[NP_PLACEMENT_FAULTS_MAX];
  const unsigned count = np_placement_list_faults(cloud, &view, low, high, faults);
  np_finding_draft out = {{0}, {0}};
  np_draft_set_place(&out, "cloud %s", cloud->name);
  np_draft_set(&out, "the cloud reaches from (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m", low.x, low.y, low.z, high.x,
               high.y, high.z);
  np_check_add(c->check, &bounds, &out);
  for (unsigned i = 0; i < count; i++) {
    const np_rule rule = {faults[i].rule, NEPH_SEVERITY_WARNING, faults[i].keys};
    np_draft_set(&out, "the cloud %s", faults[i].cause);
    np_check_add(c->check, &rule, &out);
  }
}

static neph_result add_georeference(const scene_check *c, const np_scene_cloud *cloud, const np_georeference *from) {
  static const np_rule rule = {"cloud.georeferenced", NEPH_SEVERITY_NOTE, NULL};
  np_finding_draft out = {{0}, {0}};
  if (!from->is_applied) return NEPH_OK;
  char *text = np_georeference_describe(c->check->context, from);
  if (!text) return NEPH_ERROR_OUT_OF_MEMORY;
  np_draft_set_place(&out, "cloud %s", cloud->name);
  np_draft_set(&out, "the cloud %s", text);
  np_check_add(c->check, &rule, &out);
  np_alloc_free(c->check->context, text);
  return NEPH_OK;
}

/* Checks the place of a cloud's volume. */
static neph_result check_placement(const scene_check *c, unsigned index, double number, neph_volume *volume) {
  const np_scene_cloud *cloud = &c->scene->clouds[index];
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  np_anchor anchor;
  np_placement placement;
  np_georeference georeference;
  np_monitor monitor;
  bool is_known = false;
  np_check_start_monitor(c->check, &monitor);
  neph_result result = neph_check_set_file(c->check, c->name);
  const np_frame_cloud of = {&c->stores->inputs.references, c->scene, index, number, volume, &load, &monitor};
  if (!result) result = np_reference_frame_get_anchor(&of, &anchor, &is_known);
  if (!result && is_known)
    result = np_georeference_apply(c->scene, cloud, volume, &anchor.file_to_world, &georeference);
  if (!result && is_known) result = add_georeference(c, cloud, &georeference);
  if (!result && is_known) result = np_placement_make(cloud, &anchor, volume, &monitor, &placement);
  if (!result && is_known) add_placement(c, cloud, &placement);
  return result;
}

/* Checks the place of a frame's file, whose values have been checked. */
static neph_result place_file(const scene_check *c, unsigned index) {
  const np_scene_cloud *cloud = &c->scene->clouds[index];
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  const char *sequence = np_cloud_file_get_sequence(cloud);
  np_cloud_file file;
  neph_volume *volume = NULL;
  c->check->are_warnings_muted = true;
  neph_result result = np_cloud_file_get(c->check->context, cloud, c->frame, &file);
  if (!result) result = neph_check_set_file(c->check, file.path);
  if (!result && file.path && np_file_exists(file.path))
    result = np_volume_load_density(c->check->context, file.path, &load, sequence, &volume);
  if (!result && volume) result = check_placement(c, index, file.number, volume);
  c->check->are_warnings_muted = false;
  neph_volume_release(volume);
  np_alloc_free(c->check->context, file.path);
  return np_check_pass(result);
}

static neph_result check_map(const scene_check *c, const np_scene_cloud *cloud) {
  np_weather_picture picture;
  neph_result result = neph_check_set_file(c->check, cloud->bake.map_file);
  if (!result) result = np_weather_picture_load(c->check->context, &cloud->bake, &picture);
  if (!result) np_weather_picture_clear(&picture);
  return np_check_pass(result);
}

static neph_result check_measured(const scene_check *c, const neph_cloud_desc *desc) {
  np_measured_map map;
  neph_result result = neph_check_set_file(c->check, desc->measurement->name);
  if (!result) result = np_measured_map_load(c->check->context, desc, &map);
  if (!result) np_measured_map_clear(&map);
  return np_check_pass(result);
}

static neph_result check_bake(const scene_check *c, const np_scene_cloud *cloud) {
  const double radius_m = c->scene->atmosphere.planet_radius_m;
  neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, c->frame);
  neph_result result = cloud->bake.map_file ? check_map(c, cloud) : NEPH_OK;
  if (!result && at_frame.measurement) result = check_measured(c, &at_frame);
  /* The ground moves bases and clouds, and has no effect on the loss by voxels. */
  at_frame.ground_lift = at_frame.ground_cover = 0;
  return result ? result : np_check_pass(np_cloud_check_voxel(c->check->context, &at_frame, radius_m));
}

/* Checks the single file of a cloud; the plan reports a missing one. */
static neph_result check_still(const scene_check *c, const np_scene_cloud *cloud, const np_file_use *use) {
  char *path = np_frame_name_make(c->check->context, cloud->vdb, c->frame);
  if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_file_exists(path) ? np_check_volume(c->check, path, true, use, NULL) : NEPH_OK;
  np_alloc_free(c->check->context, path);
  return result;
}

/* Checks a cloud. A render writes a baked cloud's file. The plan reports missing files. A cloud with errors is not
 * placed.
 */
static neph_result check_cloud(const scene_check *c, unsigned index) {
  const np_scene_cloud *cloud = &c->scene->clouds[index];
  const size_t errors = c->check->counts[NEPH_SEVERITY_ERROR];
  if (cloud->volume) return NEPH_OK;
  if (cloud->is_baked) return check_bake(c, cloud);
  const np_file_use use = np_cloud_file_describe_use(c->scene, cloud);
  const neph_result result =
      np_scene_cloud_is_sequence(cloud) ? np_check_sequence(c->check, cloud->vdb, &use) : check_still(c, cloud, &use);
  return result || c->check->counts[NEPH_SEVERITY_ERROR] > errors ? result : place_file(c, index);
}

static neph_result check_all(scene_check *c) {
  const unsigned *resolution = c->scene->camera.resolution;
  neph_result result = np_camera_init(c->scene, resolution[0], resolution[1], NEPH_EYE_CENTRE, &c->camera);
  if (result) return np_check_pass(result);
  result = check_plan(c);
  if (!result) result = check_preview(c);
  if (!result) result = check_outputs(c);
  if (!result) result = check_terrain(c);
  for (unsigned i = 0; !result && i < c->scene->cloud_count; i++) result = check_cloud(c, i);
  return result;
}

neph_result np_check_scene_frame(neph_check *check, const neph_scene *scene, const char *name, int frame) {
  neph_scene at;
  np_stores stores = {.results = NULL};
  scene_check c = {.check = check, .scene = &at, .stores = &stores, .name = name, .frame = frame};
  neph_result result = neph_check_set_file(check, name);
  if (!result) result = np_scene_eval(scene, frame, &at);
  if (result) return np_check_pass(result);
  result = check_all(&c);
  neph_terrain_release(c.terrain);
  np_stores_clear(check->context, &stores);
  np_scene_eval_clear(&at);
  return result;
}

neph_result neph_check_scene(neph_check *check, const neph_scene *scene, int frame) {
  if (NP_LACKS(NP_CONTEXT_OF(check), scene)) return NEPH_ERROR_INVALID_ARGUMENT;
  if (scene->context != check->context)
    return np_fail(check->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "the scene belongs to another context than the check: make it in the check's");
  const unsigned float_mode = np_float_mode_enter();
  const neph_result result = np_check_scene_frame(check, scene, scene->file ? scene->file : "scene", frame);
  np_float_mode_leave(float_mode);
  return result;
}
