/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/cloud_emission.h"

#include <string.h>

#include "volume/volume_tint.h"

/* Range of temperatures. Above lightning's, the unit must be wrong; below the range no emission is visible. */
static const double hottest_k = 1e5, coldest_k = 600.0;

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

static bool has_color(const np_cloud_emission *emission) {
  return emission->color[0] || emission->color[1] || emission->color[2];
}

/* Half a kelvin at 1000 K, the resolution of halves there, is 1 % of the radiance at 680 nm. */
static neph_result load_temperature(const np_cloud_emission_source *source, np_cloud_emission *emission) {
  const char *name = source->cloud->emission.temperature;
  if (np_scene_is_none(name)) return NEPH_OK;
  neph_volume_load_desc exact = *source->load;
  exact.precision = NEPH_PRECISION_FLOAT;
  exact.grid = name ? name : "temperature";
  bool is_in_file;
  neph_result result = np_volume_load_field(source->context, source->path, &exact,
                                            name || !has_color(emission) ? NP_TEMPERATURE_KEY : NULL, &is_in_file,
                                            &emission->temperature);
  return result || !emission->temperature ? result : check_temperature(source->cloud, emission->temperature);
}

static neph_result load_flame(const np_cloud_emission_source *source, np_cloud_emission *emission,
                              bool *out_is_in_file) {
  const char *name = source->cloud->emission.flame;
  *out_is_in_file = false;
  if (np_scene_is_none(name)) return NEPH_OK;
  neph_volume_load_desc flame = *source->load;
  flame.grid = name ? name : "flame";
  neph_result result = np_volume_load_field(source->context, source->path, &flame, name ? NP_FLAME_KEY : NULL,
                                            out_is_in_file, &emission->flame);
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

/* A file of colours may have no temperatures, and then nothing of it is hot. */
static bool has_heat(const np_cloud_emission_source *source, const np_cloud_emission *emission) {
  const np_scene_emission *e = &source->cloud->emission;
  return emission->temperature || !has_color(emission) || (np_scene_is_none(e->temperature) && e->offset_k > 0.0);
}

/* ---- Places ---- */

/* Places a grid of the file: grids of one file keep their relative positions, each with its own voxels. */
static neph_result place_field(const np_cloud_emission_source *source, const neph_volume *field, np_emitter *out) {
  out->bricks = &field->bricks;
  out->index_to_world = np_affine_compose(source->file_to_world, &field->index_to_world);
  if (np_affine_invert(&out->index_to_world, &out->world_to_index)) return NEPH_OK;
  return np_fail(source->context, NEPH_ERROR_BAD_SCENE, "cloud %s: the transform of its emission cannot be inverted",
                 source->cloud->name);
}

static neph_result place_temperature(const np_cloud_emission_source *source, const neph_volume *temperature,
                                     np_emitter *out) {
  np_emitter place;
  neph_result result = place_field(source, temperature, &place);
  out->temperature = &temperature->bricks;
  out->world_to_temperature = place.world_to_index;
  out->kelvin_per_value = (float)source->cloud->emission.kelvin_per_value;
  return result;
}

static neph_result place(const np_cloud_emission_source *source, np_cloud_emission *out) {
  neph_result result = NEPH_OK;
  out->emitter.offset_k = (float)source->cloud->emission.offset_k;
  if (out->has_body) result = place_field(source, out->flame ? out->flame : source->density, &out->emitter);
  if (out->has_body && out->temperature && !result) result = place_temperature(source, out->temperature, &out->emitter);
  for (int c = 0; c < 3 && !result; c++)
    if (out->color[c]) result = place_field(source, out->color[c], &out->color_emitter[c]);
  return result;
}

/* ---- Colours ---- */

/* Negative light becomes 0. */
static uint64_t clamp_values(np_sparse_grid *grid) {
  uint64_t count = 0;
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      count += grid->leaves[i].values[n] < 0.0f;
      grid->leaves[i].values[n] = fmaxf(grid->leaves[i].values[n], 0.0f);
    }
  for (size_t i = 0; i < grid->tile_count; i++) {
    count += grid->tiles[i].value < 0.0f;
    grid->tiles[i].value = fmaxf(grid->tiles[i].value, 0.0f);
  }
  grid->background = fmaxf(grid->background, 0.0f);
  return count;
}

/* A component without any light is left out. */
static neph_result make_color(const np_cloud_emission_source *source, np_sparse_grid *grid, neph_volume **out) {
  np_grid_extent extent;
  const uint64_t negative = clamp_values(grid);
  if (negative)
    np_log(source->context, NEPH_LOG_WARNING, "%s: grid '%s': %llu values of emitted light are negative; taken as 0",
           source->path, grid->name, (unsigned long long)negative);
  if (!np_sparse_grid_measure(grid, &extent) || !(extent.value_max > 0.0f)) return NEPH_OK;
  return np_volume_create_from_grid(source->context, grid, source->load->precision, NULL, out);
}

static neph_result load_colors(const np_cloud_emission_source *source, np_cloud_emission *out) {
  const np_vector_request request = {NP_VECTOR_EMISSION, source->cloud->emission.color, source->load->policy};
  np_sparse_grid grids[3];
  bool is_found;
  if (np_scene_is_none(request.name)) return NEPH_OK;
  neph_result result = np_volume_load_vector(source->context, source->path, &request, NULL, grids, &is_found);
  for (int c = 0; c < 3 && is_found && !result; c++) result = make_color(source, &grids[c], &out->color[c]);
  for (int c = 0; c < 3; c++) np_sparse_grid_clear(&grids[c]);
  if (!result && is_found && !has_color(out))
    np_log(source->context, NEPH_LOG_WARNING, "cloud %s: the colours that it emits are all 0", source->cloud->name);
  return result;
}

/* ---- All ---- */

static neph_result load_body(const np_cloud_emission_source *source, np_cloud_emission *out) {
  bool is_flame_in_file;
  neph_result result = load_temperature(source, out);
  if (result || !has_heat(source, out)) return result;
  result = load_flame(source, out, &is_flame_in_file);
  if (!result) out->has_body = is_emitting(source, out, is_flame_in_file);
  return result;
}

neph_result np_cloud_emission_load(const np_cloud_emission_source *source, np_cloud_emission *out_emission) {
  *out_emission = (np_cloud_emission){.strength = (float)source->cloud->emission.strength};
  neph_result result = load_colors(source, out_emission);
  if (!result) result = load_body(source, out_emission);
  if (!result) result = place(source, out_emission);
  out_emission->is_enabled = out_emission->has_body || has_color(out_emission);
  if (result) np_cloud_emission_clear(out_emission);
  return result;
}

void np_cloud_emission_clear(np_cloud_emission *emission) {
  neph_volume_release(emission->temperature);
  neph_volume_release(emission->flame);
  for (int c = 0; c < 3; c++) neph_volume_release(emission->color[c]);
  *emission = (np_cloud_emission){0};
}

/* Absorption by the flame, or by a part of the cloud. */
static np_emitter make_body(const np_cloud_emission *emission, const np_instance *part) {
  np_emitter out = emission->emitter;
  np_spectrum absorption = np_spectrum_grey(emission->flame_absorption_per_m);
  out.part = NP_EMITTER_FLAME;
  if (!emission->flame) {
    absorption =
        np_spectrum_scale(np_spectrum_subtract(np_spectrum_grey(1.0f), part->albedo), part->extinction_per_value);
    out.bricks = part->bricks;
    out.part = part->part;
  }
  out.absorption_per_value = np_spectrum_scale(absorption, emission->strength);
  return out;
}

unsigned np_cloud_emission_list(const np_cloud_emission *emission, const np_emission_matter *matter,
                                np_emitter out[NP_CLOUD_EMITTERS_MAX]) {
  const unsigned bodies = !emission->has_body ? 0 : emission->flame ? 1 : matter->part_count;
  unsigned count = 0;
  for (unsigned k = 0; k < bodies; k++) out[count++] = make_body(emission, &matter->parts[k]);
  for (unsigned c = 0; c < 3; c++) {
    if (!emission->color[c]) continue;
    np_emitter *own = &out[count++];
    *own = emission->color_emitter[c];
    own->has_no_body = true;
    own->part = NP_EMITTER_COLOR + c;
    own->absorption_per_value = np_spectrum_scale(matter->color[c], emission->strength);
  }
  for (unsigned k = 0; k < count; k++) {
    out[k].is_held_out = matter->parts[0].is_held_out;
    out[k].number = matter->parts[0].number;
  }
  return count;
}
