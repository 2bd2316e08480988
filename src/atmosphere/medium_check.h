/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_ATMOSPHERE_MEDIUM_CHECK_H
#define NP_ATMOSPHERE_MEDIUM_CHECK_H

#include <nephos/atmosphere.h>

/* Whether every number of a description is allowed; if not, says which is not and what is. */
neph_result np_medium_check(neph_context *context, const neph_atmosphere_desc *desc);

#endif
