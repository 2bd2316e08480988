/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/gather_kernel.h"

#include "atmosphere/ray_warp.h"
#include "core/alloc.h"

enum {
  POINTS = 12,
  POINTS_MAX = 24,
  TERMS = 512,
  ANGLES = 257,
  PASSES = 2,
  PASSES_THICK = 4,
  COSINES = 13,
  AZIMUTHS = 9
};
enum { UP = 8, DOWN = 4, DOME_AZIMUTHS = 8 }; /* doubled for sharp lobes */

/* Altitudes by the scattering depth above them, e⁻ˣ of the total: for one exponential layer, x scale heights. */
static const double exponential_depths[] = {0.0, 0.667, 2.083, 6.667};
static const double other_depths[NP_GATHER_ALTITUDES_MAX] = {0.0, 0.25, 0.667, 1.3, 2.083, 3.3, 4.8, 6.667};

/* Largest asymmetry of a lobe in weights: the directions of the rule are some 15° apart, or 8°. */
static const float asymmetry_max = 0.85f, sharp_asymmetry_max = 0.93f;

/* Convolves two lobes, at 257 angles; the series ends when its terms are negligible. */
static void convolve_lobes(const np_phase *p, const np_phase *q, float *out) {
  double a[TERMS], b[TERMS];
  np_phase_get_moments(p, TERMS, a);
  np_phase_get_moments(q, TERMS, b);
  for (int i = 0; i < ANGLES; i++) {
    const double x = i / (ANGLES - 1.0), c = cos(NP_PI * x * x);
    double p_l = 1.0, previous = 0.0, sum = 0.0;
    for (int l = 0; l < TERMS && fmax(a[l] * a[l], b[l] * b[l]) > 1e-7; l++) {
      sum += (2 * l + 1) * a[l] * b[l] * p_l;
      const double next = ((2 * l + 1) * c * p_l - l * previous) / (l + 1);
      previous = p_l;
      p_l = next;
    }
    out[i] = (float)fmax(sum / (4.0 * NP_PI), 0.0);
  }
}

/* Fractional index, in the tables of convolved phase functions, of an angle given by 1 − cos. */
static float compute_angle(float versine) {
  return (float)(ANGLES - 1) * sqrtf(np_acos_coarse(1.0f - versine) * (1.0f / NP_PI_F));
}

np_bands np_gather_kernel_convolve(const np_gather_kernel *kernel, int aerosol, float versine) {
  const float x = compute_angle(versine);
  const int i = x < (float)(ANGLES - 2) ? (int)x : ANGLES - 2, count = kernel->medium->aerosol_count;
  np_bands sum = np_bands_grey(0.0f);
  for (int k = 0; k < count; k++) {
    const float *convolution = kernel->lobe_convolution + (aerosol * count + k) * ANGLES;
    sum += np_mixf(convolution[i], convolution[i + 1], x - (float)i) * kernel->medium->aerosol[k].share;
  }
  return sum;
}

np_bands np_gather_kernel_convolve_lobe(const np_gather_kernel *kernel, float versine) {
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < kernel->medium->aerosol_count; i++)
    sum += np_gather_kernel_convolve(kernel, i, versine) * kernel->medium->aerosol[i].share;
  return sum;
}

/* A lobe at an input and at its mirror image across the sun's plane, which the input represents as well. */
static float eval_twins(np_phase_lobe lobe, np_vec3 to, np_vec3 from) {
  return np_phase_eval_lobe(lobe, np_vec3_versine(to, from)) +
         np_phase_eval_lobe(lobe, np_vec3_versine(to, np_vec3_make(from.x, -from.y, from.z)));
}

/* Input directions at one altitude, and the quadrature weights of their rows. */
typedef struct dome_inputs {
  int count;
  np_vec3 from[NP_GATHER_INPUTS_MAX];
  float weight[NP_GATHER_INPUTS_MAX];
} dome_inputs;

static void place_inputs(const np_gather_kernel *kernel, int altitude, const float *row_weight, dome_inputs *out) {
  out->count = np_gather_kernel_count_inputs(kernel);
  for (int in = 0; in < out->count; in++) {
    const int row = in / kernel->azimuth_count, turn = in % kernel->azimuth_count;
    out->from[in] = np_gather_kernel_get_input(kernel, altitude, row, turn);
    out->weight[in] = row_weight[row];
  }
}

/* Adds the weights of every input to one output for one lobe, scaled to a sum of `share`. */
static void add_lobe(const dome_inputs *inputs, np_phase_lobe lobe, np_vec3 to, float share, float *weights) {
  float value[NP_GATHER_INPUTS_MAX], sum = 0.0f;
  for (int in = 0; in < inputs->count; in++) {
    value[in] = inputs->weight[in] * eval_twins(lobe, to, inputs->from[in]);
    sum += value[in];
  }
  for (int in = 0; in < inputs->count; in++) weights[in] += share / np_maxf(sum, 1e-20f) * value[in];
}

/* Builds the weights of one aerosol. Each lobe of a mixture is normalised on its own, so that a narrow one keeps its
 * share for any positions of the directions, and is widened to the resolution of the rule. */
static void build_weights(np_gather_kernel *kernel, int altitude, int aerosol, const dome_inputs *inputs) {
  const np_phase *phase = &kernel->medium->aerosol[aerosol].phase;
  const float greatest = kernel->azimuth_count > DOME_AZIMUTHS ? sharp_asymmetry_max : asymmetry_max;
  for (size_t out = 0; out < np_gather_kernel_count_outputs(kernel); out++) {
    const np_vec3 to = np_gather_kernel_get_output(kernel, (int)out);
    float *weights = np_gather_kernel_get_weights(kernel, altitude, aerosol) + out * (size_t)inputs->count;
    for (int i = 0; i < NP_PHASE_LOBES; i++) {
      const float g = np_clampf(phase->lobe[i].asymmetry, -greatest, greatest), share = np_phase_get_share(phase, i);
      if (share > 0.0f) add_lobe(inputs, (np_phase_lobe){g, phase->lobe[i].alpha}, to, share, weights);
    }
  }
}

/* Scattering depth of all aerosols above an altitude, summed over the bands. */
static double compute_depth(const np_medium *medium, double altitude_m) {
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < medium->aerosol_count; i++) sum += np_aerosol_column(medium, i, altitude_m);
  return (double)(sum[0] + sum[1] + sum[2]);
}

static double compute_lowest(const np_medium *medium) {
  double lowest = medium->top_m;
  for (int i = 0; i < medium->layer_count; i++)
    if (medium->layers[i].part_count) lowest = fmin(lowest, fmax(medium->layers[i].bottom_m, 0.0));
  return lowest;
}

static bool is_exponential(const np_medium *medium) {
  int layers = 0, exponentials = 0;
  for (int i = 0; i < medium->layer_count; i++) {
    const np_layer *layer = &medium->layers[i];
    layers += layer->part_count > 0;
    exponentials += layer->part_count > 0 && layer->profile == NEPH_LAYER_EXPONENTIAL && !(layer->bottom_m > 0.0) &&
                    isinf(layer->top_m);
  }
  return layers == 1 && exponentials == 1;
}

/* Altitude above which e⁻ˣ of the depth lies, by bisection. */
static double search_altitude_of(const np_medium *medium, double x, double lowest) {
  const double wanted = exp(-x) * compute_depth(medium, lowest);
  double low = lowest, high = medium->top_m;
  for (int i = 0; i < 40; i++) {
    const double middle = 0.5 * (low + high);
    *(compute_depth(medium, middle) > wanted ? &low : &high) = middle;
  }
  return x > 0.0 ? high : lowest;
}

static void place_altitudes(np_gather_kernel *kernel) {
  const np_medium *medium = kernel->medium;
  const bool is_plain = !kernel->needs_delta_scaling && is_exponential(medium);
  kernel->altitude_count =
      is_plain ? (int)(sizeof exponential_depths / sizeof *exponential_depths) : (int)NP_GATHER_ALTITUDES_MAX;
  const double lowest = compute_lowest(medium);
  for (int i = 0; i < kernel->altitude_count; i++)
    kernel->altitude_m[i] = search_altitude_of(medium, is_plain ? exponential_depths[i] : other_depths[i], lowest);
}

/* Share of each aerosol in the scattering at an altitude; without scattering there, in the vertical depth. */
static void compute_parts(const np_medium *medium, double altitude_m, np_bands *out_part) {
  np_scattering air;
  np_scattering_at(medium, altitude_m, &air);
  const np_bands sum = np_aerosol_sum(medium, &air, 0);
  for (int i = 0; i < medium->aerosol_count; i++)
    out_part[i] = np_bands_select(sum > 0.0f, air.aerosol[i] / np_bands_max(sum, np_bands_grey(1e-30f)),
                                  medium->aerosol[i].share);
}

static void build_altitude(np_gather_kernel *kernel, int altitude, const np_path_rule *rule) {
  const np_quadrature up = np_quadrature_gauss(kernel->up), down = np_quadrature_gauss(kernel->down);
  const np_medium *medium = kernel->medium;
  const double h = kernel->altitude_m[altitude], horizon = np_horizon_cosine(medium, h);
  float row_weight[NP_GATHER_ROWS_MAX];
  for (int k = 0; k < kernel->up + kernel->down; k++) {
    const bool is_up = k < kernel->up;
    const np_quadrature *q = is_up ? &up : &down;
    const double u = q->x[is_up ? k : k - kernel->up], range = is_up ? 1.0 - horizon : -(1.0 + horizon);
    kernel->input_cosine[altitude][k] = (float)(horizon + range * u * u);
    row_weight[k] = (float)(fabs(range) * 2.0 * u * q->weight[is_up ? k : k - kernel->up]);
    kernel->ray[altitude][k] = np_ray_on_side(medium, h, horizon + range * u * u, !is_up);
    np_path_build(medium, &kernel->ray[altitude][k], rule, &kernel->path[altitude][k]);
  }
  compute_parts(medium, h, kernel->part[altitude]);
  dome_inputs inputs;
  place_inputs(kernel, altitude, row_weight, &inputs);
  for (int i = 0; i < medium->aerosol_count; i++) build_weights(kernel, altitude, i, &inputs);
}

static bool has_sharp_lobe(const np_medium *medium) {
  bool is_sharp = false;
  for (int i = 0; i < medium->aerosol_count; i++) {
    const np_phase *phase = &medium->aerosol[i].phase;
    for (int k = 0; k < NP_PHASE_LOBES; k++)
      is_sharp |= np_phase_get_share(phase, k) > 0.0f && fabsf(phase->lobe[k].asymmetry) > asymmetry_max;
  }
  return is_sharp;
}

static void set_sizes(np_gather_kernel *kernel) {
  kernel->needs_delta_scaling = kernel->medium->needs_delta_scaling;
  kernel->passes = kernel->needs_delta_scaling ? PASSES_THICK : PASSES;
  kernel->cosines = kernel->needs_delta_scaling ? NP_GATHER_COSINES_MAX : COSINES;
  kernel->azimuths = kernel->needs_delta_scaling ? NP_GATHER_AZIMUTHS_MAX : AZIMUTHS;
  const int finer = kernel->needs_delta_scaling && has_sharp_lobe(kernel->medium) ? 2 : 1;
  kernel->up = UP * finer;
  kernel->down = DOWN * finer;
  kernel->azimuth_count = DOME_AZIMUTHS * finer;
}

neph_result np_gather_kernel_build(neph_context *context, const np_medium *medium, np_gather_kernel *out_kernel) {
  const size_t count = (size_t)medium->aerosol_count;
  out_kernel->medium = medium;
  if (!count) return NEPH_OK;
  set_sizes(out_kernel);
  place_altitudes(out_kernel);
  const size_t outputs = np_gather_kernel_count_outputs(out_kernel) * (size_t)np_gather_kernel_count_inputs(out_kernel);
  out_kernel->weight = np_alloc(context, (size_t)out_kernel->altitude_count * count * outputs, sizeof(float));
  if (!out_kernel->weight) return NEPH_ERROR_OUT_OF_MEMORY;
  out_kernel->lobe_convolution = np_alloc(context, count * count * ANGLES, sizeof(float));
  if (!out_kernel->lobe_convolution) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count * count; i++)
    convolve_lobes(&medium->aerosol[i / count].phase, &medium->aerosol[i % count].phase,
                   out_kernel->lobe_convolution + i * ANGLES);
  const np_path_rule rule = np_path_rule_make(np_warp_is_needed(medium) ? POINTS_MAX : POINTS);
  for (int altitude = 0; altitude < out_kernel->altitude_count; altitude++) build_altitude(out_kernel, altitude, &rule);
  return NEPH_OK;
}

void np_gather_kernel_free(neph_context *context, np_gather_kernel *kernel) {
  np_alloc_free(context, kernel->weight);
  np_alloc_free(context, kernel->lobe_convolution);
  kernel->weight = kernel->lobe_convolution = NULL;
}
