/* SPDX-License-Identifier: Apache-2.0 */
/* One solution of the multiple scattering on its way: the levels of cells, and how far each band has come. */
#ifndef NP_TRANSPORT_SCATTERING_SOLVER_H
#define NP_TRANSPORT_SCATTERING_SOLVER_H

#include "transport/scattering_field.h"
#include "transport/scattering_field_private.h"
#include "transport/solver_state.h"
#include "transport/transport_level.h"

enum { NP_SCATTERING_LEVELS_MAX = 6 };

/* Directions, and what comes along them from outside. */
typedef struct np_scattering_angles {
  np_ordinates ordinates;
  np_boundary_radiance boundary;
  np_transport_lights lights;
} np_scattering_angles;

/* Progress of the solution of a band. */
typedef struct np_scattering_reach {
  unsigned level;  /* the last that was swept; the number of levels: none */
  unsigned sweeps; /* of that level, where they were cut; 0: up to its tolerance */
  double residual;
} np_scattering_reach;

typedef struct np_scattering_solver {
  neph_context *context;
  const np_world *world;
  const np_sun_optical_depth_source *depths;
  const np_scattering_desc *desc;
  np_monitor *monitor;
  np_scattering_field *out;
  np_scattering_angles *fine,
      *broad; /* of the result, and of what is iterated; the same where nothing is to be resolved further */
  np_workspace workspace;
  bool is_related;     /* bands differ in their lights alone, and have one grid */
  bool is_nested;      /* the present band begins on the coarsest grid, from nothing */
  bool is_transferred; /* other bands take from the first how light differs once it is resolved */
  double sunlight[NP_BAND_COUNT], surroundings[NP_BAND_COUNT]; /* irradiance on a sphere of either, means over cells */
  np_spectrum *sun;                                            /* irradiance at each live cell of the finest grid */
  double end_s;  /* of the monitor's seconds, for the sweeps of all bands; infinite: no limit */
  bool has_time; /* the present band's share of them is not used up */
  np_scattering_reach reached,
      cut; /* by the present band; and by the last one that was cut, past which no other goes */
  np_monitor_part whole;
  np_solver_state state;
  unsigned level_count, band, turn; /* the band, and its place in the order of solving */
  /* The result's; where its cells are fine, those twice as wide; then the same in the degree that is iterated, if that
   * is another; then coarser ones. */
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

/* Solves for the present band. `is_first`: nothing is known yet of the levels' light. `sum` is that over the sources of
 * the band before, then of this one; 0: there is no light. */
neph_result np_scattering_solver_solve_band(np_scattering_solver *s, bool is_first, double *sum);

/* The degree of the harmonics that light is iterated in, and the one that it is resolved into, for so many cells. */
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

/* Lets sunlight be known of where paths may come to it from. */
void np_importance_spread(const np_transport_grid *grid, np_importance *importance);

#endif
