/* SPDX-License-Identifier: Apache-2.0 */
/* Measurement of cloud cover. */
#ifndef NP_CLOUD_CENSUS_H
#define NP_CLOUD_CENSUS_H

#include "cloud/cloud_model.h"

/* Computes the covered share of the field's sky. */
neph_result np_census_count(const np_cloud_model *model, np_monitor *monitor, double *out_fraction);

#endif
