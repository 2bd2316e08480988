/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/ray_path.h"

#include <assert.h>

#include "atmosphere/optical_depth.h"
#include "atmosphere/ray_warp.h"

/* Parts of the atmosphere's height below which a ray to the ground, or a limb ray, needs no warp. */
static const double ground_plain_below = 0.03, limb_plain_below = 0.003;
/* Limb rays descend at least this steeply. */
static const double limb_cosine = -0.005;
/* Step over which two Gauss points give the depth, in heights of the atmosphere. */
static const double depth_step = 0.2;

/* Points at t = from + (to − from)·u², in ascending t for either order of the two. */
static int place_squared(const np_medium *medium, const np_ray *ray, np_path *path, int at, const np_quadrature *plain,
                         double from, double to) {
  const double length = to - from;
  assert(at >= 0 && (size_t)(at + plain->count) <= sizeof path->node / sizeof *path->node);
  np_quadrature warped;
  if (path->is_warped) warped = np_warp_rule(medium, ray, from, to, 2, plain);
  const np_quadrature *rule = path->is_warped ? &warped : plain;
  for (int i = 0; i < rule->count; i++) {
    const int k = length >= 0.0 ? i : rule->count - 1 - i;
    const double u = rule->x[k];
    path->node[at + i].t = from + length * u * u;
    path->node[at + i].weight_m = (float)(2.0 * u * fabs(length) * rule->weight[k]);
  }
  return at + rule->count;
}

static int place_evenly(const np_medium *medium, const np_ray *ray, np_path *path, double begin_m, double end_m,
                        const np_quadrature *plain) {
  const double length = end_m - begin_m;
  np_quadrature warped;
  if (path->is_warped) warped = np_warp_rule(medium, ray, begin_m, end_m, 1, plain);
  const np_quadrature *rule = path->is_warped ? &warped : plain;
  for (int i = 0; i < rule->count; i++) {
    path->node[i].t = begin_m + length * rule->x[i];
    path->node[i].weight_m = (float)(length * rule->weight[i]);
  }
  return rule->count;
}

static int place_nodes(const np_medium *medium, const np_ray *ray, const np_path_rule *rule, np_path *path) {
  if (!(ray->length_m > 0.0)) return 0;
  path->is_warped = np_warp_is_needed(medium);
  if (ray->hits_ground) {
    if (ray->altitude_m < ground_plain_below * medium->top_m)
      return place_evenly(medium, ray, path, 0.0, ray->length_m, &rule->whole);
    return place_squared(medium, ray, path, 0, &rule->whole, ray->length_m, 0.0);
  }
  if (ray->cosine < limb_cosine && ray->altitude_m > limb_plain_below * medium->top_m) {
    const double perigee = np_ray_perigee(ray);
    const int half = place_squared(medium, ray, path, 0, &rule->half, perigee, 0.0);
    return place_squared(medium, ray, path, half, &rule->half, perigee, ray->length_m);
  }
  return place_squared(medium, ray, path, 0, &rule->whole, 0.0, ray->length_m);
}

np_bands np_ray_gap_depth(const np_medium *medium, const np_ray *ray, double begin_m, double end_m) {
  const int steps = (int)np_clamp(ceil((end_m - begin_m) / (depth_step * medium->top_m)), 1.0, 16.0);
  const double step = (end_m - begin_m) / steps, offset = 0.5 / sqrt(3.0);
  np_bands depth = np_bands_grey(0.0f);
  for (int i = 0; i < steps; i++) {
    const double middle = begin_m + (i + 0.5) * step;
    depth += np_extinction_at(medium, np_ray_altitude(ray, middle - offset * step)) +
             np_extinction_at(medium, np_ray_altitude(ray, middle + offset * step));
  }
  return depth * (float)(0.5 * step);
}

/* Depth between two points, split at the kinks of profiles. */
static np_bands compute_gap(const np_medium *medium, const np_ray *ray, const np_path *path, double begin_m,
                            double end_m) {
  return path->is_warped ? np_ray_optical_depth(medium, ray, begin_m, end_m)
                         : np_ray_gap_depth(medium, ray, begin_m, end_m);
}

/* Fills the placed points of a part of a ray, `depth` being that up to its begin; returns the depth up to its end. */
static np_bands fill_points(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, np_bands depth,
                            np_path *path) {
  double before = begin_m;
  for (int i = 0; i < path->count; i++) {
    np_path_node *node = &path->node[i];
    depth += compute_gap(medium, ray, path, before, node->t);
    before = node->t;
    const double altitude = np_ray_altitude(ray, node->t);
    node->altitude_m = (float)altitude;
    node->r = (float)(ray->r + (altitude - ray->altitude_m));
    node->cosine = (float)np_ray_cosine(ray, node->t);
    np_scattering_at(medium, altitude, &node->air);
    node->transmittance = np_bands_exp(-depth);
  }
  if (path->count) depth += compute_gap(medium, ray, path, before, end_m);
  path->end_transmittance = np_bands_exp(-depth);
  return depth;
}

void np_path_build(const np_medium *medium, const np_ray *ray, const np_path_rule *rule, np_path *out_path) {
  out_path->count = place_nodes(medium, ray, rule, out_path);
  (void)fill_points(medium, ray, 0.0, ray->length_m, np_bands_grey(0.0f), out_path);
}

void np_path_build_part(const np_medium *medium, const np_ray *ray, double begin_m, double end_m,
                        const np_quadrature *rule, np_bands *depth, np_path *out_path) {
  out_path->is_warped = np_warp_is_needed(medium);
  out_path->count = place_evenly(medium, ray, out_path, begin_m, end_m, rule);
  *depth = fill_points(medium, ray, begin_m, end_m, *depth, out_path);
}
