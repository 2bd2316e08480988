/* SPDX-License-Identifier: Apache-2.0 */
/* Rays towards where sky and ground are bright: next-event estimation of a light that is infinitely far.
 *
 * A vertex in cloud or on the ground sends, at the guide's rate (caches/sky_guide.h), a ray that goes past the clouds,
 * as dim as they make it, and does what paths do there: sees the sky or ground of the tables, or goes on through air
 * that is traced. A path that leaves by chance meets the same light. Both are weighed by their densities (balance
 * heuristic).
 */
#ifndef NP_INTEGRATE_SKY_NEXT_EVENT_H
#define NP_INTEGRATE_SKY_NEXT_EVENT_H

#include "integrate/path_state.h"
#include "caches/sky_guide.h"

typedef struct np_sky_next_event {
  np_vec3 direction;
  float density;    /* expected number of rays in this direction, 1/sr */
  float brightness; /* radiance in this direction, relative to the mean */
} np_sky_next_event;

/* Whether this vertex sends a ray, and where to. */
static inline bool np_sky_next_event_sample(const np_tracer *t, const np_path_state *path, np_sky_next_event *out) {
  if (!path->has_sky_next_event) return false;
  const np_sky_guide *guide = t->lighting->sky_guide;
  if (!(np_random_float(t->random) < guide->rate)) return false;
  float density;
  out->direction = np_sky_guide_draw(guide, t->random, &density);
  out->density = guide->rate * density;
  out->brightness = np_sky_guide_brightness(guide, density);
  return true;
}

/* The ray as a path of its own; false: Russian roulette ends it, by the light that it may carry, the radiance there
 * times `share`, the vertex's scattering per steradian. `density` is the density of the path's own directions. Sun and
 * emitters have rays of their own: a density of 0 keeps them out. */
static inline bool np_sky_next_event_start(const np_path_state *path, const np_sky_next_event *sky, float share,
                                           float density, np_random *random, np_path_state *out_ray) {
  const float weight = share / (sky->density + density);
  const float expected = fminf(weight * sky->brightness * np_spectrum_max(path->throughput) / path->weight, 1.0f);
  if (!(np_random_float(random) < expected)) return false;
  *out_ray = *path;
  out_ray->direction = sky->direction;
  out_ray->density = 0.0f;
  out_ray->expected_gain = 1.0f;
  out_ray->throughput = np_spectrum_scale(path->throughput, weight / expected);
  out_ray->has_sky_next_event = false;
  out_ray->depth++;
  return true;
}

/* A path that leaves the clouds by chance: where a ray was aimed at the sky too, the two share the weight by the
 * balance heuristic. */
static inline void np_sky_next_event_weigh_miss(const np_tracer *t, np_path_state *path) {
  if (!path->has_sky_next_event) return;
  const np_sky_guide *guide = t->lighting->sky_guide;
  const float aimed = guide->rate * np_sky_guide_eval(guide, path->direction);
  path->throughput = np_spectrum_scale(path->throughput, path->density / (path->density + aimed));
  path->has_sky_next_event = false;
}

#endif
