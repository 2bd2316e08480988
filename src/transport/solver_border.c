/* SPDX-License-Identifier: Apache-2.0 */
/* Light that leaves the box during a solution, and is returned by ground and air. */
#include "transport/scattering_solver.h"

void np_scattering_solver_light_border(np_scattering_solver *s) {
  const np_outflow *outflow = s->has_outflow ? &s->outflow[s->band] : NULL;
  np_border *borders[] = {&s->broad->border, &s->fine->border};
  for (int i = 0; i < (s->fine == s->broad ? 1 : 2); i++)
    if (outflow)
      np_border_set_outflow(s->context, borders[i], s->band, outflow);
    else
      np_border_reset(borders[i], s->band);
  for (unsigned n = 0; n < s->level_count; n++)
    if (s->levels[n].ground)
      np_ground_columns_get(&s->ground, &s->broad->border, s->band, outflow, &s->levels[n].grid, s->levels[n].ground);
}
