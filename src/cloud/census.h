/* SPDX-License-Identifier: Apache-2.0 */
/* A census of a field. */
#ifndef NP_CLOUD_CENSUS_H
#define NP_CLOUD_CENSUS_H

#include "cloud/cloud_model.h"

/* Share of the field's sky that is covered. */
neph_result np_census_count(const np_cloud_model *model, np_monitor *monitor, double *out_fraction);

#endif
