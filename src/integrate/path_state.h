/* SPDX-License-Identifier: Apache-2.0 */
/* State of a path: path_camera.c starts paths, path.c traces them. */
#ifndef NP_INTEGRATE_PATH_STATE_H
#define NP_INTEGRATE_PATH_STATE_H

#include "atmosphere/air_flight.h"
#include "core/isa.h"
#include "integrate/guide.h"
#include "integrate/hero.h"
#include "integrate/surroundings.h"

/* State that all paths of a sample share. */
typedef struct np_tracer {
  const np_world *world;
  const np_lighting *lighting;
  const np_integrator_settings *settings;
  np_random *random;
  np_integrator_sample *out;
  np_air_light air_light;
  float sun_sr; /* solid angle of the sun's disk */
} np_tracer;

/* End of a flight. */
typedef enum np_path_event {
  NP_PATH_CLOUD,
  NP_PATH_AIR,
  NP_PATH_GROUND,
  NP_PATH_SPACE,
  NP_PATH_SURROUNDINGS /* sky or ground, from tables */
} np_path_event;

typedef struct np_path_state {
  np_dvec3 position;
  np_vec3 direction; /* direction of flight, away from the camera */
  float density;     /* density with which the direction was drawn, 1/sr */
  np_spectrum throughput;
  np_hero hero;
  float weight;        /* throughput at the start or the last guided collision, by which it is judged faint */
  float reference;     /* light of the camera's ray, by which paths are counted; 0: not known */
  float expected_gain; /* ≥ 1: sunlight that the next collision may scatter, relative to isotropic scattering */
  unsigned order;      /* scatterings in cloud so far */
  unsigned depth;      /* number of branches so far */
  np_component component;
  bool has_component;      /* the component depends on the surface that the camera sees, not on clouds */
  bool has_sky_next_event; /* the last vertex sent a ray to the sky: light that the path meets outside clouds is
                              weighted by the balance heuristic */
  bool is_through_air;     /* one of the path's vertices was in the air */
  bool is_cut;             /* beyond the limit on scatterings: its light is lost */
  bool is_guided;          /* it is guided by `guide` from its last vertex on */
  bool is_ground_ahead;
  const np_instance *volume; /* the cloud of the present collision */
  np_reference_air air;      /* the air of the present collision */
  np_ground_hit ground;      /* the ground of the present collision */
  np_guide guide;
} np_path_state;

/* Everything that reaches the camera along a path, from its first vertex on. */
void NP_KERNEL(np_path_follow)(const np_tracer *t, np_path_state *path, np_path_event event);

static inline bool np_path_may_be_guided(const np_tracer *t) {
  return t->settings->is_split && t->lighting->scattering;
}

static inline void np_path_add(np_integrator_sample *out, np_component component, np_spectrum radiance) {
  out->component[component] = np_spectrum_add(out->component[component], radiance);
}

/* A shadow without bias, for surroundings from tables. */
static inline float np_path_shadow(const np_world *world, const np_lighting *lighting,
                                   const np_integrator_settings *settings, np_dvec3 position, np_vec3 to_sun,
                                   np_random *random) {
  (void)lighting, (void)settings;
  return np_track_transmittance(&world->clouds, position, to_sun, INFINITY, np_track_faint_depth, random);
}

/* Band that leads a path: bands differ in air, and in clouds whose phase functions have colour. */
static inline np_hero np_path_draw_hero(const np_tracer *t) {
  const bool has_colour = t->world->atmosphere || np_world_has_phase_bands(t->world);
  return has_colour ? np_hero_draw(t->random) : (np_hero){0, np_spectrum_grey(1.0f)};
}

#endif
