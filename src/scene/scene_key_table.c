/* SPDX-License-Identifier: Apache-2.0 */
/* All keys in schema order, and renamed keys. */
#include "scene/scene_key_rows.h"
#include "scene/scene_keys.h"

/* Tables in schema order. */
static const np_key_table *const tables[] = {&np_keys_first,   &np_keys_camera, &np_keys_sky,
                                             &np_keys_clouds,  &np_keys_shape,  &np_keys_last,
                                             &np_keys_quality, &np_keys_output, &np_keys_frames};

size_t np_key_count(void) {
  size_t count = 0;
  for (size_t t = 0; t < sizeof tables / sizeof *tables; t++) count += tables[t]->count;
  return count;
}

const np_key *np_key_get(size_t index) {
  const np_key_table *const *table = tables;
  for (; index >= (*table)->count; table++) index -= (*table)->count;
  return &(*table)->keys[index];
}

/* ---- Renamed keys ---- */

static const np_key_rename renames[] = {
    {"render.splitting", "render.path_guiding"},
    {"render.look_gain", "render.approximation_gain"},
    {"clouds[].liquid_water.r_eff", "clouds[].liquid_water.effective_radius"},
    {"clouds[].netcdf.r_eff", "clouds[].netcdf.effective_radius"},
    {"clouds[].netcdf.ice_r_eff", "clouds[].netcdf.ice_effective_radius"},
    {"render.sun_depth", "render.sun_optical_depth"},
};

size_t np_key_rename_count(void) { return sizeof renames / sizeof *renames; }

const np_key_rename *np_key_rename_at(size_t index) { return &renames[index]; }
