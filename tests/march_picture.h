/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of one cloud in light scattered once, by which the march's error is measured against its look-ups of
 * density.
 *
 * One ray a pixel through its middle, so that nothing but steps makes an error, which is the rms over all pixels,
 * relative to the rms of the picture. The reference is a march of eight midpoint steps a voxel, each lit through the
 * exact integral of the trilinear field.
 *
 * The baseline, jittered exponential Euler, goes through the cloud's box in steps of one length, shifted by one random
 * number a ray, takes the density at one point of each, and marches towards the sun likewise from wherever it is not
 * zero. Both of its marches end where less than 0.1 % is left. It does not skip empty space; its look-ups outside empty
 * bricks are counted beside.
 */
#ifndef NP_MARCH_PICTURE_H
#define NP_MARCH_PICTURE_H

#include "integrate/integrator.h"

enum { MARCH_PIXELS_MAX = 96 * 64 };

void np_march_sample_counted(const np_world *world, const np_lighting *lighting, const np_integrator_settings *settings,
                             const np_camera_ray *ray, np_random *random, np_integrator_sample *out);

/* A cloud in voxels of 1 m, index space being the world, seen along x from outside its box. Not to be copied: it holds
 * pointers to its own parts. */
typedef struct march_picture {
  np_instance cloud;
  np_world world; /* its sun has an irradiance of 1 */
  np_lighting lighting;
  double low[3], high[3]; /* corners of the box */
  int up;                 /* axis: 1 or 2 */
  unsigned width, height; /* MARCH_PIXELS_MAX pixels at most */
  np_camera_ray rays[MARCH_PIXELS_MAX];
  double phase[MARCH_PIXELS_MAX], reference[MARCH_PIXELS_MAX]; /* phase function of sunlight; radiance */
  double rms;
} march_picture;

/* Sets the cloud, with the phase function of HG 0.85; its box, size and axis are left to the caller. */
void march_picture_init(march_picture *picture, const np_bricks *bricks, float extinction_per_value);

/* Places camera and sun, its azimuth counted from the line of sight, and computes the reference. */
void march_picture_light(march_picture *picture, double elevation_rad, double azimuth_rad);

/* Look-ups of one picture for a pixel, and its error. */
typedef struct march_point {
  double lookups, useful, error; /* all look-ups; those in bricks that are not empty */
} march_point;

march_point march_picture_measure(const march_picture *picture, float tolerance);
march_point march_picture_measure_euler(const march_picture *picture, double step, double light_step);

/* Fewest look-ups of some points that have an error, between two of them by a power law; NAN where none gets there. */
double march_points_compute_lookups(const march_point *points, int count, double error, bool is_useful);

/* Optical depth of a cloud along a ray, the trilinear field integrated exactly. */
double march_compute_depth(const np_instance *cloud, np_dvec3 origin, np_vec3 direction);

#endif
