/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a picture before anything is built: a bias for each stage, as a row of the stage table says
 * (np_stage_expect_*), and the noise of its samples. docs/error.md has the terms. */
#ifndef NP_PLAN_ERROR_FORECAST_H
#define NP_PLAN_ERROR_FORECAST_H

#include "plan/plan_parts.h"

/* Terms that the estimate of a finished picture shares (bias_model.h). */
typedef struct np_bias_term_table {
  double air, clear_air; /* tables of the air, and light between air, clouds and ground, by day */
  double steps;          /* share of a march's tolerance */
  double emission;       /* light of a fire on smoke and ground */
  double water;          /* light that water sends up to clouds: its glint comes to them over few directions */
  double air_over_water; /* air's own light above water, whose glint lights the molecules evenly */
} np_bias_term_table;

extern const np_bias_term_table np_bias_terms;

/* The bias for the error that a solution expects of its cells, the clouds' albedo, and the sine of the light's
 * elevation. */
double np_bias_of_cells(double cell_error, double albedo, double sine);

/* The bias for water below the clouds and the sine of the light's elevation. */
double np_bias_of_water(double sine);

/* The bias for the degree of a solution of the multiple scattering and its final residual. */
double np_bias_of_solution(unsigned degree, double residual);

/* The bias for a method, where the mean square of the clouds' opacity is `cover`. */
double np_bias_of_method(neph_multiple_scattering method, double cover);

/* Predicted noise for a mean number of samples per pixel, and number of samples for a noise. */
double np_plan_get_noise(const np_plan *plan, double samples);
double np_plan_count_samples(const np_plan *plan, double noise);

/* Noise that the target error leaves beside the bias, at least half of the target; infinite without a target. */
double np_plan_choose_noise(const np_plan *plan);

/* Mean samples a pixel that the plan takes: as requested, or as many as that noise takes. */
double np_plan_choose_samples(const np_plan *plan);

#endif
