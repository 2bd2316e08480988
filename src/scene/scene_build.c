/* SPDX-License-Identifier: Apache-2.0 */
/* Typed calls that build a scene. Each writes its keys into the document, numbers as numbers, so that ranges and
 * messages are the same as for a file. */
#include <inttypes.h>
#include <math.h>
#include <nephos/scene_build.h>
#include <string.h>

#include "atmosphere/atmosphere_private.h"
#include "core/alloc.h"
#include "core/given.h"
#include "core/text.h"
#include "scene/scene_apply.h"
#include "scene/scene_edit.h"
#include "terrain/terrain_private.h"
#include "volume/volume_private.h"

enum { KEY_SIZE = 96 };

/* Editor of a scene's document: a copy, in which the section `prefix` is rewritten. */
typedef struct section_writer {
  neph_context *context;
  np_node *document;
  char prefix[KEY_SIZE]; /* "camera", "clouds[3]" */
  neph_result result;    /* first failure so far */
} section_writer;

static void put_node(section_writer *w, const char *name, np_node *value) {
  char key[2 * KEY_SIZE];
  np_print(key, sizeof key, "%s.%s", w->prefix, name);
  if (!value) w->result = NEPH_ERROR_OUT_OF_MEMORY;
  if (!w->result)
    w->result = np_scene_edit(w->context, w->document, key, value);
  else
    np_node_destroy(w->context, value);
}

/* Sets numbers in SI. */
static void put_reals(section_writer *w, const char *name, const double *values, unsigned count) {
  put_node(w, name, np_node_create_numbers(w->context, values, count));
}

static void put_real(section_writer *w, const char *name, double value) { put_reals(w, name, &value, 1); }

static void put_text(section_writer *w, const char *name, const char *text) {
  np_node *node = np_node_create(w->context, NP_NODE_SCALAR, text, NULL);
  if (node) node->is_quoted = true;
  put_node(w, name, node);
}

static void put_word(section_writer *w, const char *name, const char *word) {
  put_node(w, name, np_node_create(w->context, NP_NODE_SCALAR, word, NULL));
}

/* ---- Sections ---- */

/* Replaces a section of the document by an empty mapping, or appends one. NULL: out of memory. */
static np_node *renew_section(section_writer *w) {
  np_node *old = np_node_search(w->document, w->prefix);
  np_node *section = np_node_create(w->context, NP_NODE_MAPPING, NULL, w->prefix);
  if (section && old)
    np_node_replace(w->context, w->document, old, section);
  else if (section)
    np_node_append(w->document, section);
  return section;
}

/* Begins an edit of a scene. */
static section_writer open_writer(const neph_scene *scene, const char *prefix) {
  section_writer w = {.context = scene->context, .document = np_node_copy(scene->context, np_scene_get_source(scene))};
  np_print(w.prefix, sizeof w.prefix, "%s", prefix);
  w.result = w.document ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  return w;
}

/* Rebuilds the scene from the edited document. */
static neph_result close_writer(neph_scene *scene, section_writer *w) {
  if (!w->result) return np_scene_set_document(scene, w->document);
  np_node_destroy(w->context, w->document);
  return w->result;
}

/* Rewrites a section by the function `put`. */
static neph_result set_section(neph_scene *scene, const char *prefix, void (*put)(section_writer *w, const void *desc),
                               const void *desc) {
  section_writer w = open_writer(scene, prefix);
  if (!w.result && !renew_section(&w)) w.result = NEPH_ERROR_OUT_OF_MEMORY;
  if (!w.result) put(&w, desc);
  return close_writer(scene, &w);
}

/* ---- Camera and sun ---- */

/* Sets a number; infinity represents the key's default word. */
static void put_finite(section_writer *w, const char *name, double value) {
  if (value != HUGE_VAL) put_real(w, name, value);
}

static void put_lens(section_writer *w, const neph_camera_desc *camera) {
  put_finite(w, "f_stop", camera->f_stop);
  put_finite(w, "focus_distance", camera->focus_distance_m);
  if (camera->blade_count) put_real(w, "blades", camera->blade_count);
  if (!camera->has_exposure) return;
  put_real(w, "shutter", camera->shutter_s);
  put_real(w, "iso", camera->iso);
}

static void put_projection(section_writer *w, const neph_camera_desc *camera) {
  static const char *const kinds[] = {"perspective", "orthographic", "equirectangular", "fisheye"};
  if (camera->kind) put_word(w, "kind", (unsigned)camera->kind < 4 ? kinds[camera->kind] : "unknown");
  if (camera->has_focal_length)
    put_real(w, "focal_length", camera->focal_length_m);
  else if (camera->kind == NEPH_CAMERA_PERSPECTIVE)
    put_real(w, "fov", camera->fov_rad);
  if (camera->kind == NEPH_CAMERA_FISHEYE) put_real(w, "fisheye_fov", camera->fisheye_fov_rad);
  if (camera->has_focal_length || isfinite(camera->f_stop)) put_real(w, "sensor", camera->sensor_m);
  if (camera->kind == NEPH_CAMERA_ORTHOGRAPHIC) put_real(w, "orthographic_width", camera->orthographic_width_m);
  if (camera->shift[0] != 0.0 || camera->shift[1] != 0.0) put_reals(w, "shift", camera->shift, 2);
  if (camera->kind != NEPH_CAMERA_EQUIRECTANGULAR) put_real(w, "roll", camera->roll_rad);
  if (camera->near_m != 0.0) put_real(w, "near", camera->near_m);
  put_finite(w, "far", camera->far_m);
}

static void put_stereo(section_writer *w, const neph_camera_desc *camera) {
  put_real(w, "stereo.interaxial", camera->interaxial_m);
  put_finite(w, "stereo.convergence", camera->convergence_m);
}

static void put_camera(section_writer *w, const void *desc) {
  const neph_camera_desc *camera = desc;
  const double resolution[2] = {camera->resolution[0], camera->resolution[1]};
  put_reals(w, "position", camera->position_m, 3);
  put_reals(w, "look_at", camera->look_at_m, 3);
  put_projection(w, camera);
  put_lens(w, camera);
  if (camera->is_stereo) put_stereo(w, camera);
  put_reals(w, "resolution", resolution, 2);
}

neph_result neph_scene_set_camera(neph_scene *scene, const neph_camera_desc *desc) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_camera_desc defaults = NEPH_CAMERA_DESC_DEFAULT;
  neph_camera_desc camera;
  neph_result result = np_desc_read(scene->context, "neph_camera_desc", &defaults, sizeof defaults, desc, &camera);
  return result ? result : set_section(scene, "camera", put_camera, &camera);
}

static void put_sun(section_writer *w, const void *desc) {
  const neph_sun_desc *sun = desc;
  put_real(w, "elevation", sun->elevation_rad);
  put_real(w, "azimuth", sun->azimuth_rad);
  if (sun->has_irradiance) put_reals(w, "irradiance", sun->irradiance_w_m2_nm, 3);
  if (sun->has_angular_radius) put_real(w, "angular_radius", sun->angular_radius_rad);
  put_word(w, "limb_darkening", sun->has_limb_darkening ? "true" : "false");
}

/* Converts a direction to the angles of the sun's keys. */
static neph_result convert_direction(const neph_scene *scene, neph_sun_desc *sun) {
  const double *d = sun->direction, across = hypot(d[0], d[1]), length = hypot(across, d[2]);
  if (!(length > 0.0) || !isfinite(length))
    return np_fail(scene->context, NEPH_ERROR_BAD_SCENE, "sun direction is (%g, %g, %g), must be finite and not zero",
                   d[0], d[1], d[2]);
  sun->elevation_rad = atan2(d[2], across);
  sun->azimuth_rad = across > 0.0 ? atan2(d[0], d[1]) : 0.0;
  return NEPH_OK;
}

neph_result neph_scene_set_sun(neph_scene *scene, const neph_sun_desc *desc) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_sun_desc defaults = NEPH_SUN_DESC_DEFAULT;
  neph_sun_desc sun;
  neph_result result = np_desc_read(scene->context, "neph_sun_desc", &defaults, sizeof defaults, desc, &sun);
  if (!result && sun.has_direction) result = convert_direction(scene, &sun);
  return result ? result : set_section(scene, "sun", put_sun, &sun);
}

/* ---- Clouds ---- */

static void put_density(section_writer *w, const neph_placement_desc *p) {
  static const char *const keys[] = {[NEPH_DENSITY_EXTINCTION] = "extinction",
                                     [NEPH_DENSITY_MEAN_FREE_PATH] = "mean_free_path",
                                     [NEPH_DENSITY_OPTICAL_DEPTH] = "optical_depth",
                                     [NEPH_DENSITY_LIQUID_WATER] = "liquid_water.effective_radius"};
  put_real(w, keys[p->density_unit], p->density_value);
}

static void put_phase(section_writer *w, const neph_placement_desc *p) {
  static const char *const habits[] = {
      [NEPH_ICE_MIXED] = "mixed", [NEPH_ICE_COLUMN] = "column", [NEPH_ICE_PLATE] = "plate"};
  switch (p->phase) {
  case NEPH_PHASE_DROPLETS:
    put_real(w, "phase.droplets.diameter", p->droplet_diameter_m);
    return;
  case NEPH_PHASE_HENYEY_GREENSTEIN:
    put_real(w, "phase.hg", p->asymmetry);
    return;
  case NEPH_PHASE_TWO_LOBE:
    put_real(w, "phase.two_lobe.forward", p->asymmetry);
    put_real(w, "phase.two_lobe.backward", p->second_asymmetry);
    put_real(w, "phase.two_lobe.weight", p->second_weight);
    return;
  case NEPH_PHASE_CORNETTE_SHANKS:
  case NEPH_PHASE_DRAINE:
    put_real(w, "phase.draine.g", p->asymmetry);
    put_real(w, "phase.draine.alpha", p->phase == NEPH_PHASE_DRAINE ? p->draine_alpha : 1);
    return;
  case NEPH_PHASE_TABLE:
    put_text(w, "phase.table", p->phase_table);
    return;
  case NEPH_PHASE_MIE:
    put_real(w, "phase.mie.effective_radius", p->effective_radius_m);
    put_real(w, "phase.mie.effective_variance", p->effective_variance);
    return;
  case NEPH_PHASE_RAIN:
    put_real(w, "phase.rain.mode_diameter", p->rain_mode_diameter_m);
    return;
  case NEPH_PHASE_ICE:
    put_word(w, "phase.ice.habit", habits[p->ice_habit]);
    return;
  case NEPH_PHASE_HAZE:
  case NEPH_PHASE_RAYLEIGH:
  case NEPH_PHASE_ISOTROPIC:
    put_word(w, "phase", p->phase == NEPH_PHASE_RAYLEIGH ? "rayleigh" : "isotropic");
    return;
  }
}

static void put_detail(section_writer *w, const neph_placement_desc *p) {
  char seed[24];
  np_print(seed, sizeof seed, "%" PRIu64, p->detail_seed);
  put_real(w, "detail.strength", p->detail_strength);
  if (p->detail_size_m != 0.0) put_real(w, "detail.size", p->detail_size_m);
  put_word(w, "detail.seed", seed);
}

static void put_placement(section_writer *w, const neph_placement_desc *p) {
  if (p->name) put_text(w, "name", p->name);
  if (p->has_position) put_reals(w, "position", p->position_m, 3);
  put_real(w, "rotation", p->rotation_rad);
  put_real(w, "scale", p->scale);
  put_density(w, p);
  put_reals(w, "albedo", p->albedo, 3);
  put_phase(w, p);
  if (p->detail_strength != 0.0) put_detail(w, p);
}

static neph_result read_placement(neph_context *context, const neph_placement_desc *desc, neph_placement_desc *out) {
  static const neph_placement_desc defaults = NEPH_PLACEMENT_DESC_DEFAULT;
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(context, "neph_placement_desc", &defaults, sizeof defaults, desc, out);
  if (result) return result;
  if ((unsigned)out->density_unit > NEPH_DENSITY_LIQUID_WATER)
    return np_fail(context, bad, "neph_placement_desc.density_unit is %d, must be a neph_density_unit",
                   (int)out->density_unit);
  if ((unsigned)out->phase > NEPH_PHASE_ICE || out->phase == NEPH_PHASE_HAZE)
    return np_fail(context, bad, "neph_placement_desc.phase is %d, must be a neph_phase for clouds", (int)out->phase);
  if ((unsigned)out->ice_habit > NEPH_ICE_PLATE)
    return np_fail(context, bad, "neph_placement_desc.ice_habit is %d, must be a neph_ice_habit", (int)out->ice_habit);
  if (out->phase == NEPH_PHASE_TABLE && !out->phase_table)
    return np_fail(context, bad, "neph_placement_desc.phase_table is NULL, must name a CSV file");
  return NEPH_OK;
}

/* List of clouds, created if missing; NULL: out of memory. */
static np_node *open_clouds(section_writer *w) {
  np_node *clouds = np_node_search(w->document, "clouds");
  if (clouds) return clouds;
  clouds = np_node_create(w->context, NP_NODE_SEQUENCE, NULL, "clouds");
  if (clouds) np_node_append(w->document, clouds);
  return clouds;
}

/* Sets a cloud to a volume at `index`, which may be one past the end. */
static neph_result set_cloud(neph_scene *scene, unsigned index, neph_volume *volume, const neph_placement_desc *p) {
  char prefix[KEY_SIZE];
  np_print(prefix, sizeof prefix, "clouds[%u]", index);
  section_writer w = open_writer(scene, prefix);
  np_node *clouds = w.result ? NULL : open_clouds(&w);
  np_node *cloud = clouds ? np_node_create(w.context, NP_NODE_MAPPING, NULL, NULL) : NULL;
  if (cloud) {
    cloud->assets.volume = neph_volume_retain(volume);
    np_node *old = np_node_get(clouds, index);
    if (old)
      np_node_replace(w.context, clouds, old, cloud);
    else
      np_node_append(clouds, cloud);
    put_placement(&w, p);
  } else {
    w.result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  return close_writer(scene, &w);
}

static neph_result check_context(const neph_scene *scene, const neph_context *context, const char *what) {
  if (context == scene->context) return NEPH_OK;
  return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "the %s belongs to another context than the scene: make it in the scene's", what);
}

neph_result neph_scene_add_volume(neph_scene *scene, neph_volume *volume, const neph_placement_desc *desc,
                                  unsigned *out_index) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), volume)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_placement_desc placement;
  const unsigned index = scene->cloud_count;
  if (!volume) return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "neph_scene_add_volume: the volume is NULL");
  neph_result result = check_context(scene, np_volume_get_context(volume), "volume");
  if (!result) result = read_placement(scene->context, desc, &placement);
  if (!result) result = set_cloud(scene, index, volume, &placement);
  if (!result && out_index) *out_index = index;
  return result;
}

neph_result neph_scene_set_placement(neph_scene *scene, unsigned index, const neph_placement_desc *desc) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_placement_desc placement;
  neph_volume *volume = index < scene->cloud_count ? scene->clouds[index].volume : NULL;
  if (!volume)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "cloud %u of %u is not one that neph_scene_add_volume has added", index, scene->cloud_count);
  neph_result result = read_placement(scene->context, desc, &placement);
  return result ? result : set_cloud(scene, index, volume, &placement);
}

/* ---- Terrain, water and atmosphere ---- */

/* Sets a section to an asset, or to "none" without one. */
static neph_result set_asset(neph_scene *scene, const char *name, np_node_assets assets) {
  const bool is_none = !assets.terrain && !assets.atmosphere;
  section_writer w = open_writer(scene, name);
  np_node *section = w.result ? NULL : renew_section(&w);
  if (section && is_none) {
    section->kind = NP_NODE_SCALAR;
    section->text = np_alloc_text(w.context, "none");
  } else if (section) {
    section->assets = np_node_assets_retain(assets);
  }
  if (!section || (is_none && !section->text)) w.result = NEPH_ERROR_OUT_OF_MEMORY;
  return close_writer(scene, &w);
}

neph_result neph_scene_set_terrain(neph_scene *scene, neph_terrain *terrain) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = terrain ? check_context(scene, np_terrain_get_context(terrain), "terrain") : NEPH_OK;
  return result ? result : set_asset(scene, "terrain", (np_node_assets){.terrain = terrain});
}

static void put_water(section_writer *w, const void *desc) {
  const neph_water_desc *water = desc;
  put_real(w, "level", water->level_m);
  put_real(w, "wind", water->wind_m_s);
  put_reals(w, "albedo", water->albedo, 3);
}

neph_result neph_scene_set_water(neph_scene *scene, const neph_water_desc *desc) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_water_desc defaults = NEPH_WATER_DESC_DEFAULT;
  neph_water_desc water;
  if (!desc) return set_asset(scene, "water", (np_node_assets){0});
  neph_result result = np_desc_read(scene->context, "neph_water_desc", &defaults, sizeof defaults, desc, &water);
  return result ? result : set_section(scene, "water", put_water, &water);
}

neph_result neph_scene_set_atmosphere(neph_scene *scene, neph_atmosphere *atmosphere) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = atmosphere ? check_context(scene, np_atmosphere_get_context(atmosphere), "atmosphere") : NEPH_OK;
  return result ? result : set_asset(scene, "atmosphere", (np_node_assets){.atmosphere = atmosphere});
}
