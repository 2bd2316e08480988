/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_ATMOSPHERE_MEDIUM_CHECK_H
#define NP_ATMOSPHERE_MEDIUM_CHECK_H

#include <nephos/atmosphere.h>

/* Relative rms error that tables may make: what is asked for by default, and what can be asked for. */
#define NP_SKY_TOLERANCE_DEFAULT 0.007
#define NP_SKY_TOLERANCE_MIN 0.003
#define NP_SKY_TOLERANCE_MAX 0.1

/* Whether every number of a description is allowed; if not, says which is not and what is. */
neph_result np_medium_check(neph_context *context, const neph_atmosphere_desc *desc);

#endif
