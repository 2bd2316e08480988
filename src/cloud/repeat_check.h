/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of fields that repeat. */
#ifndef NP_CLOUD_REPEAT_CHECK_H
#define NP_CLOUD_REPEAT_CHECK_H

#include <nephos/cloud.h>

/* First setting, besides the model, that prevents a field from repeating, as a requirement; NULL: none. */
const char *np_repeat_search_obstacle(const neph_cloud_desc *desc);

/* Refuses descriptions that cannot repeat. */
neph_result np_repeat_check(neph_context *context, const neph_cloud_desc *desc);

#endif
