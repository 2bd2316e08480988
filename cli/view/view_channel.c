/* SPDX-License-Identifier: Apache-2.0 */
#include "view_channel.h"

#include <math.h>
#include <string.h>

#include "print.h"

const char cli_view_luminance[] = "luminance";
const char cli_view_relative_error[] = "relative_error";

static const char *const components[] = {"R", "G", "B"};
enum { COMPONENT_COUNT = 3 };
static const double stops_max = 12.0;
static const double share_max = 1.0; /* an error as large as the luminance */

static size_t count_pixels(const neph_image *image) {
  return (size_t)neph_image_get_width(image) * neph_image_get_height(image);
}

/* The plane of a component of a colour, "sun.R"; NULL: there is none. */
static const float *get_component(const neph_image *image, const char *name, size_t component) {
  cli_text text = {0};
  cli_text_add(&text, "%s.%s", name, components[component]);
  const float *plane = text.has_failed ? NULL : neph_image_get_values(image, cli_text_get(&text));
  cli_text_clear(&text);
  return plane;
}

/* ---- Numbers as colours ---- */

/* Colour of a number in [0, 1]: anchors of the map viridis, whose lightness grows evenly. */
static double get_shade(double number, size_t component) {
  static const double anchors[][COMPONENT_COUNT] = {{0.267, 0.005, 0.329},
                                                    {0.230, 0.322, 0.546},
                                                    {0.128, 0.567, 0.551},
                                                    {0.369, 0.789, 0.383},
                                                    {0.993, 0.906, 0.144}};
  const double at = 4.0 * fmin(fmax(number, 0.0), 1.0), first = fmin(floor(at), 3.0);
  const size_t index = (size_t)first;
  return anchors[index][component] + (at - first) * (anchors[index + 1][component] - anchors[index][component]);
}

/* Planes behind the number of a pixel: one plane, or those of the picture with or without its error. */
typedef struct number_source {
  const float *plane;
  const float *colour[COMPONENT_COUNT];
  const float *error[COMPONENT_COUNT];
} number_source;

static double get_luminance(const float *const planes[COMPONENT_COUNT], size_t pixel) {
  static const double weights[COMPONENT_COUNT] = {0.2126, 0.7152, 0.0722};
  double luminance = 0.0;
  for (size_t k = 0; k < COMPONENT_COUNT; k++) luminance += weights[k] * (double)planes[k][pixel];
  return luminance;
}

static bool is_stops(const number_source *source) { return !source->plane && !source->error[0]; }

/* A number of a channel, the error as a share of the luminance, or the stops of luminance; infinite: none. */
static double get_number(const number_source *source, size_t pixel) {
  if (source->plane) return (double)source->plane[pixel];
  const double luminance = get_luminance(source->colour, pixel);
  if (is_stops(source)) return luminance > 0.0 ? log2(luminance) : -HUGE_VAL;
  return luminance > 0.0 ? get_luminance(source->error, pixel) / luminance : HUGE_VAL;
}

static void measure_range(const neph_image *image, const number_source *source, cli_view_channel *out) {
  out->least = HUGE_VAL;
  out->greatest = -HUGE_VAL;
  for (size_t i = 0; i < count_pixels(image); i++) {
    const double number = get_number(source, i);
    if (!isfinite(number)) continue;
    out->least = fmin(out->least, number);
    out->greatest = fmax(out->greatest, number);
  }
  if (is_stops(source)) out->least = fmax(out->least, out->greatest - stops_max);
  if (source->error[0]) out->greatest = fmin(out->greatest, share_max);
}

static void paint_numbers(const neph_image *image, const number_source *source, cli_view_channel *channel) {
  const double extent = channel->greatest > channel->least ? channel->greatest - channel->least : 1.0;
  for (size_t k = 0; k < COMPONENT_COUNT; k++) {
    float *to = neph_image_get_channel(channel->image, components[k]);
    for (size_t i = 0; i < count_pixels(image); i++) {
      const double number = get_number(source, i);
      const bool is_shown = isfinite(number) || is_stops(source);
      to[i] = is_shown ? (float)get_shade((number - channel->least) / extent, k) : 0.0f;
    }
  }
}

/* ---- Channels ---- */

static neph_result create_colour(const neph_image *image, const char *name, cli_view_channel *out) {
  for (size_t k = 0; k < COMPONENT_COUNT; k++) {
    const float *from = get_component(image, name, k);
    if (!from) return NEPH_ERROR_NOT_FOUND;
    memcpy(neph_image_get_channel(out->image, components[k]), from, count_pixels(image) * sizeof *from);
  }
  return NEPH_OK;
}

/* The planes of a name; false: the picture lacks one. */
static bool get_source(const neph_image *image, const char *name, number_source *out) {
  *out = (number_source){0};
  const bool is_share = !strcmp(name, cli_view_relative_error);
  if (!is_share && strcmp(name, cli_view_luminance)) return (out->plane = neph_image_get_values(image, name)) != NULL;
  for (size_t k = 0; k < COMPONENT_COUNT; k++) {
    if (!(out->colour[k] = neph_image_get_values(image, components[k]))) return false;
    if (is_share && !(out->error[k] = get_component(image, "standard_error", k))) return false;
  }
  return true;
}

static neph_result create_numbers(const neph_image *image, const char *name, const cli_view_channel *range,
                                  cli_view_channel *out) {
  number_source source;
  if (!get_source(image, name, &source)) return NEPH_ERROR_NOT_FOUND;
  out->is_scalar = true;
  if (range) {
    out->least = range->least;
    out->greatest = range->greatest;
  } else {
    measure_range(image, &source, out);
  }
  paint_numbers(image, &source, out);
  return NEPH_OK;
}

/* Copies the light of sun and moon, so that colours have the white balance of the picture. */
static neph_result copy_lights(const neph_image *image, neph_image *out) {
  static const char *const names[] = {"nephos:meterX", "nephos:meterY", "nephos:sunElevation", "nephos:moonElevation"};
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < sizeof names / sizeof *names; i++) {
    const char *value = neph_image_get_attribute(image, names[i]);
    if (value) result = neph_image_set_attribute(out, names[i], value);
  }
  return result;
}

neph_result cli_view_channel_create(neph_context *context, const neph_image *image, const char *name,
                                    const cli_view_channel *range, cli_view_channel *out) {
  *out = (cli_view_channel){0};
  neph_result result = neph_image_create(context, neph_image_get_width(image), neph_image_get_height(image),
                                         COMPONENT_COUNT, components, &out->image);
  if (result) return result;
  result = copy_lights(image, out->image);
  if (!result)
    result = get_component(image, name, 0) ? create_colour(image, name, out) : create_numbers(image, name, range, out);
  if (!result) return NEPH_OK;
  neph_image_destroy(out->image);
  out->image = NULL;
  return result;
}

void cli_view_channel_write_names(const neph_image *image, FILE *out) {
  fputc('[', out);
  cli_put_json_text(out, cli_view_luminance);
  number_source error;
  if (get_source(image, cli_view_relative_error, &error)) {
    fputc(',', out);
    cli_put_json_text(out, cli_view_relative_error);
  }
  for (unsigned i = 0; i < neph_image_get_channel_count(image); i++) {
    const char *name = neph_image_get_channel_name(image, i), *dot = strrchr(name, '.');
    const bool is_colour = dot && (!strcmp(dot, ".G") || !strcmp(dot, ".B") || !strcmp(dot, ".R"));
    const bool is_beauty = strlen(name) == 1 && strchr("RGB", *name);
    if (is_beauty || (is_colour && strcmp(dot, ".R"))) continue;
    cli_text text = {0};
    cli_text_add(&text, "%.*s", is_colour ? (int)(dot - name) : (int)strlen(name), name);
    fputc(',', out);
    cli_put_json_text(out, cli_text_get(&text));
    cli_text_clear(&text);
  }
  fputc(']', out);
}
