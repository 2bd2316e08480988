/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of height fields. */
#ifndef NP_CHECK_CHECK_HEIGHTS_H
#define NP_CHECK_CHECK_HEIGHTS_H

#include <nephos/terrain.h>

#include "check/findings.h"

/* `desc` has the properties that a file does not state; NULL: unknown. */
neph_result np_check_heights(neph_check *check, const char *path, const neph_terrain_desc *desc);

#endif
