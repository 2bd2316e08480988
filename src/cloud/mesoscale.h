/* SPDX-License-Identifier: Apache-2.0 */
/* Streets and mesoscale cells of the landscape. */
#ifndef NP_CLOUD_MESOSCALE_H
#define NP_CLOUD_MESOSCALE_H

#include "cloud/cloud_private.h"

/* Whether a model has streets and cells. */
bool np_mesoscale_is_possible(neph_cloud_model model);

/* Share of the landscape's own groups and clearings that is left beside the patterns; 1 without any. */
float np_mesoscale_get_ground_share(const np_landscape *land);

/* Adds the patterns to heights at positions in the air, in cells of the landscape; at most NP_LANDSCAPE_BLOCK. */
void np_mesoscale_add(const np_landscape *land, size_t count, const double *air_x, const double *air_y, float *heights);

#endif
