/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of the aerosol's gather (mie_gather.h) that depend on the medium alone: directions, paths along them, and the
 * phase functions between them. */
#ifndef NP_ATMOSPHERE_GATHER_KERNEL_H
#define NP_ATMOSPHERE_GATHER_KERNEL_H

#include "atmosphere/optical_depth.h"
#include "atmosphere/ray_path.h"
#include "core/stable.h"

enum {
  NP_GATHER_ALTITUDES_MAX = 8,
  NP_GATHER_COSINES_MAX = 25,
  NP_GATHER_AZIMUTHS_MAX = 17, /* azimuths on the half circle, both ends inclusive */
  NP_GATHER_SUNS_MAX = 17,
  NP_GATHER_ROWS_MAX = 24, /* rows of the dome */
  NP_GATHER_INPUTS_MAX = NP_GATHER_ROWS_MAX * 16
};

/* Inputs that depend on the medium alone: the dome directions at each altitude, their paths, and the phase functions
 * between each of them and each direction of the table. */
typedef struct np_gather_kernel {
  const np_medium *medium;
  int altitude_count;
  int cosines, azimuths;       /* output directions */
  int up, down, azimuth_count; /* input dome: rows above and below the horizon, azimuths of each */
  bool needs_delta_scaling;    /* there is enough aerosol for its forward peak to matter in later orders */
  int passes;                  /* passes of gathering: each uses the aerosol light of the pass before */
  double altitude_m[NP_GATHER_ALTITUDES_MAX];
  np_bands part[NP_GATHER_ALTITUDES_MAX][NP_AEROSOLS_MAX]; /* share of each aerosol in the scattering at the altitude */
  float input_cosine[NP_GATHER_ALTITUDES_MAX][NP_GATHER_ROWS_MAX];
  np_ray ray[NP_GATHER_ALTITUDES_MAX][NP_GATHER_ROWS_MAX];
  np_path path[NP_GATHER_ALTITUDES_MAX][NP_GATHER_ROWS_MAX];
  float *weight;           /* quadrature weight × phase function, for altitudes × aerosols × outputs × inputs */
  float *lobe_convolution; /* pairs of aerosols: one phase function convolved with the other, over √(Θ/π) */
} np_gather_kernel;

neph_result np_gather_kernel_build(neph_context *context, const np_medium *medium, np_gather_kernel *out_kernel);
void np_gather_kernel_free(neph_context *context, np_gather_kernel *kernel);

static inline np_vec3 np_gather_direction(float cosine, double azimuth) {
  const float sine = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  return np_vec3_make(sine * (float)cos(azimuth), sine * (float)sin(azimuth), cosine);
}

/* An output direction: elevations e = π/2·x·|x|, x uniform, concentrate at the horizontal. */
static inline np_vec3 np_gather_kernel_get_output(const np_gather_kernel *kernel, int out) {
  const double x = 2.0 * (out / kernel->azimuths) / (kernel->cosines - 1.0) - 1.0;
  const float cosine = (float)sin(0.5 * NP_PI * x * fabs(x));
  return np_gather_direction(cosine, NP_PI * (out % kernel->azimuths) / (kernel->azimuths - 1.0));
}

/* An input direction of the dome at an altitude. */
static inline np_vec3 np_gather_kernel_get_input(const np_gather_kernel *kernel, int altitude, int row, int turn) {
  return np_gather_direction(kernel->input_cosine[altitude][row], NP_PI * (turn + 0.5) / kernel->azimuth_count);
}

static inline int np_gather_kernel_count_inputs(const np_gather_kernel *kernel) {
  return (kernel->up + kernel->down) * kernel->azimuth_count;
}

static inline size_t np_gather_kernel_count_outputs(const np_gather_kernel *kernel) {
  return (size_t)(kernel->cosines * kernel->azimuths);
}

/* Weights of an aerosol at an altitude: outputs × inputs. */
static inline float *np_gather_kernel_get_weights(const np_gather_kernel *kernel, int altitude, int aerosol) {
  const size_t block = np_gather_kernel_count_outputs(kernel) * (size_t)np_gather_kernel_count_inputs(kernel);
  return kernel->weight + (size_t)(altitude * kernel->medium->aerosol_count + aerosol) * block;
}

/* Phase function of one aerosol convolved with the mean of all. */
np_bands np_gather_kernel_convolve(const np_gather_kernel *kernel, int aerosol, float versine);

/* Mean phase function of the aerosols convolved with itself: the aureole of the sun after two scatterings. */
np_bands np_gather_kernel_convolve_lobe(const np_gather_kernel *kernel, float versine);

#endif
