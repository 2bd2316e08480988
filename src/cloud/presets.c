/* SPDX-License-Identifier: Apache-2.0 */
/* Named clouds: a row each, tuned by eye against photographs; lengths from the ranges that the WMO's cloud atlas and
 * Stull 2017, "Practical Meteorology", give for each species. */
#include <stdio.h>
#include <string.h>

#include "cloud/cloud_private.h"

typedef struct preset {
  const char *name;
  double base_altitude_m, thickness_m, coverage, cell_m, type, billow_m, erosion, wispiness, turbulence;
  double extinction_per_m;
} preset;

static const preset presets[] = {
    {"cumulus_humilis", 1100, 450, 0.22, 1200, 0.2, 260, 0.45, 0.40, 0.40, 0.05},
    {"cumulus_mediocris", 1200, 1200, 0.35, 1800, 0.6, 430, 0.55, 0.30, 0.30, 0.06},
    {"cumulus_congestus", 1000, 3600, 0.30, 3600, 1.0, 900, 0.50, 0.25, 0.25, 0.09},
    {"stratocumulus", 900, 450, 0.88, 1300, 0.35, 380, 0.45, 0.35, 0.35, 0.045},
};

enum { PRESET_COUNT = sizeof presets / sizeof *presets };

void np_cloud_list_presets(char *out, size_t size) {
  size_t length = 0;
  out[0] = '\0';
  for (int i = 0; i < PRESET_COUNT && length < size; i++)
    length += (size_t)snprintf(out + length, size - length, "%s%s", i ? ", " : "", presets[i].name);
}

static neph_result fail_unknown(neph_context *context, const char *name) {
  char list[256];
  np_cloud_list_presets(list, sizeof list);
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "cloud: preset is \"%s\", must be one of %s", name, list);
}

bool np_cloud_has_preset(const char *name) {
  for (int i = 0; i < PRESET_COUNT; i++)
    if (!strcmp(presets[i].name, name)) return true;
  return false;
}

neph_result neph_cloud_get_preset(neph_context *context, const char *name, neph_cloud_desc *out_desc) {
  for (int i = 0; i < PRESET_COUNT; i++) {
    const preset *p = &presets[i];
    if (strcmp(p->name, name) != 0) continue;
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    desc.base_altitude_m = p->base_altitude_m;
    desc.thickness_m = p->thickness_m;
    desc.coverage = p->coverage;
    desc.cell_m = p->cell_m;
    desc.type = p->type;
    desc.billow_m = p->billow_m;
    desc.erosion = p->erosion;
    desc.wispiness = p->wispiness;
    desc.turbulence = p->turbulence;
    desc.extinction_per_m = p->extinction_per_m;
    *out_desc = desc;
    return NEPH_OK;
  }
  return fail_unknown(context, name);
}
