/* SPDX-License-Identifier: Apache-2.0 */
#include "render/cloud_glow.h"

#include <string.h>

#include "volume/volume_private.h"

/* Hotter than lightning: a unit has been taken for another. Below the other end nothing is seen to glow. */
static const double hottest_k = 1e5, coldest_k = 600.0;

static bool is_none(const char *name) { return name && strcmp(name, "none") == 0; }

/* A grid's own lattice, placed as the density's is: both come from one file, and keep their places to each other. */
static np_affine place(const np_placement *placement, const neph_volume *density, const neph_volume *field) {
  const np_affine file_to_world = np_affine_compose(&placement->index_to_world, &density->world_to_index);
  return np_affine_compose(&file_to_world, &field->index_to_world);
}

static neph_result check_temperature(const np_scene_cloud *cloud, const neph_volume *temperature) {
  const np_scene_emission *e = &cloud->emission;
  const double top = (double)fmaxf(temperature->value_max, temperature->bricks.background);
  const double kelvin = e->offset_k + e->kelvin_per_value * top;
  if (kelvin > hottest_k)
    return np_fail(temperature->context, NEPH_ERROR_BAD_SCENE,
                   "cloud %s: grid '%s' holds %g, which is %.4g K: must be at most %g K, emission.kelvin says what a "
                   "value of 1 is",
                   cloud->name, temperature->name, top, kelvin, hottest_k);
  if (kelvin < coldest_k)
    np_log(temperature->context, NEPH_LOG_WARNING,
           "cloud %s: grid '%s' holds %g at most, which is %.4g K, too cold to be seen to glow: emission.kelvin says "
           "what a value of 1 is",
           cloud->name, temperature->name, top, kelvin);
  np_log(temperature->context, NEPH_LOG_INFO, "cloud %s: hottest at %.4g K", cloud->name, kelvin);
  return NEPH_OK;
}

/* Half a kelvin at 1000 K, which is how finely halves tell values there, is 1 % of the radiance at 680 nm. */
static neph_result load_temperature(const np_scene_cloud *cloud, const char *path, const neph_volume *density,
                                    const neph_volume_load_desc *desc, np_cloud_glow *glow) {
  const char *name = cloud->emission.temperature;
  if (is_none(name)) return NEPH_OK;
  neph_volume_load_desc exact = *desc;
  exact.precision = NEPH_PRECISION_FLOAT;
  exact.grid = name ? name : "temperature";
  neph_result result = np_volume_load_field(density->context, path, &exact, true, NULL, &glow->temperature);
  return result || !glow->temperature ? result : check_temperature(cloud, glow->temperature);
}

/* Where the file has flames they alone glow, though there be none in this frame. */
static neph_result load_flame(const np_scene_cloud *cloud, const char *path, const neph_volume *density,
                              const neph_volume_load_desc *desc, np_cloud_glow *glow) {
  const char *name = cloud->emission.flame;
  if (is_none(name)) return NEPH_OK;
  neph_volume_load_desc flame = *desc;
  flame.grid = name ? name : "flame";
  bool is_in_file = false;
  neph_result result = np_volume_load_field(density->context, path, &flame, name != NULL, &is_in_file, &glow->flame);
  if (!is_in_file) return result;
  glow->is_there = glow->flame;
  glow->flame_absorption_per_m = (float)cloud->emission.absorption_per_m;
  return result;
}

neph_result np_cloud_glow_load(const np_scene_cloud *cloud, const char *path, const neph_volume *density,
                               const np_placement *placement, const neph_volume_load_desc *desc,
                               np_cloud_glow *out_glow) {
  *out_glow = (np_cloud_glow){.is_there = true, .strength = (float)cloud->emission.strength};
  neph_result result = load_temperature(cloud, path, density, desc, out_glow);
  if (!result) result = load_flame(cloud, path, density, desc, out_glow);
  if (result) {
    np_cloud_glow_clear(out_glow);
    return result;
  }
  const neph_volume *source = out_glow->flame ? out_glow->flame : density, *temperature = out_glow->temperature;
  np_glow *glow = &out_glow->glow;
  glow->bricks = &source->bricks;
  glow->index_to_world = place(placement, density, source);
  glow->offset_k = (float)cloud->emission.offset_k;
  bool is_sound = np_affine_invert(&glow->index_to_world, &glow->world_to_index);
  if (temperature) {
    const np_affine index_to_world = place(placement, density, temperature);
    is_sound = np_affine_invert(&index_to_world, &glow->world_to_temperature) && is_sound;
    glow->temperature = &temperature->bricks;
    glow->kelvin_per_value = (float)cloud->emission.kelvin_per_value;
  }
  if (is_sound) return NEPH_OK;
  np_cloud_glow_clear(out_glow);
  return np_fail(density->context, NEPH_ERROR_BAD_SCENE, "cloud %s: the transform of its emission cannot be inverted",
                 cloud->name);
}

void np_cloud_glow_clear(np_cloud_glow *glow) {
  neph_volume_release(glow->temperature);
  neph_volume_release(glow->flame);
  *glow = (np_cloud_glow){0};
}

np_glow np_cloud_glow_get(const np_cloud_glow *glow, const np_view_volume *cloud) {
  np_glow out = glow->glow;
  np_spectrum absorption = np_spectrum_grey(glow->flame_absorption_per_m);
  if (!glow->flame)
    absorption =
        np_spectrum_scale(np_spectrum_subtract(np_spectrum_grey(1.0f), cloud->albedo), cloud->extinction_per_value);
  out.absorption_per_value = np_spectrum_scale(absorption, glow->strength);
  return out;
}
