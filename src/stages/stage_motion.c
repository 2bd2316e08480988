/* SPDX-License-Identifier: Apache-2.0 */
/* Motion of camera and clouds about the frame: poses by the scene's tracks, winds of baked clouds, velocities of files.
 */
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "plan/placement.h"
#include "plan/plan_motion.h"
#include "scene/scene_pose.h"
#include "stages/motion.h"
#include "stages/stage_part.h"
#include "volume/volume_tint.h"

/* ---- Camera ---- */

static double get_time(const np_motion *m, int pose) { return m->open + (m->close - m->open) * pose / NP_MOTION_SPANS; }

static neph_result make_camera(const np_motion_inputs *in, const np_scene_pose *pose, np_camera *out) {
  const neph_render_desc *desc = &in->plan->request.desc;
  return np_camera_make(in->scene->context, &pose->camera, desc->width, desc->height, desc->eye, out);
}

/* Pixels between the pictures of a place before the camera, in the middle and towards the corners, by two cameras. */
static double compute_shift(const np_camera *from, const np_camera *to, double distance_m) {
  double most = 0.0;
  for (int k = 0; k < 5; k++) {
    const double x = from->width * (k == 4  ? 0.5
                                    : k & 1 ? 0.9
                                            : 0.1),
                 y = from->height * (k == 4  ? 0.5
                                     : k & 2 ? 0.9
                                             : 0.1);
    np_film_ray ray;
    double film[2], depth;
    if (!np_camera_start_ray(from, (float)x, (float)y, 0.5f, 0.0f, &ray)) continue;
    if (!np_camera_project(to, np_dvec3_along(ray.origin, ray.direction, distance_m), film, &depth)) continue;
    most = fmax(most, hypot(film[0] - x, film[1] - y));
  }
  return most;
}

/* Lines between the poses err by a quarter of their error over twice the distance. */
static void describe_camera(const np_motion_inputs *in, const np_motion *m) {
  const double distance_m = np_scene_camera_get_target_m(&in->scene->camera);
  double error = 0.0;
  np_motion coarse = *m;
  for (int k = 1; k < NP_MOTION_POSES; k += 2) {
    np_camera between;
    coarse.camera[0] = m->camera[k - 1];
    coarse.camera[1] = m->camera[k + 1];
    coarse.open = 0.0;
    coarse.close = NP_MOTION_SPANS;
    np_motion_get_camera(&coarse, 0.5, &between);
    error = fmax(error, 0.25 * compute_shift(&m->camera[k], &between, distance_m));
  }
  np_log(m->context, NEPH_LOG_INFO,
         "the camera moves by up to %.3g pixels while the shutter is open, interpolated from %d poses to %.2g",
         compute_shift(&m->camera[0], &m->camera[NP_MOTION_SPANS], distance_m), (int)NP_MOTION_POSES, error);
}

/* ---- Clouds ---- */

/* Three grids of each level of detail, from the finest on; nothing of a cloud without velocities. */
typedef struct cloud_velocity {
  np_sparse_grid grids[NP_VELOCITY_GRIDS_MAX];
  unsigned level_count;
} cloud_velocity;

typedef struct moving_cloud {
  const np_motion_inputs *in;
  np_motion *motion;
  unsigned number;
  const np_scene_cloud *cloud;
  const np_cloud_parts *parts;
  np_cloud_motion *out;
  const cloud_velocity *velocity; /* NULL: none has been read */
} moving_cloud;

static moving_cloud choose_cloud(const np_motion_inputs *in, np_motion *m, unsigned number) {
  return (moving_cloud){in, m, number, &in->scene->clouds[number], &in->clouds->at[number], &m->clouds[number], NULL};
}

/* Maps the file to the world in a pose. Files of a sequence depend on the box of another frame: they are moved, not
 * turned.
 */
static neph_result place(const moving_cloud *c, const np_cloud_pose *pose, np_affine *out) {
  np_scene_cloud moved = *c->cloud;
  moved.density_unit = NP_DENSITY_EXTINCTION; /* which is not looked for */
  moved.has_position = pose->has_position;
  memcpy(moved.position_m, pose->position_m, sizeof moved.position_m);
  if (!np_scene_cloud_is_sequence(c->cloud)) {
    moved.rotation_rad = pose->rotation_rad;
    memcpy(moved.tilt_rad, pose->tilt_rad, sizeof moved.tilt_rad);
    memcpy(moved.scale, pose->scale, sizeof moved.scale);
    memcpy(moved.pivot_point, pose->pivot_point, sizeof moved.pivot_point);
    moved.voxel_m = pose->voxel_m;
  }
  np_anchor anchor;
  const neph_result result = np_placement_anchor(&moved, c->parts->volume, c->in->monitor, &anchor);
  *out = anchor.file_to_world;
  const np_georeference *georeference = &c->parts->georeference;
  if (georeference->is_applied) *out = np_affine_compose(&georeference->to_world, out);
  return result;
}

static np_affine make_shift(const double wind_m_s[2], double time_s) {
  np_affine shift = np_affine_identity();
  for (int a = 0; a < 2; a++) shift.m[a][3] = wind_m_s[a] * time_s;
  return shift;
}

/* Maps the world of the frame to the world of a pose, `time` frames away: by the tracks, and, within the cloud, its
 * wind. Of a cloud that stays it is the identity, to the bit. */
static neph_result make_move(const moving_cloud *c, const np_cloud_pose *pose, double time, np_affine *out) {
  const np_scene_cloud *cloud = c->cloud;
  const np_cloud_pose own = np_cloud_pose_get(cloud);
  np_affine rest, placed, inverse;
  *out = np_affine_identity();
  neph_result result = place(c, &own, &rest);
  if (!result) result = place(c, pose, &placed);
  if (result) return result;
  if (np_plan_has_wind(cloud)) {
    const np_affine shift = make_shift(cloud->bake.wind_m_s, cloud->frame_time_s * time);
    placed = np_affine_compose(&placed, &shift);
  }
  if (!memcmp(rest.m, placed.m, sizeof rest.m)) return NEPH_OK;
  if (!np_affine_invert(&rest, &inverse))
    return np_fail(c->motion->context, NEPH_ERROR_BAD_SCENE, "cloud %s: its transform cannot be inverted", cloud->name);
  *out = np_affine_compose(&placed, &inverse);
  return NEPH_OK;
}

/* Copies stand still while the shutter is open. */
static neph_result refuse_places(const moving_cloud *c, const char *reason) {
  return np_fail(c->motion->context, NEPH_ERROR_BAD_SCENE,
                 "cloud %s: it has places, which stand still during a frame, but %s: leave out places, or "
                 "camera.motion_blur and the motion output, or set velocity: none",
                 c->cloud->name, reason);
}

/* The moves of one pose; the next frame's and the previous frame's follow the poses of the exposure. */
static neph_result add_pose(const moving_cloud *c, const np_scene_pose *pose, double time, int number) {
  const np_affine still = np_affine_identity();
  np_affine move;
  const neph_result result = make_move(c, &pose->clouds[c->number], time, &move);
  if (result) return result;
  if (c->cloud->place_count > 0 && memcmp(move.m, still.m, sizeof move.m) != 0)
    return refuse_places(c, "its keys are animated");
  if (number == NP_MOTION_POSES) c->out->next = move;
  if (number == NP_MOTION_POSES + 1) c->out->previous = move;
  if (number >= NP_MOTION_POSES) return NEPH_OK;
  c->out->is_rigid = c->out->is_rigid || memcmp(move.m, still.m, sizeof move.m) != 0;
  if (!np_affine_invert(&move, &c->out->to_frame[number])) c->out->to_frame[number] = still;
  return NEPH_OK;
}

static neph_result add_poses(const np_motion_inputs *in, np_motion *m, const np_scene_pose *pose, double time,
                             int number) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < m->cloud_count && !result; i++) {
    const moving_cloud c = choose_cloud(in, m, i);
    if (c.parts->volume) result = add_pose(&c, pose, time, number);
  }
  return result;
}

/* ---- Velocities ---- */

static neph_result move_bricks(const moving_cloud *c, const neph_volume *volume, const np_bricks *rest,
                               np_moving_bricks **out) {
  const np_motion *m = c->motion;
  const np_brick_motion_desc desc = {.rest = rest,
                                     .index_to_file = volume->index_to_world,
                                     .velocity = c->velocity->grids,
                                     .level_count = c->velocity->level_count,
                                     .scale = c->cloud->velocity_scale,
                                     .begin_s = m->has_exposure ? m->open * c->out->velocity_s : 0.0,
                                     .end_s = m->has_exposure ? m->close * c->out->velocity_s : 0.0};
  return np_moving_bricks_build(m->context, &desc, c->in->monitor, out);
}

static neph_result move_volume(const moving_cloud *c, const neph_volume *volume, np_moving_bricks **out) {
  return volume ? move_bricks(c, volume, &volume->bricks, out) : NEPH_OK;
}

/* Moves the bricks of a cloud's colours or levels, and of its emitters. */
static neph_result move_parts(const moving_cloud *c) {
  const np_cloud_emission *emission = &c->parts->emission;
  const neph_volume *cloud = c->parts->volume;
  const unsigned count = np_volume_count_parts(cloud);
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < count && count > 1 && !result; k++)
    result = move_bricks(c, np_volume_get_part(cloud, k), np_cloud_parts_get_bricks(c->parts, k), &c->out->parts[k]);
  if (!result) result = move_volume(c, emission->flame, &c->out->parts[NP_EMITTER_FLAME]);
  for (int k = 0; k < 3 && !result; k++)
    result = move_volume(c, emission->color[k], &c->out->parts[NP_EMITTER_COLOR + k]);
  return result;
}

static void describe_velocity(const moving_cloud *c) {
  if (!(c->in->scene->frame_rate > 0.0))
    np_log(c->motion->context, NEPH_LOG_WARNING,
           "cloud %s: moves by its velocities at 24 frames a second: the scene has no frame_rate", c->cloud->name);
  np_log(c->motion->context, NEPH_LOG_INFO,
         "cloud %s: its velocities move it by up to %.3g voxels from the frame's time; %zu bricks, %.3g MB",
         c->cloud->name, (double)c->out->density->reach, c->out->density->bricks.brick_count,
         6e-6 * NP_BRICK_STRIDE * (double)c->out->density->bricks.brick_count);
}

static neph_result build_velocity(moving_cloud *c, const char *path) {
  cloud_velocity velocity = {.level_count = 0};
  const np_vector_request request = {NP_VECTOR_VELOCITY, c->cloud->velocity, c->cloud->policy};
  neph_result result = np_volume_load_velocities(c->motion->context, path, &request, c->in->monitor, velocity.grids,
                                                 &velocity.level_count);
  const bool is_found = velocity.level_count > 0;
  c->velocity = &velocity;
  if (!result && is_found && c->cloud->place_count > 0) result = refuse_places(c, "its file has velocities");
  if (!result && is_found) {
    const neph_volume *volume = c->parts->volume;
    const np_bricks *density =
        np_volume_count_parts(volume) > 1 ? &volume->bricks : np_cloud_parts_get_bricks(c->parts, 0);
    result = move_bricks(c, volume, density, &c->out->density);
    if (!result) result = move_volume(c, c->parts->emission.temperature, &c->out->temperature);
    if (!result) result = move_parts(c);
  }
  for (int g = 0; g < NP_VELOCITY_GRIDS_MAX; g++) np_sparse_grid_clear(&velocity.grids[g]);
  c->velocity = NULL;
  if (!result && c->out->density) describe_velocity(c);
  return result;
}

static neph_result add_velocity(const np_motion_inputs *in, np_motion *m, unsigned number) {
  np_stage_part part = in->part;
  part.cloud = number;
  moving_cloud c = choose_cloud(in, m, number);
  c.out->velocity_s = np_scene_get_frame_s(in->scene);
  if (np_scene_cloud_is_sequence(c.cloud)) c.out->velocity_s *= c.cloud->frame_speed;
  if (!c.parts->volume) return NEPH_OK;
  for (unsigned k = 0; k < np_volume_count_parts(c.parts->volume); k++) {
    np_affine *to_index = &c.out->frame_to_part[k];
    *to_index = np_cloud_parts_get_world_to_index(c.parts, k, &c.parts->placed.world_to_index);
    (void)np_affine_invert(to_index, &c.out->part_to_frame[k]);
  }
  if (!np_plan_has_velocity(c.cloud)) return NEPH_OK;
  np_cloud_file file;
  neph_result result = np_stage_get_cloud_file(&part, &file);
  if (!result && file.path) result = build_velocity(&c, file.path);
  np_alloc_free(m->context, file.path);
  return result;
}

/* ---- The stage ---- */

static neph_result build_pose(const np_motion_inputs *in, np_motion *m, double time, int number, np_camera *out) {
  np_scene_pose pose;
  neph_result result = np_scene_pose_eval(in->scene, time, &pose);
  if (!result) result = make_camera(in, &pose, out);
  if (!result) result = add_poses(in, m, &pose, time, number);
  np_scene_pose_clear(m->context, &pose);
  return result;
}

static neph_result build(const np_motion_inputs *in, np_motion *m) {
  m->now = *in->camera;
  neph_result result = build_pose(in, m, 1.0, NP_MOTION_POSES, &m->next);
  if (!result) result = build_pose(in, m, -1.0, NP_MOTION_POSES + 1, &m->previous);
  for (int k = 0; k < NP_MOTION_POSES && m->has_exposure && !result; k++)
    result = build_pose(in, m, get_time(m, k), k, &m->camera[k]);
  for (unsigned i = 0; i < m->cloud_count && !result; i++) result = add_velocity(in, m, i);
  for (unsigned i = 0; i < m->cloud_count && !result && m->has_exposure; i++)
    m->has_clouds = m->has_clouds || m->clouds[i].is_rigid || m->clouds[i].density;
  if (!result && m->has_camera) describe_camera(in, m);
  return result;
}

static neph_result build_motion(const np_motion_inputs *in, np_motion **out) {
  np_motion *m = *out = np_alloc(in->context, 1, sizeof *m);
  if (!m) return NEPH_ERROR_OUT_OF_MEMORY;
  m->context = in->context;
  m->has_exposure = in->scene->motion_blur.is_enabled;
  m->has_camera = m->has_exposure && np_scene_has_camera_tracks(in->scene);
  np_scene_get_exposure(in->scene, &m->open, &m->close);
  m->cloud_count = in->clouds->count;
  m->clouds = np_alloc(in->context, m->cloud_count, sizeof *m->clouds);
  np_monitor_set_stage(in->monitor, "motion");
  return m->clouds ? build(in, m) : NEPH_ERROR_OUT_OF_MEMORY;
}

NP_STAGE_BUILD(motion, motion, task->picture->motion)

void np_stage_clear_motion(const np_stage_task *task) {
  np_motion_destroy(task->picture->motion);
  task->picture->motion = NULL;
}
