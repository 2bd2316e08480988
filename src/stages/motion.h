/* SPDX-License-Identifier: Apache-2.0 */
/* Motion of camera and clouds about a frame: the world at the time of a ray, and its place a frame earlier and later.
 *
 * Times are frames from the frame's own. Poses are evaluated at even times of the exposure and interpolated linearly
 * between them; clouds with velocities move by those beyond (volume/brick_motion.h). Each ray has its own camera, and a
 * copy of the world in which the clouds are where they are at its time: light, tables and caches are the frame's.
 */
#ifndef NP_STAGES_MOTION_H
#define NP_STAGES_MOTION_H

#include "integrate/integrator.h"
#include "stages/packet.h"
#include "volume/brick_motion.h"

enum { NP_MOTION_SPANS = 32, NP_MOTION_POSES = NP_MOTION_SPANS + 1 };

typedef struct np_cloud_motion {
  bool is_rigid;                       /* it moves as a whole */
  np_affine to_frame[NP_MOTION_POSES]; /* maps the world at a pose to the world at the frame's time */
  np_affine next, previous;            /* map the world at the frame's time to the world a frame later and earlier */
  double velocity_s;                   /* time of a frame, for its velocities */
  np_affine part_to_frame[NP_TINT_PARTS_MAX]; /* maps the voxels of each of its colours or levels to the frame, … */
  np_affine frame_to_part[NP_TINT_PARTS_MAX]; /* … and its inverse */
  np_moving_bricks *density, *temperature;    /* NULL: without velocities */
  np_moving_bricks *parts[NP_CLOUD_EMITTERS_MAX]; /* bricks of each colour, if a cloud has several, and of emitters */
} np_cloud_motion;

typedef struct np_motion {
  neph_context *context;
  bool has_exposure;           /* something moves while the shutter is open; false: motion vectors only */
  bool has_camera, has_clouds; /* they move while the shutter is open */
  double open, close;
  np_camera camera[NP_MOTION_POSES], now, next, previous;
  unsigned cloud_count;
  np_cloud_motion *clouds; /* one for each cloud of the scene */
} np_motion;

/* The camera at a time of the exposure. */
void np_motion_get_camera(const np_motion *motion, double time, np_camera *out);

/* A light's world at a time of the exposure. */
typedef struct np_moved_light {
  np_world world;
  np_lighting lighting;
  np_reflection reflection;
  np_instance clouds[NP_INSTANCES_MAX];
  np_bricks bricks[NP_INSTANCES_MAX];
  np_brick_motion motions[NP_INSTANCES_MAX];
  np_emission emission;
  np_emitter emitters[NP_INSTANCES_MAX];
  np_bricks emitting[NP_INSTANCES_MAX][2]; /* flames or clouds, and temperatures */
  np_brick_motion emitting_motions[NP_INSTANCES_MAX][2];
} np_moved_light;

void np_motion_move(const np_motion *motion, const np_packet_light *light, double time, np_moved_light *out);

/* Mean motion of the visible points of a ray, in pixels right and up, to the next and from the previous frame. */
typedef struct np_motion_vectors {
  float forward[2], backward[2];
} np_motion_vectors;

np_motion_vectors np_motion_compute_vectors(const np_motion *motion, const np_world *world, const np_camera_ray *ray,
                                            const np_integrator_sample *sample, double time);

void np_motion_destroy(np_motion *motion);

#endif
