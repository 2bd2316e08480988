/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/scattering_solver.h"

/* Forward-scattered sunlight is where it first collides, per extinction. */
void np_importance_add(const np_transport_level *finest, const float *moments, float share, float whole,
                       np_importance *importance) {
  const size_t count = np_harmonics_count(finest->grid.degree);
  const float even = share * sqrtf(0.25f / NP_PI_F), linear = share * sqrtf(0.75f / NP_PI_F);
  const float quadratic = share * sqrtf(15.0f / 16.0f / NP_PI_F);
  static const unsigned harmonic_of_axis[3] = {3, 1, 2};
  static const float quadratic_scale[5] = {2.0f, 2.0f, 0.57735027f, 2.0f, 1.0f}; /* √(1/3) */
  for (size_t active = 0; active < finest->grid.active_count; active++) {
    np_importance *out = &importance[active];
    const float *phi = moments + active * count, extinction = finest->grid.extinction[active];
    out->mean += even * phi[0];
    for (int a = 0; a < 3; a++) out->linear[a] += linear * phi[harmonic_of_axis[a]];
    for (int i = 0; i < 5; i++) out->quadratic[i] += quadratic * quadratic_scale[i] * phi[4 + i];
    if (extinction > 0.0f) out->lit = fmaxf(out->lit, fminf(finest->sun[active] / extinction, whole));
  }
}

/* Attenuation of importance across one cell along an axis, in (0, 1]: exponential in the cell's optical depth, at the
 * rate of diffuse light plus 0.35 for paths that are split before they arrive. */
static float compute_fall(const np_transport_grid *g, const int32_t at[3], int axis, size_t active) {
  const float *ratio = g->ratio + active * (g->degree + 1), width = (float)np_transport_grid_width(g, axis, at[axis]);
  const float transport = sqrtf(fmaxf(1.0f - ratio[1], 0.0f)), loss = sqrtf(3.0f * fmaxf(1.0f - ratio[0], 0.0f));
  return expf(-(0.35f + loss * transport) * g->extinction[active] * width);
}

/* A cell's own light, or more where a neighbour along an axis has much. */
static void spread_from(const np_transport_grid *g, const int32_t at[3], int axis, int step, size_t active,
                        np_importance *importance) {
  const int32_t next = np_transport_grid_neighbour(g, at, axis, step);
  if (next < 0 || !(importance[next].lit > importance[active].lit)) return;
  importance[active].lit = fmaxf(importance[active].lit, importance[next].lit * compute_fall(g, at, axis, active));
}

/* Propagates the importance of sunlight in four sweeps over the cells, forward and backward in turn, so that it also
 * turns corners. */
void np_importance_spread(const np_transport_grid *g, np_importance *importance) {
  const int32_t count = (int32_t)np_transport_grid_count(g);
  for (int pass = 0; pass < 4; pass++) {
    const bool is_back = pass % 2;
    for (int32_t i = 0; i < count; i++) {
      const int32_t cell = is_back ? count - 1 - i : i, active = g->active[cell];
      if (active < 0) continue;
      int32_t at[3];
      np_transport_grid_split(g, cell, at);
      for (int axis = 0; axis < 3; axis++) spread_from(g, at, axis, is_back ? 1 : -1, (size_t)active, importance);
    }
  }
}
