/* SPDX-License-Identifier: Apache-2.0 */
/* The aerosol's source J(ω) = ∫ p(ω·ω′) L(ω′) dω′ over a dome of directions ω′ at a few altitudes.
 *
 * L is split into first-order aerosol light, p̄(ω′·S)·g(ω′), and the rest, Ls. The dome's rule resolves neither the
 * lobe p nor the product of two lobes. But Ls and g are smooth, and quotients of sums over the same rule are weighted
 * means of them, in which its error cancels. With the convolution of two lobes, (p∗q)(Θ) = Σ
 * (2l+1)/(4π)·χ_l(p)·χ_l(q)·P_l(cosΘ):
 *
 * J(ω) = Σ w p(ω·ω′)·Ls(ω′) / Σ w p(ω·ω′) + (p∗p̄)(Θ)·Σ w p(ω·ω′) p̄(ω′·S)·g(ω′) / Σ w p(ω·ω′) p̄(ω′·S).
 *
 * Each of several aerosols is gathered by its own p; the table stores their mean, weighted by their shares in
 * scattering. */
#include "atmosphere/atmosphere_tables.h"

#include "atmosphere/gather_ground.h"
#include "atmosphere/mie_gather.h"
#include "core/alloc.h"
#include "core/parallel.h"

typedef struct gather_job {
  np_sky_light
      light; /* light of the domes; its gather is NULL in the first pass, and then the table of the previous pass */
  const np_moment_table *moments; /* divisor of the stored source */
  const np_gather_kernel *kernel;
  const np_sea *sea;                              /* ground of the domes; NULL: land */
  np_water_mirror mirror;                         /* reflects skylight where there is water */
  np_water_skylight skylight[NP_GATHER_SUNS_MAX]; /* found in the pass before */
  np_gather_table *table;
} gather_job;

/* Traces the dome at one altitude under one sun. */
static void trace_dome(const gather_job *job, int altitude, int sun_index, np_scattered *out_dome,
                       np_bands *out_phase) {
  const np_gather_kernel *kernel = job->kernel;
  const float sun_cosine = job->table->sun_cosine[sun_index];
  const np_vec3 sun = np_gather_direction(sun_cosine, 0.0);
  for (int row = 0; row < kernel->up + kernel->down; row++) {
    const np_ray *ray = &kernel->ray[altitude][row];
    np_fan fan = {.count = kernel->azimuth_count, .r = (float)ray->r};
    for (int turn = 0; turn < kernel->azimuth_count; turn++) {
      const np_vec3 from = np_gather_kernel_get_input(kernel, altitude, row, turn);
      const float versine = np_vec3_versine(from, sun);
      fan.sun_cosine[turn] = sun_cosine;
      fan.angle_cosine[turn] = 1.0f - versine;
      out_phase[row * kernel->azimuth_count + turn] = np_aerosol_phase(kernel->medium, versine);
    }
    np_fan_pad(&fan);
    np_scattered *out_row = out_dome + row * kernel->azimuth_count;
    np_sky_trace(&job->light, &fan, &kernel->path[altitude][row], out_row);
    np_gather_ground_add(kernel, &job->light, job->sea, &job->skylight[sun_index], altitude, row, &fan, out_row);
  }
}

/* Source of one aerosol in one direction from a traced dome; its peak lacks the factor (p∗p̄)(Θ). */
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

/* Mean source of all aerosols by their shares. The peak is divided by the mean lobe, by which readers multiply. */
static np_gather_source gather_direction(const np_gather_kernel *kernel, int altitude, size_t out, float versine,
                                         const np_scattered *dome, const np_bands *phase) {
  np_gather_source sum = {np_bands_grey(0.0f), np_bands_grey(0.0f)};
  for (int i = 0; i < kernel->medium->aerosol_count; i++) {
    const int inputs = np_gather_kernel_count_inputs(kernel);
    const float *weight = np_gather_kernel_get_weights(kernel, altitude, i) + out * (size_t)inputs;
    const np_gather_source own = convolve(weight, inputs, dome, phase);
    sum.smooth += kernel->part[altitude][i] * own.smooth;
    sum.peak += kernel->part[altitude][i] * np_gather_kernel_convolve(kernel, i, versine) * own.peak;
  }
  if (kernel->needs_delta_scaling)
    sum.peak /= np_bands_max(np_gather_kernel_convolve_lobe(kernel, versine), np_bands_grey(1e-20f));
  else
    sum = (np_gather_source){sum.smooth + sum.peak, np_bands_grey(0.0f)};
  return sum;
}

static void gather_altitude(const gather_job *job, int sun, int altitude) {
  const np_gather_kernel *kernel = job->kernel;
  np_scattered dome[NP_GATHER_INPUTS_MAX];
  np_bands phase[NP_GATHER_INPUTS_MAX];
  const float sun_cosine = job->table->sun_cosine[sun];
  trace_dome(job, altitude, sun, dome, phase);
  /* Without light the moments are 0: the floor bounds the quotient, which would be noise. */
  const np_bands total = np_bands_max(np_moment_table_total(job->moments, kernel->altitude_m[altitude], sun_cosine),
                                      np_bands_grey(1e-12f));
  for (int out = 0; out < (int)np_gather_kernel_count_outputs(kernel); out++) {
    const int row_out = out / kernel->azimuths, turn = out % kernel->azimuths;
    const np_vec3 to = np_gather_kernel_get_output(kernel, out);
    const float versine = np_vec3_versine(to, np_gather_direction(sun_cosine, 0.0));
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

static neph_result reflect_skylight(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  gather_job *job = user;
  np_scattered dome[NP_GATHER_INPUTS_MAX];
  np_bands phase[NP_GATHER_INPUTS_MAX];
  for (size_t sun = begin; sun < end; sun++) {
    trace_dome(job, 0, (int)sun, dome, phase);
    np_water_mirror_reflect(&job->mirror, job->kernel, dome, phase, &job->skylight[sun]);
  }
  return NEPH_OK;
}

/* Chooses the suns: at most `step` apart, the nominal one among them if their number allows, and none beyond the end of
 * twilight, where there is no light. */
static void place_suns(np_gather_table *table, double zenith, double spread, double step) {
  const double low = fmax(zenith - spread, 0.0), high = fmin(fmax(zenith + spread, low), NP_PI);
  const double wanted = 2.0 * fmax(ceil((high - low) / (2.0 * step) - 1e-6), 1.0) + 1.0;
  table->sun_count = (int)fmin(wanted, NP_GATHER_SUNS_MAX);
  for (int i = 0; i < table->sun_count; i++)
    table->sun_cosine[i] = (float)cos(low + (high - low) * i / (table->sun_count - 1));
}

neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  const np_sea *sea, double sun_zenith_rad, double spread_rad, np_sun_disk disk,
                                  np_monitor *monitor, np_gather_table *out_table) {
  const np_medium *medium = depths->medium;
  np_gather_table *first = np_alloc(context, 1, sizeof *first);
  if (!first) return NEPH_ERROR_OUT_OF_MEMORY;
  out_table->kernel = first->kernel = kernel;
  /* 2° on the Earth. */
  const double step = 2.0 * NP_DEGREE * np_twilight_scale(medium) / 0.1753;
  place_suns(out_table, sun_zenith_rad, spread_rad, step);
  place_suns(first, sun_zenith_rad, spread_rad, step);
  gather_job job = {.light = {np_fan_get_kernels(context->isa), medium, depths, dome_moments, NULL, disk},
                    .moments = moments,
                    .kernel = kernel,
                    .sea = sea,
                    .table = first};
  const size_t pieces = (size_t)out_table->sun_count * (size_t)kernel->altitude_count;
  neph_result result = sea ? np_water_mirror_init(context, kernel, &sea->water, &job.mirror) : NEPH_OK;
  for (int pass = 1; !result && pass <= kernel->passes; pass++) {
    job.table = (kernel->passes - pass) % 2 ? first : out_table;
    if (sea) result = np_parallel_for(context, monitor, (size_t)out_table->sun_count, 1, reflect_skylight, &job);
    if (!result) result = np_parallel_for(context, monitor, pieces, 1, gather_pieces, &job);
    job.light.gather = job.table;
  }
  np_water_mirror_clear(&job.mirror);
  np_alloc_free(context, first);
  return result;
}
