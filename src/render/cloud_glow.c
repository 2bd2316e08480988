/* SPDX-License-Identifier: Apache-2.0 */
#include "render/cloud_glow.h"

#include <string.h>

#include "volume/volume_private.h"

/* Hotter than lightning: a unit has been taken for another. Below the other end nothing is seen to glow. */
static const double hottest_k = 1e5, coldest_k = 600.0;

static bool is_none(const char *name) { return name && strcmp(name, "none") == 0; }

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
static neph_result load_temperature(const np_cloud_glow_source *source, np_cloud_glow *glow) {
  const char *name = source->cloud->emission.temperature;
  if (is_none(name)) return NEPH_OK;
  neph_volume_load_desc exact = *source->load;
  exact.precision = NEPH_PRECISION_FLOAT;
  exact.grid = name ? name : "temperature";
  neph_result result = np_volume_load_field(source->context, source->path, &exact, true, NULL, &glow->temperature);
  return result || !glow->temperature ? result : check_temperature(source->cloud, glow->temperature);
}

static neph_result load_flame(const np_cloud_glow_source *source, np_cloud_glow *glow, bool *out_is_in_file) {
  const char *name = source->cloud->emission.flame;
  *out_is_in_file = false;
  if (is_none(name)) return NEPH_OK;
  neph_volume_load_desc flame = *source->load;
  flame.grid = name ? name : "flame";
  neph_result result =
      np_volume_load_field(source->context, source->path, &flame, name != NULL, out_is_in_file, &glow->flame);
  if (glow->flame) glow->flame_absorption_per_m = (float)source->cloud->emission.absorption_per_m;
  return result;
}

/* Flames glow where there are any. Without them the cloud does, by what it absorbs at its temperature; but where the
 * file has a grid of flames, and it is empty, a temperature that is the same everywhere is that of no cloud. */
static bool has_glow(const np_cloud_glow_source *source, const np_cloud_glow *glow, bool is_flame_in_file) {
  if (glow->flame) return true;
  if (!source->density || (is_flame_in_file && !glow->temperature)) return false;
  if (is_flame_in_file)
    np_log(source->context, NEPH_LOG_INFO, "cloud %s: without flames it glows by its temperature and what it absorbs",
           source->cloud->name);
  return true;
}

/* Grids of one file keep their places to each other, each on a lattice of its own. */
static neph_result place(const np_cloud_glow_source *source, np_cloud_glow *out) {
  const neph_volume *field = out->flame ? out->flame : source->density, *temperature = out->temperature;
  np_glow *glow = &out->glow;
  glow->bricks = &field->bricks;
  glow->index_to_world = np_affine_compose(source->file_to_world, &field->index_to_world);
  glow->offset_k = (float)source->cloud->emission.offset_k;
  bool is_sound = np_affine_invert(&glow->index_to_world, &glow->world_to_index);
  if (temperature) {
    const np_affine index_to_world = np_affine_compose(source->file_to_world, &temperature->index_to_world);
    is_sound = np_affine_invert(&index_to_world, &glow->world_to_temperature) && is_sound;
    glow->temperature = &temperature->bricks;
    glow->kelvin_per_value = (float)source->cloud->emission.kelvin_per_value;
  }
  if (is_sound) return NEPH_OK;
  return np_fail(source->context, NEPH_ERROR_BAD_SCENE, "cloud %s: the transform of its emission cannot be inverted",
                 source->cloud->name);
}

neph_result np_cloud_glow_load(const np_cloud_glow_source *source, np_cloud_glow *out_glow) {
  *out_glow = (np_cloud_glow){.strength = (float)source->cloud->emission.strength};
  bool is_flame_in_file;
  neph_result result = load_temperature(source, out_glow);
  if (!result) result = load_flame(source, out_glow, &is_flame_in_file);
  if (!result) out_glow->is_there = has_glow(source, out_glow, is_flame_in_file);
  if (!result && out_glow->is_there) result = place(source, out_glow);
  if (result) np_cloud_glow_clear(out_glow);
  return result;
}

void np_cloud_glow_clear(np_cloud_glow *glow) {
  neph_volume_release(glow->temperature);
  neph_volume_release(glow->flame);
  *glow = (np_cloud_glow){0};
}

np_glow np_cloud_glow_get(const np_cloud_glow *glow, const np_instance *cloud) {
  np_glow out = glow->glow;
  np_spectrum absorption = np_spectrum_grey(glow->flame_absorption_per_m);
  if (!glow->flame)
    absorption =
        np_spectrum_scale(np_spectrum_subtract(np_spectrum_grey(1.0f), cloud->albedo), cloud->extinction_per_value);
  out.absorption_per_value = np_spectrum_scale(absorption, glow->strength);
  return out;
}
