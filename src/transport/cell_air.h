/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight that the air within the cells scatters once. Its higher orders within the box are left out: as much light
 * goes on as comes.
 *
 * The source of a cell is v·j(z): v the share of sunlight that the clouds let through to its middle, j that of the
 * layer in the sun, even over the upward and over the downward directions, E·σ·share/2π. Molecules scatter half of the
 * light to either side, aerosols by their phase function. Sunlight that the air takes is counted in E, sky beyond the
 * box at the border, and so no light is lost or counted twice.
 */
#ifndef NP_TRANSPORT_CELL_AIR_H
#define NP_TRANSPORT_CELL_AIR_H

#include "transport/scattering_field.h"
#include "transport/transport_grid.h"

/* Ways of light through a layer. */
enum { NP_CELL_AIR_DOWN, NP_CELL_AIR_UP, NP_CELL_AIR_WAYS };

typedef struct np_cell_air {
  float *sunlit;                       /* v of each cell [k][j][i]; NULL: the air scatters too little to matter */
  float (*radiance)[NP_CELL_AIR_WAYS]; /* j of each layer in the present band, W m⁻³ sr⁻¹ nm⁻¹ */
  bool is_borrowed;                    /* the arrays are another grid's */
} np_cell_air;

/* Sets up the cells of a grid; np_cell_air_clear frees them, after a failure too. `fade`: of each cloud, the share of
 * its optical depth that dims the beam. */
neph_result np_cell_air_fill(const np_transport_grid *grid, const np_world *world,
                             const np_sun_optical_depth_source *depths, const float *fade, np_monitor *monitor,
                             np_cell_air *out);
void np_cell_air_clear(neph_context *context, np_cell_air *air);

/* The same air, for a grid with the same planes, until `air` is cleared. */
np_cell_air np_cell_air_borrow(const np_cell_air *air);

/* Renews `radiance` for a band. */
void np_cell_air_set_band(const np_transport_grid *grid, const np_world *world, unsigned band, np_cell_air *air);

/* Irradiance that the air of a box without clouds adds on a plane beneath it, or above it; 0 where it is left out. The
 * sides of the box bound the way through it. */
np_spectrum np_cell_air_compute_irradiance(const np_transport_grid *grid, const np_world *world, int way);

#endif
