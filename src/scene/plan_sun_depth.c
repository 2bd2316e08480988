/* SPDX-License-Identifier: Apache-2.0 */
/* What the sun optical-depth volume costs, and what it saves, in seconds of one core.
 *
 * Times and counts are medians over six clouds, thick and thin, heaped and flat, measured by bench_sun_depth and with
 * look-ups counted; their ratios matter alone. docs/transport.md has the table and what the choice makes of it.
 */
#include <math.h>
#include <stdio.h>

#include "core/units.h"
#include "scene/plan.h"

/* Beyond this the middle of the sun's disk does not stand for all of it inside a cloud. */
static const double disk_radius_max_rad = NP_PI / 180.0;

/* To fill a voxel's share of the lattice: 62 to 118 ns. */
static const double fill_s = 100e-9;
/* To walk through one brick: 81 to 131 ns alone, 90 and 95 as part of a picture. */
static const double brick_s = 90e-9;
/* To look a depth up, known or not: 15 to 37 ns. */
static const double look_up_s = 35e-9;
/* Questions that a ray of the march has, whatever it meets: 2.1 to 3. */
static const double ray_questions = 2.4;
/* Bricks that they need not walk through, as parts of the way through a thin cloud. */
static const double ray_ways = 1.8;
/* A thicker cloud is dark after a part of it. */
static const double dark_depth = 25.0;
/* A ray for shadows in the air asks some 80 times, mostly from outside: 5 to 20 times a ray of the march. */
static const double air_ray_factor = 10.0;

/* What is taken for the depth of clouds whose grids are not read yet: a cumulus'. */
static const double depth_unread = 40.0;
/* The least sine of the light's elevation: level light does not run through a layer for ever. */
static const double sine_least = 0.1;

static double find_sine(const np_plan *plan) {
  if (!plan->are_lights_known) return 0.5;
  const np_dvec3 to_light = plan->has_sun ? plan->lights.to_sun : plan->lights.moon.direction;
  return fmax(to_light.z, sine_least);
}

/* Bricks on the way of the light through a cloud, and the depth of the cloud. */
static double count_bricks(const np_plan *plan, const np_scene_cloud *cloud, double *out_depth) {
  const neph_cloud_desc *bake = &cloud->bake;
  *out_depth = cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH ? cloud->density_value : depth_unread;
  if (!cloud->is_baked) return cbrt(plan->cloud_voxel_count) / 8.0;
  *out_depth = bake->extinction_per_m * bake->thickness_m;
  const double way_m = fmin(bake->thickness_m / find_sine(plan), hypot(bake->extent_m[0], bake->extent_m[1]));
  return way_m / (8.0 * bake->voxel_m);
}

/* Of a ray of the march, in the mean over the clouds. */
static double find_saving(const np_plan *plan, const neph_scene *scene) {
  double bricks = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    double depth;
    const double way = count_bricks(plan, &scene->clouds[i], &depth);
    bricks += ray_ways * way / (1.0 + depth / dark_depth) / scene->cloud_count;
  }
  return fmax(bricks * brick_s - ray_questions * look_up_s, 0.0);
}

/* Of the whole picture, whatever of it is asked for: a part has the bits of the whole. */
static double count_rays(const np_plan *plan) {
  const double spacing = plan->air_ray_spacing, pixels = (double)plan->desc.width * plan->desc.height;
  const double air_rays = spacing > 0.0 ? pixels / (spacing * spacing) : 0.0;
  const double rays = plan->desc.integrator == NEPH_INTEGRATOR_MARCH ? pixels * plan->desc.sample_count : 0.0;
  return rays + air_ray_factor * air_rays;
}

bool np_plan_choose_sun_volume(const np_plan *plan, const neph_scene *scene, char *out_reason, size_t reason_size) {
  const np_sun_depth wanted = scene->render.sun_depth;
  if (wanted != NP_SUN_DEPTH_AUTO) {
    snprintf(out_reason, reason_size, "render.sun_depth is %s", wanted == NP_SUN_DEPTH_VOLUME ? "volume" : "march");
    return wanted == NP_SUN_DEPTH_VOLUME;
  }
  if (scene->sun.angular_radius_rad > disk_radius_max_rad) {
    snprintf(out_reason, reason_size, "sun.angular_radius is above 1 deg: its disk is marched for");
    return false;
  }
  const double filling = fill_s * plan->cloud_voxel_count, saving = find_saving(plan, scene) * count_rays(plan);
  snprintf(out_reason, reason_size, "filling it takes some %.1g s of one core and spares some %.1g s of marching",
           filling, saving);
  return filling < saving;
}
