/* SPDX-License-Identifier: Apache-2.0 */
/* Cases of the Intercomparison of 3D Radiation Codes, phase 1 (Cahalan et al. 2005, "The I3RC: Bringing together the
 * most advanced radiative transfer tools for cloudy atmospheres", BAMS 86): the step cloud and the Landsat cloud, which
 * repeat without end over a black surface, without air. */
#ifndef NP_PROBE_I3RC_CASE_H
#define NP_PROBE_I3RC_CASE_H

#include "probe/plane_light.h"

/* An experiment of I3RC. In both cases the phase function is Henyey and Greenstein's with g = 0.85. */
typedef struct np_i3rc_experiment {
  double zenith_deg, albedo; /* zenith angle of the sun, single-scattering albedo */
} np_i3rc_experiment;

enum { NP_I3RC_EXPERIMENTS = 4 };

extern const np_i3rc_experiment np_i3rc_experiments[NP_I3RC_EXPERIMENTS];

/* Field of a case. Columns are x fastest, as the files have them. */
typedef struct np_i3rc_field {
  neph_context *context;
  unsigned size[3]; /* voxels */
  double voxel_m[3], base_m;
  double ground_m, top_m; /* heights of the planes of transmitted and reflected light */
  float *values;          /* extinction, 1/m; z fastest last: ((k·size[1]) + j)·size[0] + i */
} np_i3rc_field;

/* Columns that results are given in. */
void np_i3rc_field_get_columns(const np_i3rc_field *field, unsigned out_columns[2]);

/* Makes the field of case 1 or 3; the latter reads scene43.tau.128x128 and scene43.dz.128x128 in `folder`. */
neph_result np_i3rc_field_create(neph_context *context, int number, const char *folder, np_i3rc_field *out);
void np_i3rc_field_clear(np_i3rc_field *field); /* a zeroed field is allowed */

/* A field under the sun of an experiment, ready to be measured; the sun's irradiance on the level is 1. */
typedef struct np_i3rc_world np_i3rc_world;

neph_result np_i3rc_world_create(const np_i3rc_field *field, const np_i3rc_experiment *experiment,
                                 neph_integrator integrator, uint64_t seed, np_i3rc_world **out_world);
void np_i3rc_world_destroy(np_i3rc_world *world); /* NULL is allowed */
const np_plane_source *np_i3rc_world_get_source(const np_i3rc_world *world);

/* Reads `count` numbers separated by space; others, and any other number of them, are refused. */
neph_result np_i3rc_read_numbers(neph_context *context, const char *path, size_t count, double *out);

#endif
