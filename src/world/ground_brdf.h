/* SPDX-License-Identifier: Apache-2.0 */
/* Reflection of rough land: facets that face light and viewer alike hide their shadows, so that ground is brighter with
 * the sun behind the viewer, and flatter than Lambert's. Oren and Nayar 1994, "Generalization of Lambert's Reflectance
 * Model", in the form of Fujii 2012, "A tiny improvement of Oren-Nayar reflectance model", over its mean albedo
 * (Portsmouth, Kutz and Hill 2025, "EON: A practical energy-preserving rough diffuse BRDF", eq. 15), so that ground of
 * any roughness sends back as much of a uniform sky. Near the horizon the ratio is held to that at 78°. */
#ifndef NP_WORLD_GROUND_BRDF_H
#define NP_WORLD_GROUND_BRDF_H

#include "core/math.h"
#include "core/units.h"

/* BRDF over that of Lambert's law, for unit directions towards viewer and light above the surface. `roughness` is 0 to
 * 1; 0: 1, exactly. */
static inline float np_ground_brdf_get_ratio(float roughness, np_vec3 normal, np_vec3 to_viewer, np_vec3 to_light) {
  if (!(roughness > 0.0f)) return 1.0f;
  const float in = np_maxf(np_vec3_dot(normal, to_light), 0.0f), out = np_maxf(np_vec3_dot(normal, to_viewer), 0.0f);
  const float s = np_vec3_dot(to_light, to_viewer) - in * out, larger = np_maxf(in, out);
  const float t = s > 0.0f ? np_maxf(larger, 0.2f) : 1.0f;
  const float mean = 1.0f + (2.0f / 3.0f - 28.0f / (15.0f * NP_PI_F)) * roughness;
  return np_maxf((1.0f + roughness * s / t) / mean, 0.0f);
}

#endif
