/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds that multiple scattering is not solved for: all, where none scatters light, and clouds out of view whose light
 * is lost in that of the picture. Their sun optical depths stay, and with them their shade on the ground and in the
 * air; a cloud that shades another one which is solved for is solved for too.
 *
 * A ball of radius r at a distance D from a place shines on it from a solid angle of π(r/D)², with E/π per unit of it
 * at the most, while the sun gives E·sin h to level ground and E to clouds. Three times that share bounds light that
 * falls where the sun does not. */
#include "plan/plan_choices.h"
#include "scene/camera.h"

/* Limit on the total share of the picture's light that omitted clouds may change. */
static const double share_max = 0.01;

static const double unlit_factor = 3.0, sine_min = 0.1;

/* Share of its size that a cloud may go beyond its expected box. */
static const double margin = 0.1;

/* Rays along each side of the picture, to which distances are measured. */
enum { LATTICE = 33 };

typedef struct ball {
  np_dvec3 centre;
  double radius;
} ball;

static bool is_black(const np_scene_cloud *cloud) {
  return cloud->albedo[0] == 0.0 && cloud->albedo[1] == 0.0 && cloud->albedo[2] == 0.0;
}

static bool are_all_black(const neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (!is_black(&scene->clouds[i])) return false;
  return scene->cloud_count > 0;
}

/* Expected box of a cloud in one place; false: it is not known before the cloud is built. */
static bool get_box(const np_plan *plan, const neph_scene *scene, unsigned i, np_dvec3 *out_low, np_dvec3 *out_high) {
  const np_scene_cloud *cloud = &scene->clouds[i];
  const np_input_file *file = np_inputs_get_file(&plan->inputs, i);
  if (cloud->place_count > 0 || (!cloud->is_baked && !file->is_known)) return false;
  np_dvec3 low = file->low, high = file->high;
  if (cloud->is_baked) {
    const neph_cloud_desc *bake = &cloud->bake;
    const double x = 0.5 * bake->extent_m[0], y = 0.5 * bake->extent_m[1];
    low = np_dvec3_make(bake->center_m[0] - x, bake->center_m[1] - y, bake->base_altitude_m);
    high = np_dvec3_make(bake->center_m[0] + x, bake->center_m[1] + y, bake->base_altitude_m + bake->thickness_m);
  }
  const np_dvec3 more = np_dvec3_scale(np_dvec3_subtract(high, low), margin);
  *out_low = np_dvec3_subtract(low, more);
  *out_high = np_dvec3_add(high, more);
  return true;
}

static ball make_ball(np_dvec3 low, np_dvec3 high) {
  return (ball){np_dvec3_scale(np_dvec3_add(low, high), 0.5), 0.5 * np_dvec3_length(np_dvec3_subtract(high, low))};
}

/* Shortest distance from a point to the camera's possible view. */
static double compute_distance(const np_camera *camera, np_dvec3 place) {
  double least = HUGE_VAL;
  for (unsigned n = 0; n < LATTICE * LATTICE; n++) {
    np_film_ray ray;
    const float x = (float)(n % LATTICE) / (LATTICE - 1), y = (float)(n / LATTICE) / (LATTICE - 1);
    if (!np_camera_start_ray(camera, x * (float)camera->width, y * (float)camera->height, 0.5f, 0.5f, &ray)) continue;
    const np_dvec3 away = np_dvec3_subtract(place, ray.origin), along = np_vec3_to_double(ray.direction);
    const double t = fmax(np_dvec3_dot(away, along), 0.0);
    least = fmin(least, np_dvec3_length(np_dvec3_subtract(away, np_dvec3_scale(along, t))));
  }
  return least;
}

/* Share of the light of visible points that comes by way of a cloud; infinite if the cloud is near the view. */
static double compute_share(const np_plan *plan, const np_camera *camera, const ball *cloud) {
  const np_decisions *made = &plan->decisions;
  const double sine = made->are_lights_known ? fmax(made->lights.to_sun.z, sine_min) : sine_min;
  const double distance = compute_distance(camera, cloud->centre);
  return distance > 2.0 * cloud->radius ? unlit_factor * pow(cloud->radius / distance, 2.0) / sine : HUGE_VAL;
}

/* Whether the shadow of one ball may reach another. */
static bool is_shading(np_dvec3 to_sun, const ball *from, const ball *onto) {
  const np_dvec3 way = np_dvec3_subtract(onto->centre, from->centre);
  const double along = -np_dvec3_dot(way, to_sun), reach = from->radius + onto->radius;
  const np_dvec3 beside = np_dvec3_add(way, np_dvec3_scale(to_sun, along));
  return along > -reach && np_dvec3_length(beside) < reach;
}

/* Clouds of a picture, and those that may be left out. */
typedef struct cloud_shares {
  unsigned count;
  ball balls[NP_INSTANCES_MAX];
  double share[NP_INSTANCES_MAX]; /* infinite: it is solved for */
} cloud_shares;

/* Clouds whose shadows may reach a cloud that is solved for are solved for too. */
static void solve_shading(np_dvec3 to_sun, cloud_shares *c) {
  bool is_changed = true;
  while (is_changed) {
    is_changed = false;
    for (unsigned i = 0; i < c->count; i++)
      for (unsigned k = 0; k < c->count && isfinite(c->share[i]); k++)
        if (isinf(c->share[k]) && is_shading(to_sun, &c->balls[i], &c->balls[k])) {
          c->share[i] = HUGE_VAL;
          is_changed = true;
        }
  }
}

static bool can_leave_out(const np_plan *plan, const neph_scene *scene) {
  return plan->request.desc.integrator == NEPH_INTEGRATOR_MARCH && !scene->animation && !np_scene_has_water(scene) &&
         !np_plan_needs(plan, NP_STAGE_MOON) && scene->cloud_count <= NP_INSTANCES_MAX;
}

/* False where some cloud's box is not known. */
static bool measure_shares(const np_plan *plan, const neph_scene *scene, cloud_shares *out) {
  np_camera camera;
  out->count = scene->cloud_count;
  if (np_camera_init(scene, plan->request.desc.width, plan->request.desc.height, NEPH_EYE_CENTRE, &camera))
    return false;
  for (unsigned i = 0; i < out->count; i++) {
    np_dvec3 low, high;
    if (!get_box(plan, scene, i, &low, &high)) return false;
    out->balls[i] = make_ball(low, high);
    const np_scene_cloud *cloud = &scene->clouds[i];
    const bool is_solved =
        cloud->emission.is_enabled || cloud->repeat != NP_REPEAT_NONE || np_camera_sees_box(&camera, low, high);
    out->share[i] = is_solved ? HUGE_VAL : compute_share(plan, &camera, &out->balls[i]);
  }
  return true;
}

np_left_out np_plan_choose_left_out(const np_plan *plan, const neph_scene *scene) {
  cloud_shares c;
  np_left_out out = {.clouds = 0};
  if (are_all_black(scene)) return (np_left_out){.clouds = UINT64_MAX, .is_all = true, .are_black = true};
  if (!can_leave_out(plan, scene) || !measure_shares(plan, scene, &c)) return out;
  solve_shading(plan->decisions.lights.to_sun, &c);
  for (;;) {
    unsigned least = 0;
    for (unsigned i = 1; i < c.count; i++)
      if (c.share[i] < c.share[least]) least = i;
    if (c.count == 0 || !(out.share + c.share[least] < share_max)) break;
    out.share += c.share[least];
    out.clouds |= UINT64_C(1) << least;
    out.count++;
    c.share[least] = HUGE_VAL;
  }
  out.is_all = out.count == scene->cloud_count && out.count > 0;
  return out;
}
