/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_control.h"

#include <math.h>
#include <string.h>

#include "core/text.h"
#include "scene/scene_keys.h"

/* ---- Basic keys ---- */

typedef enum scale { LINEAR, LOGARITHMIC } scale;

/* A basic key. A range of 0 to 0 is the key's own. */
typedef struct basic_row {
  const char *path, *label;
  double min, max; /* in the key's unit */
  scale scale;
} basic_row;

static const basic_row basics[] = {
    {"camera.position", "position", -2e4, 2e4, LINEAR},
    {"camera.look_at", "look at", -2e4, 2e4, LINEAR},
    {"camera.fov", "angle of view", 5, 120, LINEAR},
    {"camera.focal_length", "focal length", 0.01, 0.4, LOGARITHMIC},
    {"camera.roll", "roll", -45, 45, LINEAR},
    {"camera.f_stop", "f-stop", 1, 32, LOGARITHMIC},
    {"camera.focus_distance", "focus", 1, 1e5, LOGARITHMIC},
    {"sun.elevation", "height", -20, 90, LINEAR},
    {"sun.azimuth", "direction", 0, 360, LINEAR},
    {"sun.time", "time", 0, 0, LINEAR},
    {"place.latitude", "latitude", 0, 0, LINEAR},
    {"place.longitude", "longitude", 0, 0, LINEAR},
    {"moon.elevation", "height", 0, 0, LINEAR},
    {"moon.azimuth", "direction", 0, 360, LINEAR},
    {"atmosphere.preset", "air", 0, 0, LINEAR},
    {"atmosphere.haze", "kind of haze", 0, 0, LINEAR},
    {"atmosphere.visibility", "visual range", 1e3, 2e5, LOGARITHMIC},
    {"atmosphere.mie_scattering", "haze", 1e-7, 1e-3, LOGARITHMIC},
    {"atmosphere.mie_height", "height of haze", 100, 1e4, LOGARITHMIC},
    {"atmosphere.mie_asymmetry", "haze forward", 0, 0.95, LINEAR},
    {"atmosphere.ozone_absorption", "ozone", 1e-7, 1e-5, LOGARITHMIC},
    {"clouds[].name", "name", 0, 0, LINEAR},
    {"clouds[].position", "position", -2e4, 2e4, LINEAR},
    {"clouds[].rotation", "rotation", -180, 180, LINEAR},
    {"clouds[].scale", "scale", 0.1, 10, LOGARITHMIC},
    {"clouds[].extinction", "extinction", 1e-3, 1, LOGARITHMIC},
    {"clouds[].optical_depth", "optical depth", 0.1, 300, LOGARITHMIC},
    {"clouds[].albedo", "albedo", 0.9, 1, LINEAR},
    {"clouds[].phase.hg", "forward", -0.5, 0.95, LINEAR},
    {"clouds[].phase.droplets.diameter", "droplets", 0, 0, LOGARITHMIC},
    {"clouds[].bake.preset", "kind", 0, 0, LINEAR},
    {"clouds[].bake.seed", "seed", 0, 100, LINEAR},
    {"clouds[].bake.coverage", "coverage", 0, 0, LINEAR},
    {"clouds[].bake.base", "base", 0, 12e3, LINEAR},
    {"clouds[].bake.thickness", "thickness", 50, 12e3, LOGARITHMIC},
    {"clouds[].bake.cell", "size", 100, 2e4, LOGARITHMIC},
    {"clouds[].bake.type", "heap or layer", 0, 0, LINEAR},
    {"clouds[].bake.billow", "billows", 20, 3e3, LOGARITHMIC},
    {"clouds[].bake.billowiness", "billowiness", 0, 0, LINEAR},
    {"clouds[].bake.erosion", "erosion", 0, 0, LINEAR},
    {"clouds[].bake.wispiness", "wispiness", 0, 0, LINEAR},
    {"clouds[].bake.turbulence", "turbulence", 0, 0, LINEAR},
    {"clouds[].bake.extinction", "density", 1e-3, 0.3, LOGARITHMIC},
    {"clouds[].bake.anvil", "anvil", 0, 0, LINEAR},
    {"clouds[].bake.age", "age", 0, 0, LINEAR},
    {"clouds[].bake.precipitation", "rain", 0, 0, LINEAR},
    {"clouds[].bake.extent", "extent", 500, 1e5, LOGARITHMIC},
    {"clouds[].bake.voxel", "voxel", 2, 200, LOGARITHMIC},
    {"terrain.albedo", "albedo", 0, 0, LINEAR},
    {"terrain.ridges.seed", "seed", 0, 100, LINEAR},
    {"terrain.ridges.relief", "relief", 0, 5e3, LINEAR},
    {"terrain.ridges.ridge", "width of ridges", 500, 5e4, LOGARITHMIC},
    {"terrain.snow.level", "snow line", 0, 5e3, LINEAR},
    {"water.level", "level", -100, 1e3, LINEAR},
    {"water.wind", "wind", 0, 20, LINEAR},
    {"render.quality", "quality", 0, 0, LINEAR},
    {"render.samples", "samples", 1, 256, LOGARITHMIC},
    {"output.exposure", "exposure", -10, 10, LINEAR},
    {"output.view", "view", 0, 0, LINEAR},
    {"output.glare", "glare", 0, 0.2, LINEAR},
};

/* The row of a key; another key has one of its name, without a path. */
static basic_row get_row(const np_key *key) {
  for (size_t i = 0; i < sizeof basics / sizeof *basics; i++)
    if (!strcmp(basics[i].path, key->path)) return basics[i];
  return (basic_row){.label = np_key_get_name(key)};
}

const char *np_control_get_basic(size_t index) {
  return index < sizeof basics / sizeof *basics ? basics[index].path : NULL;
}

/* ---- Ranges ---- */

/* First number of the default in the key's unit; 0: none. */
static double get_fallback(const np_key *key) {
  double value = 0.0;
  if (!key->fallback || !np_value_parse_real(key->fallback, key->unit, &value)) return 0.0;
  return value / np_unit_to_si(key->unit, 1.0);
}

/* A range without a row: the key's own where that is narrow, else around the default. */
static bool choose_range(const np_key *key, np_range *out) {
  static const double narrow = 1000.0, around = 4.0;
  const double fallback = fabs(get_fallback(key));
  *out = key->range;
  if (key->range.max - key->range.min <= narrow) return key->range.min < key->range.max;
  if (!(fallback > 0.0)) return false;
  out->min = fmax(key->range.min, key->range.min < 0.0 ? -around * fallback : 0.0);
  out->max = fmin(key->range.max, around * fallback);
  return out->min < out->max;
}

/* The greatest of 1, 2 and 5 times a power of ten that is not above a value. */
static double round_step(double value) {
  const double power = pow(10.0, floor(log10(value))), digit = value / power;
  return power * (digit < 2.0 ? 1.0 : digit < 5.0 ? 2.0 : 5.0);
}

static double choose_step(const np_key *key, const np_control *control) {
  static const double step_share = 0.01;
  if (key->type == NP_KEY_INTEGER) return 1.0;
  if (control->is_logarithmic) return step_share;
  return round_step(step_share * (control->soft.max - control->soft.min));
}

void np_control_get(const np_key *key, np_control *out) {
  const basic_row row = get_row(key);
  const bool is_number = key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER || key->type == NP_KEY_SEED;
  *out = (np_control){.is_basic = row.path != NULL};
  np_print(out->label, sizeof out->label, "%s", row.label);
  for (char *c = out->label; *c; c++)
    if (*c == '_') *c = ' ';
  if (!is_number) return;
  out->is_logarithmic = row.scale == LOGARITHMIC;
  out->has_range = row.min < row.max;
  if (out->has_range)
    out->soft = (np_range){row.min, row.max};
  else if (key->type != NP_KEY_SEED)
    out->has_range = choose_range(key, &out->soft);
  if (out->has_range) out->step = key->type == NP_KEY_SEED ? 1.0 : choose_step(key, out);
}

/* ---- Costs ---- */

/* Cost of the keys with a prefix; the longest prefix decides. */
static const struct cost_row {
  const char *prefix, *cost;
} costs[] = {
    {"", "light"},
    {"version", "display"},
    {"output", "view"},
    {"output.exposure", "display"},
    {"output.view", "display"},
    {"output.glare", "display"},
    {"output.preview", "display"},
    {"output.preview_bits", "display"},
    {"output.image", "display"},
    {"output.pixel_type", "display"},
    {"camera", "view"},
    {"stars", "view"},
    {"airglow", "view"},
    {"render", "view"},
    {"render.quality", "bake"},
    {"render.detail", "bake"},
    {"render.multiple_scattering", "light"},
    {"render.sun_optical_depth", "light"},
    {"render.light_detail", "light"},
    {"render.light_depth", "light"},
    {"render.light_degree", "light"},
    {"render.light_residual", "light"},
    {"render.light_memory", "light"},
    {"animate", "bake"},
    {"clouds", "bake"},
    {"clouds[].name", "view"},
    {"clouds[].holdout", "view"},
    {"clouds[].position", "light"},
    {"clouds[].rotation", "light"},
    {"clouds[].scale", "light"},
    {"clouds[].tilt", "light"},
    {"clouds[].extinction", "light"},
    {"clouds[].mean_free_path", "light"},
    {"clouds[].optical_depth", "light"},
    {"clouds[].liquid_water", "light"},
    {"clouds[].albedo", "light"},
    {"clouds[].phase", "light"},
    {"clouds[].emission", "light"},
    {"clouds[].detail", "light"},
    {"terrain", "bake"},
    {"terrain.albedo", "light"},
    {"terrain.ground_cover", "light"},
    {"terrain.rock", "light"},
    {"terrain.snow", "light"},
    {"terrain.holdout", "view"},
};

const char *np_control_get_cost(const np_key *key) {
  const struct cost_row *best = costs;
  for (size_t i = 1; i < sizeof costs / sizeof *costs; i++) {
    const size_t length = strlen(costs[i].prefix);
    const bool fits = !strncmp(key->path, costs[i].prefix, length) && strchr(".[", key->path[length]);
    if (fits && length > strlen(best->prefix)) best = &costs[i];
  }
  return best->cost;
}
