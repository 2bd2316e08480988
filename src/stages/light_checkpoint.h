/* SPDX-License-Identifier: Apache-2.0 */
/* Unfinished solutions of multiple scattering, stored with a picture's checkpoint: in the cache, if there is one, so
 * that any process can resume them; else in files beside the checkpoint, which hold the whole solution when it is
 * finished. */
#ifndef NP_STAGES_LIGHT_CHECKPOINT_H
#define NP_STAGES_LIGHT_CHECKPOINT_H

#include "stages/stage_part.h"

/* Kind of cache entries that hold unfinished solutions. */
#define NP_LIGHT_STATE_KIND "lightstate"

typedef struct np_light_checkpoint {
  neph_context *context;
  np_monitor *monitor;
  bool is_resumed;
  char key[33];
  char *path;                /* NULL: in the cache */
  np_solution_keeper keeper; /* the solver calls it */
  double start_s;
} np_light_checkpoint;

/* Opens the checkpoint of a picture that keeps them, under the key of its solution. False: there is no memory. Else it
 * is to be closed. */
bool np_light_checkpoint_open(const np_stage_part *in, const char key[33], np_light_checkpoint *out);

/* A solution that an earlier process has found; NULL: none. */
np_scattering_field *np_light_checkpoint_load(np_light_checkpoint *checkpoint, const np_world *world);

/* Saves a solution beside the picture's checkpoint, unless it is quick to recompute or stored in the cache. */
void np_light_checkpoint_save(np_light_checkpoint *checkpoint, const np_scattering_field *field);

void np_light_checkpoint_close(np_light_checkpoint *checkpoint);

#endif
