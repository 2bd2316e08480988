/* SPDX-License-Identifier: Apache-2.0 */
/* Fit of a model to a measured field: each pixel gets its optical depth, its covered share and its tops. */
#ifndef NP_CLOUD_MEASURED_FIT_H
#define NP_CLOUD_MEASURED_FIT_H

#include "cloud/cloud_model.h"
#include "cloud/measured_map.h"

/* Fills the columns of a complete model. They are cleared with it, whatever the outcome. */
neph_result np_measured_fit(np_cloud_model *model, const np_measured_map *map, np_monitor *monitor);

#endif
