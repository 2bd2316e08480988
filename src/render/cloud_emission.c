/* SPDX-License-Identifier: Apache-2.0 */
#include "render/cloud_emission.h"

#include <string.h>

#include "volume/volume_private.h"

/* Hotter than lightning: a unit has been taken for another. Below the other end no emission is visible. */
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
static neph_result load_temperature(const np_cloud_emission_source *source, np_cloud_emission *emission) {
  const char *name = source->cloud->emission.temperature;
  if (is_none(name)) return NEPH_OK;
  neph_volume_load_desc exact = *source->load;
  exact.precision = NEPH_PRECISION_FLOAT;
  exact.grid = name ? name : "temperature";
  neph_result result = np_volume_load_field(source->context, source->path, &exact, true, NULL, &emission->temperature);
  return result || !emission->temperature ? result : check_temperature(source->cloud, emission->temperature);
}

static neph_result load_flame(const np_cloud_emission_source *source, np_cloud_emission *emission,
                              bool *out_is_in_file) {
  const char *name = source->cloud->emission.flame;
  *out_is_in_file = false;
  if (is_none(name)) return NEPH_OK;
  neph_volume_load_desc flame = *source->load;
  flame.grid = name ? name : "flame";
  neph_result result =
      np_volume_load_field(source->context, source->path, &flame, name != NULL, out_is_in_file, &emission->flame);
  if (emission->flame) emission->flame_absorption_per_m = (float)source->cloud->emission.absorption_per_m;
  return result;
}

/* Flames emit where there are any. Without them the cloud does, by what it absorbs at its temperature; but where the
 * file has a grid of flames, and it is empty, a temperature that is the same everywhere is that of no cloud. */
static bool is_emitting(const np_cloud_emission_source *source, const np_cloud_emission *emission,
                        bool is_flame_in_file) {
  if (emission->flame) return true;
  if (!source->density || (is_flame_in_file && !emission->temperature)) return false;
  if (is_flame_in_file)
    np_log(source->context, NEPH_LOG_INFO, "cloud %s: without flames it glows by its temperature and what it absorbs",
           source->cloud->name);
  return true;
}

/* Grids of one file keep their places to each other, each on a lattice of its own. */
static neph_result place(const np_cloud_emission_source *source, np_cloud_emission *out) {
  const neph_volume *field = out->flame ? out->flame : source->density, *temperature = out->temperature;
  np_emitter *emitter = &out->emitter;
  emitter->bricks = &field->bricks;
  emitter->index_to_world = np_affine_compose(source->file_to_world, &field->index_to_world);
  emitter->offset_k = (float)source->cloud->emission.offset_k;
  bool is_sound = np_affine_invert(&emitter->index_to_world, &emitter->world_to_index);
  if (temperature) {
    const np_affine index_to_world = np_affine_compose(source->file_to_world, &temperature->index_to_world);
    is_sound = np_affine_invert(&index_to_world, &emitter->world_to_temperature) && is_sound;
    emitter->temperature = &temperature->bricks;
    emitter->kelvin_per_value = (float)source->cloud->emission.kelvin_per_value;
  }
  if (is_sound) return NEPH_OK;
  return np_fail(source->context, NEPH_ERROR_BAD_SCENE, "cloud %s: the transform of its emission cannot be inverted",
                 source->cloud->name);
}

neph_result np_cloud_emission_load(const np_cloud_emission_source *source, np_cloud_emission *out_emission) {
  *out_emission = (np_cloud_emission){.strength = (float)source->cloud->emission.strength};
  bool is_flame_in_file;
  neph_result result = load_temperature(source, out_emission);
  if (!result) result = load_flame(source, out_emission, &is_flame_in_file);
  if (!result) out_emission->is_enabled = is_emitting(source, out_emission, is_flame_in_file);
  if (!result && out_emission->is_enabled) result = place(source, out_emission);
  if (result) np_cloud_emission_clear(out_emission);
  return result;
}

void np_cloud_emission_clear(np_cloud_emission *emission) {
  neph_volume_release(emission->temperature);
  neph_volume_release(emission->flame);
  *emission = (np_cloud_emission){0};
}

np_emitter np_cloud_emission_get(const np_cloud_emission *emission, const np_instance *cloud) {
  np_emitter out = emission->emitter;
  out.is_held_out = cloud->is_held_out;
  out.number = cloud->number;
  np_spectrum absorption = np_spectrum_grey(emission->flame_absorption_per_m);
  if (!emission->flame)
    absorption =
        np_spectrum_scale(np_spectrum_subtract(np_spectrum_grey(1.0f), cloud->albedo), cloud->extinction_per_value);
  out.absorption_per_value = np_spectrum_scale(absorption, emission->strength);
  return out;
}
