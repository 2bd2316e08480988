/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks from a stranger: whether every index in them leads to something, and every bound is one. */
#ifndef NP_VOLUME_BRICKS_CHECK_H
#define NP_VOLUME_BRICKS_CHECK_H

#include "volume/bricks.h"

/* Extents, periods and numbers of nodes and bricks, as np_bricks_build makes them. To be called before the table is
 * counted. */
bool np_bricks_check_shape(const np_bricks *bricks);

/* Table and nodes, once they are there. */
bool np_bricks_check_content(const np_bricks *bricks);

#endif
