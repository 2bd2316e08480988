/* SPDX-License-Identifier: Apache-2.0 */
/* Motion vectors: the visible points of a sample, weighted by opacity, are moved to the previous and the next frame and
 * projected there. Clouds move at the mean distance of their opacity, ground at the ray's hit; everything else is
 * infinitely far, and moves by the camera's rotation alone. */
#include "stages/motion.h"

/* Pixels to the right and up. */
typedef struct vector_sums {
  double weight, forward[2], backward[2];
} vector_sums;

/* Shortest horizontal difference of two film positions: the left and right edges of a panorama meet. */
static double wrap(const np_camera *camera, double across) {
  return camera->kind == NEPH_CAMERA_EQUIRECTANGULAR ? across - camera->width * round(across / camera->width) : across;
}

static void add(const np_motion *m, double weight, const double now[2], const double then[2], double out[2]) {
  out[0] += weight * wrap(&m->now, then[0] - now[0]);
  out[1] -= weight * (then[1] - now[1]);
}

/* Adds the motion of a point from its position in the `previous` frame and to its position in the `next` one. A point
 * without a projection does not move. */
static void add_points(const np_motion *m, vector_sums *sums, double weight, np_dvec3 point, np_dvec3 next,
                       np_dvec3 previous) {
  double now[2], then[2], depth;
  sums->weight += weight;
  if (!np_camera_project(&m->now, point, now, &depth)) return;
  if (np_camera_project(&m->next, next, then, &depth)) add(m, weight, now, then, sums->forward);
  if (np_camera_project(&m->previous, previous, then, &depth)) add(m, weight, now, then, sums->backward);
}

static void add_sky(const np_motion *m, vector_sums *sums, double weight, np_vec3 direction) {
  const np_dvec3 d = np_vec3_to_double(direction);
  double now[2], then[2];
  sums->weight += weight;
  if (!np_camera_project_direction(&m->now, d, now)) return;
  if (np_camera_project_direction(&m->next, d, then)) add(m, weight, now, then, sums->forward);
  if (np_camera_project_direction(&m->previous, d, then)) add(m, weight, now, then, sums->backward);
}

/* The place at the frame's time of a point at a time of the exposure. */
static np_dvec3 rewind_point(const np_motion *m, const np_cloud_motion *cloud, np_dvec3 point, double time) {
  if (!m->has_exposure || !cloud->is_rigid) return point;
  const double at = NP_MOTION_SPANS * np_clamp((time - m->open) / (m->close - m->open), 0.0, 1.0);
  const int pose = (int)fmin(floor(at), NP_MOTION_SPANS - 1);
  const np_dvec3 a = np_affine_point(&cloud->to_frame[pose], point),
                 b = np_affine_point(&cloud->to_frame[pose + 1], point);
  return np_dvec3_add(a, np_dvec3_scale(np_dvec3_subtract(b, a), at - pose));
}

/* Displacement of a point in the time of one frame, by the velocity grid of the first part that moves there; parts of a
 * cloud with levels of detail cover different places. */
static np_dvec3 compute_step(const np_cloud_motion *cloud, np_dvec3 point) {
  np_dvec3 step = np_dvec3_make(0.0, 0.0, 0.0);
  for (unsigned k = 0; k < NP_TINT_PARTS_MAX && np_dvec3_length(step) == 0.0; k++) {
    const np_moving_bricks *part = k == 0 ? cloud->density : cloud->parts[k];
    if (!part) continue;
    const np_dvec3 index = np_affine_point(&cloud->frame_to_part[k], point);
    const np_dvec3 voxels = np_brick_motion_get_velocity(&part->bricks, &part->motion, index);
    step = np_affine_vector(&cloud->part_to_frame[k], np_dvec3_scale(voxels, cloud->velocity_s));
  }
  return step;
}

static void add_cloud(const np_motion *m, vector_sums *sums, double weight, unsigned number, np_dvec3 point,
                      double time) {
  const np_cloud_motion *cloud = &m->clouds[number];
  np_dvec3 now = rewind_point(m, cloud, point, time), ahead = now, behind = now;
  if (cloud->density) {
    const np_dvec3 step = compute_step(cloud, now), here = now;
    now = np_dvec3_add(here, np_dvec3_scale(step, -time));
    ahead = np_dvec3_add(here, np_dvec3_scale(step, 1.0 - time));
    behind = np_dvec3_add(here, np_dvec3_scale(step, -1.0 - time));
  }
  add_points(m, sums, weight, now, np_affine_point(&cloud->next, ahead), np_affine_point(&cloud->previous, behind));
}

/* Adds the ground's share of a pixel's opacity, whose mean distance is found by subtracting the clouds. */
static void add_ground(const np_motion *m, vector_sums *sums, const np_world *world, const np_camera_ray *ray,
                       const np_integrator_sample *sample, double cloud_weight, double *distance) {
  np_ground_hit hit;
  const double weight = (double)sample->opaque_weight - cloud_weight;
  if (!sample->is_ground_behind || !(weight > 0.0) || !np_camera_ray_intersect_ground(world, ray, &hit)) return;
  const np_dvec3 point = np_dvec3_along(ray->origin, ray->direction, hit.distance_m);
  add_points(m, sums, weight, point, point, point);
  *distance -= weight * hit.distance_m;
}

np_motion_vectors np_motion_compute_vectors(const np_motion *motion, const np_world *world, const np_camera_ray *ray,
                                            const np_integrator_sample *sample, double time) {
  vector_sums sums = {.weight = 0.0};
  double clouds = 0.0, distance = (double)sample->opaque_distance;
  for (unsigned c = 0; c < motion->cloud_count; c++) clouds += (double)ray->layers->cloud_opacity[c];
  add_ground(motion, &sums, world, ray, sample, clouds, &distance);
  for (unsigned c = 0; c < motion->cloud_count; c++) {
    const double weight = (double)ray->layers->cloud_opacity[c];
    if (weight > 0.0)
      add_cloud(motion, &sums, weight, c, np_dvec3_along(ray->origin, ray->direction, distance / clouds), time);
  }
  const double sky = sample->is_ground_behind ? 0.0 : (double)sample->transmittance;
  if (sky > 0.0 || !(sums.weight > 0.0)) add_sky(motion, &sums, fmax(sky, 1e-6), ray->direction);
  np_motion_vectors out;
  for (int k = 0; k < 2; k++) {
    out.forward[k] = (float)(sums.forward[k] / sums.weight);
    out.backward[k] = (float)(sums.backward[k] / sums.weight);
  }
  return out;
}
