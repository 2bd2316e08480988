/* SPDX-License-Identifier: Apache-2.0 */
/* Cost and saving of the sun optical-depth volume, in seconds of one core.
 *
 * Times and counts are medians over six clouds, thick and thin, heaped and flat, measured by bench_sun_optical_depth
 * and with look-ups counted; their ratios matter alone. docs/transport.md has the table and what the choice makes of
 * it.
 */
#include <math.h>
#include <string.h>

#include "core/frame_name.h"
#include "core/units.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "plan/stage_decisions.h"
#include "scene/sequence.h"

/* Angular radius of the sun's disk above which its centre is no approximation of the disk within clouds. */
static const double disk_radius_max_rad = NP_PI / 180.0;

/* Time to fill a voxel's share of the lattice: 92 ns for a transparent brick; 260 to 490 for one that may be opaque,
 * for nodes half a voxel apart. */
static const double fill_s = 90e-9, fill_steep_s = 340e-9;
/* Time to walk through one brick: 81 to 131 ns alone, 90 and 95 as part of a picture. */
static const double brick_s = 90e-9;
/* Time to look a depth up, known or not: 36 to 50 ns. */
static const double look_up_s = 45e-9;
/* Queries of a march ray, whether or not it meets cloud: 2.1 to 3. */
static const double queries_per_ray = 2.4;
/* Bricks whose traversal is saved, relative to the bricks along a ray through a thin cloud. */
static const double ray_ways = 1.9;
/* Optical depth above which a march ray ends, or is dark, before it has crossed the cloud. */
static const double thick_depth = 300.0;
/* A ray for shadows in the air has some 80 queries, mostly outside clouds: 4 to 30 times a ray of the march. */
static const double air_ray_factor = 10.0;

/* Least number of frames that a sequence's sun volume is assumed to serve. */
static const double sequence_frames = 16.0;
/* Optical depth assumed for clouds whose grids are not read yet: a cumulus'. */
static const double depth_unread = 40.0;
/* The least sine of the light's elevation: level light does not run through a layer for ever. */
static const double sine_least = 0.1;

static double get_sine(const np_decisions *decisions) {
  if (!decisions->are_lights_known) return 0.5;
  return decisions->has_sun ? decisions->lights.to_sun.z : decisions->lights.moon.direction.z;
}

/* A cloud as light runs through it. */
typedef struct ray_passage {
  double bricks, depth;
} ray_passage;

static ray_passage compute_passage(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud) {
  if (!cloud->is_baked) {
    const bool is_known = cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH;
    return (ray_passage){cbrt(np_plan_get_cloud_voxels(plan)) / 8.0, is_known ? cloud->density_value : depth_unread};
  }
  const neph_cloud_desc bake = np_plan_get_bake(&plan->request, scene, cloud);
  const double way_m =
      fmin(bake.thickness_m / fmax(get_sine(&plan->decisions), sine_least), hypot(bake.extent_m[0], bake.extent_m[1]));
  return (ray_passage){way_m / (8.0 * bake.voxel_m), bake.extinction_per_m * bake.thickness_m};
}

/* Means over the clouds: time to fill a voxel, and time that a ray of the march saves. */
static void compute_costs(const np_plan *plan, const neph_scene *scene, double *out_fill_s, double *out_saving_s) {
  double fill = 0.0, bricks = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const ray_passage p = compute_passage(plan, scene, &scene->clouds[i]);
    fill += (fill_s + (fill_steep_s - fill_s) * fmin(p.depth / fmax(p.bricks, 1.0), 1.0)) / scene->cloud_count;
    bricks += ray_ways * p.bricks / (1.0 + p.depth / thick_depth) / scene->cloud_count;
  }
  *out_fill_s = fill;
  *out_saving_s = fmax(bricks * brick_s - queries_per_ray * look_up_s, 0.0);
}

/* Rays towards the sun of a path, with pixels that see no cloud, relative to those of a march's ray, while the light is
 * above the horizon; and samples assumed for all pictures by path, of which more may be taken later. */
static const double path_ray_factor = 2.0, path_samples = 16.0;

/* Samples a pixel; of a picture that the scene's samples follow, those. */
static double count_samples(const np_request *request, const neph_scene *scene) {
  const double own = request->desc.sample_count;
  return request->takes_near && !np_request_is_coarse(request) ? fmax(own, scene->render.sample_count) : own;
}

/* Counts of the whole picture, whatever part of it is rendered: a part has the bits of the whole. */
static double count_rays(const np_plan *plan, const neph_scene *scene) {
  const np_request *r = &plan->request;
  const double spacing = plan->decisions.air_ray_spacing, pixels = (double)r->desc.width * r->desc.height;
  const double air_rays = spacing > 0.0 ? pixels / (spacing * spacing) : 0.0;
  const bool is_march = r->desc.integrator == NEPH_INTEGRATOR_MARCH;
  const double of_paths = get_sine(&plan->decisions) > 0.0 ? path_ray_factor * path_samples : 0.0;
  const double rays = is_march ? count_samples(r, scene) : of_paths;
  return pixels * rays + air_ray_factor * air_rays;
}

static bool is_numbered(const char *path) { return path && np_frame_name_is_pattern(path); }

/* Whether only the camera moves in a sequence of frames. It depends on the scene alone, so that a frame's bits do not
 * depend on the other frames of a run. */
static bool is_sequence_of_still_clouds(const neph_scene *scene) {
  bool is_still = np_scene_has_still_light(scene);
  for (unsigned i = 0; i < scene->cloud_count; i++)
    is_still = is_still && !is_numbered(scene->clouds[i].vdb) && !np_scene_cloud_has_steps(&scene->clouds[i]);
  return is_still && is_numbered(scene->output.image);
}

/* Nodes of the lattice that hold a depth: their bytes for a voxel with cloud, 9 to 50 in five scenes. */
static const double voxel_bytes = 25.0;

void np_stage_count_sun_optical_depth(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  const double lights = np_plan_count_lights(plan), voxels = np_plan_get_cloud_voxels(plan);
  double steep = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const ray_passage p = compute_passage(plan, scene, &scene->clouds[i]);
    steep += fmin(p.depth / fmax(p.bricks, 1.0), 1.0) / scene->cloud_count;
  }
  const double counted = lights * fmin(voxels, (double)desc.bytes_max / voxel_bytes);
  out->of[NP_UNIT_SUN_VOXEL] = counted * (1.0 - steep);
  out->of[NP_UNIT_STEEP_SUN_VOXEL] = counted * steep;
}

void np_stage_choose_sun_volume(np_decision *d, np_stage_decision *out) {
  const neph_scene *scene = d->scene;
  const np_sun_optical_depth_method given = scene->render.sun_optical_depth;
  if (given != NP_SUN_OPTICAL_DEPTH_AUTO) {
    const bool is_volume = given == NP_SUN_OPTICAL_DEPTH_VOLUME;
    np_stage_decide(d, out, is_volume, "render.sun_optical_depth is %s", is_volume ? "volume" : "march");
    return;
  }
  if (scene->sun.angular_radius_rad > disk_radius_max_rad) {
    np_stage_decide(d, out, false, "sun.angular_radius is above 1 deg: its disk is marched for");
    return;
  }
  double voxel_s, ray_s;
  compute_costs(d->plan, scene, &voxel_s, &ray_s);
  const double filling = voxel_s * np_plan_get_cloud_voxels(d->plan), saving = ray_s * count_rays(d->plan, scene);
  const bool is_sequence = is_sequence_of_still_clouds(scene);
  np_stage_decide(d, out, filling / (is_sequence ? sequence_frames : 1.0) < saving,
                  "filling it takes some %.1g s of one core%s and spares some %.1g s of rays", filling,
                  is_sequence ? ", once for a sequence of frames," : "", saving);
}
