/* SPDX-License-Identifier: Apache-2.0 */
/* Presets of clouds, one row each. Extinctions are of the order of 1.5·LWC/r_eff for the liquid water of each kind;
 * extinctions, lengths and shapes were adjusted by the look of rendered pictures. */
#include "cloud/presets.h"

#include <string.h>

#include "core/given.h"
#include "core/text.h"

typedef struct preset {
  const char *name;
  neph_cloud_desc desc; /* fields of 0 have their value of NEPH_CLOUD_DESC_DEFAULT if 0 is not allowed */
} preset;

/* clang-format off */
static const preset presets[] = {
    {"cumulus_humilis",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {8000, 8000}, .voxel_m = 14, .base_altitude_m = 1100, .thickness_m = 380, .coverage = 0.22,
      .cell_m = 900, .type = 0.2, .billow_m = 160, .billowiness = 0.5,
      .erosion = 0.45, .wispiness = 0.60, .turbulence = 0.55,
      .extinction_per_m = 0.08}},
    {"cumulus_mediocris",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 1200, .thickness_m = 1200, .coverage = 0.30,
      .cell_m = 1500, .type = 0.7, .billow_m = 320, .billowiness = 0.6,
      .erosion = 0.40, .wispiness = 0.45, .turbulence = 0.40,
      .extinction_per_m = 0.10}},
    {"cumulus_congestus",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 1000, .thickness_m = 3600, .coverage = 0.30,
      .cell_m = 3600, .type = 1.0, .billow_m = 540, .billowiness = 0.6,
      .erosion = 0.40, .wispiness = 0.25, .turbulence = 0.25,
      .extinction_per_m = 0.15}},
    {"stratocumulus",
     {.model = NEPH_CLOUD_MODEL_DECK, .extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 900,
      .thickness_m = 420, .coverage = 0.78, .cell_m = 1500, .billow_m = 150, .billowiness = 0.5,
      .erosion = 0.5, .turbulence = 0.6, .stretch = 2.2, .wind_m_s = {7, 3}, .extinction_per_m = 0.06}},
    {"stratus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {20e3, 20e3}, .voxel_m = 40, .base_altitude_m = 300,
      .thickness_m = 400, .coverage = 1, .cell_m = 4000, .billow_m = 800, .billowiness = 0.5,
      .erosion = 0.25, .turbulence = 0.3,
      .softness = 0.5, .stretch = 1.7, .wind_m_s = {6, 2}, .extinction_per_m = 0.04}},
    {"nimbostratus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {24e3, 24e3}, .voxel_m = 80, .base_altitude_m = 800,
      .thickness_m = 2800, .coverage = 1, .cell_m = 6000, .billow_m = 1400, .billowiness = 0.5,
      .erosion = 0.35, .turbulence = 0.4, .skew_m = {1400, 500},
      .softness = 0.45, .precipitation = 0.85, .extinction_per_m = 0.05}},
    {"altocumulus_floccus",
     {.model = NEPH_CLOUD_MODEL_THERMALS, .extent_m = {8000, 8000}, .voxel_m = 14, .base_altitude_m = 3600,
      .thickness_m = 380, .coverage = 0.35, .cell_m = 560, .type = 0.6, .billow_m = 170, .billowiness = 0.6,
      .erosion = 0.40, .wispiness = 0.75, .turbulence = 0.7, .precipitation = 0.25,
      .skew_m = {200, 80}, .extinction_per_m = 0.06}},
    {"altostratus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {30e3, 30e3}, .voxel_m = 80, .base_altitude_m = 3600,
      .thickness_m = 1400, .coverage = 1, .cell_m = 7000, .billow_m = 700, .billowiness = 0.5,
      .erosion = 0.5, .turbulence = 0.5,
      .softness = 0.8, .stretch = 7, .wind_m_s = {14, 6}, .extinction_per_m = 3.5e-3}},
    {"cumulonimbus",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {30e3, 30e3}, .voxel_m = 90, .base_altitude_m = 900, .thickness_m = 10500, .coverage = 0.45,
      .cell_m = 9500, .type = 1.0, .billow_m = 2200, .billowiness = 0.5,
      .erosion = 0.30, .wispiness = 0.20, .turbulence = 0.25, .softness = 0.25,
      .anvil = 0.8, .precipitation = 1, .skew_m = {2200, 500}, .wind_m_s = {9, 2},
      .has_profile = true, .profile = {0, 0.08, 0.2, 0.36, 0.7}, .extinction_per_m = 0.15}},
    {"cirrus",
     {.model = NEPH_CLOUD_MODEL_STREAKS, .extent_m = {14e3, 14e3}, .voxel_m = 25, .base_altitude_m = 8800,
      .thickness_m = 1100, .coverage = 0.45, .cell_m = 4200, .billow_m = 420, .billowiness = 0.5,
      .erosion = 0.9, .turbulence = 0.5,
      .softness = 0.5, .stretch = 12, .skew_m = {4500, 1400}, .wind_m_s = {28, 9}, .extinction_per_m = 4e-3}},
    {"fog",
     {.model = NEPH_CLOUD_MODEL_FOG, .extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 0,
      .thickness_m = 240, .coverage = 0.9, .cell_m = 2600, .billow_m = 260, .billowiness = 0.35,
      .erosion = 0.55, .softness = 0.55, .stretch = 1.6, .wind_m_s = {1.5, 0.5}, .extinction_per_m = 0.02}},
    {"valley_stratus",
     {.model = NEPH_CLOUD_MODEL_FOG, .extent_m = {16e3, 16e3}, .voxel_m = 40, .base_altitude_m = 100,
      .thickness_m = 700, .coverage = 1, .cell_m = 5000, .billow_m = 620, .billowiness = 0.4,
      .erosion = 0.4, .softness = 0.3, .stretch = 1.5, .wind_m_s = {3, 1}, .extinction_per_m = 0.04}},
    {"altocumulus_lenticularis",
     {.model = NEPH_CLOUD_MODEL_LENSES, .extent_m = {24e3, 24e3}, .voxel_m = 40, .base_altitude_m = 4200,
      .thickness_m = 1500, .coverage = 0.14, .cell_m = 7500, .billow_m = 1300, .erosion = 0.35,
      .softness = 0.25, .sublayers = 4, .skew_m = {900, 0}, .wind_m_s = {24, 0}, .extinction_per_m = 0.02}},
    {"contrail",
     {.model = NEPH_CLOUD_MODEL_TRAILS, .extent_m = {20e3, 20e3}, .voxel_m = 25, .base_altitude_m = 9800,
      .thickness_m = 900, .coverage = 0.07, .cell_m = 9000, .billow_m = 900, .erosion = 0.6, .age = 0.6, .trails = 4,
      .skew_m = {700, 500}, .wind_m_s = {20, 8}, .extinction_per_m = 4e-3}},
};
/* clang-format on */

/* Presets whose clouds are of crystals; the others are of droplets. */
static const char *const ices[] = {"altostratus", "cirrus", "contrail"};

/* Presets whose clouds are a sheet from horizon to horizon; the others are single clouds, or fields that end. */
static const char *const sheets[] = {"stratocumulus", "stratus", "nimbostratus",  "altostratus",
                                     "cirrus",        "fog",     "valley_stratus"};

enum { PRESET_COUNT = sizeof presets / sizeof *presets };

const char *np_cloud_get_preset_name(size_t index) { return index < PRESET_COUNT ? presets[index].name : NULL; }

void np_cloud_list_presets(np_text *out) {
  for (int i = 0; i < PRESET_COUNT; i++) np_text_add(out, "%s%s", i ? ", " : "", presets[i].name);
}

static const preset *search_preset(const char *name) {
  for (int i = 0; i < PRESET_COUNT; i++)
    if (!strcmp(presets[i].name, name)) return &presets[i];
  return NULL;
}

bool np_cloud_has_preset(const char *name) { return search_preset(name) != NULL; }

static bool is_listed(const char *name, const char *const *list, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!strcmp(list[i], name)) return true;
  return false;
}

bool np_cloud_preset_is_ice(const char *name) { return is_listed(name, ices, sizeof ices / sizeof *ices); }

bool np_cloud_preset_is_sheet(const char *name) { return is_listed(name, sheets, sizeof sheets / sizeof *sheets); }

double np_cloud_preset_get_extent(const char *name) {
  const preset *found = search_preset(name);
  return found ? found->desc.extent_m[0] : 0.0;
}

neph_result neph_cloud_get_preset(neph_context *context, const char *name, neph_cloud_desc *out_desc) {
  if (NP_LACKS(context, name, out_desc)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_cloud_desc defaults = NEPH_CLOUD_DESC_DEFAULT;
  const preset *found = search_preset(name);
  if (!found) {
    np_text list = {.context = context};
    np_cloud_list_presets(&list);
    if (list.has_failed) return np_text_end(&list, NEPH_OK);
    return np_text_end(&list, np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                                      "cloud: preset is \"%s\", must be one of %s", name, np_text_get(&list)));
  }
  neph_cloud_desc desc = found->desc;
  desc.struct_size = sizeof desc;
  desc.lifetime_s = defaults.lifetime_s;
  if (desc.age == 0) desc.age = defaults.age;
  if (desc.trails == 0) desc.trails = defaults.trails;
  desc.trail_direction_rad = defaults.trail_direction_rad;
  if (desc.sublayers == 0) desc.sublayers = defaults.sublayers;
  desc.cells_size_m = defaults.cells_size_m;
  if (desc.stretch == 0) desc.stretch = defaults.stretch;
  if (!desc.has_profile) memcpy(desc.profile, defaults.profile, sizeof desc.profile);
  memcpy(desc.wind_direction_rad, defaults.wind_direction_rad, sizeof desc.wind_direction_rad);
  desc.shape = defaults.shape;
  memcpy(desc.billow_amounts, defaults.billow_amounts, sizeof desc.billow_amounts);
  memcpy(desc.billow_frequencies, defaults.billow_frequencies, sizeof desc.billow_frequencies);
  memcpy(desc.wisp_amounts, defaults.wisp_amounts, sizeof desc.wisp_amounts);
  memcpy(desc.wisp_frequencies, defaults.wisp_frequencies, sizeof desc.wisp_frequencies);
  memcpy(desc.map_size_m, defaults.map_size_m, sizeof desc.map_size_m);
  return np_desc_write(context, "neph_cloud_desc", &desc, sizeof desc, out_desc);
}
