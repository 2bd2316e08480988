/* SPDX-License-Identifier: Apache-2.0 */
/* From radiance to a picture for the eye: exposure, a filmic curve, sRGB, dither.
 *
 * The curve is that of Lottes 2016 ("Advanced Techniques and Optimization of HDR Color Pipelines", GDC): with x the
 * exposed value, f(x) = xᵃ/(b·xᵃᵈ + c), where contrast a shapes the toe, d the shoulder, and b and c put middle grey
 * where it belongs and the brightest value at 1.
 *
 * A curve on each channel turns a bright orange yellow and a bright blue pale; a curve on the brightest channel alone
 * keeps hue and saturation, and never lets light burn to white. Half of each keeps the sky blue; towards the top of the
 * range the curve on each channel takes over, so that the sun is white.
 */
#include "image/preview.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/random.h"
#include "image/color_space.h"

static const float contrast = 1.3f, shoulder = 0.95f;
static const float brightest = 16.0f, middle_in = 0.18f, middle_out = 0.2f;
static const float rec709_luminance[3] = {0.2126f, 0.7152f, 0.0722f};

/* The three planes shown; all the same for a grey picture. */
typedef struct preview_planes {
  const float *plane[3];
  float factor[3]; /* exposure over white */
  bool has_primaries;
  float rec709_from_rgb[3][3]; /* of primaries that are not Rec.709's */
} preview_planes;

/* Primaries without a header are Rec.709's, as OpenEXR has it; so are those of bands, which are none. */
static void choose_primaries(const neph_image *image, preview_planes *out) {
  const float *own = image->header.chromaticities;
  const float *rec709 = np_color_space_get_chromaticities(NP_COLOR_REC709);
  np_color_matrix matrix;
  out->has_primaries = image->header.has_chromaticities && memcmp(own, rec709, sizeof image->header.chromaticities) &&
                       np_color_space_to_rec709(own, &matrix);
  for (int r = 0; out->has_primaries && r < 3; r++)
    for (int c = 0; c < 3; c++) out->rec709_from_rgb[r][c] = (float)matrix.at[r][c];
}

static void convert_primaries(const preview_planes *planes, float rgb[3]) {
  if (!planes->has_primaries) return;
  const float own[3] = {rgb[0], rgb[1], rgb[2]};
  for (int r = 0; r < 3; r++) {
    const float *row = planes->rec709_from_rgb[r];
    rgb[r] = row[0] * own[0] + row[1] * own[1] + row[2] * own[2];
  }
}

static bool get_planes(const neph_image *image, preview_planes *out) {
  static const char *const colours[3] = {"R", "G", "B"};
  for (int c = 0; c < 3; c++) {
    out->plane[c] = neph_image_get_values(image, colours[c]);
    if (!out->plane[c]) out->plane[c] = neph_image_get_values(image, "Y");
    if (!out->plane[c]) return false;
  }
  choose_primaries(image, out);
  return true;
}

/* ---- Exposure ---- */

/* Luminances by the logarithm, sixteen bins a stop. */
enum { BINS_PER_STOP = 16, STOPS_EITHER_WAY = 64, BIN_COUNT = 2 * STOPS_EITHER_WAY * BINS_PER_STOP };

typedef struct luminance_histogram {
  uint64_t bin[BIN_COUNT], count;
} luminance_histogram;

static double get_bin_stops(int bin) { return (bin + 0.5) / BINS_PER_STOP - STOPS_EITHER_WAY; }

static void fill_histogram(const preview_planes *planes, size_t pixel_count, luminance_histogram *out) {
  *out = (luminance_histogram){.count = 0};
  for (size_t i = 0; i < pixel_count; i++) {
    float rgb[3], luminance = 0;
    for (int c = 0; c < 3; c++) rgb[c] = planes->plane[c][i] * planes->factor[c];
    convert_primaries(planes, rgb);
    for (int c = 0; c < 3; c++) luminance += rec709_luminance[c] * fmaxf(rgb[c], 0.0f);
    if (!(luminance > 0) || !isfinite(luminance)) continue;
    float bin = (log2f(luminance) + STOPS_EITHER_WAY) * BINS_PER_STOP;
    out->bin[(int)fminf(fmaxf(bin, 0.0f), BIN_COUNT - 1)]++;
    out->count++;
  }
}

/* The bin below or in which a fraction of the pixels lies. */
static int search_bin(const luminance_histogram *histogram, double fraction) {
  uint64_t below = 0;
  int bin = 0;
  for (; bin < BIN_COUNT - 1; bin++) {
    below += histogram->bin[bin];
    if ((double)below >= fraction * (double)histogram->count) break;
  }
  return bin;
}

static void drop_below(luminance_histogram *histogram, int first_bin) {
  for (int bin = 0; bin < first_bin; bin++) {
    histogram->count -= histogram->bin[bin];
    histogram->bin[bin] = 0;
  }
}

static double average_stops(const luminance_histogram *histogram, int first_bin, int last_bin) {
  double sum = 0, count = 0;
  for (int bin = first_bin; bin <= last_bin; bin++) {
    sum += (double)histogram->bin[bin] * get_bin_stops(bin);
    count += (double)histogram->bin[bin];
  }
  return sum / count;
}

/* Pixels twelve stops under the brightest hundredth count as unlit. The log-average of the lit, without its darkest
 * tenth and brightest hundredth, comes a little above middle grey, unless that puts the brightest hundredth where the
 * curve is flat. */
static double choose_exposure(const preview_planes *planes, size_t pixel_count) {
  static const double average_to = 0.33, bright_to_at_most = 4.0;
  enum { LIT_STOPS = 12 };
  luminance_histogram histogram;
  fill_histogram(planes, pixel_count, &histogram);
  if (histogram.count == 0) return 1.0;
  int bright = search_bin(&histogram, 0.99);
  drop_below(&histogram, bright - LIT_STOPS * BINS_PER_STOP);
  bright = search_bin(&histogram, 0.99);
  double average = average_stops(&histogram, search_bin(&histogram, 0.10), bright);
  return fmin(average_to / exp2(average), bright_to_at_most / exp2(get_bin_stops(bright)));
}

double np_preview_choose_exposure(const neph_image *image, const double white[3]) {
  preview_planes planes;
  if (!get_planes(image, &planes)) return 1.0;
  for (int c = 0; c < 3; c++) planes.factor[c] = (float)(1.0 / white[c]);
  return choose_exposure(&planes, (size_t)image->width * image->height);
}

/* ---- Tone ---- */

typedef struct tone_curve {
  float b, c;
} tone_curve;

/* f(middle_in) = middle_out and f(brightest) = 1, solved for b and c. */
static tone_curve solve_curve(void) {
  float middle_a = powf(middle_in, contrast), middle_ad = powf(middle_in, contrast * shoulder);
  float bright_a = powf(brightest, contrast), bright_ad = powf(brightest, contrast * shoulder);
  float b = (middle_a / middle_out - bright_a) / (middle_ad - bright_ad);
  return (tone_curve){b, bright_a - b * bright_ad};
}

static float apply_curve(tone_curve curve, float x) {
  if (!(x > 0)) return 0;
  float clipped = fminf(x, brightest), powered = powf(clipped, contrast);
  return fminf(powered / (curve.b * powf(clipped, contrast * shoulder) + curve.c), 1.0f);
}

/* Weight of the hue-keeping half at a brightness: all of it up to 1, none from the top of the range. */
static float compute_hue_weight(float peak) {
  float t = fminf(fmaxf(log2f(peak) / log2f(brightest), 0.0f), 1.0f);
  return 0.5f * (1.0f - t * t * (3.0f - 2.0f * t));
}

static void map_tone(tone_curve curve, const float exposed[3], float out_display[3]) {
  float peak = fmaxf(exposed[0], fmaxf(exposed[1], exposed[2]));
  float hue_weight = peak > 0 ? compute_hue_weight(peak) : 0.0f;
  float hue_scale = peak > 0 ? apply_curve(curve, peak) / peak : 0.0f;
  for (int c = 0; c < 3; c++) {
    float kept = fmaxf(exposed[c], 0.0f) * hue_scale;
    out_display[c] = hue_weight * kept + (1.0f - hue_weight) * apply_curve(curve, exposed[c]);
  }
}

void np_preview_map_tone(const float exposed[3], float out_display[3]) {
  map_tone(solve_curve(), exposed, out_display);
}

/* IEC 61966-2-1. */
static float encode_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

/* ---- Dither ---- */

/* Three numbers in [0, 1) for a pixel, by its place alone. */
static void draw_uniform(size_t x, size_t y, float out[3]) {
  uint64_t bits = np_random_mix(np_random_mix((uint64_t)y << 32 | (uint64_t)x) + UINT64_C(0x9e3779b97f4a7c15));
  for (int c = 0; c < 3; c++) out[c] = (float)(bits >> 21 * c & 0x1fffffu) * 0x1p-21f;
}

/* The difference of neighbours' numbers: triangular over ±1 step, which hides every band at equal noise, and without
 * low frequencies along the row. It fades out at 0 and 255, where clipping would shift the mean. */
static uint8_t quantize(float encoded, float noise) {
  float steps = encoded * 255.0f;
  float amplitude = fminf(1.0f, fminf(steps, 255.0f - steps));
  return (uint8_t)lrintf(fminf(fmaxf(steps + amplitude * noise, 0.0f), 255.0f));
}

/* ---- Pixels ---- */

typedef struct preview_job {
  const neph_image *image;
  preview_planes planes;
  tone_curve curve;
  uint8_t *rgb;
  atomic_size_t nan_count;
} preview_job;

static void paint(uint8_t *rgb, uint8_t r, uint8_t g, uint8_t b) { rgb[0] = r, rgb[1] = g, rgb[2] = b; }

static void render_pixel(preview_job *job, float exposed[3], const float noise[3], uint8_t *rgb) {
  float display[3];
  if (isnan(exposed[0]) || isnan(exposed[1]) || isnan(exposed[2])) {
    atomic_fetch_add(&job->nan_count, 1);
    paint(rgb, 255, 0, 255);
  } else if (fmaxf(exposed[0], fmaxf(exposed[1], exposed[2])) == HUGE_VALF) {
    paint(rgb, 255, 255, 255);
  } else {
    convert_primaries(&job->planes, exposed);
    map_tone(job->curve, exposed, display);
    for (int c = 0; c < 3; c++) rgb[c] = quantize(encode_srgb(display[c]), noise[c]);
  }
}

static void render_row(preview_job *job, size_t y) {
  size_t width = job->image->width;
  float here[3], right[3];
  draw_uniform(0, y, here);
  for (size_t x = 0; x < width; x++) {
    float exposed[3], noise[3];
    size_t i = y * width + x;
    draw_uniform(x + 1, y, right);
    for (int c = 0; c < 3; c++) {
      exposed[c] = job->planes.plane[c][i] * job->planes.factor[c];
      noise[c] = here[c] - right[c];
    }
    render_pixel(job, exposed, noise, job->rgb + 3 * i);
    memcpy(here, right, sizeof here);
  }
}

static neph_result render_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t y = begin; y < end; y++) render_row(user, y);
  return NEPH_OK;
}

static neph_result check_desc(neph_context *context, const neph_preview_desc *desc) {
  if (!(fabs(desc->exposure_ev) <= 64))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "preview exposure is %g stops, must be in [-64, 64]",
                   desc->exposure_ev);
  for (int c = 0; c < 3; c++)
    if (!(desc->white[c] > 0) || !isfinite(desc->white[c]))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "preview white of %c is %g, must be finite and above 0",
                     "RGB"[c], desc -> white[c]);
  return NEPH_OK;
}

neph_result np_preview_render(const neph_image *image, const neph_preview_desc *desc, uint8_t *out_rgb) {
  preview_job job = {.image = image, .curve = solve_curve(), .rgb = out_rgb};
  neph_result result = check_desc(image->context, desc);
  if (result) return result;
  if (!get_planes(image, &job.planes))
    return np_fail(image->context, NEPH_ERROR_INVALID_ARGUMENT, "a preview needs the channels R, G and B, or Y");
  double exposure = exp2(desc->exposure_ev);
  if (desc->is_exposure_auto) exposure *= np_preview_choose_exposure(image, desc->white);
  for (int c = 0; c < 3; c++) job.planes.factor[c] = (float)(exposure / desc->white[c]);
  result = np_parallel_for(image->context, NULL, image->height, 8, render_rows, &job);
  size_t nan_count = atomic_load(&job.nan_count);
  if (nan_count)
    np_log(image->context, NEPH_LOG_WARNING, "%zu pixels are NaN, shown in magenta in the preview", nan_count);
  return result;
}
