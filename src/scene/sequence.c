/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/sequence.h"

#include <math.h>
#include <string.h>

#include "core/frame_name.h"
#include "scene/animation.h"

bool np_scene_cloud_is_sequence(const np_scene_cloud *cloud) {
  return cloud->vdb && !cloud->is_baked && np_frame_name_is_pattern(cloud->vdb);
}

bool np_scene_cloud_has_steps(const np_scene_cloud *cloud) { return cloud->is_model && isinf(cloud->model_step); }

double np_scene_cloud_get_number(const np_scene_cloud *cloud, double frame) {
  return 1.0 + cloud->frame_speed * (frame - 1.0) + cloud->frame_offset;
}

static bool has_moving_clouds(const neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    if (np_scene_cloud_is_sequence(cloud) || np_scene_cloud_has_steps(cloud) ||
        (cloud->is_baked && cloud->frame_time_s != 0.0))
      return true;
    if (cloud->is_baked && cloud->map_image && np_frame_name_is_pattern(cloud->map_image)) return true;
    if (cloud->is_baked && cloud->map.file && np_frame_name_is_pattern(cloud->map.file)) return true;
  }
  return false;
}

static bool has_moving_sun(const neph_scene *scene) {
  return scene->sun.time.is_given && scene->sun.frame_time_s != 0.0;
}

bool np_scene_is_sequence(const neph_scene *scene) {
  return scene->animation || has_moving_clouds(scene) || has_moving_sun(scene);
}

bool np_scene_has_history(const neph_scene *scene) {
  return scene->render.history != NP_HISTORY_NONE && np_scene_is_sequence(scene);
}

/* Frames before frame 1 are in blocks, too. */
int np_scene_get_history_first(const neph_scene *scene, int frame) {
  const int64_t block = scene->render.history_frames, place = ((int64_t)frame - 1) % block;
  return (int)(frame - (place < 0 ? place + block : place));
}

bool np_scene_has_still_light(const neph_scene *scene) {
  if (has_moving_clouds(scene) || has_moving_sun(scene)) return false;
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++)
    if (!np_track_is_in(&scene->animation->tracks[i], "camera.")) return false;
  return true;
}

static bool is_of_light_or_camera(const np_track *track) {
  static const char *const paths[] = {"camera.",  "output.",        "sun.elevation", "sun.azimuth",
                                      "sun.time", "moon.elevation", "moon.azimuth",  "stars.sidereal_time"};
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
    if (np_track_is_in(track, paths[i])) return true;
  return false;
}

/* Whether a track is constant between two frames: at both ends and at all keys between. */
static bool is_constant(const np_track *track, double first, double last) {
  bool is_same = true;
  for (unsigned i = 0; i < track->value_count; i++) {
    const double value = np_track_eval(track, i, first);
    is_same = is_same && np_track_eval(track, i, last) == value;
    for (unsigned k = 0; k < track->key_count; k++)
      if (track->frames[k] > first && track->frames[k] < last)
        is_same = is_same && track->values[k * track->value_count + i] == value;
  }
  return is_same;
}

bool np_scene_stays_between(const neph_scene *scene, int first, int last) {
  if (has_moving_clouds(scene)) return false;
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++) {
    const np_track *track = &scene->animation->tracks[i];
    if (!is_of_light_or_camera(track) && !is_constant(track, first, last)) return false;
  }
  return true;
}

/* ---- Extent of the camera ---- */

/* Range of one number of a track; no interpolation exceeds its key values. */
static void get_range(const np_track *track, unsigned index, double *out_min, double *out_max) {
  *out_min = HUGE_VAL;
  *out_max = -HUGE_VAL;
  for (unsigned k = 0; k < track->key_count; k++) {
    *out_min = fmin(*out_min, track->values[k * track->value_count + index]);
    *out_max = fmax(*out_max, track->values[k * track->value_count + index]);
  }
}

static void add_position(const np_track *track, np_scene_reach *reach) {
  for (unsigned i = 0; i < track->value_count; i++) {
    const unsigned axis = track->component == NP_TRACK_ALL ? i : (unsigned)track->component;
    get_range(track, i, &reach->camera_min_m[axis], &reach->camera_max_m[axis]);
  }
}

/* Narrows the angle of view: the least fov, or the longest focal length. */
static void add_lens(const np_track *track, np_scene_camera *narrowest) {
  const struct {
    const char *path;
    double *value;
    bool is_greatest;
  } rows[] = {{"camera.fov", &narrowest->fov_rad, false},
              {"camera.fisheye_fov", &narrowest->fisheye_fov_rad, false},
              {"camera.focal_length", &narrowest->focal_length_m, true},
              {"camera.sensor", &narrowest->sensor_m, false},
              {"camera.orthographic_width", &narrowest->orthographic_width_m, false}};
  double low, high;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    if (strcmp(track->path, rows[i].path) != 0) continue;
    get_range(track, 0, &low, &high);
    *rows[i].value = rows[i].is_greatest ? high : low;
  }
}

static void add_target(const np_track *track, np_scene_camera *narrowest) {
  double high;
  for (unsigned i = 0; i < track->value_count; i++)
    get_range(track, i, &narrowest->look_at_m[track->component == NP_TRACK_ALL ? i : (unsigned)track->component],
              &high);
}

void np_scene_derive_reach(neph_scene *scene) {
  np_scene_reach *reach = &scene->reach;
  *reach = (np_scene_reach){.narrowest = scene->camera};
  memcpy(reach->camera_min_m, scene->camera.position_m, sizeof reach->camera_min_m);
  memcpy(reach->camera_max_m, scene->camera.position_m, sizeof reach->camera_max_m);
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++) {
    const np_track *track = &scene->animation->tracks[i];
    if (!strcmp(track->path, "camera.position")) add_position(track, reach);
    if (!strcmp(track->path, "camera.look_at")) add_target(track, &reach->narrowest);
    add_lens(track, &reach->narrowest);
  }
  memcpy(reach->narrowest.position_m, reach->camera_min_m, sizeof reach->camera_min_m);
}
