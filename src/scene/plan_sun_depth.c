/* SPDX-License-Identifier: Apache-2.0 */
/* What the sun optical-depth volume costs, and what it saves, in look-ups of density. */
#include <math.h>
#include <stdio.h>

#include "core/units.h"
#include "scene/plan.h"

/* Beyond this the middle of the sun's disk does not stand for all of it inside a cloud. */
static const double disk_radius_max_rad = NP_PI / 180.0;

/* Every node is filled from one look-up; nodes on the faces of cells count twice, and some are around the cloud. Those
 * of steep cells, half a voxel apart, are as many again. */
static double count_filling(double voxels) { return 4.0 * voxels; }

/* A ray of the march in three meets cloud and takes some 16 steps before it is dark there; one for shadows in the air
 * asks at some 48 places. From each some quarter of the cloud's breadth lies before the sun. */
static double count_marching(const np_plan *plan) {
  const double spacing = plan->air_ray_spacing, pixels = (double)plan->ray_count / plan->desc.sample_count;
  const double air_rays = spacing > 0.0 ? pixels / (spacing * spacing) : 0.0;
  const double rays = plan->desc.integrator == NEPH_INTEGRATOR_MARCH ? (double)plan->ray_count : 0.0;
  return (rays / 3.0 * 16.0 + air_rays * 48.0) * 0.25 * cbrt(plan->cloud_voxel_count);
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
  const double filling = count_filling(plan->cloud_voxel_count), marching = count_marching(plan);
  snprintf(out_reason, reason_size, "some %.1g look-ups to fill it against %.1g to march for every step", filling,
           marching);
  return filling < marching;
}
