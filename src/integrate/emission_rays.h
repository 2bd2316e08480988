/* SPDX-License-Identifier: Apache-2.0 */
/* Light of emission along a ray, ∫ j·T ds: walked through the emitters' cells, with the clouds' optical depth
 * followed beside. T is exact at every place that is examined, so that emitters may lie in cloud, around it or apart
 * from it, and where the extinction is 0 nothing is divided by it.
 */
#ifndef NP_INTEGRATE_EMISSION_RAYS_H
#define NP_INTEGRATE_EMISSION_RAYS_H

#include "core/units.h"
#include "integrate/integrator.h"
#include "volume/depth_cursor.h"
#include "world/emission.h"

/* ---- Steps through an emitter ---- */

/* An emitter along a ray, cell by cell, and each cell in even steps. */
typedef struct np_emitter_walk {
  const np_emitter *emitter;
  np_dvec3 origin;
  np_vec3 direction;
  np_brick_walk walk;
  np_brick_span span;
  double steps_per_m;
  int step, count;
} np_emitter_walk;

static inline void np_emitter_walk_start(np_emitter_walk *w, const np_emitter *emitter, np_dvec3 origin,
                                         np_vec3 direction, double distance_end, float step_voxels) {
  *w = (np_emitter_walk){.emitter = emitter, .origin = origin, .direction = direction};
  const np_dvec3 along = np_affine_vector(&emitter->world_to_index, np_vec3_to_double(direction));
  np_brick_walk_start(&w->walk, emitter->bricks, np_affine_point(&emitter->world_to_index, origin), along, 0.0,
                      distance_end);
  w->steps_per_m = np_dvec3_length(along) / (double)step_voxels;
}

static inline bool np_emitter_walk_next(np_emitter_walk *w, double *out_begin, double *out_end) {
  if (++w->step > w->count) {
    if (!np_brick_walk_next(&w->walk, &w->span)) return false;
    w->step = 1;
    w->count = (int)fmin(fmax(ceil((w->span.t_end - w->span.t_begin) * w->steps_per_m), 1.0), 4096.0);
  }
  const double length = (w->span.t_end - w->span.t_begin) / w->count;
  *out_begin = w->span.t_begin + length * (w->step - 1);
  *out_end = w->span.t_begin + length * w->step;
  return true;
}

/* j at a place of the present step. */
static inline np_spectrum np_emitter_walk_eval(const np_emitter_walk *w, const np_emission *emission, double t) {
  const float value = w->span.brick == NP_BRICK_NONE ? w->span.range.min
                                                     : np_brick_eval(w->emitter->bricks, w->span.brick, w->span.cell,
                                                                     np_brick_walk_local(&w->walk, &w->span, t));
  return np_emitter_eval(emission, w->emitter, np_dvec3_along(w->origin, w->direction, t), value);
}

/* ---- Without bias ---- */

/* Light from a place on a ray, behind the air before it where there is any, which begins `air_begin_m` before the
 * ray's origin. */
static inline np_spectrum np_emission_dim(const np_world *world, np_dvec3 origin, np_vec3 direction, double air_begin_m,
                                          double distance, np_spectrum light) {
  const np_dvec3 eye = np_dvec3_along(origin, direction, -air_begin_m);
  return np_spectrum_multiply(
      light, np_world_air(world, world->camera_sky, eye, direction, air_begin_m + distance).transmittance);
}

/* ∫ j ds up to a free flight's end among clouds, which makes ∫ j·T ds in the mean: one place, drawn evenly, in each
 * step. Through air where `has_air`. */
static inline np_spectrum np_emission_collect(const np_world *world, np_dvec3 origin, np_vec3 direction,
                                              double distance_end, float step_voxels, bool has_air, np_random *random) {
  const np_emission *emission = world->emission;
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned g = 0; g < emission->emitter_count; g++) {
    np_emitter_walk w;
    double begin, end;
    np_emitter_walk_start(&w, &emission->emitters[g], origin, direction, distance_end, step_voxels);
    while (np_emitter_walk_next(&w, &begin, &end)) {
      const double t = begin + (end - begin) * np_random_double(random);
      np_spectrum light = np_emitter_walk_eval(&w, emission, t);
      if (has_air && !np_spectrum_is_zero(light)) light = np_emission_dim(world, origin, direction, 0.0, t, light);
      sum = np_spectrum_add_scaled(sum, (float)(end - begin), light);
    }
  }
  return sum;
}

/* Draws a position in a step with a density proportional to transmittance at constant extinction, the extinction in the
 * step's middle. Returns that transmittance over the density. */
static inline double np_emission_draw_place(double begin, double end, double extinction, np_random *random,
                                            double *out_weight, double *out_depth) {
  const double length = end - begin, depth = extinction * length;
  if (depth < 1e-4) {
    *out_weight = length;
    *out_depth = 0.0;
    return begin + length * np_random_double(random);
  }
  *out_depth = np_track_forced_flight(depth, random);
  *out_weight = -expm1(-depth) / extinction;
  return begin + *out_depth / extinction;
}

/* Emission has no opacity. */
static inline void np_emission_record(np_integrator_layers *layers, double begin, double end, np_spectrum light) {
  np_integrator_add_depth(layers, (np_depth_record){.begin = (float)begin, .end = (float)end, .light = light});
}

/* ∫ j·T ds of one emitter along a ray, T through clouds, and, where `has_air`, through air: the camera's, or what is
 * traced, which begins `air_begin_m` before the origin. In each step one place; what is faint is ended by Russian
 * roulette. Recorded by depth in `layers`, unless it is NULL. */
static inline np_spectrum np_emitter_along(const np_world *world, const np_emitter *emitter, np_dvec3 origin,
                                           np_vec3 direction, double distance_end, float step_voxels, bool has_air,
                                           double air_begin_m, np_random *random, np_integrator_layers *layers) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  np_depth_cursors clouds;
  np_emitter_walk w;
  double begin, end, forgiven = 0.0;
  np_emitter_walk_start(&w, emitter, origin, direction, distance_end, step_voxels);
  np_depth_cursors_start(&clouds, &world->clouds, origin, direction, distance_end);
  while (np_emitter_walk_next(&w, &begin, &end)) {
    const float extinction =
        np_instances_extinction(&world->clouds, np_dvec3_along(origin, direction, 0.5 * (begin + end)));
    double weight, drawn_depth;
    const double t = np_emission_draw_place(begin, end, (double)extinction, random, &weight, &drawn_depth);
    np_depth_cursors_advance(&clouds, t);
    double depth = np_depth_cursors_sum(&clouds) - forgiven;
    const double before = depth;
    if (!np_track_roulette(&depth, np_track_faint_depth, random)) break;
    forgiven += before - depth;
    np_spectrum light = np_emitter_walk_eval(&w, world->emission, t);
    if (np_spectrum_is_zero(light)) continue;
    if (has_air) light = np_emission_dim(world, origin, direction, air_begin_m, t, light);
    light = np_spectrum_scale(light, (float)(weight * exp(drawn_depth - depth)));
    sum = np_spectrum_add(sum, light);
    if (layers) np_emission_record(layers, air_begin_m + begin, air_begin_m + end, light);
  }
  return sum;
}

/* The same of all emitters. */
static inline np_spectrum np_emission_along(const np_world *world, np_dvec3 origin, np_vec3 direction,
                                            double distance_end, float step_voxels, bool has_air, double air_begin_m,
                                            np_random *random) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned g = 0; g < world->emission->emitter_count; g++)
    sum = np_spectrum_add(sum, np_emitter_along(world, &world->emission->emitters[g], origin, direction, distance_end,
                                                step_voxels, has_air, air_begin_m, random, NULL));
  return sum;
}

/* ---- Steps ---- */

/* j depends on a high power of the temperature, the twentieth in a dark flame, and is sharper than the grids it is
 * computed of: steps of half a voxel lose 0.6 % of it, these 0.2 %.
 */
static const float np_emission_march_step_voxels = 0.25f;

/* Transmittance below which emission along a ray is neglected. A flame may be a thousand times brighter than sunlit
 * smoke before it. */
static const float np_emission_faint_transmittance = 1e-6f;

/* Optical depth from which on a step is opaque, and the most that j's mean may be over its value at the middle. */
static const float np_emission_opaque_step = 0.5f, np_emission_correction_max = 16.0f;

/* Each cloud's depth times its factor in a band; factors NULL: 1. */
static inline np_spectrum np_emission_get_depth(const np_depth_cursors *clouds, const np_spectrum *factors) {
  np_spectrum depth = np_spectrum_grey(0.0f);
  for (unsigned i = 0; i < clouds->count; i++) {
    const unsigned cloud = np_instances_get_index(clouds->clouds, clouds->cursor[i].volume);
    depth = np_spectrum_add_scaled(depth, (float)clouds->cursor[i].depth,
                                   factors ? factors[cloud] : np_spectrum_grey(1.0f));
  }
  for (unsigned i = 0; i < clouds->clouds->count && clouds->clouds->places; i++)
    depth = np_spectrum_add_scaled(depth, (float)clouds->past[i], factors ? factors[i] : np_spectrum_grey(1.0f));
  return depth;
}

/* A step of constant j, of length 1: T·φ₁(σh), from the depths at its ends. */
static inline np_spectrum np_emission_weigh_step(np_spectrum before, np_spectrum after) {
  np_spectrum weight;
  for (int b = 0; b < NP_BAND_COUNT; b++)
    weight.band[b] = np_transmittance(before.band[b]) * np_step_weight(fmaxf(after.band[b] - before.band[b], 0.0f));
  return weight;
}

/* Mean of j over its value at a step's middle. A cloud that emits as it absorbs shows j/σ where the step is opaque,
 * however its density changes within: j goes with σ, whose mean is known. Transparent steps keep the midpoint rule. */
static inline float np_emission_correct_mean(const np_world *world, np_dvec3 middle, double length, float depth) {
  const float at_middle = np_instances_extinction(&world->clouds, middle) * (float)length;
  if (depth < np_emission_opaque_step || !(at_middle > 0.0f)) return 1.0f;
  return np_minf(depth / at_middle, np_emission_correction_max);
}

/* ∫ j·T ds of what the camera sees, by the midpoint rule for j, twice: through the clouds, and through them where each
 * cloud's extinction counts `factors` times. */
static inline void np_emission_march(const np_world *world, const np_camera_ray *ray, double distance_end,
                                     const np_spectrum *factors, np_spectrum *out_straight, np_spectrum *out_scaled) {
  *out_straight = *out_scaled = np_spectrum_grey(0.0f);
  np_depth_cursors clouds;
  for (unsigned g = 0; g < world->emission->emitter_count; g++) {
    np_emitter_walk w;
    double begin, end;
    if (world->emission->emitters[g].is_held_out) continue;
    np_emitter_walk_start(&w, &world->emission->emitters[g], ray->origin, ray->direction, distance_end,
                          np_emission_march_step_voxels);
    np_depth_cursors_start(&clouds, &world->clouds, ray->origin, ray->direction, distance_end);
    while (np_emitter_walk_next(&w, &begin, &end)) {
      np_depth_cursors_advance(&clouds, begin);
      const np_spectrum straight = np_emission_get_depth(&clouds, NULL);
      const np_spectrum scaled = np_emission_get_depth(&clouds, factors);
      if (np_spectrum_max(np_spectrum_exp_negative(scaled)) < np_emission_faint_transmittance) break;
      const double middle = 0.5 * (begin + end);
      np_spectrum light = np_emitter_walk_eval(&w, world->emission, middle);
      if (np_spectrum_is_zero(light)) continue;
      light = np_emission_dim(world, ray->origin, ray->direction, ray->begin_m, middle, light);
      np_depth_cursors_advance(&clouds, end);
      const np_spectrum straight_end = np_emission_get_depth(&clouds, NULL);
      const float mean = np_emission_correct_mean(world, np_dvec3_along(ray->origin, ray->direction, middle),
                                                  end - begin, straight_end.band[0] - straight.band[0]);
      light = np_spectrum_scale(light, mean * (float)(end - begin));
      const np_spectrum straight_weight = np_emission_weigh_step(straight, straight_end);
      const np_spectrum scaled_weight = np_emission_weigh_step(scaled, np_emission_get_depth(&clouds, factors));
      *out_straight = np_spectrum_add(*out_straight, np_spectrum_multiply(straight_weight, light));
      *out_scaled = np_spectrum_add(*out_scaled, np_spectrum_multiply(scaled_weight, light));
      if (np_integrator_has_depths(ray))
        np_emission_record(ray->layers, ray->begin_m + begin, ray->begin_m + end,
                           np_spectrum_multiply(scaled_weight, light));
    }
  }
}

/* ---- Next-event estimation ---- */

/* Step length, in voxels, along rays from a vertex to emitters. Its error is small beside the noise of their
 * directions. */
static const float np_emission_far_step_voxels = 2.0f;

/* Distance of a ray to the ground. */
static inline double np_emission_get_end(const np_world *world, np_dvec3 origin, np_vec3 direction) {
  return world->has_planet || world->terrain ? np_world_find_ground(world, origin, direction, NULL) : HUGE_VAL;
}

/* A direction towards an emitter, `u` choosing which, and its density; false where there is none. */
static inline bool np_emission_draw_direction(const np_world *world, np_dvec3 origin, double u, np_random *random,
                                              np_vec3 *out_direction, float *out_density) {
  np_dvec3 place;
  if (!np_emission_draw(world->emission, u, random, &place)) return false;
  const np_dvec3 away = np_dvec3_subtract(place, origin);
  const double distance = np_dvec3_length(away);
  if (!(distance > 0.0)) return false;
  *out_direction = np_dvec3_to_float(np_dvec3_scale(away, 1.0 / distance));
  *out_density = np_emission_direction_density(world->emission, origin, *out_direction);
  return *out_density > 0.0f;
}

/* Irradiance of emission on a plane, through cloud and past ground: one direction, `u` choosing the cell. */
static inline np_spectrum np_emission_irradiance_along(const np_world *world, np_dvec3 position, np_vec3 normal,
                                                       double u, np_random *random) {
  np_vec3 direction;
  float density;
  const np_spectrum dark = np_spectrum_grey(0.0f);
  if (!np_emission_draw_direction(world, position, u, random, &direction, &density)) return dark;
  const float cosine = np_vec3_dot(normal, direction);
  if (cosine <= 0.0f) return dark;
  const double end = np_emission_get_end(world, position, direction);
  const np_spectrum light =
      np_emission_along(world, position, direction, end, np_emission_far_step_voxels, false, 0.0, random);
  return np_spectrum_scale(light, cosine / density);
}

/* The mean of several directions, to cells of equal shares of the power. */
static inline np_spectrum np_emission_irradiance(const np_world *world, np_dvec3 position, np_vec3 normal,
                                                 np_random *random) {
  enum { DIRECTIONS = 4 };
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < DIRECTIONS; i++) {
    const double u = (i + np_random_double(random)) / DIRECTIONS;
    sum = np_spectrum_add(sum, np_emission_irradiance_along(world, position, normal, u, random));
  }
  return np_spectrum_scale(sum, 1.0f / DIRECTIONS);
}

#endif
