/* SPDX-License-Identifier: Apache-2.0 */
/* Choices of a plan by a model of their cost. */
#ifndef NP_PLAN_PLAN_CHOICES_H
#define NP_PLAN_PLAN_CHOICES_H

#include <math.h>

#include "caches/lighting.h"
#include "plan/plan_parts.h"

/* Distance in pixels between rays along which shadows in the air are searched: 0.25°, half of the sun's disk, but at
 * least two pixels, or less where that would leave fewer than 64 rays across a picture of hills. */
double np_plan_choose_air_spacing(const np_request *request, const neph_scene *scene);

struct np_scattering_desc;

/* Chooses the cells for clouds in a world box: as many as render.light_memory allows if all of them held cloud, and
 * fine cells by the number of the whole picture's rays that meet the box. */
void np_plan_choose_cells(const np_plan *plan, const neph_scene *scene, np_dvec3 low, np_dvec3 high,
                          struct np_scattering_desc *out);

/* Chooses the tile of a field that repeats on the sphere, and the box of its cells in place of that of all tiles: the
 * period is 0 where there is none. Returns the box's area over that of its cells. */
double np_plan_choose_fold(const neph_scene *scene, np_dvec3 *low, np_dvec3 *high, np_transport_fold *out);

/* The clouds that need no solution, by the directions of the lights and the outlines of the clouds. */
np_left_out np_plan_choose_left_out(const np_plan *plan, const neph_scene *scene);

/* Expected cells. Unknown where clouds are files whose headers have not been read, or phase functions are files. */
typedef struct np_cells_forecast {
  bool is_known, are_errors_known; /* errors of no files, whose densest values are not read */
  np_scattering_forecast cells;
} np_cells_forecast;

neph_result np_plan_forecast_cells(const np_plan *plan, const neph_scene *scene, np_cells_forecast *out);

/* Cells with cloud of a solution, of a plan that has its decisions: memory within the limit of the plan. */
np_cell_counts np_plan_count_cells(const np_plan *plan, const neph_scene *scene);

#endif
