/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of files of triangles. */
#ifndef NP_CHECK_CHECK_MESH_H
#define NP_CHECK_CHECK_MESH_H

#include <nephos/terrain.h>

#include "check/findings.h"

/* `desc` is a scene's; NULL: the unit of the file is unknown. */
neph_result np_check_mesh(neph_check *check, const char *path, const neph_mesh_desc *desc);

#endif
