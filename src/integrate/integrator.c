/* SPDX-License-Identifier: Apache-2.0 */
#include "integrate/integrator.h"

#include "core/isa.h"

#define DECLARE(level)                                                                                                 \
  void np_march_sample_##level(const np_world *, const np_lighting *, const np_integrator_settings *,                  \
                               const np_camera_ray *, np_random *, np_integrator_sample *);                            \
  void np_path_sample_##level(const np_world *, const np_lighting *, const np_integrator_settings *,                   \
                              const np_camera_ray *, np_random *, np_integrator_sample *);                             \
  double np_march_half_distance_##level(const np_world *, const np_camera_ray *, double);                              \
  np_view_depth np_march_view_depth_##level(const np_world *, const np_camera_ray *, double);
DECLARE(v1)
DECLARE(v3)
DECLARE(v4)

#define KERNELS(level)                                                                                                 \
  {                                                                                                                    \
    .march = np_march_sample_##level, .path = np_path_sample_##level, .half_distance = np_march_half_distance_##level, \
    .view_depth = np_march_view_depth_##level                                                                          \
  }

static const np_integrator_kernels kernels[NP_ISA_COUNT] = {KERNELS(v1), KERNELS(v3), KERNELS(v4)};

const np_integrator_kernels *np_integrator_get_kernels(neph_isa isa) { return &kernels[isa]; }
