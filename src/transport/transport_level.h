/* SPDX-License-Identifier: Apache-2.0 */
/* Scattered light on one grid, in one band: its sources, its solution, and how the one is found from the other. */
#ifndef NP_TRANSPORT_TRANSPORT_LEVEL_H
#define NP_TRANSPORT_TRANSPORT_LEVEL_H

#include "transport/diffusion_correction.h"
#include "transport/fixed_point.h"
#include "transport/sweep.h"
#include "transport/workspace.h"

typedef struct np_transport_level {
  np_transport_grid grid;
  float *sun;              /* first collisions times irradiance of each active cell, W m⁻³ nm⁻¹ */
  float *emission;         /* moment l = 0 of the emission of each active cell; NULL: nothing emits */
  np_column_light *ground; /* light of ground near, by column [j][i]; NULL: none is near */
  np_cell_air air;         /* light of the air in the cells */
  float *phi;              /* the solution: [active][harmonic] */
  float *first_phi;        /* solution of the first band; NULL: no other band starts from it */
  float *change;           /* change from a further band's start to its solution; NULL: no finer grid starts from it */
  np_diffusion diffusion;  /* diffusion system of the grid, once light has been iterated on it */
} np_transport_level;

/* Data that all grids of a solution share. */
typedef struct np_transport_lights {
  neph_context *context;
  np_monitor *monitor;
  const np_ordinates *ordinates;
  np_workspace *workspace;
  float sun_harmonics[NP_HARMONIC_COUNT_MAX]; /* spherical harmonics in the direction of sunlight */
  const np_border_faces *border;              /* radiance from outside */
} np_transport_lights;

/* Sources and solution of a grid that is filled; all 0. */
neph_result np_transport_level_allocate(np_transport_level *level, bool is_emitting);
void np_transport_level_clear(np_transport_level *level);

/* Frees the solution, which no other band needs. */
void np_transport_level_drop(np_transport_level *level);

/* Allocates the starts of further bands. `has_finer`: a finer grid starts from this one. */
neph_result np_transport_level_allocate_starts(np_transport_level *level, bool has_finer);

typedef struct np_transport_effort {
  double tolerance;
  bool is_finest;
  unsigned sweeps_max;                 /* 0: as many as the level is worth */
  const np_fixed_point_keeper *keeper; /* NULL: none */
  np_outflow *outflow;                 /* out: renewed by a solve that was not cut; NULL: not measured */
  double residual;                     /* out: relative */
  unsigned sweeps;                     /* out */
  bool is_cut;                         /* out: the monitor's budget ended it */
} np_transport_effort;

/* Moment l = 0 of the light of the air in an active cell, even over all directions: mean·∫Y₀₀ dΩ. */
static inline float np_transport_level_get_air(const np_transport_level *level, size_t active) {
  const np_transport_grid *g = &level->grid;
  const int32_t cell = g->cell[active], k = cell / (g->size[0] * g->size[1]);
  const float *radiance = level->air.radiance[k];
  return sqrtf(NP_PI_F) * (radiance[NP_CELL_AIR_DOWN] + radiance[NP_CELL_AIR_UP]) * level->air.sunlit[cell];
}

/* Improves `phi` until the tolerance is met, or the monitor's budget ends, which is left for the caller to end. */
neph_result np_transport_level_solve(const np_transport_lights *lights, np_transport_level *level,
                                     np_transport_effort *effort);

/* Iterates by one sweep without acceleration. With a time budget, which needs another vector like `phi`, `phi` is
 * unchanged if the budget ends within the sweep. */
neph_result np_transport_level_sweep(const np_transport_lights *lights, np_transport_level *level, bool has_budget);

/* Start of a finer grid: the coarser solution between the middles of its cells. */
neph_result np_transport_level_prolong(const np_transport_level *coarse, np_monitor *monitor, np_transport_level *fine);

/* Adds the interpolated change of the coarser solution to the finer one, even if time has run out: it costs little. */
neph_result np_transport_level_prolong_change(const np_transport_level *coarse, np_transport_level *fine);

/* Start of the same cells with light resolved into more degrees: `broad` with that light of the sun added
 * which only there counts as having gone straight on. Quick: it is not stopped half way. */
neph_result np_transport_level_resolve(const np_transport_lights *lights, const np_transport_level *broad,
                                       np_transport_level *fine);

/* Whether a solution of so many moments costs so little that it is driven to the precision of floats; and the number of
 * steps that it remembers, two vectors of moments each. */
bool np_transport_level_is_cheap(double moments, double tolerance);
unsigned np_transport_level_get_depth(double moments, double tolerance);

/* Makes means over cells, up to NP_HARMONIC_COUNT_MAX numbers each, values that interpolate to the right curve. */
neph_result np_transport_grid_sharpen(const np_transport_grid *grid, unsigned count, np_monitor *monitor,
                                      float *values);

/* Columns alone, whose axis is z: replaces the mean radiance and the flux in `phi`, the moments of a sweep, by those
 * that balance (column_balance.c). `scratch` takes NP_COLUMN_SCRATCH doubles a cell. */
enum { NP_COLUMN_SCRATCH = 6 };
bool np_transport_grid_is_column(const np_transport_grid *grid);
void np_column_balance(const np_transport_lights *lights, const np_transport_level *level, double *scratch, float *phi);

#endif
