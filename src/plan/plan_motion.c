/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan_motion.h"

#include <string.h>

#include "core/text.h"
#include "plan/stage_decisions.h"
#include "scene/scene_pose.h"

bool np_plan_has_velocity(const np_scene_cloud *cloud) {
  return cloud->vdb && !cloud->is_baked && !np_scene_is_none(cloud->velocity);
}

bool np_plan_has_wind(const np_scene_cloud *cloud) {
  const double *wind = cloud->bake.wind_m_s;
  return cloud->is_baked && cloud->frame_time_s != 0.0 && (wind[0] != 0.0 || wind[1] != 0.0);
}

/* Lists the moving parts of the scene, for the plan's reason; empty: nothing moves. */
static void describe_movers(const neph_scene *scene, char *out, size_t size) {
  unsigned by_wind = 0, by_velocity = 0;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    by_wind += np_plan_has_wind(&scene->clouds[i]);
    by_velocity += np_plan_has_velocity(&scene->clouds[i]);
  }
  const struct {
    bool is_moving;
    const char *name;
  } rows[] = {{np_scene_has_camera_tracks(scene), "the camera by its tracks"},
              {np_scene_has_cloud_tracks(scene), "clouds by their tracks"},
              {by_wind > 0, "baked clouds by their wind"},
              {by_velocity > 0, "clouds of files by their velocities"}};
  out[0] = '\0';
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    if (!rows[i].is_moving) continue;
    const size_t length = strlen(out);
    np_print(out + length, size - length, "%s%s", length ? ", " : "", rows[i].name);
  }
}

void np_stage_decide_motion(np_decision *d, np_stage_decision *out) {
  const bool is_open = d->scene->motion_blur.is_enabled, has_vectors = d->plan->request.aovs & NP_AOV_MOTION;
  char movers[160];
  describe_movers(d->scene, movers, sizeof movers);
  const bool is_needed = has_vectors || (is_open && movers[0]);
  if (!is_open && !has_vectors) {
    np_stage_decide(d, out, is_needed, "camera.motion_blur is none, and no output shows motion");
  } else if (!movers[0]) {
    np_stage_decide(d, out, is_needed, "%snothing moves", has_vectors ? "for motion vectors: " : "");
  } else {
    double open, close;
    np_scene_get_exposure(d->scene, &open, &close);
    char exposure[80] = "for motion vectors";
    if (is_open) np_print(exposure, sizeof exposure, "the shutter is open from %+.4g to %+.4g frames", open, close);
    np_stage_decide(d, out, is_needed, "%s: %s", exposure, movers);
  }
}
