/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_air.h"

#include <math.h>
#include <string.h>

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/haze_layers.h"
#include "core/alloc.h"
#include "core/text.h"
#include "scene/animation.h"
#include "scene/scene_tracks.h"

/* ---- Presets ---- */

static const char *const preset_names[] = {[NP_AIR_NONE] = "earth",
                                           [NP_AIR_EARTH] = "earth",
                                           [NP_AIR_EARTH_HAZY] = "earth-hazy",
                                           [NP_AIR_MARS] = "mars",
                                           [NP_AIR_EMPTY] = "earth"};

neph_result np_scene_air_start(neph_scene *scene) {
  np_scene_air *air = &scene->air;
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  neph_result result =
      neph_atmosphere_get_preset(scene->context, preset_names[air->preset], &desc, &air->sun_distance_au);
  if (result) return result;
  air->molecules = desc.layers[0];
  air->aerosol = air->haze ? np_haze_make(air->haze, air->molecules.scattering_per_m[1]) : desc.layers[1];
  air->ozone = desc.layers[2];
  for (int b = 0; b < 3; b++)
    air->aerosol_extinction_per_m[b] = air->aerosol.scattering_per_m[b] + air->aerosol.absorption_per_m[b];
  desc.layers = NULL;
  desc.layer_count = 0;
  scene->atmosphere = desc;
  return NEPH_OK;
}

/* ---- Listed layers ---- */

static neph_result read_row(np_scene_problems *problems, const char *path, const np_key *key, const np_node *row,
                            unsigned index, np_scene_rows *rows) {
  double *altitude = &rows->values[index], *density = &rows->values[rows->count + index];
  const bool is_pair = row->kind == NP_NODE_SEQUENCE && np_node_count(row) == 2 && row->first->kind == NP_NODE_SCALAR &&
                       row->first->next->kind == NP_NODE_SCALAR;
  if (!is_pair || !np_value_parse_real(row->first->text, key->unit, altitude) ||
      !np_value_parse_real(row->first->next->text, NP_UNIT_NONE, density))
    return np_scene_fail_at(problems, row, "%s[%u] must be a pair of an altitude in m and a density", path, index);
  if (!(*density >= key->range.min && *density <= key->range.max))
    return np_scene_fail_at(problems, row->first->next, "%s[%u]: the density is %g, must be in [%g, %g]", path, index,
                            *density, key->range.min, key->range.max);
  if (index && !(*altitude > altitude[-1]))
    return np_scene_fail_at(problems, row->first, "%s[%u]: the altitude is %g m, must be above the one before, %g m",
                            path, index, *altitude, altitude[-1]);
  return NEPH_OK;
}

neph_result np_scene_air_read_rows(np_scene_problems *problems, const char *path, const np_key *key,
                                   const np_node *node, np_scene_rows *out_rows) {
  const size_t count = node->kind == NP_NODE_SEQUENCE ? np_node_count(node) : 0;
  if (count < 2)
    return np_scene_fail_at(problems, node, "%s must be a list of at least 2 pairs of an altitude in m and a density",
                            path);
  out_rows->values = np_alloc(problems->context, 2 * count, sizeof *out_rows->values);
  if (!out_rows->values) return NEPH_ERROR_OUT_OF_MEMORY;
  out_rows->count = (unsigned)count;
  neph_result result = NEPH_OK;
  const np_node *row = node->first;
  for (unsigned i = 0; !result && row; i++, row = row->next) result = read_row(problems, path, key, row, i, out_rows);
  return result;
}

/* Completes the description of a listed layer. */
static neph_atmosphere_layer complete_layer(const np_scene_layer *layer) {
  neph_atmosphere_layer desc = layer->desc;
  const double *asymmetry = desc.phase == NEPH_PHASE_CORNETTE_SHANKS ? layer->cornette_shanks
                            : desc.phase == NEPH_PHASE_TWO_LOBE      ? layer->forward
                            : desc.phase == NEPH_PHASE_HAZE          ? layer->haze
                                                                     : layer->henyey_greenstein;
  memcpy(desc.asymmetry, asymmetry, sizeof desc.asymmetry);
  desc.table_altitude_m = layer->rows.values;
  desc.table_density = layer->rows.values ? layer->rows.values + layer->rows.count : NULL;
  desc.table_rows = layer->rows.count;
  return desc;
}

/* ---- Description ---- */

void np_scene_air_derive_sun(neph_scene *scene) {
  np_scene_sun *sun = &scene->sun;
  const double distance = scene->air.sun_distance_au;
  if (!sun->has_angular_radius) sun->angular_radius_rad /= distance;
  for (int b = 0; b < 3 && !sun->has_irradiance; b++) sun->irradiance_w_m2_nm[b] /= distance * distance;
}

/* Factor on haze of the keys' amount that leaves the visual range: 0 where the air alone has a shorter one. */
static double compute_haze_factor(const np_scene_air *air) {
  const double molecules = air->molecules.scattering_per_m[1], given = air->aerosol_extinction_per_m[1];
  if (!air->has_visibility || !(given > 0.0)) return 1.0;
  return fmax(np_haze_compute_extinction(air->visibility_m, molecules), 0.0) / given;
}

/* Makes the layers of haze, of which there are up to NP_HAZE_LAYERS; a key for its asymmetry replaces three lobes by
 * one. Returns their number. */
static unsigned make_haze(const np_scene_air *air, neph_atmosphere_layer *out) {
  const double factor = compute_haze_factor(air);
  neph_atmosphere_layer haze = air->aerosol;
  for (int b = 0; b < 3; b++) {
    haze.scattering_per_m[b] *= factor;
    haze.absorption_per_m[b] = fmax(factor * air->aerosol_extinction_per_m[b] - haze.scattering_per_m[b], 0.0);
  }
  if (air->has_asymmetry && haze.phase == NEPH_PHASE_HAZE) haze.phase = NEPH_PHASE_CORNETTE_SHANKS;
  return np_haze_split(air->haze, &haze, out);
}

/* Copies planet and air from an atmosphere object. */
static void derive_given(neph_scene *scene, neph_atmosphere *given) {
  scene->air.given = given;
  scene->has_atmosphere = scene->has_ground_albedo = true;
  scene->atmosphere = *np_atmosphere_get_desc(given);
}

neph_result np_scene_air_derive(neph_scene *scene) {
  np_scene_air *air = &scene->air;
  const np_node *node = np_node_search(scene->document, "atmosphere");
  scene->has_atmosphere = air->preset != NP_AIR_NONE;
  if (node && node->assets.atmosphere) return derive_given(scene, node->assets.atmosphere), NEPH_OK;
  neph_atmosphere_layer preset[2 + NP_HAZE_LAYERS] = {air->molecules};
  unsigned own = 1 + make_haze(air, &preset[1]);
  preset[own++] = air->ozone;
  if (air->preset == NP_AIR_EMPTY) own = 0;
  scene->layers = np_alloc(scene->context, own + (size_t)air->layer_count, sizeof *scene->layers);
  if (!scene->layers) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(scene->layers, preset, own * sizeof *preset);
  for (unsigned i = 0; i < air->layer_count; i++) scene->layers[own + i] = complete_layer(&air->layers[i]);
  scene->atmosphere.layers = scene->layers;
  scene->atmosphere.layer_count = own + air->layer_count;
  return NEPH_OK;
}

/* Lowest altitude at which a layer has density. */
static double compute_begin(const neph_atmosphere_layer *layer) {
  const double low = layer->profile == NEPH_LAYER_TABLE  ? layer->table_altitude_m[0]
                     : layer->profile == NEPH_LAYER_TENT ? layer->center_m - layer->width_m
                                                         : layer->bottom_m;
  return fmax(low, layer->bottom_m);
}

static neph_result check_layer(const neph_scene *scene, unsigned index, const np_node *node,
                               np_scene_problems *problems) {
  const neph_atmosphere_layer layer = complete_layer(&scene->air.layers[index]);
  const double begin = compute_begin(&layer);
  if (!(layer.top_m > layer.bottom_m))
    return np_scene_fail_at(problems, node, "atmosphere.layers[%u].top is %g m, must be above its bottom, %g m", index,
                            layer.top_m, layer.bottom_m);
  if (begin < scene->atmosphere.top_altitude_m) return NEPH_OK;
  return np_scene_fail_at(problems, node,
                          "atmosphere.layers[%u] begins at %g m, must do so below atmosphere.top_altitude, %g m", index,
                          begin, scene->atmosphere.top_altitude_m);
}

/* Checks that the top lies above the beginning of the preset's own layers, of which only ozone begins above the ground.
 */
static neph_result check_top(const neph_scene *scene, const np_node *section, np_scene_problems *problems) {
  const np_node *key = np_node_search(section, "top_altitude");
  const double top = scene->atmosphere.top_altitude_m, begin = compute_begin(&scene->air.ozone);
  const bool has_ozone = scene->air.preset != NP_AIR_NONE && scene->air.preset != NP_AIR_EMPTY;
  if (!key || !has_ozone || begin < top) return NEPH_OK;
  return np_scene_fail_at(problems, key,
                          "atmosphere.top_altitude is %g m, must be above %g m, where the ozone of atmosphere.preset "
                          "begins (atmosphere.preset: empty has none)",
                          top, begin);
}

/* `when` is "" or names the frame in messages. */
static neph_result check_visibility(const np_scene_air *air, const np_node *section, const char *when,
                                    np_scene_problems *problems) {
  const np_node *key = np_node_search(section, "visibility"), *node = key ? key : section;
  const double molecules = air->molecules.scattering_per_m[1], range = np_haze_compute_range(molecules);
  if (!air->has_visibility) return NEPH_OK;
  if (!(air->visibility_m < range))
    return np_scene_fail_at(problems, node,
                            "atmosphere.visibility is %g km%s, must be below %.4g km, the visual range of air without "
                            "haze (rayleigh_scattering at 550 nm is %g 1/m)",
                            air->visibility_m * 1e-3, when, range * 1e-3, molecules);
  if (air->aerosol_extinction_per_m[1] > 0.0) return NEPH_OK;
  return np_scene_fail_at(problems, node,
                          "atmosphere.visibility is %g km%s, and mie_extinction at 550 nm is 0 1/m: no haze to scale",
                          air->visibility_m * 1e-3, when);
}

/* Checks haze by the numbers of its keys. */
static neph_result check_haze(const np_scene_air *air, const np_node *section, const char *when,
                              np_scene_problems *problems) {
  const double *scattering = air->aerosol.scattering_per_m, *extinction = air->aerosol_extinction_per_m;
  const np_node *key = np_node_search(section, "mie_extinction");
  for (int i = 0; i < 3; i++)
    if (extinction[i] < scattering[i])
      return np_scene_fail_at(problems, key ? key : section,
                              "atmosphere.mie_extinction is %g 1/m%s, must not be below mie_scattering, %g 1/m",
                              extinction[i], when, scattering[i]);
  return check_visibility(air, section, when, problems);
}

/* Checks haze in the key frames of a track, between which values are monotone. */
static neph_result check_haze_track(const neph_scene *scene, const np_track *track, const np_node *section,
                                    np_scene_problems *problems) {
  neph_result result = NEPH_OK;
  for (unsigned k = 0; !result && k < track->key_count; k++) {
    neph_scene at = *scene;
    char when[48];
    np_scene_write_section(&at, "atmosphere.", track->frames[k]);
    np_print(when, sizeof when, " in frame %.10g", track->frames[k]);
    result = check_haze(&at.air, section, when, problems);
  }
  return result;
}

neph_result np_scene_air_check(const neph_scene *scene, np_scene_problems *problems) {
  const np_node *air = np_node_search(scene->document, "atmosphere");
  const np_animation *animation = scene->animation;
  if (!air) return NEPH_OK;
  neph_result result = check_haze(&scene->air, air, "", problems);
  if (!result) result = check_top(scene, air, problems);
  for (unsigned i = 0; !result && animation && i < animation->count; i++)
    if (np_track_is_in(&animation->tracks[i], "atmosphere."))
      result = check_haze_track(scene, &animation->tracks[i], air, problems);
  if (result) return result;
  const np_node *list = np_node_search(air, "layers"), *node = list ? list->first : NULL;
  for (unsigned i = 0; node && i < scene->air.layer_count; i++, node = node->next)
    np_scene_goes_on(problems, check_layer(scene, i, node, problems), &result);
  return result;
}

void np_scene_air_clear(neph_scene *scene) {
  for (unsigned i = 0; i < scene->air.layer_count; i++) np_alloc_free(scene->context, scene->air.layers[i].rows.values);
  np_alloc_free(scene->context, scene->air.layers);
  np_alloc_free(scene->context, scene->layers);
  scene->air.layers = NULL;
  scene->air.layer_count = 0;
  scene->layers = NULL;
}
