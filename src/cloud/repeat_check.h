/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of fields that repeat. */
#ifndef NP_CLOUD_REPEAT_CHECK_H
#define NP_CLOUD_REPEAT_CHECK_H

#include <nephos/cloud.h>

/* Refuses descriptions that cannot repeat. */
neph_result np_repeat_check(neph_context *context, const neph_cloud_desc *desc);

#endif
