/* SPDX-License-Identifier: Apache-2.0 */
/* A survey of the columns of voxels that a bake of a model has: their optical depths and tops. */
#ifndef NP_CLOUD_MEASURED_SURVEY_H
#define NP_CLOUD_MEASURED_SURVEY_H

#include "cloud/cloud_model.h"

/* One value of each column of the model's lattice of columns; NULL: not surveyed. */
typedef struct np_measured_survey {
  int32_t step;  /* only every so many columns along each axis are surveyed; others stay as they are */
  float *depths; /* optical depth */
  float *tops_m; /* top above the base, of the highest voxel with a noticeable extinction; 0: none */
} np_measured_survey;

/* Lattice of the columns of a bake of the description. */
neph_result np_measured_lattice_make(const np_cloud_model *model, np_measured_columns *out_columns);

/* Evaluates the model at the voxels of a bake. */
neph_result np_measured_survey_make(const np_cloud_model *model, np_monitor *monitor, np_measured_survey *survey);

#endif
