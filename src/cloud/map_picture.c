/* SPDX-License-Identifier: Apache-2.0 */
/* Renders a weather map from above, as a bake uses it: one panel for each quantity in the picture.
 *
 * Values have the sRGB code 255·v, as in the painted picture: coverage in grey, other quantities in hues. The picture
 * is displaced by the wind up to the description's time, and sampled like the landscape. Nothing is baked beyond the
 * field, whose border is drawn: values are dimmed there. A thin line marks the picture's border, beyond which its edge
 * values continue. */
#include <math.h>

#include "cloud/cloud_desc.h"
#include "cloud/cloud_name.h"
#include "cloud/shape_desc.h"
#include "cloud/weather_picture.h"
#include "core/context_private.h"
#include "core/given.h"
#include "core/parallel.h"

enum {
  LONG_SIDE = 1000,
  MARGIN = 12,
  GAP = 8,
  SUBSAMPLES = 3 /* subsamples along each axis of a pixel */,
  OUTLINE = 2
};

static const double fields_max = 5; /* largest extent of a panel, in fields along an axis */
static const float dimmed = 0.35f;

/* Colours in sRGB. */
static const float outline_color[3] = {1.0f, 0.25f, 0.12f}, end_color[3] = {0.25f, 0.5f, 1.0f}, gap_grey = 0.3f;

static const float hues[NEPH_CLOUD_MAP_QUANTITY_COUNT][3] = {
    [NEPH_CLOUD_MAP_COVERAGE] = {1.0f, 1.0f, 1.0f},       [NEPH_CLOUD_MAP_TYPE] = {1.0f, 0.62f, 0.25f},
    [NEPH_CLOUD_MAP_BASE] = {0.4f, 0.9f, 0.5f},           [NEPH_CLOUD_MAP_THICKNESS] = {1.0f, 0.9f, 0.35f},
    [NEPH_CLOUD_MAP_PRECIPITATION] = {0.4f, 0.65f, 1.0f}, [NEPH_CLOUD_MAP_AGE] = {0.9f, 0.5f, 0.9f}};

typedef struct map_box {
  double min_m[2], max_m[2];
} map_box;

typedef struct map_view {
  const neph_cloud_desc *desc;
  np_weather_picture picture;
  map_box panel, field, painted; /* in the world */
  double pixel_m;
  unsigned size[2], count; /* pixels of a panel; number of panels */
  neph_cloud_map_quantity quantities[NEPH_CLOUD_MAP_QUANTITY_COUNT];
  float *planes[3];
} map_view;

/* ---- Layout ---- */

static map_box make_box(const double center_m[2], const double size_m[2]) {
  map_box box;
  for (int a = 0; a < 2; a++) {
    box.min_m[a] = center_m[a] - 0.5 * size_m[a];
    box.max_m[a] = center_m[a] + 0.5 * size_m[a];
  }
  return box;
}

/* Extent of the panels: the field and the undisplaced picture, so that frames align, as long as the field stays large
 * enough to be visible. */
static map_box choose_shown(const map_view *v) {
  double size_m[2];
  for (int a = 0; a < 2; a++) {
    const double most_m = fields_max * v->desc->extent_m[a];
    size_m[a] = v->desc->is_map_tiling ? v->desc->extent_m[a] : fmin(v->picture.size_m[a], most_m);
    size_m[a] = fmax(size_m[a], v->desc->extent_m[a]);
  }
  return make_box(v->desc->center_m, size_m);
}

static void lay_out(map_view *v) {
  const neph_cloud_desc *desc = v->desc;
  double painted_m[2];
  for (int a = 0; a < 2; a++) painted_m[a] = desc->center_m[a] + desc->wind_m_s[a] * desc->time_s;
  v->field = make_box(desc->center_m, desc->extent_m);
  v->painted = make_box(painted_m, v->picture.size_m);
  const map_box shown = choose_shown(v);
  v->pixel_m = fmax(shown.max_m[0] - shown.min_m[0], shown.max_m[1] - shown.min_m[1]) / LONG_SIDE;
  for (int a = 0; a < 2; a++) {
    const double pixels = ceil((shown.max_m[a] - shown.min_m[a]) / v->pixel_m * (1 - 1e-9)) + 2 * MARGIN;
    const double middle_m = 0.5 * (shown.min_m[a] + shown.max_m[a]);
    v->size[a] = (unsigned)pixels;
    v->panel.min_m[a] = middle_m - 0.5 * pixels * v->pixel_m;
    v->panel.max_m[a] = middle_m + 0.5 * pixels * v->pixel_m;
  }
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++)
    if (v->picture.values[q]) v->quantities[v->count++] = (neph_cloud_map_quantity)q;
}

static unsigned compute_width(const map_view *v) { return v->count * v->size[0] + (v->count - 1) * GAP; }

/* ---- Pixels ---- */

static bool is_inside(const map_box *box, const double at_m[2], double beyond_m) {
  for (int a = 0; a < 2; a++)
    if (at_m[a] < box->min_m[a] - beyond_m || at_m[a] > box->max_m[a] + beyond_m) return false;
  return true;
}

/* Mean over a pixel. */
static float sample_pixel(const map_view *v, neph_cloud_map_quantity quantity, const double at_m[2]) {
  float sum = 0.0f;
  double center_m[2];
  for (int a = 0; a < 2; a++) center_m[a] = 0.5 * (v->painted.min_m[a] + v->painted.max_m[a]);
  for (int i = 0; i < SUBSAMPLES * SUBSAMPLES; i++) {
    const double x = ((i % SUBSAMPLES + 0.5) / SUBSAMPLES - 0.5) * v->pixel_m;
    const double y = ((i / SUBSAMPLES + 0.5) / SUBSAMPLES - 0.5) * v->pixel_m;
    sum += np_weather_picture_sample(&v->picture, quantity, at_m[0] + x - center_m[0], at_m[1] + y - center_m[1]);
  }
  return sum / (SUBSAMPLES * SUBSAMPLES);
}

/* Linear value of a component of sRGB (IEC 61966-2-1). */
static float decode_srgb(float code) { return code <= 0.04045f ? code / 12.92f : powf((code + 0.055f) / 1.055f, 2.4f); }

static void put_color(const map_view *v, size_t pixel, const float color[3], float share) {
  for (int c = 0; c < 3; c++) v->planes[c][pixel] = decode_srgb(color[c] * share);
}

static void draw_pixel(const map_view *v, neph_cloud_map_quantity quantity, const double at_m[2], size_t pixel) {
  const bool is_in_field = is_inside(&v->field, at_m, 0), is_painted = is_inside(&v->painted, at_m, 0);
  if (!is_in_field && is_inside(&v->field, at_m, OUTLINE * v->pixel_m))
    put_color(v, pixel, outline_color, 1.0f);
  else if (!v->desc->is_map_tiling && !is_painted && is_inside(&v->painted, at_m, v->pixel_m))
    put_color(v, pixel, end_color, 1.0f);
  else
    put_color(v, pixel, hues[quantity], sample_pixel(v, quantity, at_m) * (is_in_field ? 1.0f : dimmed));
}

static void draw_row(const map_view *v, unsigned row) {
  const unsigned width = compute_width(v);
  for (unsigned column = 0; column < width; column++) {
    const unsigned number = column / (v->size[0] + GAP), x = column % (v->size[0] + GAP);
    const size_t pixel = (size_t)row * width + column;
    const double at_m[2] = {v->panel.min_m[0] + (x + 0.5) * v->pixel_m, v->panel.max_m[1] - (row + 0.5) * v->pixel_m};
    if (x < v->size[0])
      draw_pixel(v, v->quantities[number], at_m, pixel);
    else
      put_color(v, pixel, (const float[3]){1.0f, 1.0f, 1.0f}, gap_grey);
  }
}

static neph_result draw_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) draw_row(user, (unsigned)row);
  return NEPH_OK;
}

static neph_result draw(neph_context *context, map_view *v, const char *path) {
  static const char *const names[] = {"R", "G", "B"};
  neph_preview_desc shown = NEPH_PREVIEW_DESC_DEFAULT;
  neph_image *image;
  neph_result result = neph_image_create(context, compute_width(v), v->size[1], 3, names, &image);
  if (result) return result;
  for (int c = 0; c < 3; c++) v->planes[c] = neph_image_get_channel(image, names[c]);
  shown.exposure = NEPH_EXPOSURE_FIXED;
  shown.view = NEPH_VIEW_STANDARD;
  result = np_parallel_for(context, NULL, v->size[1], 8, draw_rows, v);
  if (!result) result = neph_image_save_png(image, path, &shown);
  neph_image_destroy(image);
  return result;
}

/* ---- Entry ---- */

static neph_result describe(neph_context *context, const map_view *v, neph_map_picture *out_picture) {
  neph_map_picture picture = NEPH_MAP_PICTURE_DEFAULT;
  picture.panel_width = v->size[0];
  picture.panel_height = v->size[1];
  picture.gap = GAP;
  picture.pixel_m = v->pixel_m;
  for (int a = 0; a < 2; a++) {
    picture.panel_min_m[a] = v->panel.min_m[a];
    picture.panel_max_m[a] = v->panel.max_m[a];
    picture.field_min_m[a] = v->field.min_m[a];
    picture.field_max_m[a] = v->field.max_m[a];
    picture.painted_min_m[a] = v->painted.min_m[a];
    picture.painted_max_m[a] = v->painted.max_m[a];
  }
  picture.panel_count = v->count;
  for (unsigned i = 0; i < v->count; i++) picture.quantities[i] = np_cloud_map_quantity_get_name(v->quantities[i]);
  return np_desc_write(context, "neph_map_picture", &picture, sizeof picture, out_picture);
}

static neph_result show_map(neph_context *context, const neph_cloud_desc *desc, const char *path,
                            neph_map_picture *out_picture) {
  map_view v = {.desc = desc};
  if (!desc->map_file || np_cloud_desc_has_shape(desc))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s has no weather map to show%s, must have a picture: set map", np_cloud_desc_name(desc),
                   desc->map_file ? " beside its shape" : "");
  neph_result result = np_weather_picture_load(context, desc, &v.picture);
  if (result) return result;
  lay_out(&v);
  if (path) result = draw(context, &v, path);
  if (!result && out_picture) result = describe(context, &v, out_picture);
  np_weather_picture_clear(&v.picture);
  return result;
}

neph_result neph_cloud_save_map(neph_context *context, const neph_cloud_desc *cloud, const char *path,
                                neph_map_picture *out_picture) {
  neph_cloud_desc desc;
  if (NP_LACKS(context, context)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_cloud_desc_read(context, cloud, &desc);
  if (result) return result;
  const unsigned mode = np_float_mode_enter();
  result = show_map(context, &desc, path, out_picture);
  np_float_mode_leave(mode);
  return result;
}
