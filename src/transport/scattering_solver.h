/* SPDX-License-Identifier: Apache-2.0 */
/* State of one solution of multiple scattering: levels of cells, and progress of each band. */
#ifndef NP_TRANSPORT_SCATTERING_SOLVER_H
#define NP_TRANSPORT_SCATTERING_SOLVER_H

#include "transport/scattering_field.h"
#include "transport/scattering_field_private.h"
#include "transport/ground_columns.h"
#include "transport/solved_clouds.h"
#include "transport/transport_level.h"

enum { NP_SCATTERING_LEVELS_MAX = 6 };

/* Sweeps that resolve a solution into more degrees, and that follow on fine cells: a third of either changes a picture
 * by a tenth of a per cent. */
enum { NP_RESOLVING_SWEEPS = 2, NP_REFINING_SWEEPS = 2 };

/* Directions of one degree, and the radiance that enters the box along them. */
typedef struct np_scattering_angles {
  np_ordinates ordinates;
  np_border border;
  np_transport_lights lights;
} np_scattering_angles;

/* Progress of the solution of a band. */
typedef struct np_scattering_reach {
  unsigned level;  /* the last that was swept; the number of levels: none */
  unsigned sweeps; /* sweeps of that level, where they were cut; 0: it reached its tolerance */
  double residual;
} np_scattering_reach;

/* ---- States ----
 *
 * A solution on its way is kept from sweep to sweep: one that goes on from there has the bits of one that was not
 * stopped. Whatever changes a solution is a step. A state has the number of the step that was under way and all that
 * steps have changed; a resumed solution goes through the same steps, leaves out those before, and takes the state up
 * at this one. All else, such as cells and sources, is computed again. */

typedef struct np_solver_state {
  const np_solution_keeper *keeper; /* where states are kept; NULL: nowhere */
  np_cache_entry entry;             /* state from which the solution continues, open up to its step */
  unsigned step, resumed;           /* number of the present step, from 1; step of the entry, 0: there is none */
  unsigned restart;                 /* number of the step from which a cancelled solution can be resumed; 0: none */
  bool has_fine;                    /* the finest level has a solution, not only the levels that are iterated */
  bool has_history;                 /* the entry of the cache also has the history of an unfinished iteration */
  bool is_damaged;                  /* the entry does not belong to this solution */
  bool is_anew;                     /* whatever the keeper has, the solution begins anew */
  bool is_last;                     /* the last state is kept */
  double last_s;                    /* time on the monitor's clock at which a state was kept */
} np_solver_state;

typedef struct np_scattering_solver {
  neph_context *context;
  const np_world *world;                    /* the world of the clouds that are solved for */
  const np_solved_clouds *solved;           /* clouds that are solved for, with their indices among all clouds */
  const np_world *all;                      /* the world with all clouds, whose shade counts */
  np_scaled_phase phases[NP_INSTANCES_MAX]; /* phase functions of the clouds that are solved for */
  const np_sun_optical_depth_source *depths;
  const np_scattering_desc *desc;
  np_monitor *monitor;
  np_scattering_field *out;
  np_scattering_angles *fine,
      *broad; /* directions of the result, and of the iteration; equal if the iteration has the result's degree */
  np_workspace workspace;
  bool is_related;     /* bands differ in their lights alone, and have one grid */
  bool is_nested;      /* the present band starts on the coarsest grid from zero */
  bool is_transferred; /* other bands take the change of light by the finer angular resolution from the first band */
  double sunlight[NP_BAND_COUNT], surroundings[NP_BAND_COUNT]; /* mean irradiances on a sphere in the cells */
  np_ground_columns ground;                                    /* ground within the finest cells */
  np_outflow outflow[NP_BAND_COUNT];
  bool has_outflow;             /* outflow of the present band is known */
  bool is_returned;             /* ground and air return so much of it that the finest level measures its own */
  double sources;               /* sum over the sources of the present band, before ground and air return any */
  float fade[NP_INSTANCES_MAX]; /* share of each of all cloud's depth that dims the beam where light is iterated */
  np_spectrum *sun;             /* irradiance at each active cell of the finest grid */
  double end_s;                 /* end of the sweeps of all bands on the monitor's clock; infinite: no limit */
  bool has_time;                /* the time budget of the present band is not used up */
  np_scattering_reach reached,
      cut; /* progress of the present band, and of the band that was cut, beyond which no later band goes */
  np_monitor_part whole;
  np_solver_state state;
  unsigned level_count, band, turn; /* the band, and its place in the order of solving */
  /* Levels from fine to coarse: the result's level; if it is fine, a level of cells twice as wide; if the iteration has
   * a lower degree, a level of that degree; then coarser ones. */
  np_transport_level levels[NP_SCATTERING_LEVELS_MAX];
} np_scattering_solver;

/* The finest that is iterated. */
static inline unsigned np_scattering_solver_get_iterated(const np_scattering_solver *s) {
  return (s->levels[0].grid.is_fine ? 1u : 0u) + (s->fine != s->broad ? 1u : 0u);
}

/* The outermost bands of grey clouds first: the one in the middle starts from both. */
static const unsigned char np_scattering_band_order[NP_BAND_COUNT] = {0, 2, 1};

/* The grids for the present band's albedo, on the cells that were placed. */
neph_result np_scattering_solver_build_levels(np_scattering_solver *s);
void np_scattering_solver_clear_levels(np_scattering_solver *s);

/* Updates the radiance of ground and air around the box by the present band's light that leaves the clouds. */
void np_scattering_solver_light_border(np_scattering_solver *s);

/* Solves for the present band. `is_first`: nothing is known yet of the levels' light. `sum` is that over the sources of
 * the band before, then of this one; 0: there is no light. */
neph_result np_scattering_solver_solve_band(np_scattering_solver *s, bool is_first, double *sum);

/* Keeps the iterated levels' light, where a further band starts from the present one. */
void np_scattering_solver_keep_first(np_scattering_solver *s);

/* Opens the kept state of a solution, if there is one. */
void np_solver_state_open(np_scattering_solver *s);

typedef enum np_step_kind {
  NP_STEP_RESTARTABLE, /* the step can be repeated after any interruption */
  NP_STEP_WITHIN,      /* after an interruption, the last restartable step must be repeated */
  NP_STEP_FRAGILE      /* the step cannot be repeated; only a kept iteration can be resumed */
} np_step_kind;

/* Begins a step, and stores a state if one is due. False: the step is skipped, because a resumed state is later, or
 * because the resumed state is damaged, when all steps are skipped. */
bool np_solver_state_begin(np_scattering_solver *s, np_step_kind kind);

/* Keeps, of a cancelled solution, the state at the beginning of the last restartable step. */
void np_solver_state_save_last(np_scattering_solver *s);

/* NEPH_ERROR_BAD_FILE where the solution went on from an entry that holds something else: it is refused, with its
 * warning, so that no other solution meets it. */
neph_result np_solver_state_check(np_scattering_solver *s);

void np_solver_state_close(np_scattering_solver *s);

/* Load and save an unfinished iteration (np_fixed_point_keeper); `user` is the solver. */
bool np_solver_state_load_history(void *user, np_fixed_point *problem, np_fixed_point_history *history);
void np_solver_state_save_history(void *user, const np_fixed_point *problem, const np_fixed_point_history *history,
                                  bool is_last);

/* Degrees of the spherical harmonics for a number of cells: of the iteration, and of the result. */
typedef struct np_scattering_degrees {
  unsigned iterated, resolved;
} np_scattering_degrees;

np_scattering_degrees np_scattering_desc_choose_degrees(const np_scattering_desc *desc, double cells, bool is_layered,
                                                        bool is_fine_wanted);

/* Importance of cells, which guides paths: integrate/guide.h says how. */

/* Adds one band, of the share `share` in the mean, of a solution whose sharpened moments are [active][harmonic];
 * `whole` is the sun's irradiance, of which no cell gets more. */
void np_importance_add(const np_transport_level *finest, const float *moments, float share, float whole,
                       np_importance *importance);

/* Propagates the importance of sunlight to neighbouring cells, from which paths may reach it. */
void np_importance_spread(const np_transport_grid *grid, np_importance *importance);

#endif
