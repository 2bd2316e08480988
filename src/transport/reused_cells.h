/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of an earlier solution, for a later one of the same clouds. */
#ifndef NP_TRANSPORT_REUSED_CELLS_H
#define NP_TRANSPORT_REUSED_CELLS_H

#include "transport/transport_grid.h"

struct np_reused_cells {
  np_transport_grid grid; /* empty once a solution has taken it */
  bool is_lit;            /* its first collisions are those of the present sun */
};

/* Moves reused cells into a grid that was placed alike; false: there are none. Their first collisions stay where the
 * sun is the same, else there are none. */
bool np_reused_cells_move(np_reused_cells *cells, np_transport_grid *grid, bool *out_is_lit);

#endif
