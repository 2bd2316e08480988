/* SPDX-License-Identifier: Apache-2.0 */
/* Calibrated gain of the approximations of multiple scattering: the factor that gives them the mean brightness of a
 * solved cloud, by effective optical depth, single scattering albedo, asymmetry, and angle between light and view.
 *
 * The effective optical depth τ of a cloud is that of a cube from which light escapes as fast: 3/τ² = Σ 1/τᵢ² over the
 * cloud's three axes, and τᵢ = Σ T² / Σ T the mean depth T of columns along the axis, weighted by what they hold. Thin
 * haze around a cloud hardly counts. Along a periodic axis τᵢ is infinite.
 */
#ifndef NP_INTEGRATE_APPROXIMATION_GAIN_H
#define NP_INTEGRATE_APPROXIMATION_GAIN_H

#include "core/math.h"
#include "optics/multiple_scattering.h"
#include "volume/instance.h"

/* ---- Table ---- */

/* Depths of ½·4ⁱ. */
enum { NP_GAIN_DEPTHS = 6, NP_GAIN_ALBEDOS = 3, NP_GAIN_ASYMMETRIES = 3 };

static const double np_gain_depth_first = 0.5, np_gain_depth_ratio = 4.0;
static const double np_gain_albedos[NP_GAIN_ALBEDOS] = {1.0, 0.9, 0.5};
static const double np_gain_asymmetries[NP_GAIN_ASYMMETRIES] = {0.0, 0.6, 0.85};

typedef float np_gain_table[NP_GAIN_ASYMMETRIES][NP_GAIN_DEPTHS][NP_GAIN_ALBEDOS][NP_GAIN_ANGLES];

/* One row a method; `none` is single scattering, as the derivative has it for light of the surroundings. */
extern const np_gain_table np_gain_table_octaves, np_gain_table_softened_beer, np_gain_table_powder,
    np_gain_table_derivative, np_gain_table_none;

/* ---- Gain of a cloud ---- */

/* Effective optical depth. */
float np_cloud_gain_compute_depth(const np_instance *cloud);

/* Gain of a method; depth, albedo and asymmetry beyond the table's are taken as its nearest. */
void np_cloud_gain_fill(neph_multiple_scattering method, const np_instance *cloud, float depth, np_cloud_gain *out);

/* Place among the nodes, 0 to NP_GAIN_ANGLES − 1, of the angle between view and light of this versine. */
static inline float np_cloud_gain_get_place(float versine) {
  return (float)(NP_GAIN_ANGLES - 1) * sqrtf(np_clampf(0.5f * versine, 0.0f, 1.0f));
}

/* Gain at an angle. */
static inline np_spectrum np_cloud_gain_get(const np_spectrum gain[NP_GAIN_ANGLES], float versine) {
  const float place = np_cloud_gain_get_place(versine);
  const int node = place < (float)(NP_GAIN_ANGLES - 2) ? (int)place : NP_GAIN_ANGLES - 2;
  return np_spectrum_mix(gain[node], gain[node + 1], place - (float)node);
}

#endif
