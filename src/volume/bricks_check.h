/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of bricks read from a file: every index must be in range, and every bound must be sound. */
#ifndef NP_VOLUME_BRICKS_CHECK_H
#define NP_VOLUME_BRICKS_CHECK_H

#include "volume/bricks.h"

/* Extents, periods, and numbers of nodes and bricks, by the rules of np_bricks_build. Call it before the table is
 * counted. */
bool np_bricks_check_shape(const np_bricks *bricks);

/* Checks table and nodes after loading. */
bool np_bricks_check_content(const np_bricks *bricks);

#endif
