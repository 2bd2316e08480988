/* SPDX-License-Identifier: Apache-2.0 */
/* The clouds of a world that multiple scattering is solved for. */
#ifndef NP_TRANSPORT_SOLVED_CLOUDS_H
#define NP_TRANSPORT_SOLVED_CLOUDS_H

#include "transport/scattering_field.h"

typedef struct np_solved_clouds {
  neph_context *context;             /* borrowed */
  np_instance *at;                   /* the clouds that are solved for; NULL: all are */
  unsigned number[NP_INSTANCES_MAX]; /* number of each in the whole world */
  np_world world;                    /* the world with these clouds alone; it borrows all but `at` */
} np_solved_clouds;

/* Lists the clouds that are solved for. In a world with placed clouds these are all clouds, or none. */
neph_result np_solved_clouds_list(neph_context *context, const np_world *world, uint64_t left_out,
                                  np_solved_clouds *out);
void np_solved_clouds_clear(np_solved_clouds *solved);

#endif
