/* SPDX-License-Identifier: Apache-2.0 */
/* Types that the parts of the march share: state of a ray, and sun optical depths. Inline, or compiled once per
 * instruction-set level. */
#ifndef NP_INTEGRATE_MARCH_H
#define NP_INTEGRATE_MARCH_H

#include "core/isa.h"
#include "integrate/approximation.h"
#include "integrate/integrator.h"
#include "integrate/step.h"
#include "volume/brick_motion.h"

/* Phase values of an approximation's terms at one angle between light and view in one cloud. */
typedef struct np_march_terms {
  float own[NP_APPROXIMATION_TERMS_MAX];
  /* A calibrated gain G adds `excess` = G − 1 more of the terms of a Henyey-Greenstein phase function: light
   * that was scattered often does not show the peaks and bows of the cloud's own. */
  float smooth[NP_APPROXIMATION_TERMS_MAX];
  np_spectrum excess;
} np_march_terms;

typedef struct np_march {
  const np_world *world;
  const np_lighting *lighting;
  const np_integrator_settings *settings;
  const np_camera_ray *ray;
  np_view_ray view;   /* the ray, for queries of its air */
  np_sky_ray sky_ray; /* `view.sky_ray`, from the first query on */
  np_random *random;
  np_vec3 to_sun;
  float carry; /* largest weight of the light of later steps; 0: the ray ends */
  float transmittance;
  np_step step;        /* being gathered */
  np_step_knot knot;   /* where it ends */
  float step_length_m; /* length of the longest step near the camera */
  float step_growth;   /* its growth with distance, a length over a length */
  np_integrator_sample *out;

  const np_scattering_field *field;    /* solution of the multiple scattering; NULL: an approximation is used */
  const np_scattering_medium *medium;  /* medium of `field`; NULL without a field */
  const np_viewer_light *viewer_light; /* light of `field` for this ray; NULL: none */
  const np_approximation_row *method;  /* where there is no solution, and its */
  unsigned term_count;
  bool has_outgoing;
  bool has_motion;        /* some cloud is not where it is at the frame's time */
  bool is_grey;           /* every cloud has one albedo in all bands */
  np_spectrum scaled;     /* transmittance of the scaled medium; grey 1 stays where there is none */
  np_spectrum peak_depth; /* optical depth that the scaled medium has less */
  float sun_rate;         /* rate of light's change along the ray over the rate that its depth implies; at least 1 */
  float sun_optical_depth,
      sun_place; /* sun optical depth of the last lit step, and scaled optical depth along the ray up to it */
  float passed;  /* scaled optical depth of the steps that have been lit */

  /* Phase values of each cloud. The angle to the sun is constant along the ray. */
  union {
    np_march_terms terms[NP_INSTANCES_MAX]; /* terms of the approximation */
    struct {
      np_peak_column column;
      float outgoing[NP_HARMONIC_COUNT_MAX]; /* light of the solution's moments to the camera, where `has_outgoing` */
    } peak[NP_INSTANCES_MAX];
  } sun;
} np_march;

/* Aerial perspective between the eye and a place in a cloud at `distance_m` from the ray's origin, with the shadows in
 * the air. */
static inline np_aerial_perspective np_march_get_air(np_march *m, double distance_m) {
  if (!m->view.sky_ray && np_world_has_sky_tables(m->world)) {
    m->sky_ray = np_sky_ray_start(m->world->camera_sky, m->view.direction);
    m->view.sky_ray = &m->sky_ray;
  }
  return np_lighting_camera_air(m->lighting, m->world, &m->view, m->ray->begin_m + distance_m, NP_RAY_END_CLOUD);
}

/* Light a step: add the light that it scatters to the camera, and attenuate the ray. `scaled`: in the scaled medium
 * with a solution of multiple scattering; `approximation`: by single scattering and an approximation of multiple
 * scattering. */
void NP_KERNEL(np_march_start_scaled)(np_march *m);
void NP_KERNEL(np_march_light_scaled)(np_march *m, const np_step *s);
void NP_KERNEL(np_march_start_approximation)(np_march *m);
void NP_KERNEL(np_march_light_approximation)(np_march *m, const np_step *s);

/* Transmittance of the clouds towards the sun (np_cloud_shadow_fn). */
float NP_KERNEL(np_march_sun_transmittance)(const np_world *world, const np_lighting *lighting,
                                            const np_integrator_settings *settings, np_dvec3 position, np_vec3 to_sun,
                                            np_random *random);

/* Transmittance of the clouds for sunlight on the ground; same arguments as np_march_sun_transmittance. */
float NP_KERNEL(np_march_shadow)(const np_world *world, const np_lighting *lighting,
                                 const np_integrator_settings *settings, np_dvec3 position, np_vec3 to_sun,
                                 np_random *random);

/* 1 − cos of the angle between the ray and the way to the sun. */
static inline float np_march_get_sun_versine(const np_march *m) {
  const np_vec3 d = m->ray->direction;
  return np_vec3_versine(d, m->to_sun);
}

static inline void np_march_add(np_march *m, np_component component, float scale, np_spectrum radiance) {
  m->out->component[component] = np_spectrum_add_scaled(m->out->component[component], scale, radiance);
}

/* A place of a step on the ray, as light and tables know it, which are of the frame's time: where the matter that is
 * there now is then, in the mean of the step's clouds by their depth. */
static inline np_dvec3 np_march_get_lit_place(const np_march *m, const np_step *s, double distance) {
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, distance);
  if (!m->has_motion) return position;
  np_dvec3 moved = np_dvec3_make(0, 0, 0);
  double all = 0.0;
  for (unsigned i = 0; i < s->count; i++) {
    const np_instance *cloud = s->volume[i];
    const double depth = (double)s->depth[i];
    all += depth;
    if (!cloud->index_to_frame) continue;
    const np_dvec3 index = np_brick_motion_get_rest(cloud->bricks, np_affine_point(&cloud->world_to_index, position));
    const np_dvec3 rest = np_affine_point(cloud->index_to_frame, index);
    moved = np_dvec3_add(moved, np_dvec3_scale(np_dvec3_subtract(rest, position), depth));
  }
  return all > 0.0 ? np_dvec3_add(position, np_dvec3_scale(moved, 1.0 / all)) : position;
}

/* Share of a step's optical depth that belongs to visible clouds, not to holdouts. */
static inline float np_march_get_shown_share(const np_march *m, const np_step *s) {
  if (!m->settings->has_holdout) return 1.0f;
  float shown = 0.0f, all = 0.0f;
  for (unsigned i = 0; i < s->count; i++) {
    all += s->depth[i];
    if (!s->volume[i]->is_held_out) shown += s->depth[i];
  }
  return all > 0.0f ? shown / all : 0.0f;
}

/* A weight below `least` becomes `least` with that probability which keeps its mean, or nothing: so that a light which
 * counts for little is seldom walked for. */
static inline float np_march_roulette(float weight, float least, np_random *random) {
  if (weight >= least) return weight;
  return np_random_float(random) * least < weight ? least : 0.0f;
}

/* The rate at which light changes is unknown where the ray enters a cloud. */
static inline void np_march_forget_sun(np_march *m) {
  m->sun_rate = 1.0f;
  m->sun_optical_depth = NP_SUN_OPTICAL_DEPTH_UNKNOWN;
}

/* Opacity of a ray below which its error need not shrink with it. */
static const float np_march_opacity_least = 1e-4f;

/* Error allowed in the light of a step of that `opacity`, so that the ray's is right to the tolerance: with
 * look-ups that go as error^{−½}, the fewest are needed where it is as opacity^{−⅔}. A step hides a quarter of its ray
 * or so. */
static inline float np_march_get_light_error(const np_march *m, float opacity) {
  const float all = np_maxf(1.0f - m->carry + opacity, np_march_opacity_least);
  const float ratio = 0.25f * all / np_maxf(opacity, 1e-6f);
  return m->settings->tolerance * np_cbrtf_rough(ratio * ratio);
}

#endif
