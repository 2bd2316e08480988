/* SPDX-License-Identifier: Apache-2.0 */
/* The waterline of a weather map: the threshold between cloud and clear sky. */
#ifndef NP_CLOUD_WATERLINE_H
#define NP_CLOUD_WATERLINE_H

#include "cloud/cloud_model.h"

/* Number of bisection steps of a model. */
static inline int np_waterline_count_steps(const np_cloud_model *model) { return model->is_sketch ? 9 : 14; }

/* A tested waterline, and the error of its coverage. */
typedef struct np_waterline {
  float value;
  double miss;
} np_waterline;

/* Sets the waterline and its dependent values. */
void np_waterline_set(np_cloud_model *model, float waterline);

/* Records the model's waterline if its coverage error is less than the best so far. */
void np_waterline_update_best(np_cloud_model *model, double fraction, np_waterline *best);

/* Whether the best of all tested waterlines is taken: for few columns, many of which change at a time, and for a
 * picture's clouds, whose borders are not in the shadow. */
bool np_waterline_is_best(const np_cloud_model *model);

/* Searches the waterline, with a census at each step. */
neph_result np_waterline_search(np_cloud_model *model, np_monitor *monitor);

#endif
