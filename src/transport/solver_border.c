/* SPDX-License-Identifier: Apache-2.0 */
/* Light that a solution under way sends down, and gets back. */
#include "transport/scattering_solver.h"

void np_scattering_solver_light_below(np_scattering_solver *s) {
  float(*irradiance)[NP_BORDER_PLAN] = s->has_downwelling ? s->downwelling[s->band] : NULL;
  np_border *borders[] = {&s->broad->border, &s->fine->border};
  for (int i = 0; i < (s->fine == s->broad ? 1 : 2); i++)
    if (irradiance)
      np_border_set_downwelling(borders[i], s->band, irradiance);
    else
      np_border_reset(borders[i], s->band);
  for (unsigned n = 0; n < s->level_count; n++)
    if (s->levels[n].ground)
      np_ground_columns_get(&s->ground, &s->broad->border, s->band, irradiance, &s->levels[n].grid,
                            s->levels[n].ground);
}
