/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/sky_guide.h"

#include <assert.h>

#include "core/units.h"
#include "transport/scattering_field.h"

/* Sine of the elevation at which a row begins. */
static float compute_sine(float row) {
  const float root = 2.0f * row / NP_SKY_GUIDE_ROWS - 1.0f;
  return root * fabsf(root);
}

static float compute_solid_angle(int cell) {
  const float row = (float)(cell / NP_SKY_GUIDE_COLUMNS);
  return (compute_sine(row + 1.0f) - compute_sine(row)) * (2.0f * NP_PI_F / NP_SKY_GUIDE_COLUMNS);
}

/* Direction in a cell, uniform for uniform u and v. */
static np_vec3 compute_direction(int cell, float u, float v) {
  const float row = (float)(cell / NP_SKY_GUIDE_COLUMNS), column = (float)(cell % NP_SKY_GUIDE_COLUMNS);
  const float low = compute_sine(row), sine = low + u * (compute_sine(row + 1.0f) - low);
  const float azimuth = (column + v) * (2.0f * NP_PI_F / NP_SKY_GUIDE_COLUMNS);
  const float cosine = sqrtf(fmaxf(1.0f - sine * sine, 0.0f));
  return np_vec3_normalize(np_vec3_make(cosine * cosf(azimuth), cosine * sinf(azimuth), sine));
}

/* Mean over bands, each in units of `unit`. */
static float compute_value(np_spectrum light, np_spectrum unit) {
  for (int b = 0; b < NP_BAND_COUNT; b++) light.band[b] = unit.band[b] > 0.0f ? light.band[b] / unit.band[b] : 0.0f;
  return np_spectrum_mean(light);
}

static void set_densities(const np_spectrum radiance[NP_SKY_GUIDE_CELLS], np_spectrum mean, np_sky_guide *out) {
  float sum = 0.0f;
  for (int i = 0; i < NP_SKY_GUIDE_CELLS; i++) {
    out->density[i] = fmaxf(compute_value(radiance[i], mean) - np_sky_guide_bright, 0.0f);
    out->cumulative[i] = sum += out->density[i] * compute_solid_angle(i);
  }
  out->excess_sr = sum;
  for (int i = 0; i < NP_SKY_GUIDE_CELLS && sum > 0.0f; i++) {
    out->density[i] /= sum;
    out->cumulative[i] /= sum;
  }
}

void np_sky_guide_build(const np_world *world, const np_sun_optical_depth_source *depths, np_dvec3 position,
                        float ray_cost, np_sky_guide *out) {
  np_spectrum radiance[NP_SKY_GUIDE_CELLS], mean = np_spectrum_grey(0.0f);
  for (int i = 0; i < NP_SKY_GUIDE_CELLS; i++) {
    radiance[i] = np_boundary_radiance_compute(world, depths, position, compute_direction(i, 0.5f, 0.5f));
    mean = np_spectrum_add_scaled(mean, compute_solid_angle(i) / (4.0f * NP_PI_F), radiance[i]);
  }
  set_densities(radiance, mean, out);
  const float sun = compute_value(np_world_sunlight(world, position, world->to_sun), mean);
  out->rate = out->excess_sr / ((4.0f * NP_PI_F + sun) * ray_cost);
  if (!(out->rate >= np_sky_guide_least_rate)) out->rate = 0.0f;
}

np_vec3 np_sky_guide_draw(const np_sky_guide *guide, np_random *random, float *out_density) {
  const float choice = np_random_float(random), u = np_random_float(random), v = np_random_float(random);
  assert(guide->cumulative[NP_SKY_GUIDE_CELLS - 1] == 1.0f);
  int low = 0, high = NP_SKY_GUIDE_CELLS - 1;
  while (low < high) {
    const int middle = (low + high) / 2;
    if (guide->cumulative[middle] > choice)
      high = middle;
    else
      low = middle + 1;
  }
  *out_density = guide->density[low];
  assert(*out_density > 0.0f);
  return compute_direction(low, u, v);
}
