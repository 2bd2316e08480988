/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/motion.h"

#include "core/alloc.h"

/* A time between two poses. */
typedef struct pose_place {
  int pose;
  double share; /* share of the way to the next pose */
} pose_place;

static pose_place get_place(const np_motion *m, double time) {
  const double at = NP_MOTION_SPANS * (time - m->open) / (m->close - m->open);
  const int pose = (int)np_clamp(floor(at), 0.0, NP_MOTION_SPANS - 1);
  return (pose_place){pose, np_clamp(at - pose, 0.0, 1.0)};
}

/* ---- Camera ---- */

static double mix(double a, double b, double share) { return a == b ? a : a + share * (b - a); }
static float mix_float(float a, float b, double share) { return (float)mix((double)a, (double)b, share); }

static np_vec3 mix_axis(np_vec3 a, np_vec3 b, double share) {
  const np_dvec3 from = np_vec3_to_double(a), to = np_vec3_to_double(b);
  const np_dvec3 between = np_dvec3_add(from, np_dvec3_scale(np_dvec3_subtract(to, from), share));
  return np_dvec3_to_float(np_dvec3_normalize(between));
}

static void mix_cameras(const np_camera *a, const np_camera *b, double share, np_camera *out) {
  *out = *a;
  out->origin = np_dvec3_add(a->origin, np_dvec3_scale(np_dvec3_subtract(b->origin, a->origin), share));
  out->right = mix_axis(a->right, b->right, share);
  out->up = mix_axis(a->up, b->up, share);
  out->back = mix_axis(a->back, b->back, share);
  out->tan_half_width = mix_float(a->tan_half_width, b->tan_half_width, share);
  out->tan_half_height = mix_float(a->tan_half_height, b->tan_half_height, share);
  out->half_width_m = mix_float(a->half_width_m, b->half_width_m, share);
  out->half_height_m = mix_float(a->half_height_m, b->half_height_m, share);
  out->half_angle = mix_float(a->half_angle, b->half_angle, share);
  for (int k = 0; k < 2; k++) out->shift[k] = mix_float(a->shift[k], b->shift[k], share);
  out->lens_radius_m = mix_float(a->lens_radius_m, b->lens_radius_m, share);
  out->focus_m = mix_float(a->focus_m, b->focus_m, share);
  out->near_m = mix(a->near_m, b->near_m, share);
  out->far_m = mix(a->far_m, b->far_m, share);
}

void np_motion_get_camera(const np_motion *motion, double time, np_camera *out) {
  const pose_place at = get_place(motion, time);
  mix_cameras(&motion->camera[at.pose], &motion->camera[at.pose + 1], at.share, out);
}

/* ---- Clouds ---- */

static np_affine mix_affines(const np_affine *a, const np_affine *b, double share) {
  np_affine out;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) out.m[row][column] = mix(a->m[row][column], b->m[row][column], share);
  return out;
}

/* Sets the velocities of bricks for a time. */
static const np_bricks *move_bricks(const np_moving_bricks *moving, double time_s, np_bricks *bricks,
                                    np_brick_motion *motion) {
  *motion = moving->motion;
  motion->time_s = (float)time_s;
  *bricks = moving->bricks;
  bricks->motion = motion;
  return bricks;
}

static void move_cloud(const np_motion *m, unsigned index, double time, np_moved_light *out) {
  np_instance *cloud = &out->clouds[index];
  const np_cloud_motion *own = &m->clouds[cloud->number];
  if (own->is_rigid) {
    const pose_place at = get_place(m, time);
    const np_affine to_frame = mix_affines(&own->to_frame[at.pose], &own->to_frame[at.pose + 1], at.share);
    cloud->world_to_index = np_affine_compose(&cloud->world_to_index, &to_frame);
  }
  const np_moving_bricks *part = own->parts[cloud->part] ? own->parts[cloud->part] : own->density;
  if (part) cloud->bricks = move_bricks(part, time * own->velocity_s, &out->bricks[index], &out->motions[index]);
  if (own->is_rigid || own->density) cloud->index_to_frame = &own->part_to_frame[cloud->part];
}

static void move_emitter(const np_motion *m, unsigned index, double time, np_moved_light *out) {
  np_emitter *emitter = &out->emitters[index];
  const np_cloud_motion *own = &m->clouds[emitter->number];
  if (own->is_rigid) {
    const pose_place at = get_place(m, time);
    const np_affine to_frame = mix_affines(&own->to_frame[at.pose], &own->to_frame[at.pose + 1], at.share);
    np_affine from_frame;
    if (!np_affine_invert(&to_frame, &from_frame)) return;
    emitter->world_to_index = np_affine_compose(&emitter->world_to_index, &to_frame);
    emitter->index_to_world = np_affine_compose(&from_frame, &emitter->index_to_world);
    emitter->world_to_temperature = np_affine_compose(&emitter->world_to_temperature, &to_frame);
  }
  const double time_s = time * own->velocity_s;
  const np_moving_bricks *field = own->parts[emitter->part] ? own->parts[emitter->part] : own->density;
  if (field) emitter->bricks = move_bricks(field, time_s, &out->emitting[index][0], &out->emitting_motions[index][0]);
  if (own->temperature && emitter->temperature)
    emitter->temperature =
        move_bricks(own->temperature, time_s, &out->emitting[index][1], &out->emitting_motions[index][1]);
}

static void move_emission(const np_motion *m, double time, np_moved_light *out) {
  out->emission = *out->world.emission;
  out->emission.emitters = out->emitters;
  for (unsigned i = 0; i < out->emission.emitter_count; i++) {
    out->emitters[i] = out->world.emission->emitters[i];
    move_emitter(m, i, time, out);
  }
  out->world.emission = &out->emission;
}

void np_motion_move(const np_motion *motion, const np_packet_light *light, double time, np_moved_light *out) {
  out->world = light->world;
  out->lighting = light->lighting;
  for (unsigned i = 0; i < out->world.clouds.count; i++) {
    out->clouds[i] = light->world.clouds.at[i];
    move_cloud(motion, i, time, out);
  }
  out->world.clouds.at = out->clouds;
  if (out->world.emission) move_emission(motion, time, out);
  if (!light->lighting.reflection) return;
  out->reflection = *light->lighting.reflection;
  out->reflection.world.clouds = out->world.clouds;
  out->reflection.world.emission = out->world.emission;
  out->lighting.reflection = &out->reflection;
}

void np_motion_destroy(np_motion *motion) {
  if (!motion) return;
  for (unsigned i = 0; motion->clouds && i < motion->cloud_count; i++) {
    np_moving_bricks_destroy(motion->clouds[i].density);
    np_moving_bricks_destroy(motion->clouds[i].temperature);
    for (int k = 0; k < NP_CLOUD_EMITTERS_MAX; k++) np_moving_bricks_destroy(motion->clouds[i].parts[k]);
  }
  np_alloc_free(motion->context, motion->clouds);
  np_alloc_free(motion->context, motion);
}
