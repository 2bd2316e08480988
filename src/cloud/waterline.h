/* SPDX-License-Identifier: Apache-2.0 */
/* The waterline of a weather map, which parts cloud from sky. */
#ifndef NP_CLOUD_WATERLINE_H
#define NP_CLOUD_WATERLINE_H

#include "cloud/cloud_model.h"

enum { NP_WATERLINE_STEPS = 14 }; /* of halving */

/* A waterline that was tried, and by how much its coverage misses the wanted one. */
typedef struct np_waterline {
  float value;
  double miss;
} np_waterline;

/* Sets the waterline and what follows from it. */
void np_waterline_set(np_cloud_model *model, float waterline);

/* Keeps the model's waterline if the covered fraction misses the wanted one by less than the best so far. */
void np_waterline_keep_better(np_cloud_model *model, double fraction, np_waterline *best);

/* Whether the best of all waterlines tried is taken: of few columns many change at a time, of a picture's clouds the
 * borders are not in the shadow. */
bool np_waterline_is_best(const np_cloud_model *model);

/* Finds the waterline by a census at each step. */
neph_result np_waterline_search(np_cloud_model *model, np_monitor *monitor);

#endif
