/* SPDX-License-Identifier: Apache-2.0 */
/* The aerosol's source J(ω) = ∫ p(ω·ω′) L(ω′) dω′ over a dome of directions ω′ at a few altitudes.
 *
 * L is split into what aerosol scattered once, p̄(ω′·S)·g(ω′), and the rest, Ls. Neither the lobe p nor the product
 * of two lobes is resolved by the dome's rule; but Ls and g are smooth, and quotients of sums over the same rule are
 * weighted means of them, in which its error cancels. With (p∗q)(Θ) = Σ (2l+1)/(4π)·χ_l(p)·χ_l(q)·P_l(cosΘ), one lobe
 * convolved with another:
 *
 *   J(ω) = Σ w p(ω·ω′)·Ls(ω′) / Σ w p(ω·ω′)  +  (p∗p̄)(Θ)·Σ w p(ω·ω′) p̄(ω′·S)·g(ω′) / Σ w p(ω·ω′) p̄(ω′·S).
 *
 * Of several aerosols each is gathered by its own p, and what is kept is their mean by their parts in the scattering.
 */
#include "atmosphere/mie_gather.h"

#include "atmosphere/ray_warp.h"
#include "atmosphere/sky_trace.h"
#include "core/alloc.h"
#include "core/parallel.h"
#include "core/stable.h"

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
enum { UP = 8, DOWN = 4, TURNS = 8 }; /* twice as many of each where a lobe is sharp */

/* Altitudes by the scattering depth above them, e⁻ˣ of the whole: for one exponential these are its scale heights. */
static const double exponential_depths[] = {0.0, 0.667, 2.083, 6.667};
static const double other_depths[NP_GATHER_ALTITUDES_MAX] = {0.0, 0.25, 0.667, 1.3, 2.083, 3.3, 4.8, 6.667};

/* Lobes are widened to this in weights: the rule's directions lie some fifteen degrees apart, or eight. */
static const float asymmetry_max = 0.85f, sharp_asymmetry_max = 0.93f;

/* Elevations e = π/2·x·|x|, x even: they crowd about the horizontal. */
static float output_cosine(const np_gather_kernel *kernel, int i) {
  const double x = 2.0 * i / (kernel->cosines - 1.0) - 1.0;
  return (float)sin(0.5 * NP_PI * x * fabs(x));
}

static double output_azimuth(const np_gather_kernel *kernel, int i) { return NP_PI * i / (kernel->azimuths - 1.0); }

static np_vec3 direction_of(float cosine, double azimuth) {
  const float sine = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  return np_vec3_make(sine * (float)cos(azimuth), sine * (float)sin(azimuth), cosine);
}

static double input_azimuth(const np_gather_kernel *kernel, int turn) { return NP_PI * (turn + 0.5) / kernel->turns; }

static float versine_between(np_vec3 a, np_vec3 b) { return np_versine(a.x, a.y, a.z, b.x, b.y, b.z); }

/* Two lobes convolved, at 257 angles; the series ends where its terms no longer count. */
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

/* Place of an angle in those tables. */
static float find_angle(float versine) {
  return (float)(ANGLES - 1) * sqrtf(np_acos_coarse(1.0f - versine) * (1.0f / NP_PI_F));
}

/* One aerosol's lobe convolved with the mean of all. */
static np_bands lookup_twice(const np_gather_kernel *kernel, int aerosol, float versine) {
  const float x = find_angle(versine);
  const int i = x < (float)(ANGLES - 2) ? (int)x : ANGLES - 2, count = kernel->medium->aerosol_count;
  np_bands sum = np_bands_grey(0.0f);
  for (int k = 0; k < count; k++) {
    const float *twice = kernel->twice + (aerosol * count + k) * ANGLES;
    sum += np_mixf(twice[i], twice[i + 1], x - (float)i) * kernel->medium->aerosol[k].share;
  }
  return sum;
}

np_bands np_gather_kernel_twice(const np_gather_kernel *kernel, float versine) {
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < kernel->medium->aerosol_count; i++)
    sum += lookup_twice(kernel, i, versine) * kernel->medium->aerosol[i].share;
  return sum;
}

static int count_inputs(const np_gather_kernel *kernel) { return (kernel->up + kernel->down) * kernel->turns; }

static size_t count_outputs(const np_gather_kernel *kernel) { return (size_t)(kernel->cosines * kernel->azimuths); }

static float *find_weights(const np_gather_kernel *kernel, int altitude, int aerosol) {
  const size_t block = count_outputs(kernel) * (size_t)count_inputs(kernel);
  return kernel->weight + (size_t)(altitude * kernel->medium->aerosol_count + aerosol) * block;
}

/* One lobe at an input and its mirror image behind the sun's plane, for which the input stands as well. */
static float eval_twins(np_phase_lobe lobe, np_vec3 to, np_vec3 from) {
  return np_phase_eval_lobe(lobe, versine_between(to, from)) +
         np_phase_eval_lobe(lobe, versine_between(to, np_vec3_make(from.x, -from.y, from.z)));
}

/* The directions that are gathered from at one altitude, and the rule's weights of their rows. */
typedef struct dome_inputs {
  int count;
  np_vec3 from[NP_GATHER_INPUTS_MAX];
  float weight[NP_GATHER_INPUTS_MAX];
} dome_inputs;

static void place_inputs(const np_gather_kernel *kernel, int altitude, const float *row_weight, dome_inputs *out) {
  out->count = count_inputs(kernel);
  for (int in = 0; in < out->count; in++) {
    const int row = in / kernel->turns, turn = in % kernel->turns;
    out->from[in] = direction_of(kernel->input_cosine[altitude][row], input_azimuth(kernel, turn));
    out->weight[in] = row_weight[row];
  }
}

/* Adds the weights of every input in one output for one lobe, scaled to a sum of `share`. */
static void add_lobe(const dome_inputs *inputs, np_phase_lobe lobe, np_vec3 to, float share, float *weights) {
  float value[NP_GATHER_INPUTS_MAX], sum = 0.0f;
  for (int in = 0; in < inputs->count; in++) {
    value[in] = inputs->weight[in] * eval_twins(lobe, to, inputs->from[in]);
    sum += value[in];
  }
  for (int in = 0; in < inputs->count; in++) weights[in] += share / np_maxf(sum, 1e-20f) * value[in];
}

/* Each lobe of a mixture is scaled by itself, so that a narrow one keeps its share wherever the rule's directions lie,
 * and is widened to what the rule tells apart. */
static void build_weights(np_gather_kernel *kernel, int altitude, int aerosol, const dome_inputs *inputs) {
  const np_phase *phase = &kernel->medium->aerosol[aerosol].phase;
  const float greatest = kernel->turns > TURNS ? sharp_asymmetry_max : asymmetry_max;
  const float share[2] = {1.0f - phase->weight, phase->weight};
  for (size_t out = 0; out < count_outputs(kernel); out++) {
    const np_vec3 to = direction_of(output_cosine(kernel, (int)out / kernel->azimuths),
                                    output_azimuth(kernel, (int)out % kernel->azimuths));
    float *weights = find_weights(kernel, altitude, aerosol) + out * (size_t)inputs->count;
    for (int i = 0; i < 2; i++) {
      const float g = np_clampf(phase->lobe[i].asymmetry, -greatest, greatest);
      if (share[i] > 0.0f) add_lobe(inputs, (np_phase_lobe){g, phase->lobe[i].alpha}, to, share[i], weights);
    }
  }
}

/* Scattering depth of all aerosols above an altitude, summed over the bands. */
static double find_depth(const np_medium *medium, double altitude_m) {
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < medium->aerosol_count; i++) sum += np_aerosol_column(medium, i, altitude_m);
  return (double)(sum[0] + sum[1] + sum[2]);
}

static double find_lowest(const np_medium *medium) {
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

/* The altitude above which e⁻ˣ of the depth lies, by bisection. */
static double find_altitude_of(const np_medium *medium, double x, double lowest) {
  const double wanted = exp(-x) * find_depth(medium, lowest);
  double low = lowest, high = medium->top_m;
  for (int i = 0; i < 40; i++) {
    const double middle = 0.5 * (low + high);
    *(find_depth(medium, middle) > wanted ? &low : &high) = middle;
  }
  return x > 0.0 ? high : lowest;
}

static void place_altitudes(np_gather_kernel *kernel) {
  const np_medium *medium = kernel->medium;
  const bool is_plain = !kernel->is_thick && is_exponential(medium);
  kernel->altitude_count =
      is_plain ? (int)(sizeof exponential_depths / sizeof *exponential_depths) : (int)NP_GATHER_ALTITUDES_MAX;
  const double lowest = find_lowest(medium);
  for (int i = 0; i < kernel->altitude_count; i++)
    kernel->altitude_m[i] = find_altitude_of(medium, is_plain ? exponential_depths[i] : other_depths[i], lowest);
}

/* What part each aerosol has in the scattering at an altitude; where there is none, in all of it. */
static void find_parts(const np_medium *medium, double altitude_m, np_bands *out_part) {
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
  find_parts(medium, h, kernel->part[altitude]);
  dome_inputs inputs;
  place_inputs(kernel, altitude, row_weight, &inputs);
  for (int i = 0; i < medium->aerosol_count; i++) build_weights(kernel, altitude, i, &inputs);
}

static bool has_sharp_lobe(const np_medium *medium) {
  bool is_sharp = false;
  for (int i = 0; i < medium->aerosol_count; i++) {
    const np_phase *phase = &medium->aerosol[i].phase;
    is_sharp |= fabsf(phase->lobe[0].asymmetry) > asymmetry_max ||
                (phase->weight > 0.0f && fabsf(phase->lobe[1].asymmetry) > asymmetry_max);
  }
  return is_sharp;
}

static void set_sizes(np_gather_kernel *kernel) {
  kernel->is_thick = kernel->medium->is_thick;
  kernel->passes = kernel->is_thick ? PASSES_THICK : PASSES;
  kernel->cosines = kernel->is_thick ? NP_GATHER_COSINES_MAX : COSINES;
  kernel->azimuths = kernel->is_thick ? NP_GATHER_AZIMUTHS_MAX : AZIMUTHS;
  const int finer = kernel->is_thick && has_sharp_lobe(kernel->medium) ? 2 : 1;
  kernel->up = UP * finer;
  kernel->down = DOWN * finer;
  kernel->turns = TURNS * finer;
}

neph_result np_gather_kernel_build(neph_context *context, const np_medium *medium, np_gather_kernel *out_kernel) {
  const size_t count = (size_t)medium->aerosol_count;
  out_kernel->medium = medium;
  if (!count) return NEPH_OK;
  set_sizes(out_kernel);
  place_altitudes(out_kernel);
  const size_t outputs = count_outputs(out_kernel) * (size_t)count_inputs(out_kernel);
  out_kernel->weight = np_alloc(context, (size_t)out_kernel->altitude_count * count * outputs, sizeof(float));
  if (!out_kernel->weight) return NEPH_ERROR_OUT_OF_MEMORY;
  out_kernel->twice = np_alloc(context, count * count * ANGLES, sizeof(float));
  if (!out_kernel->twice) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count * count; i++)
    convolve_lobes(&medium->aerosol[i / count].phase, &medium->aerosol[i % count].phase,
                   out_kernel->twice + i * ANGLES);
  const np_path_rule rule = np_path_rule_make(np_warp_is_due(medium) ? POINTS_MAX : POINTS);
  for (int altitude = 0; altitude < out_kernel->altitude_count; altitude++) build_altitude(out_kernel, altitude, &rule);
  return NEPH_OK;
}

void np_gather_kernel_free(neph_context *context, np_gather_kernel *kernel) {
  np_alloc_free(context, kernel->weight);
  np_alloc_free(context, kernel->twice);
  kernel->weight = kernel->twice = NULL;
}

typedef struct gather_job {
  np_sky_light light;             /* of the domes; its gather is the first pass in the second, NULL in the first */
  const np_moment_table *moments; /* what the source is stored over */
  const np_gather_kernel *kernel;
  np_gather_table *table;
} gather_job;

/* Traces the dome at one altitude under one sun. */
static void trace_dome(const gather_job *job, int altitude, float sun_cosine, np_scattered *out_dome,
                       np_bands *out_phase) {
  const np_gather_kernel *kernel = job->kernel;
  const np_vec3 sun = direction_of(sun_cosine, 0.0);
  for (int row = 0; row < kernel->up + kernel->down; row++) {
    const np_ray *ray = &kernel->ray[altitude][row];
    np_fan fan = {.count = kernel->turns, .r = (float)ray->r};
    for (int turn = 0; turn < kernel->turns; turn++) {
      const np_vec3 from = direction_of(kernel->input_cosine[altitude][row], input_azimuth(kernel, turn));
      const float versine = versine_between(from, sun);
      fan.sun_cosine[turn] = sun_cosine;
      fan.angle_cosine[turn] = 1.0f - versine;
      out_phase[row * kernel->turns + turn] = np_aerosol_phase(kernel->medium, versine);
    }
    np_fan_pad(&fan);
    np_sky_trace(&job->light, &fan, ray, &kernel->path[altitude][row], true, out_dome + row * kernel->turns);
  }
}

/* The source of one aerosol in one direction from a traced dome: its peak without (p∗p̄)(Θ). */
static np_gather_source convolve(const float *weight, int count, const np_scattered *dome, const np_bands *phase) {
  np_bands smooth = np_bands_grey(0.0f), peak = np_bands_grey(0.0f), peak_weight = np_bands_grey(0.0f);
  float smooth_weight = 0.0f;
  for (int in = 0; in < count; in++) {
    const np_bands wp = weight[in] * phase[in];
    smooth += weight[in] * dome[in].smooth;
    smooth_weight += weight[in];
    peak += wp * dome[in].peak;
    peak_weight += wp;
  }
  return (np_gather_source){smooth / np_maxf(smooth_weight, 1e-20f),
                            peak / np_bands_max(peak_weight, np_bands_grey(1e-20f))};
}

/* The mean of all aerosols by their parts; the peak over the mean lobe of all, where readers multiply that on. */
static np_gather_source gather_direction(const np_gather_kernel *kernel, int altitude, size_t out, float versine,
                                         const np_scattered *dome, const np_bands *phase) {
  np_gather_source sum = {np_bands_grey(0.0f), np_bands_grey(0.0f)};
  for (int i = 0; i < kernel->medium->aerosol_count; i++) {
    const int inputs = count_inputs(kernel);
    const float *weight = find_weights(kernel, altitude, i) + out * (size_t)inputs;
    const np_gather_source own = convolve(weight, inputs, dome, phase);
    sum.smooth += kernel->part[altitude][i] * own.smooth;
    sum.peak += kernel->part[altitude][i] * lookup_twice(kernel, i, versine) * own.peak;
  }
  if (kernel->is_thick)
    sum.peak /= np_bands_max(np_gather_kernel_twice(kernel, versine), np_bands_grey(1e-20f));
  else
    sum = (np_gather_source){sum.smooth + sum.peak, np_bands_grey(0.0f)};
  return sum;
}

static void gather_altitude(const gather_job *job, int sun, int altitude) {
  const np_gather_kernel *kernel = job->kernel;
  np_scattered dome[NP_GATHER_INPUTS_MAX];
  np_bands phase[NP_GATHER_INPUTS_MAX];
  const float sun_cosine = job->table->sun_cosine[sun];
  trace_dome(job, altitude, sun_cosine, dome, phase);
  /* Where the moments hold no light there is none to scale: a quotient bounded, not the noise of two zeros. */
  const np_bands total = np_bands_max(np_moment_table_total(job->moments, kernel->altitude_m[altitude], sun_cosine),
                                      np_bands_grey(1e-12f));
  for (int out = 0; out < (int)count_outputs(kernel); out++) {
    const int row_out = out / kernel->azimuths, turn = out % kernel->azimuths;
    const np_vec3 to = direction_of(output_cosine(kernel, row_out), output_azimuth(kernel, turn));
    const float versine = versine_between(to, direction_of(sun_cosine, 0.0));
    const np_gather_source s = gather_direction(kernel, altitude, (size_t)out, versine, dome, phase);
    job->table->source[sun][altitude][row_out][turn] = (np_gather_source){s.smooth / total, s.peak / total};
  }
}

static neph_result gather_pieces(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const gather_job *job = user;
  const size_t altitudes = (size_t)job->kernel->altitude_count;
  for (size_t i = begin; i < end; i++) gather_altitude(job, (int)(i / altitudes), (int)(i % altitudes));
  return NEPH_OK;
}

/* Suns no more than `step` apart, the wanted one among them where their number allows; none beyond the end of twilight,
 * where there is nothing to gather. */
static void place_suns(np_gather_table *table, double zenith, double spread, double step) {
  const double low = fmax(zenith - spread, 0.0), high = fmin(fmax(zenith + spread, low), NP_PI);
  const double wanted = 2.0 * fmax(ceil((high - low) / (2.0 * step) - 1e-6), 1.0) + 1.0;
  table->sun_count = (int)fmin(wanted, NP_GATHER_SUNS_MAX);
  for (int i = 0; i < table->sun_count; i++)
    table->sun_cosine[i] = (float)cos(low + (high - low) * i / (table->sun_count - 1));
}

neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  double sun_zenith_rad, double spread_rad, np_sun_disk disk, np_monitor *monitor,
                                  np_gather_table *out_table) {
  const np_medium *medium = depths->medium;
  np_gather_table *first = np_alloc(context, 1, sizeof *first);
  if (!first) return NEPH_ERROR_OUT_OF_MEMORY;
  out_table->kernel = first->kernel = kernel;
  /* Two degrees on the Earth. */
  const double step = 2.0 * NP_DEGREE * np_twilight_scale(medium) / 0.1753;
  place_suns(out_table, sun_zenith_rad, spread_rad, step);
  place_suns(first, sun_zenith_rad, spread_rad, step);
  gather_job job = {
      {np_fan_get_kernels(context->isa), medium, depths, dome_moments, NULL, disk}, moments, kernel, first};
  const size_t pieces = (size_t)out_table->sun_count * (size_t)kernel->altitude_count;
  neph_result result = NEPH_OK;
  for (int pass = 1; !result && pass <= kernel->passes; pass++) {
    job.table = (kernel->passes - pass) % 2 ? first : out_table;
    result = np_parallel_for(context, monitor, pieces, 1, gather_pieces, &job);
    job.light.gather = job.table;
  }
  np_alloc_free(context, first);
  return result;
}

/* Place of an altitude among the kernel's. */
static int find_altitude(const np_gather_kernel *kernel, double altitude_m, float *out_upper) {
  int i = 0;
  while (i + 2 < kernel->altitude_count && altitude_m > kernel->altitude_m[i + 1]) i++;
  const double low = kernel->altitude_m[i], high = kernel->altitude_m[i + 1];
  *out_upper = high > low ? (float)np_clamp((altitude_m - low) / (high - low), 0.0, 1.0) : 0.0f;
  return i;
}

static np_gather_source mix_sources(const np_gather_source *a, const np_gather_source *b, float t) {
  return (np_gather_source){np_bands_mix(a->smooth, b->smooth, t), np_bands_mix(a->peak, b->peak, t)};
}

void np_gather_table_row(const np_gather_table *table, double altitude_m, float view_cosine, np_gather_row *out_row) {
  const np_gather_kernel *kernel = table->kernel;
  float upper;
  const int i = find_altitude(kernel, altitude_m, &upper);
  const float elevation = 1.0f - np_acos_coarse(view_cosine) * (2.0f / NP_PI_F);
  const float x = 0.5f * (copysignf(sqrtf(fabsf(elevation)), elevation) + 1.0f) * (float)(kernel->cosines - 1);
  const int j = x < (float)(kernel->cosines - 2) ? (int)np_maxf(x, 0.0f) : kernel->cosines - 2;
  const float f = x - (float)j;
  for (int s = 0; s < table->sun_count; s++)
    for (int k = 0; k < kernel->azimuths; k++) {
      const np_gather_source low = mix_sources(&table->source[s][i][j][k], &table->source[s][i][j + 1][k], f);
      const np_gather_source high = mix_sources(&table->source[s][i + 1][j][k], &table->source[s][i + 1][j + 1][k], f);
      out_row->source[s][k] = mix_sources(&low, &high, upper);
    }
}
