/* SPDX-License-Identifier: Apache-2.0 */
/* The rays of a picture that meet the clouds' box, by a lattice of them over the whole picture, whatever is rendered of
 * it. All, where keys change from frame to frame: cells are the same in every frame. */
#include "plan/plan_detail.h"
#include "scene/camera.h"

/* Rays along each side of the lattice. */
enum { LATTICE = 64 };

/* One axis of a box: cuts [begin, end] of a ray to what lies between its two planes. */
static void clip_axis(double origin, double direction, double low, double high, double *begin, double *end) {
  const double away = fabs(direction) > 1e-12 ? direction : copysign(1e-12, direction);
  const double first = (low - origin) / away, second = (high - origin) / away;
  *begin = fmax(*begin, fmin(first, second));
  *end = fmin(*end, fmax(first, second));
}

static bool is_met(const np_film_ray *ray, np_dvec3 low, np_dvec3 high) {
  double begin = 0.0, end = HUGE_VAL;
  clip_axis(ray->origin.x, (double)ray->direction.x, low.x, high.x, &begin, &end);
  clip_axis(ray->origin.y, (double)ray->direction.y, low.y, high.y, &begin, &end);
  clip_axis(ray->origin.z, (double)ray->direction.z, low.z, high.z, &begin, &end);
  return begin <= end;
}

static unsigned count_met(const np_camera *camera, np_dvec3 low, np_dvec3 high) {
  unsigned count = 0;
  for (unsigned n = 0; n < LATTICE * LATTICE; n++) {
    const float x = ((float)(n % LATTICE) + 0.5f) / LATTICE, y = ((float)(n / LATTICE) + 0.5f) / LATTICE;
    np_film_ray ray;
    if (np_camera_start_ray(camera, x * (float)camera->width, y * (float)camera->height, 0.5f, 0.5f, &ray))
      count += is_met(&ray, low, high);
  }
  return count;
}

double np_plan_count_rays_to(const np_request *request, const neph_scene *scene, np_dvec3 low, np_dvec3 high) {
  const neph_render_desc *desc = &request->desc;
  const double all = (double)desc->width * desc->height * desc->sample_count;
  np_camera camera;
  if (scene->animation || !(low.x <= high.x)) return all;
  if (np_camera_init(scene, desc->width, desc->height, NEPH_EYE_CENTRE, &camera)) return all;
  /* A margin of half a square of the lattice on each side, for boxes between its rays. */
  const double side = (sqrt(count_met(&camera, low, high)) + 1.0) / LATTICE;
  return all * fmin(side * side, 1.0);
}
