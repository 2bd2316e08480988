/* SPDX-License-Identifier: Apache-2.0 */
/* The march: exponential midpoint steps through the clouds, cut at the cells of every cloud's bricks.
 *
 * Over a step of length h with extinction σ (at its midpoint) and source S per unit of extinction, the equation of
 * transfer gives L += T·S·(1 − e^{−σh}), T the transmittance to the step; second order, and exact where σ and S are
 * constant. Air between camera and step enters by parts: with I(t) its in-scatter and Tₐ(t) its transmittance to t,
 * ∫T dI = T(end)·I(end) + ∫I·(−dT), so that each step adds (Tₐ·S + I)·(−ΔT).
 *
 * Where the view has a solution of the multiple scattering (light/multi_scatter.c) the march runs in its scaled
 * medium, with σ′ = Σ k·σ for σ. S is sunlight that came as if straight, times the direct term D
 * (light/scaled_phase.c), and the solution's moments towards the camera. What lies behind is seen twice: through the
 * true transmittance, and, spread by the forward peak too little to matter, through what the scaled one has more.
 *
 * Otherwise S is sunlight through the optical depth towards the sun, and light from sky or ground along one drawn
 * direction, and a look (integrate/look.h) may stand for light scattered more than once.
 * Compiled once per instruction-set level.
 */
#include "core/isa.h"
#include "integrate/look.h"
#include "integrate/stretch.h"
#include "integrate/surroundings.h"
#include "light/multi_scatter.h"

void NP_KERNEL(np_march_sample)(const np_scene_view *view, const np_integrator_settings *settings,
                                const np_camera_ray *ray, np_random *random, np_integrator_sample *out);
double NP_KERNEL(np_march_half_distance)(const np_scene_view *view, const np_camera_ray *ray, double distance_max);

/* Longest step in the scaled medium, in its optical depth at the densest point of a cell. */
static const float step_depth = 0.6f;

typedef struct march {
  const np_scene_view *view;
  const np_integrator_settings *settings;
  const np_camera_ray *ray;
  np_random *random;
  np_vec3 to_sun;
  /* np_look_fill_phases() of each cloud of the view: the angle to the sun is constant along the ray. */
  float sun_phase[NP_VIEW_VOLUMES_MAX][NP_LOOK_TERMS_MAX];
  const np_multi_scatter *scatter; /* NULL: a look stands for it */
  np_peak_column columns[NP_VIEW_VOLUMES_MAX];
  float harmonics[NP_HARMONIC_COUNT]; /* towards the camera */
  np_spectrum scaled;                 /* transmittance of the scaled medium; grey 1 stays where there is none */
  np_spectrum peak_depth;             /* optical depth that the scaled medium has less */
  float carry;                        /* what later steps can still contribute; 0 ends the ray */
  float transmittance;
  double air_distance; /* where `air` was last looked up */
  np_aerial_perspective air;
  np_integrator_sample *out;
} march;

static float march_shadow(const np_scene_view *view, const np_integrator_settings *settings, np_dvec3 position,
                          np_vec3 to_sun, np_random *random) {
  (void)random;
  return np_transmittance(
      np_track_depth(view, position, to_sun, INFINITY, settings->light_step_voxels, NP_FAINT_DEPTH));
}

static void set_sun_phases(march *m) {
  const np_vec3 d = m->ray->direction;
  const float versine = np_versine(d.x, d.y, d.z, m->to_sun.x, m->to_sun.y, m->to_sun.z);
  for (unsigned i = 0; i < m->view->volume_count; i++)
    np_look_fill_phases(&m->settings->look, &m->view->volumes[i].phase, versine, m->sun_phase[i]);
}

/* The same for the direct term of the scaled medium. */
static void set_columns(march *m) {
  const np_vec3 d = m->ray->direction;
  const float versine = np_versine(d.x, d.y, d.z, m->to_sun.x, m->to_sun.y, m->to_sun.z);
  for (unsigned i = 0; i < m->view->volume_count; i++)
    np_scaled_phase_fill_column(&m->scatter->phases[i], versine, &m->columns[i]);
  np_harmonics_eval(np_vec3_scale(d, -1.0f), m->harmonics);
}

static void add_scaled(np_integrator_sample *out, np_component component, float scale, np_spectrum radiance) {
  out->component[component] = np_spectrum_add_scaled(out->component[component], scale, radiance);
}

/* Light scattered once, and what stands for more. */
static void add_terms(march *m, np_component single, const float *phases, const float *transmittances,
                      np_spectrum light) {
  const np_look *look = &m->settings->look;
  float multiple = 0.0f;
  for (unsigned n = 1; n < np_look_count_terms(look); n++) multiple += phases[n] * transmittances[n];
  add_scaled(m->out, single, look->gain * phases[0] * transmittances[0], light);
  add_scaled(m->out, NP_COMPONENT_MULTIPLE, look->gain * multiple, light);
}

static void fill_transmittances(const march *m, np_dvec3 position, np_vec3 direction, float out[NP_LOOK_TERMS_MAX]) {
  const np_look *look = &m->settings->look;
  np_look_fill_transmittances(look,
                              np_track_depth(m->view, position, direction, INFINITY, m->settings->light_step_voxels,
                                             np_look_depth_of_interest(look)),
                              out);
}

/* Sunlight scattered towards the camera at `position`, weighted: `share[i]` is what part of the step's opacity, times
 * albedo, the i-th active cloud has. */
static void add_sun(march *m, np_dvec3 position, const np_media *all, const np_stretch *s, const np_spectrum *share,
                    np_spectrum weight) {
  const np_look *look = &m->settings->look;
  const np_spectrum sun = np_spectrum_multiply(np_light_sun(m->view, position, m->to_sun), weight);
  if (np_spectrum_is_zero(sun)) return;
  const bool is_slope = look->kind == NP_LOOK_DERIVATIVE;
  float transmittances[NP_LOOK_TERMS_MAX];
  if (is_slope) {
    transmittances[0] = np_look_slope(look, m->view, position, m->to_sun);
  } else {
    fill_transmittances(m, position, m->to_sun, transmittances);
  }
  for (unsigned i = 0; i < s->count; i++) {
    const np_view_volume *volume = all->medium[s->active[i]].volume;
    const float even = 1.0f / NP_PI_F, *phases = is_slope ? &even : m->sun_phase[volume - m->view->volumes];
    const np_spectrum light = np_spectrum_scale(sun, np_look_weight(look, volume, position));
    add_terms(m, NP_COMPONENT_SUN, phases, transmittances, np_spectrum_multiply(light, share[i]));
  }
}

/* One active cloud, drawn by its share; 1 over the probability of the draw goes to `out_weight`. */
static unsigned draw_cloud(const np_spectrum *share, unsigned count, np_random *random, float *out_weight) {
  float total = 0.0f;
  for (unsigned i = 0; i < count; i++) total += np_spectrum_max(share[i]);
  float rest = np_random_float(random) * total;
  unsigned chosen = 0;
  while (chosen + 1 < count && (rest -= np_spectrum_max(share[chosen])) >= 0.0f) chosen++;
  *out_weight = total > 0.0f ? total / np_spectrum_max(share[chosen]) : 0.0f;
  return chosen;
}

/* A direction from an even mixture of the phase function and the whole sphere: the first finds what shines through the
 * cloud, the second what shines on it from the side that the cloud does not throw forward. */
static np_vec3 draw_direction(const np_phase *phase, np_vec3 forward, np_random *random, float *out_pdf) {
  const float choice = np_random_float(random);
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  const float even = 1.0f / (4.0f * NP_PI_F);
  np_vec3 direction;
  float value;
  if (choice < 0.5f) {
    direction = np_phase_sample(phase, forward, u, &value);
  } else {
    const float z = 1.0f - 2.0f * u[0], r = sqrtf(fmaxf(0.0f, 1.0f - z * z)), azimuth = 2.0f * NP_PI_F * u[1];
    direction = np_vec3_make(r * cosf(azimuth), r * sinf(azimuth), z);
    value = np_phase_eval(phase, np_versine(forward.x, forward.y, forward.z, direction.x, direction.y, direction.z));
  }
  *out_pdf = 0.5f * (value + even);
  return direction;
}

/* Light from sky or ground along one direction. */
static void add_surroundings(march *m, np_dvec3 position, const np_media *all, const np_stretch *s,
                             const np_spectrum *share, np_spectrum weight) {
  float draw_weight, pdf;
  const unsigned chosen = draw_cloud(share, s->count, m->random, &draw_weight);
  if (draw_weight <= 0.0f) return;
  const np_phase *phase = &all->medium[s->active[chosen]].volume->phase;
  const np_vec3 forward = m->ray->direction;
  const np_vec3 direction = draw_direction(phase, forward, m->random, &pdf);
  bool is_ground;
  np_spectrum light =
      np_surroundings_incoming(m->view, m->settings, position, direction, march_shadow, m->random, &is_ground);
  light = np_spectrum_multiply(light, np_spectrum_multiply(weight, share[chosen]));
  if (np_spectrum_is_zero(light)) return;
  float transmittances[NP_LOOK_TERMS_MAX], phases[NP_LOOK_TERMS_MAX];
  fill_transmittances(m, position, direction, transmittances);
  np_look_fill_phases(&m->settings->look, phase,
                      np_versine(forward.x, forward.y, forward.z, direction.x, direction.y, direction.z), phases);
  light = np_spectrum_scale(light, draw_weight / pdf);
  add_terms(m, is_ground ? NP_COMPONENT_GROUND : NP_COMPONENT_SKY, phases, transmittances, light);
}

/* Optical depths of the scaled medium and of its forward peak from a point to the sun. */
static void track_scaled_depth(const march *m, np_dvec3 position, np_spectrum *out_scaled, np_spectrum *out_peak) {
  *out_scaled = *out_peak = np_spectrum_grey(0.0f);
  float depth = 0.0f;
  for (unsigned v = 0; v < m->view->volume_count && depth < NP_FAINT_DEPTH; v++) {
    const np_view_volume *volume = &m->view->volumes[v];
    const float forward = m->scatter->phases[v].forward;
    const float least = 1.0f - forward * np_spectrum_max(volume->albedo);
    const float steps_per_m = np_track_voxels_per_m(volume, m->to_sun) / m->settings->light_step_voxels;
    float own = 0.0f;
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, volume, position, m->to_sun, 0.0, INFINITY);
    while (depth + least * own < NP_FAINT_DEPTH && np_brick_walk_next(&walk, &span))
      own +=
          volume->extinction_per_value *
          np_track_span_integral(volume->bricks, &walk, &span, steps_per_m / fminf(1.0f + depth + least * own, 4.0f));
    depth += least * own;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const float peak = own * forward * volume->albedo.band[b];
      out_peak->band[b] += peak;
      out_scaled->band[b] += own - peak;
    }
  }
}

/* Sunlight thrown towards the camera by each active cloud; `scattering` is its ϖσ times what one unit of that counts
 * for. Scattered once it is T·p·e^{−τ}, which is part of D. */
static void add_scaled_sun(march *m, np_dvec3 position, const np_media *all, const np_stretch *s,
                           const np_spectrum *scattering) {
  const np_spectrum sun = np_light_sun(m->view, position, m->to_sun);
  if (np_spectrum_is_zero(sun)) return;
  np_spectrum depth, peak;
  track_scaled_depth(m, position, &depth, &peak);
  for (unsigned i = 0; i < s->count; i++) {
    const np_peak_column *column = &m->columns[all->medium[s->active[i]].volume - m->view->volumes];
    np_spectrum single, multiple;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const float light = sun.band[b] * np_transmittance(depth.band[b]) * scattering[i].band[b];
      const float once = np_transmittance(peak.band[b] + m->peak_depth.band[b]) * (column->broad + column->sharp);
      single.band[b] = light * once;
      multiple.band[b] = light * (np_peak_column_eval(column, peak.band[b], m->peak_depth.band[b]) - once);
    }
    add_scaled(m->out, NP_COMPONENT_SUN, 1.0f, single);
    add_scaled(m->out, NP_COMPONENT_MULTIPLE, 1.0f, multiple);
  }
}

static void add_solution(march *m, np_dvec3 position, const np_media *all, const np_stretch *s,
                         const np_spectrum *scattering) {
  np_light_moments moments;
  np_multi_scatter_gather(m->scatter, position, &moments);
  for (unsigned i = 0; i < s->count; i++) {
    const ptrdiff_t volume = all->medium[s->active[i]].volume - m->view->volumes;
    const np_spectrum light = np_multi_scatter_towards(&moments, &m->scatter->phases[volume], m->harmonics);
    add_scaled(m->out, NP_COMPONENT_MULTIPLE, 1.0f, np_spectrum_multiply(light, scattering[i]));
  }
}

/* A weight below `least` becomes `least` with that probability which keeps its mean, or nothing: so that a light which
 * counts for little is seldom walked for. */
static float settle(float weight, float least, np_random *random) {
  if (weight >= least) return weight;
  return np_random_float(random) * least < weight ? least : 0.0f;
}

/* Carries the ray past a step of the scaled medium, and ends a faint one or makes it stand for others. */
static void pass_scaled(march *m, const np_spectrum *depth, const np_spectrum *peak, float opacity) {
  m->scaled = np_spectrum_multiply(m->scaled, np_spectrum_exp_negative(*depth));
  m->peak_depth = np_spectrum_add(m->peak_depth, *peak);
  m->transmittance *= 1.0f - opacity;
  m->carry = np_spectrum_max(m->scaled);
  const float settled = settle(m->carry, m->settings->transmittance_end, m->random);
  if (settled == m->carry) return;
  const float factor = settled / m->carry;
  m->scaled = np_spectrum_scale(m->scaled, factor);
  m->transmittance *= factor;
  m->carry = settled;
}

/* One exponential step in the scaled medium. What a step sees of the peak's depth is that at its middle. */
static void step_scaled(march *m, const np_media *all, const np_stretch *s, double begin, double end,
                        const np_aerial_perspective *air) {
  const double middle = 0.5 * (begin + end);
  const float length = (float)(end - begin);
  np_spectrum scattering[NP_VIEW_VOLUMES_MAX], depth = np_spectrum_grey(0.0f), peak = depth, whole = depth, weight;
  float total = 0.0f;
  for (unsigned i = 0; i < s->count; i++) {
    const np_view_volume *volume = all->medium[s->active[i]].volume;
    const float own = np_medium_extinction(&all->medium[s->active[i]], middle) * length;
    scattering[i] = np_spectrum_scale(volume->albedo, own);
    peak = np_spectrum_add_scaled(peak, m->scatter->phases[volume - m->view->volumes].forward, scattering[i]);
    whole = np_spectrum_add(whole, scattering[i]);
    total += own;
  }
  if (total <= 0.0f) return;
  const float opacity = -expm1f(-total);
  add_scaled(m->out, NP_COMPONENT_AIR, m->transmittance * opacity, air->inscatter);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    depth.band[b] = total - peak.band[b];
    weight.band[b] = m->scaled.band[b] * np_step_weight(depth.band[b]) * air->transmittance.band[b];
  }
  np_integrator_add_opaque(m->out, m->transmittance * opacity, middle, np_spectrum_scale(whole, 1.0f / total));
  const float loss = m->carry * fminf(np_spectrum_max(depth), 1.0f);
  const np_spectrum half_peak = np_spectrum_scale(peak, 0.5f);
  m->peak_depth = np_spectrum_add(m->peak_depth, half_peak);
  for (unsigned i = 0; i < s->count; i++) scattering[i] = np_spectrum_multiply(scattering[i], weight);
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, middle);
  if (loss >= 1e-6f) {
    add_solution(m, position, all, s, scattering);
    add_scaled_sun(m, position, all, s, scattering);
  }
  pass_scaled(m, &depth, &half_peak, opacity);
}

/* One exponential step; `air` is that between the camera and its middle. */
static void step(march *m, const np_media *all, const np_stretch *s, double begin, double end,
                 const np_aerial_perspective *air) {
  const double middle = 0.5 * (begin + end);
  float extinction[NP_VIEW_VOLUMES_MAX], total = 0.0f;
  for (unsigned i = 0; i < s->count; i++) {
    extinction[i] = np_medium_extinction(&all->medium[s->active[i]], middle);
    total += extinction[i];
  }
  if (total <= 0.0f) return;
  const float opacity = -expm1f(-total * (float)(end - begin)), loss = m->transmittance * opacity;
  add_scaled(m->out, NP_COMPONENT_AIR, loss, air->inscatter);
  m->carry = m->transmittance = settle(m->transmittance * (1.0f - opacity), m->settings->transmittance_end, m->random);
  np_spectrum share[NP_VIEW_VOLUMES_MAX];
  for (unsigned i = 0; i < s->count; i++) {
    share[i] = np_spectrum_scale(all->medium[s->active[i]].volume->albedo, extinction[i] / total);
    np_integrator_add_opaque(m->out, loss * extinction[i] / total, middle, all->medium[s->active[i]].volume->albedo);
  }
  if (loss < 1e-6f || m->settings->scattering_max == 0) return;
  const np_dvec3 position = np_dvec3_along(m->ray->origin, m->ray->direction, middle);
  const float sun = settle(loss, 0.01f, m->random), sky = settle(loss, 0.1f, m->random);
  if (sun > 0.0f) add_sun(m, position, all, s, share, np_spectrum_scale(air->transmittance, sun));
  if (sky > 0.0f) add_surroundings(m, position, all, s, share, np_spectrum_scale(air->transmittance, sky));
}

/* The air up to `distance`; where one stretch ends and the next begins it is looked up once. */
static np_aerial_perspective look_through_air(march *m, double distance) {
  if (distance != m->air_distance) {
    m->air = np_light_air(m->view, m->view->camera_sky, m->ray->origin, m->ray->direction, distance);
    m->air_distance = distance;
  }
  return m->air;
}

static np_aerial_perspective mix_air(const np_aerial_perspective *a, const np_aerial_perspective *b, float t) {
  return (np_aerial_perspective){np_spectrum_mix(a->transmittance, b->transmittance, t),
                                 np_spectrum_mix(a->inscatter, b->inscatter, t)};
}

/* The densest that a stretch can be, scaled. */
static float find_scaled_extinction(const march *m, const np_media *all, const np_stretch *s) {
  float sum = 0.0f;
  for (unsigned i = 0; i < s->count; i++) {
    const np_medium *cloud = &all->medium[s->active[i]];
    const float forward = m->scatter->phases[cloud->volume - m->view->volumes].forward;
    sum += (1.0f - forward * np_spectrum_max(cloud->volume->albedo)) * cloud->volume->extinction_per_value *
           cloud->span.range.max;
  }
  return sum;
}

/* Steps through a stretch: whole steps shifted by the ray's jitter, cut at both ends. */
static void cross(march *m, const np_media *all, const np_stretch *s) {
  const double length = s->end - s->begin;
  float steps_per_m = 0.0f;
  for (unsigned i = 0; i < s->count; i++) steps_per_m = fmaxf(steps_per_m, all->medium[s->active[i]].steps_per_m);
  if (m->scatter) steps_per_m = fmaxf(steps_per_m, find_scaled_extinction(m, all, s) / step_depth);
  const int count = (int)fmin(fmax(1.0, ceil(length * (double)steps_per_m)), 4096.0);
  const np_aerial_perspective near = look_through_air(m, s->begin), far = look_through_air(m, s->end);
  float begin = 0.0f;
  for (int k = 0; k <= count && m->carry > 0.0f; k++) {
    const float end = fminf(((float)k + m->ray->jitter) / (float)count, 1.0f);
    const np_aerial_perspective air = mix_air(&near, &far, 0.5f * (begin + end));
    const double from = s->begin + length * (double)begin, to = s->begin + length * (double)end;
    if (end > begin) (m->scatter ? step_scaled : step)(m, all, s, from, to, &air);
    begin = end;
  }
}

void NP_KERNEL(np_march_sample)(const np_scene_view *view, const np_integrator_settings *settings,
                                const np_camera_ray *ray, np_random *random, np_integrator_sample *out) {
  *out = (np_integrator_sample){.transmittance = 1.0f};
  np_ground_hit hit;
  out->is_ground_behind = np_ground_intersect(view, ray->origin, ray->direction, &hit);
  march m = {.view = view,
             .settings = settings,
             .ray = ray,
             .random = random,
             .scatter = settings->scattering_max > 1 ? view->multi_scatter : NULL,
             .scaled = np_spectrum_grey(1.0f),
             .carry = 1.0f,
             .transmittance = 1.0f,
             .air_distance = -1.0,
             .out = out};
  np_media all;
  np_media_start(&all, view, ray, out->is_ground_behind ? hit.distance_m : HUGE_VAL, settings->step_voxels);
  if (all.count > 0) {
    m.to_sun = np_light_sample_sun(view, np_random_float(random), np_random_float(random));
    m.scatter ? set_columns(&m) : set_sun_phases(&m);
    np_stretch s;
    while (m.carry > 0.0f && np_media_next(&all, &s)) cross(&m, &all, &s);
  }
  out->transmittance = m.transmittance;
  np_surroundings_add_behind(view, settings, ray, out->is_ground_behind ? &hit : NULL, m.transmittance, march_shadow,
                             random, out);
  if (m.scatter)
    np_surroundings_add_peak(view, settings, ray, out->is_ground_behind ? &hit : NULL,
                             np_spectrum_subtract(m.scaled, np_spectrum_grey(m.transmittance)), march_shadow, random,
                             out);
}

double NP_KERNEL(np_march_half_distance)(const np_scene_view *view, const np_camera_ray *ray, double distance_max) {
  np_media all;
  np_stretch s;
  float depth = 0.0f;
  np_media_start(&all, view, ray, distance_max, 1.0f);
  while (np_media_next(&all, &s)) {
    for (int k = 0; k < NP_BRICK_EDGE; k++) {
      const double length = (s.end - s.begin) / NP_BRICK_EDGE, middle = s.begin + length * ((double)k + 0.5);
      float extinction = 0.0f;
      for (unsigned i = 0; i < s.count; i++) extinction += np_medium_extinction(&all.medium[s.active[i]], middle);
      const float added = extinction * (float)length, missing = NP_LN2_F - depth;
      if (added >= missing) return s.begin + length * ((double)k + (double)(missing / added));
      depth += added;
    }
  }
  return INFINITY;
}
