/* SPDX-License-Identifier: Apache-2.0 */
/* The aerosol's source J(ω) = ∫ p(ω·ω′) L(ω′) dω′ over a dome of directions ω′ at four altitudes.
 *
 * L is split into what the aerosol scattered once, p(ω′·S)·g(ω′), and the rest, Ls. Neither the lobe p nor the product
 * of two lobes is resolved by the dome's rule; but Ls and g are smooth, and quotients of sums over the same rule are
 * weighted means of them, in which its error cancels. With (p∗p)(Θ) = Σ (2l+1)/(4π)·χ_l²·P_l(cosΘ), the lobe convolved
 * with itself:
 *
 *   J(ω) = Σ w p(ω·ω′)·Ls(ω′) / Σ w p(ω·ω′)  +  (p∗p)(Θ)·Σ w p(ω·ω′) p(ω′·S)·g(ω′) / Σ w p(ω·ω′) p(ω′·S).
 */
#include "atmosphere/mie_gather.h"

#include "atmosphere/sky_trace.h"
#include "core/alloc.h"
#include "core/parallel.h"
#include "core/stable.h"

enum { INPUT_ROWS = NP_GATHER_UP + NP_GATHER_DOWN, POINTS = 12, TERMS = 512 };

/* Altitudes in scale heights of the aerosol. */
static const double altitudes[NP_GATHER_ALTITUDES] = {0.0, 0.667, 2.083, 6.667};

static float output_cosine(int i) {
  const float x = 2.0f * (float)i / (NP_GATHER_COSINES - 1) - 1.0f;
  return x * fabsf(x);
}

static np_vec3 direction_of(float cosine, double azimuth) {
  const float sine = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  return np_vec3_make(sine * (float)cos(azimuth), sine * (float)sin(azimuth), cosine);
}

static double input_azimuth(int turn) { return NP_PI * (turn + 0.5) / NP_GATHER_TURNS; }

static float versine_between(np_vec3 a, np_vec3 b) { return np_versine(a.x, a.y, a.z, b.x, b.y, b.z); }

/* The lobe convolved with itself at 257 angles; the series ends where its terms no longer count. */
static void build_twice(const np_medium *medium, float *out_twice) {
  double moment[TERMS];
  np_phase_get_moments(&medium->mie_phase, TERMS, moment);
  for (int i = 0; i <= 256; i++) {
    const double x = i / 256.0, c = cos(NP_PI * x * x);
    double p = 1.0, previous = 0.0, sum = 0.0;
    for (int l = 0; l < TERMS && moment[l] * moment[l] > 1e-7; l++) {
      sum += (2 * l + 1) * moment[l] * moment[l] * p;
      const double next = ((2 * l + 1) * c * p - l * previous) / (l + 1);
      previous = p;
      p = next;
    }
    out_twice[i] = (float)fmax(sum / (4.0 * NP_PI), 0.0);
  }
}

static float lookup_twice(const np_gather_kernel *kernel, float versine) {
  const double angle = acos(np_clamp(1.0 - (double)versine, -1.0, 1.0)), x = 256.0 * sqrt(angle / NP_PI);
  const int i = (int)fmin(x, 255.0);
  return np_mixf(kernel->twice[i], kernel->twice[i + 1], (float)(x - i));
}

/* Weights of every input in every output; an input stands for its mirror image behind the sun's plane as well. */
static void build_weights(np_gather_kernel *kernel, int altitude, const float *row_weight) {
  for (int out = 0; out < NP_GATHER_OUTPUTS; out++)
    for (int in = 0; in < NP_GATHER_INPUTS; in++) {
      const int row = in / NP_GATHER_TURNS, turn = in % NP_GATHER_TURNS;
      const np_vec3 to = direction_of(output_cosine(out / NP_GATHER_AZIMUTHS),
                                      NP_PI * (out % NP_GATHER_AZIMUTHS) / (NP_GATHER_AZIMUTHS - 1));
      const np_vec3 from = direction_of(kernel->input_cosine[altitude][row], input_azimuth(turn));
      const np_vec3 mirrored = np_vec3_make(from.x, -from.y, from.z);
      kernel->weight[altitude][out][in] =
          row_weight[row] * (np_phase_eval(&kernel->medium->mie_phase, versine_between(to, from)) +
                             np_phase_eval(&kernel->medium->mie_phase, versine_between(to, mirrored)));
    }
}

static void build_altitude(np_gather_kernel *kernel, int altitude, const np_path_rule *rule) {
  const np_quadrature up = np_quadrature_gauss(NP_GATHER_UP), down = np_quadrature_gauss(NP_GATHER_DOWN);
  const np_medium *medium = kernel->medium;
  const double h = fmin(altitudes[altitude] * (double)medium->mie_height_m, medium->top_m);
  const double horizon = np_horizon_cosine(medium, h);
  float row_weight[INPUT_ROWS];
  kernel->altitude_m[altitude] = h;
  for (int k = 0; k < INPUT_ROWS; k++) {
    const bool is_up = k < NP_GATHER_UP;
    const np_quadrature *q = is_up ? &up : &down;
    const double u = q->x[is_up ? k : k - NP_GATHER_UP], range = is_up ? 1.0 - horizon : -(1.0 + horizon);
    kernel->input_cosine[altitude][k] = (float)(horizon + range * u * u);
    row_weight[k] = (float)(fabs(range) * 2.0 * u * q->weight[is_up ? k : k - NP_GATHER_UP]);
    kernel->ray[altitude][k] = np_ray_on_side(medium, h, horizon + range * u * u, !is_up);
    np_path_build(medium, &kernel->ray[altitude][k], rule, &kernel->path[altitude][k]);
  }
  build_weights(kernel, altitude, row_weight);
}

void np_gather_kernel_build(const np_medium *medium, np_gather_kernel *out_kernel) {
  const np_path_rule rule = np_path_rule_make(POINTS);
  out_kernel->medium = medium;
  build_twice(medium, out_kernel->twice);
  for (int altitude = 0; altitude < NP_GATHER_ALTITUDES; altitude++) build_altitude(out_kernel, altitude, &rule);
}

typedef struct gather_job {
  np_sky_light light;             /* of the domes; its gather is the first pass in the second, NULL in the first */
  const np_moment_table *moments; /* what the source is stored over */
  const np_gather_kernel *kernel;
  np_gather_table *table;
} gather_job;

/* Traces the dome at one altitude under one sun. */
static void trace_dome(const gather_job *job, int altitude, float sun_cosine, np_scattered *out_dome,
                       float *out_phase) {
  const np_gather_kernel *kernel = job->kernel;
  const np_vec3 sun = direction_of(sun_cosine, 0.0);
  for (int row = 0; row < INPUT_ROWS; row++) {
    const np_path *path = &kernel->path[altitude][row];
    np_sky_node nodes[POINTS];
    for (int i = 0; i < path->count; i++) np_sky_node_resolve(&job->light, &path->node[i], &nodes[i]);
    for (int turn = 0; turn < NP_GATHER_TURNS; turn++) {
      const np_vec3 from = direction_of(kernel->input_cosine[altitude][row], input_azimuth(turn));
      const float versine = versine_between(from, sun);
      out_dome[row * NP_GATHER_TURNS + turn] =
          np_sky_trace(&job->light, &kernel->ray[altitude][row], path, nodes, sun_cosine, 1.0f - versine, true);
      out_phase[row * NP_GATHER_TURNS + turn] = np_phase_eval(&kernel->medium->mie_phase, versine);
    }
  }
}

/* The source in one direction from a traced dome. */
static np_bands convolve(const float *weight, const np_scattered *dome, const float *phase, float twice) {
  np_bands smooth = np_bands_grey(0.0f), peak = np_bands_grey(0.0f);
  float smooth_weight = 0.0f, peak_weight = 0.0f;
  for (int in = 0; in < NP_GATHER_INPUTS; in++) {
    const float w = weight[in], wp = weight[in] * phase[in];
    smooth += w * dome[in].smooth;
    smooth_weight += w;
    peak += wp * dome[in].peak;
    peak_weight += wp;
  }
  return smooth / np_maxf(smooth_weight, 1e-20f) + twice * peak / np_maxf(peak_weight, 1e-20f);
}

static void gather_altitude(const gather_job *job, int sun, int altitude) {
  np_scattered dome[NP_GATHER_INPUTS];
  float phase[NP_GATHER_INPUTS];
  const float sun_cosine = job->table->sun_cosine[sun];
  trace_dome(job, altitude, sun_cosine, dome, phase);
  float upper;
  const int row = np_moment_table_row(job->moments, job->kernel->altitude_m[altitude], &upper);
  const np_bands total =
      np_moment_table_total(job->moments->moments + (size_t)row * NP_MOMENT_COLUMNS * NP_MOMENT_COUNT, upper,
                            np_sun_scale_column(&job->moments->sun, sun_cosine));
  for (int out = 0; out < NP_GATHER_OUTPUTS; out++) {
    const int row_out = out / NP_GATHER_AZIMUTHS, turn = out % NP_GATHER_AZIMUTHS;
    const np_vec3 to = direction_of(output_cosine(row_out), NP_PI * turn / (NP_GATHER_AZIMUTHS - 1));
    const float twice = lookup_twice(job->kernel, versine_between(to, direction_of(sun_cosine, 0.0)));
    const np_bands source = convolve(job->kernel->weight[altitude][out], dome, phase, twice);
    /* Where the moments hold no light there is none to scale: a quotient bounded, not the noise of two zeros. */
    job->table->source[sun][altitude][row_out][turn] = source / np_bands_max(total, np_bands_grey(1e-12f));
  }
}

static neph_result gather_pieces(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t i = begin; i < end; i++)
    gather_altitude(user, (int)(i / NP_GATHER_ALTITUDES), (int)(i % NP_GATHER_ALTITUDES));
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
                                  double sun_zenith_rad, double spread_rad, np_sun_disk disk,
                                  np_gather_table *out_table) {
  const np_medium *medium = depths->medium;
  np_gather_table *first = np_alloc(context, 1, sizeof *first);
  if (!first) return NEPH_ERROR_OUT_OF_MEMORY;
  out_table->kernel = first->kernel = kernel;
  /* Two degrees on the Earth. */
  const double step = 2.0 * NP_DEGREE * np_twilight_scale(medium) / 0.1753;
  place_suns(out_table, sun_zenith_rad, spread_rad, step);
  place_suns(first, sun_zenith_rad, spread_rad, step);
  gather_job job = {{medium, depths, dome_moments, NULL, disk}, moments, kernel, first};
  const size_t pieces = (size_t)out_table->sun_count * NP_GATHER_ALTITUDES;
  neph_result result = np_parallel_for(context, NULL, pieces, 1, gather_pieces, &job);
  if (!result) {
    job.light.gather = first;
    job.table = out_table;
    result = np_parallel_for(context, NULL, pieces, 1, gather_pieces, &job);
  }
  np_alloc_free(context, first);
  return result;
}

/* Place of an altitude among the kernel's. */
static int find_altitude(const np_gather_kernel *kernel, double altitude_m, float *out_upper) {
  int i = 0;
  while (i + 2 < NP_GATHER_ALTITUDES && altitude_m > kernel->altitude_m[i + 1]) i++;
  const double low = kernel->altitude_m[i], high = kernel->altitude_m[i + 1];
  *out_upper = high > low ? (float)np_clamp((altitude_m - low) / (high - low), 0.0, 1.0) : 0.0f;
  return i;
}

void np_gather_table_row(const np_gather_table *table, double altitude_m, float view_cosine, np_gather_row *out_row) {
  float upper;
  const int i = find_altitude(table->kernel, altitude_m, &upper);
  const float x = 0.5f * (copysignf(sqrtf(fabsf(view_cosine)), view_cosine) + 1.0f) * (NP_GATHER_COSINES - 1);
  const int j = x < (float)(NP_GATHER_COSINES - 2) ? (int)x : NP_GATHER_COSINES - 2;
  const float f = x - (float)j;
  for (int s = 0; s < table->sun_count; s++)
    for (int k = 0; k < NP_GATHER_AZIMUTHS; k++) {
      const np_bands low = np_bands_mix(table->source[s][i][j][k], table->source[s][i][j + 1][k], f);
      const np_bands high = np_bands_mix(table->source[s][i + 1][j][k], table->source[s][i + 1][j + 1][k], f);
      out_row->source[s][k] = np_bands_mix(low, high, upper);
    }
}
