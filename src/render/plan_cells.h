/* SPDX-License-Identifier: Apache-2.0 */
/* The cells on which multiple scattering will be solved, before there are clouds. */
#ifndef NP_RENDER_PLAN_CELLS_H
#define NP_RENDER_PLAN_CELLS_H

#include "caches/lighting.h"
#include "render/plan_stages.h"

struct np_scattering_desc;

/* As many cells as render.light_memory allows, were there cloud in all of them, and fine ones for the whole picture,
 * whatever of it is rendered. */
void np_plan_choose_cells(const np_plan *plan, const neph_scene *scene, struct np_scattering_desc *out);

/* Expected cells. Unknown where clouds or their phase functions are files that have not been read. */
typedef struct np_cells_forecast {
  bool is_known;
  np_scattering_forecast cells;
} np_cells_forecast;

neph_result np_plan_forecast_cells(const np_plan *plan, const neph_scene *scene, np_cells_forecast *out);

/* Bytes that a solution takes while it is computed, of a plan that has its forecast. */
double np_plan_predict_cell_bytes(const np_plan *plan, const neph_scene *scene);

#endif
