/* SPDX-License-Identifier: Apache-2.0 */
/* Named clouds: a row each. Extinction is of the order that 1.5·LWC/r_eff gives for the water of each kind; it, lengths
 * and shapes were chosen by judgement, from rendered pictures. */
#include <stdio.h>
#include <string.h>

#include "cloud/cloud_private.h"

typedef struct preset {
  const char *name;
  neph_cloud_desc desc; /* 0 in the rows below: as NEPH_CLOUD_DESC_DEFAULT has it, where 0 is not allowed */
} preset;

/* clang-format off */
static const preset presets[] = {
    {"cumulus_humilis",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {8000, 8000}, .voxel_m = 14, .base_altitude_m = 1100, .thickness_m = 380, .coverage = 0.22,
      .cell_m = 1150, .type = 0.2, .billow_m = 190, .billowiness = 0.5,
      .erosion = 0.8, .wispiness = 0.45, .turbulence = 0.40,
      .extinction_per_m = 0.08}},
    {"cumulus_mediocris",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 1200, .thickness_m = 1200, .coverage = 0.35,
      .cell_m = 1800, .type = 0.6, .billow_m = 430, .billowiness = 0.5,
      .erosion = 0.7, .wispiness = 0.30, .turbulence = 0.30,
      .extinction_per_m = 0.10}},
    {"cumulus_congestus",
     {.model = NEPH_CLOUD_MODEL_THERMALS,
      .extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 1000, .thickness_m = 3600, .coverage = 0.30,
      .cell_m = 3600, .type = 1.0, .billow_m = 900, .billowiness = 0.5,
      .erosion = 0.50, .wispiness = 0.25, .turbulence = 0.25,
      .extinction_per_m = 0.15}},
    {"stratocumulus",
     {.extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 900, .thickness_m = 450, .coverage = 0.88,
      .cell_m = 1300, .type = 0.35, .billow_m = 380, .billowiness = 0.5,
      .erosion = 0.45, .wispiness = 0.35, .turbulence = 0.35,
      .extinction_per_m = 0.06}},
    {"stratus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {20e3, 20e3}, .voxel_m = 50, .base_altitude_m = 300,
      .thickness_m = 400, .coverage = 1, .cell_m = 4000, .billow_m = 600, .billowiness = 0.5,
      .erosion = 0.25, .turbulence = 0.3,
      .softness = 0.5, .extinction_per_m = 0.04}},
    {"nimbostratus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {24e3, 24e3}, .voxel_m = 80, .base_altitude_m = 800,
      .thickness_m = 2800, .coverage = 1, .cell_m = 6000, .billow_m = 1400, .billowiness = 0.5,
      .erosion = 0.35, .turbulence = 0.4,
      .softness = 0.45, .precipitation = 0.85, .extinction_per_m = 0.05}},
    {"altocumulus_floccus",
     {.extent_m = {8000, 8000}, .voxel_m = 20, .base_altitude_m = 3600, .thickness_m = 380, .coverage = 0.35,
      .cell_m = 560, .type = 0.5, .billow_m = 190, .billowiness = 0.5,
      .erosion = 0.75, .wispiness = 0.75, .turbulence = 0.7,
      .softness = 0.25, .extinction_per_m = 0.03}},
    {"altostratus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {30e3, 30e3}, .voxel_m = 80, .base_altitude_m = 3600,
      .thickness_m = 1400, .coverage = 1, .cell_m = 7000, .billow_m = 1100, .billowiness = 0.5,
      .erosion = 0.35, .turbulence = 0.4,
      .softness = 0.7, .stretch = 3, .wind_m_s = {14, 6}, .extinction_per_m = 0.008}},
    {"cumulonimbus",
     {.extent_m = {30e3, 30e3}, .voxel_m = 90, .base_altitude_m = 900, .thickness_m = 10500, .coverage = 0.45,
      .cell_m = 9500, .type = 1.0, .billow_m = 2600, .billowiness = 0.5,
      .erosion = 0.5, .wispiness = 0.20, .turbulence = 0.25,
      .anvil = 0.8, .precipitation = 1, .skew_m = {2200, 500}, .extinction_per_m = 0.15}},
    {"cirrus",
     {.model = NEPH_CLOUD_MODEL_SLAB, .extent_m = {30e3, 30e3}, .voxel_m = 60, .base_altitude_m = 8800,
      .thickness_m = 1100, .coverage = 0.5, .cell_m = 5000, .billow_m = 420, .billowiness = 0.5,
      .erosion = 0.9, .turbulence = 0.5,
      .softness = 1, .stretch = 12, .skew_m = {4500, 1400}, .wind_m_s = {28, 9}, .extinction_per_m = 2.5e-3}},
};
/* clang-format on */

enum { PRESET_COUNT = sizeof presets / sizeof *presets };

void np_cloud_list_presets(char *out, size_t size) {
  size_t length = 0;
  out[0] = '\0';
  for (int i = 0; i < PRESET_COUNT && length < size; i++)
    length += (size_t)snprintf(out + length, size - length, "%s%s", i ? ", " : "", presets[i].name);
}

static const preset *search_preset(const char *name) {
  for (int i = 0; i < PRESET_COUNT; i++)
    if (!strcmp(presets[i].name, name)) return &presets[i];
  return NULL;
}

bool np_cloud_has_preset(const char *name) { return search_preset(name) != NULL; }

neph_result neph_cloud_get_preset(neph_context *context, const char *name, neph_cloud_desc *out_desc) {
  static const neph_cloud_desc defaults = NEPH_CLOUD_DESC_DEFAULT;
  const preset *found = search_preset(name);
  if (!found) {
    char list[512];
    np_cloud_list_presets(list, sizeof list);
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "cloud: preset is \"%s\", must be one of %s", name, list);
  }
  neph_cloud_desc desc = found->desc;
  desc.struct_size = sizeof desc;
  desc.lifetime_s = defaults.lifetime_s;
  desc.age = defaults.age;
  if (desc.sublayers == 0) desc.sublayers = defaults.sublayers;
  if (desc.stretch == 0) desc.stretch = defaults.stretch;
  memcpy(desc.profile, defaults.profile, sizeof desc.profile);
  memcpy(desc.wind_direction_rad, defaults.wind_direction_rad, sizeof desc.wind_direction_rad);
  desc.shape = defaults.shape;
  memcpy(desc.billow_amounts, defaults.billow_amounts, sizeof desc.billow_amounts);
  memcpy(desc.billow_frequencies, defaults.billow_frequencies, sizeof desc.billow_frequencies);
  memcpy(desc.wisp_amounts, defaults.wisp_amounts, sizeof desc.wisp_amounts);
  memcpy(desc.map_size_m, defaults.map_size_m, sizeof desc.map_size_m);
  return np_desc_write(context, "neph_cloud_desc", &desc, sizeof desc, out_desc);
}
