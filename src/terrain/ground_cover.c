/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/ground_cover.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/context_private.h"
#include "core/units.h"
#include "image/image_private.h"
#include "terrain/land_cover.h"

/* ---- Picture ---- */

static const char *get_ending(const char *path) {
  const char *slash = strrchr(path, '/'), *ending = strrchr(slash ? slash : path, '.');
  return ending ? ending : "";
}

static neph_result fail_ending(neph_context *context, const char *path) {
  return np_fail(context, NEPH_ERROR_UNSUPPORTED, "%s: pictures of albedo are read from .exr and .png, not from \"%s\"",
                 path, get_ending(path));
}

static bool is_png(const char *path) { return !strcasecmp(get_ending(path), ".png"); }

neph_result np_ground_cover_check_image(neph_context *context, const char *path) {
  unsigned size[2];
  if (!is_png(path) && strcasecmp(get_ending(path), ".exr") != 0) return fail_ending(context, path);
  return np_image_read_size(context, path, size);
}

static neph_result load_image(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image) {
  if (is_png(path)) return np_image_load_png(context, path, monitor, out_image);
  if (!strcasecmp(get_ending(path), ".exr")) return np_image_load_exr(context, path, monitor, out_image);
  return fail_ending(context, path);
}

/* Linear value of an sRGB code value (IEC 61966-2-1). */
static float decode_srgb(float code) { return code <= 0.04045f ? code / 12.92f : powf((code + 0.055f) / 1.055f, 2.4f); }

/* The plane of R, G or B; a grey picture's only one. NULL: the picture has other channels. */
static const float *get_plane(neph_image *image, int channel) {
  static const char *const names[3] = {"R", "G", "B"};
  const float *plane = neph_image_get_channel(image, names[channel]);
  return plane ? plane : neph_image_get_channel(image, "Y");
}

static neph_result copy_plane(np_ground_cover *cover, const char *path, const float *plane, int channel) {
  const size_t count = (size_t)cover->width * cover->height;
  const bool is_coded = is_png(path);
  for (size_t i = 0; i < count; i++) {
    const float value = is_coded ? decode_srgb(plane[i]) : plane[i];
    if (!(value >= 0.0f && value <= 1.0f))
      return np_fail(cover->context, NEPH_ERROR_BAD_FILE, "%s: albedo is %g at column %zu, row %zu, must be in [0, 1]",
                     path, (double)plane[i], i % cover->width, i / cover->width);
    cover->texels[i][channel] = value;
  }
  return NEPH_OK;
}

static neph_result copy_image(np_ground_cover *cover, const char *path, neph_image *image) {
  cover->width = neph_image_get_width(image);
  cover->height = neph_image_get_height(image);
  cover->texels = np_alloc(cover->context, (size_t)cover->width * cover->height, sizeof *cover->texels);
  if (!cover->texels) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (int c = 0; c < 3 && !result; c++) {
    const float *plane = get_plane(image, c);
    if (!plane)
      return np_fail(cover->context, NEPH_ERROR_BAD_FILE, "%s: a picture of albedo must have channels R, G and B, or Y",
                     path);
    result = copy_plane(cover, path, plane, c);
  }
  return result;
}

/* ---- Making ---- */

static np_cover_layer make_layer(bool is_enabled, const double albedo[3], double slope_rad, double level_m) {
  return (np_cover_layer){.is_enabled = is_enabled,
                          .albedo = {(float)albedo[0], (float)albedo[1], (float)albedo[2]},
                          .slope_rad = (float)slope_rad,
                          .level_m = (float)level_m};
}

neph_result np_ground_cover_create(neph_context *context, const neph_terrain_desc *desc, np_monitor *monitor,
                                   np_ground_cover *out) {
  *out = (np_ground_cover){
      .context = context,
      .noise = np_noise_get_table(context->isa),
      .albedo = {(float)desc->ground_albedo[0], (float)desc->ground_albedo[1], (float)desc->ground_albedo[2]},
      .rock = make_layer(desc->has_rock, desc->rock_albedo, desc->rock_slope_rad, 0.0),
      .snow = make_layer(desc->has_snow, desc->snow_albedo, desc->snow_slope_rad, desc->snow_level_m)};
  out->climate = desc->ground_cover;
  if (!desc->albedo_image || out->climate) return NEPH_OK;
  neph_image *image;
  neph_result result = load_image(context, desc->albedo_image, monitor, &image);
  if (result) return result;
  result = copy_image(out, desc->albedo_image, image);
  neph_image_destroy(image);
  if (result) np_ground_cover_destroy(out);
  return result;
}

void np_ground_cover_destroy(np_ground_cover *cover) {
  if (cover->texels) np_alloc_free(cover->context, cover->texels);
  *cover = (np_ground_cover){0};
}

/* ---- Look-up ---- */

/* The two texels around a position along one axis, with the first texel's centre at ½, and the fraction between
 * them. */
typedef struct albedo_texels {
  size_t low, high;
  float fraction;
} albedo_texels;

static albedo_texels compute_texels(float position, unsigned size) {
  const float last = (float)(size - 1), at = np_clampf(position * (float)size - 0.5f, 0.0f, last);
  const size_t low = (size_t)at;
  return (albedo_texels){low, low + 1 < size ? low + 1 : low, at - (float)low};
}

static void sample_image(const np_ground_cover *cover, const np_cover_place *place, float out[3]) {
  const albedo_texels u = compute_texels(place->east, cover->width);
  const albedo_texels v = compute_texels(1.0f - place->north, cover->height);
  const float(*upper)[3] = (const float(*)[3])cover->texels + v.low * cover->width;
  const float(*lower)[3] = (const float(*)[3])cover->texels + v.high * cover->width;
  for (int c = 0; c < 3; c++)
    out[c] = np_mixf(np_mixf(upper[u.low][c], upper[u.high][c], u.fraction),
                     np_mixf(lower[u.low][c], lower[u.high][c], u.fraction), v.fraction);
}

/* Longest waves of the noise at the borders of rock and of snow; its octaves go down to some 3 m. */
static const double rock_length_m = 150.0, snow_length_m = 400.0;
enum { ROCK_OCTAVES = 6, SNOW_OCTAVES = 8 };
static const float rock_gain = 0.75f, snow_gain = 0.65f;

/* Widths of the borders, and displacement by noise per unit of it: noise is within ±0.5, rms 0.1. */
static const float slope_width_rad = 0.09f, slope_sway_rad = 1.5f;
static const float level_width_m = 40.0f, level_sway_m = 1000.0f;
static const float noise_max = 0.6f;

static float eval_noise(const np_ground_cover *cover, const np_cover_place *place, bool is_snow) {
  const np_noise_lattice lattice = {.seed = is_snow, .period = {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, 1}};
  const np_noise_octaves octaves = {is_snow ? SNOW_OCTAVES : ROCK_OCTAVES, is_snow ? snow_gain : rock_gain};
  const double length = is_snow ? snow_length_m : rock_length_m;
  const float x = (float)(place->east_m / length), y = (float)(place->north_m / length), z = 0.5f;
  float value;
  cover->noise->perlin_fbm(&lattice, &octaves, &(np_noise_points){1, &x, &y, &z}, &value);
  return value;
}

/* Share of a layer at an `excess` over its border, in units of the border's width. */
static float eval_border(float excess) { return np_smoothstepf(excess + 0.5f); }

/* Whether noise can affect a border here. */
static bool is_near_border(float excess, float width, float sway) {
  return fabsf(excess) < 0.5f * width + noise_max * sway;
}

static float eval_rock(const np_ground_cover *cover, const np_cover_place *place) {
  const float steep = place->slope_rad - cover->rock.slope_rad;
  const bool is_broken = is_near_border(steep, slope_width_rad, slope_sway_rad);
  const float noise = is_broken ? eval_noise(cover, place, false) : 0.0f;
  return eval_border((steep + slope_sway_rad * noise) / slope_width_rad);
}

/* Share of snow: on high ground, less on steep slopes. */
static float eval_snow(const np_ground_cover *cover, const np_cover_place *place) {
  const float high = place->elevation_m - cover->snow.level_m, steep = place->slope_rad - cover->snow.slope_rad;
  if (high < -0.5f * level_width_m - noise_max * level_sway_m) return 0.0f;
  const bool is_broken =
      is_near_border(high, level_width_m, level_sway_m) || is_near_border(steep, slope_width_rad, slope_sway_rad);
  const float noise = is_broken ? eval_noise(cover, place, true) : 0.0f;
  return eval_border((high + level_sway_m * noise) / level_width_m) *
         (1.0f - eval_border((steep - slope_sway_rad * noise) / slope_width_rad));
}

void np_ground_cover_eval(const np_ground_cover *cover, const np_cover_place *place, float out_albedo[3]) {
  if (cover->climate)
    np_land_cover_eval(cover->climate, cover->noise, place, out_albedo);
  else if (cover->texels)
    sample_image(cover, place, out_albedo);
  else
    memcpy(out_albedo, cover->albedo, sizeof cover->albedo);
  const float rock = cover->rock.is_enabled ? eval_rock(cover, place) : 0.0f;
  const float snow = cover->snow.is_enabled ? eval_snow(cover, place) : 0.0f;
  for (int c = 0; c < 3; c++)
    out_albedo[c] = np_mixf(np_mixf(out_albedo[c], cover->rock.albedo[c], rock), cover->snow.albedo[c], snow);
}
