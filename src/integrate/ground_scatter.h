/* SPDX-License-Identifier: Apache-2.0 */
/* Ground as a vertex of paths: land by Lambert's law or rough (world/ground_brdf.h), or water (optics/water.h), whose
 * waves' reflection and diffuse light are drawn in proportion to what they send back. */
#ifndef NP_INTEGRATE_GROUND_SCATTER_H
#define NP_INTEGRATE_GROUND_SCATTER_H

#include "core/random.h"
#include "core/units.h"
#include "world/ground_brdf.h"
#include "world/world.h"

typedef struct np_ground_scatter {
  const np_ground_hit *hit;
  np_vec3 to_viewer;
  float wave_share; /* share of water's drawn directions that its waves give */
} np_ground_scatter;

/* BRDF times cosine of a direction towards light, 1/sr, and the density with which it is drawn; land's albedo is left
 * to the path. */
typedef struct np_ground_choice {
  np_spectrum value;
  float density;
} np_ground_choice;

/* Scatters a path that flies along `direction`; multiplies its throughput by the albedo of land. */
static inline np_ground_scatter np_ground_scatter_make(const np_ground_hit *hit, np_vec3 direction,
                                                       np_spectrum *throughput) {
  np_ground_scatter out = {.hit = hit, .to_viewer = np_vec3_scale(direction, -1.0f)};
  if (!hit->water) {
    *throughput = np_spectrum_multiply(*throughput, hit->albedo);
    return out;
  }
  const float reflected = np_water_reflectance(hit->water, np_vec3_dot(hit->normal, out.to_viewer));
  const float diffuse = (1.0f - reflected) * np_spectrum_max(hit->water->albedo);
  out.wave_share = reflected / (reflected + diffuse);
  return out;
}

static inline np_ground_choice np_ground_scatter_eval(const np_ground_scatter *s, np_vec3 direction) {
  const float even = fmaxf(np_vec3_dot(s->hit->normal, direction), 0.0f) * (1.0f / NP_PI_F);
  if (!s->hit->water) {
    const float ratio = np_ground_brdf_get_ratio(s->hit->roughness, s->hit->normal, s->to_viewer, direction);
    return (np_ground_choice){np_spectrum_grey(ratio * even), even};
  }
  const np_water_value water = np_water_eval(s->hit->water, s->hit->normal, s->to_viewer, direction);
  return (np_ground_choice){water.scattered, np_mixf(even, water.density, s->wave_share)};
}

/* A direction about a normal, distributed as its cosine. */
static inline np_vec3 np_ground_sample_cosine(np_vec3 normal, np_random *random, float *out_cosine) {
  const float u = np_random_float(random), azimuth = 2.0f * NP_PI_F * np_random_float(random), sine = sqrtf(u);
  np_vec3 tangent, bitangent;
  np_frame_around(normal, &tangent, &bitangent);
  *out_cosine = sqrtf(1.0f - u);
  np_vec3 direction = np_vec3_scale(normal, *out_cosine);
  direction = np_vec3_add(direction, np_vec3_scale(tangent, sine * cosf(azimuth)));
  direction = np_vec3_add(direction, np_vec3_scale(bitangent, sine * sinf(azimuth)));
  return np_vec3_normalize(direction);
}

/* Samples the direction in which a path leaves the ground; false: it enters water. `*throughput` is multiplied by
 * reflectance over density. */
static inline bool np_ground_scatter_sample(const np_ground_scatter *s, np_random *random, np_spectrum *throughput,
                                            np_vec3 *out_direction, float *out_density) {
  float cosine, weight;
  if (!s->hit->water) {
    *out_direction = np_ground_sample_cosine(s->hit->normal, random, &cosine);
    *out_density = cosine * (1.0f / NP_PI_F);
    *throughput = np_spectrum_scale(
        *throughput, np_ground_brdf_get_ratio(s->hit->roughness, s->hit->normal, s->to_viewer, *out_direction));
    return true;
  }
  if (np_random_float(random) < s->wave_share) {
    const float u = np_random_float(random), v = np_random_float(random);
    *out_direction = np_water_sample(s->hit->water, s->hit->normal, s->to_viewer, u, v, &weight);
    if (!(weight > 0.0f)) return false;
  } else {
    *out_direction = np_ground_sample_cosine(s->hit->normal, random, &cosine);
  }
  const np_ground_choice choice = np_ground_scatter_eval(s, *out_direction);
  *out_density = choice.density;
  if (!(choice.density > 0.0f)) return false;
  *throughput = np_spectrum_scale(np_spectrum_multiply(*throughput, choice.value), 1.0f / choice.density);
  return true;
}

#endif
