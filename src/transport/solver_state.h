/* SPDX-License-Identifier: Apache-2.0 */
/* A solution on its way, kept from sweep to sweep: one that goes on from there has the bits of one that was not
 * stopped.
 *
 * Whatever changes a solution is a step. A state has the number of the step that was under way and all that steps have
 * changed; who resumes goes through the same steps, leaves out those before, and takes the state up at this one. All
 * else, such as cells and sources, is computed again. */
#ifndef NP_TRANSPORT_SOLVER_STATE_H
#define NP_TRANSPORT_SOLVER_STATE_H

#include "transport/fixed_point.h"
#include "transport/scattering_field.h"

struct np_scattering_solver;

typedef struct np_solver_state {
  const np_solution_keeper *keeper; /* NULL: nothing is kept */
  np_cache_entry entry;             /* that the solution goes on from, open up to its step */
  unsigned step, resumed;           /* the present one, from 1; and that of the entry, 0: there is none */
  unsigned restart;                 /* the step from which a cancelled solution can go on; 0: there is none */
  bool has_fine;                    /* the result's grid has light, beyond the one that is iterated */
  bool has_history;                 /* the entry goes on with that of an iteration */
  bool is_damaged;                  /* the entry holds something else than the solution */
  bool is_last;                     /* the last state is kept */
  double last_s;                    /* of the monitor's seconds, when a state was kept */
} np_solver_state;

/* Opens the state that the keeper has, if it has one. */
void np_solver_state_open(struct np_scattering_solver *s);

typedef enum np_step_kind {
  NP_STEP_RESTARTABLE, /* whatever cuts it short, it can be begun again */
  NP_STEP_WITHIN,      /* cut short, the last restartable step can be */
  NP_STEP_FRAGILE      /* cut short, nothing can be begun again but what an iteration has kept */
} np_step_kind;

/* Begins a step, and keeps a state where one is due; false: the step is one of those that are left out. */
bool np_solver_state_begin(struct np_scattering_solver *s, np_step_kind kind);

/* Keeps what was there when the last restartable step began, of a solution that was cancelled. */
void np_solver_state_keep_last(struct np_scattering_solver *s);

void np_solver_state_close(struct np_scattering_solver *s);

/* Keeps iterations, with the solver as `user`. */
bool np_solver_state_load_history(void *user, np_fixed_point *problem, np_fixed_point_history *history);
void np_solver_state_save_history(void *user, const np_fixed_point *problem, const np_fixed_point_history *history,
                                  bool is_last);

#endif
