/* SPDX-License-Identifier: Apache-2.0 */
/* Packets of bands, and the way from bands to the picture's colours.
 *
 * More than three wavelengths have weights of their own. Three bands have a matrix that is fitted to the light at the
 * camera, in a further packet of bands for which nothing but air and sky is built (image/color_fit.h). It depends on
 * lights, air and the camera's position alone: all crops, tiles and samples of a picture have the same one, and so have
 * both integrators.
 */
#include <math.h>

#include "core/alloc.h"
#include "image/color_space.h"
#include "stages/color_probes.h"

/* ---- Packets ---- */

static void set_weights(const np_wavelengths *wavelengths, np_color_space space, unsigned index, np_packet *packet) {
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    double rgb[3];
    np_color_space_weigh(space, wavelengths->xyz_nm[np_band_set_get_index(wavelengths, index, b)], rgb);
    for (int c = 0; c < 3; c++) packet->color_weight[c][b] = (float)rgb[c];
  }
}

static void set_reference_weights(np_packet *packet) {
  for (int c = 0; c < 3; c++) packet->color_weight[c][c] = 1.0f;
}

static void set_many_weights(const np_plan *plan, np_packet *packets) {
  np_wavelengths wavelengths;
  np_wavelengths_choose(plan->decisions.wavelength_count, &wavelengths);
  for (unsigned i = 0; i < plan->decisions.packet_count; i++)
    set_weights(&wavelengths, plan->decisions.color_space, i, &packets[i]);
}

unsigned np_packet_count(const np_plan *plan) {
  return plan->decisions.packet_count + (np_plan_needs(plan, NP_STAGE_COLOR_FIT) ? 1 : 0);
}

np_band_set np_packet_choose_bands(const np_plan *plan, unsigned packet) {
  np_wavelengths wavelengths;
  if (plan->decisions.color_space == NP_COLOR_BANDS) return np_band_set_reference();
  if (plan->decisions.packet_count == 1) {
    np_color_fit_choose_cells(&wavelengths);
    return np_band_set_choose_cells(&wavelengths, np_color_fit_cells + (size_t)packet * NP_BAND_COUNT);
  }
  np_wavelengths_choose(plan->decisions.wavelength_count, &wavelengths);
  return np_band_set_choose(&wavelengths, packet);
}

/* The first stage: a picture has no results before. */
neph_result np_stage_build_packets(const np_stage_task *task) {
  np_assembly *out = task->picture;
  const np_plan *plan = task->in.part.plan;
  const unsigned count = np_packet_count(plan);
  out->packets = np_alloc(out->context, count, sizeof *out->packets);
  if (!out->packets) return NEPH_ERROR_OUT_OF_MEMORY;
  out->packet_count = plan->decisions.packet_count;
  out->probe_packet_count = count - out->packet_count;
  out->is_of_bands = plan->decisions.color_space == NP_COLOR_BANDS;
  for (unsigned i = 0; i < count; i++) out->packets[i].bands = np_packet_choose_bands(plan, i);
  if (out->is_of_bands)
    set_reference_weights(out->packets);
  else if (plan->decisions.packet_count > 1)
    set_many_weights(plan, out->packets);
  return NEPH_OK;
}

void np_stage_clear_packets(const np_stage_task *task) { np_alloc_free(task->in.part.context, task->picture->packets); }

/* ---- Weights ---- */

static void set_fitted_weights(const np_color_weights *weights, np_color_space space, np_packet *packet) {
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    double xyz[3], rgb[3];
    for (int c = 0; c < 3; c++) xyz[c] = weights->at[b][c] / packet->bands.shape[NP_BAND_SUN][b];
    np_color_space_weigh(space, xyz, rgb);
    for (int c = 0; c < 3; c++) packet->color_weight[c][b] = (float)rgb[c];
  }
}

/* The picture's bands and the other bands of probes, under each light; without lights their bands alone. */
neph_result np_stage_build_color_fit(const np_stage_task *task) {
  np_color_probes probes = {.light_count = task->picture->lights.count};
  for (unsigned p = 0; p < NP_COLOR_PROBE_PACKETS; p++)
    for (unsigned l = 0; l == 0 || l < probes.light_count; l++) {
      np_stage_task at = *task;
      at.packet = &task->picture->packets[p];
      at.light = &at.packet->lights[l];
      np_stage_inputs_fill(NP_STAGE_COLOR_FIT, &at);
      probes.at[p][l] = at.in.color_fit;
    }
  np_picture_color *out = &task->picture->color;
  np_color_fit fit = {.weight = 0.0};
  neph_result result = np_color_probes_add(&task->in.part, &probes, &fit, out);
  if (result) return result;
  np_color_fit_solve(&fit, &out->weights);
  out->is_fitted = true;
  set_fitted_weights(&out->weights, task->in.part.plan->decisions.color_space, task->picture->packets);
  return NEPH_OK;
}

/* ---- Values of a scene ---- */

/* A value of the probes' bands at any wavelength: linear between them and beyond, from nearest to nearest. */
static double interpolate(const np_picture_color *color, const double value[NP_COLOR_PROBE_BAND_COUNT], double nm) {
  static const int ascending[NP_COLOR_PROBE_BAND_COUNT] = {5, 2, 1, 4, 0, 3};
  double at[NP_COLOR_PROBE_BAND_COUNT];
  int i = 0;
  for (int k = 0; k < NP_COLOR_PROBE_BAND_COUNT; k++) at[k] = color->probe_nm[ascending[k]];
  while (i + 2 < NP_COLOR_PROBE_BAND_COUNT && nm > at[i + 1]) i++;
  const double low = value[ascending[i]], high = value[ascending[i + 1]];
  return fmax(low + (nm - at[i]) / (at[i + 1] - at[i]) * (high - low), 0.0);
}

/* The light at the camera over the sun's goes from band to band, and the sun's own spectrum between. */
static void compute_reflected_xyz(const np_picture_color *color, const double albedo[NP_BAND_COUNT],
                                  double out_xyz[3]) {
  np_wavelengths cells;
  np_color_fit_choose_cells(&cells);
  for (int c = 0; c < 3; c++) out_xyz[c] = 0.0;
  for (unsigned p = 0; p < cells.count / NP_BAND_COUNT; p++) {
    const np_band_set bands = np_band_set_choose(&cells, p);
    double share[NP_BAND_COUNT];
    np_band_set_convert(&bands, NP_BAND_LINEAR, albedo, share);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
      const double *xyz = cells.xyz_nm[np_band_set_get_index(&cells, p, b)];
      const double light = interpolate(color, color->light_x, bands.nm[b]) * bands.shape[NP_BAND_SUN][b];
      for (int c = 0; c < 3; c++) out_xyz[c] += share[b] * light * xyz[c];
    }
  }
}

/* The bands, over the sun's, that have the colour of the light at the camera once it is reflected. */
static bool reflect(const np_picture_color *color, const double albedo[NP_BAND_COUNT], double out_x[NP_BAND_COUNT]) {
  double xyz[3];
  compute_reflected_xyz(color, albedo, xyz);
  return xyz[1] > 0.0 && np_color_weights_invert(&color->weights, xyz, out_x);
}

np_spectrum np_picture_color_fit_albedo(const np_picture_color *color, const np_band_set *bands,
                                        const double reference[NP_BAND_COUNT]) {
  static const double white[NP_BAND_COUNT] = {1.0, 1.0, 1.0};
  double light[NP_BAND_COUNT], reflected[NP_BAND_COUNT];
  np_spectrum own = np_bands_convert(bands, NP_BAND_LINEAR, reference);
  if (!color->is_fitted || np_spectrum_is_grey(own)) return own;
  if (!reflect(color, white, light) || !reflect(color, reference, reflected)) return own;
  for (int b = 0; b < NP_BAND_COUNT; b++) own.band[b] = (float)np_clamp(reflected[b] / light[b], 0.0, 1.0);
  return own;
}

/* Rounds the reflected or the absorbed share, whichever is less, to nine bits, so to a thousandth. */
static float round_share(float share) {
  int exponent;
  const double less = fmin((double)share, 1.0 - (double)share), mantissa = frexp(less, &exponent);
  const double rounded = ldexp(nearbyint(512.0 * mantissa), exponent - 9);
  return (float)((double)share < 0.5 ? rounded : 1.0 - rounded);
}

np_spectrum np_picture_color_convert_albedo(const np_picture_color *color, const np_band_set *bands,
                                            const double reference[NP_BAND_COUNT]) {
  np_spectrum own = np_picture_color_fit_albedo(color, bands, reference);
  if (!color->is_fitted || np_spectrum_is_grey(own)) return own;
  for (int b = 0; b < NP_BAND_COUNT; b++) own.band[b] = round_share(own.band[b]);
  return own;
}

np_spectrum np_picture_color_convert_radiance(const np_picture_color *color, const np_band_set *bands,
                                              const double reference[NP_BAND_COUNT]) {
  np_spectrum own = np_bands_convert(bands, NP_BAND_LINEAR, reference);
  np_wavelengths cells;
  double xyz[3], x[NP_BAND_COUNT];
  if (!color->is_fitted) return own;
  np_color_fit_choose_cells(&cells);
  np_band_set_compute_xyz(&cells, NP_BAND_LINEAR, reference, xyz);
  if (!np_color_weights_invert(&color->weights, xyz, x)) return own;
  for (int b = 0; b < NP_BAND_COUNT; b++) own.band[b] = (float)fmax(x[b] * bands->shape[NP_BAND_SUN][b], 0.0);
  return own;
}

/* X, Y, Z of a body over many wavelengths, as bands that have them. */
static void set_factors(const np_picture_color *color, const np_band_set *bands, const np_wavelengths *cells, int knot,
                        np_black_body *body) {
  const double kelvin = np_black_body_get_knot_k(knot);
  double xyz[3] = {0.0, 0.0, 0.0}, x[NP_BAND_COUNT];
  for (unsigned i = 0; i < cells->count; i++)
    for (int c = 0; c < 3; c++) xyz[c] += cells->xyz_nm[i][c] * np_black_body_radiance(cells->nm[i], kelvin);
  const bool is_inverted = np_color_weights_invert(&color->weights, xyz, x);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const double radiance = np_black_body_radiance(bands->nm[b], kelvin);
    const double shown = is_inverted ? x[b] * bands->shape[NP_BAND_SUN][b] : radiance;
    body->factor[knot][b] = (float)fmax(shown / radiance, 0.0);
  }
}

np_black_body np_picture_color_make_black_body(const np_picture_color *color, const np_band_set *bands) {
  np_black_body body = np_black_body_make(bands->nm);
  if (!color->is_fitted) return body;
  np_wavelengths cells;
  np_color_fit_choose_cells(&cells);
  body.has_factor = 1;
  for (int knot = 0; knot < NP_BLACK_BODY_KNOTS; knot++) set_factors(color, bands, &cells, knot, &body);
  return body;
}
