/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of files of triangles. */
#ifndef NP_CHECK_CHECK_MESH_H
#define NP_CHECK_CHECK_MESH_H

#include <nephos/terrain.h>

#include "check/findings.h"

/* Checks a mesh with the description of a scene; `desc` NULL: the file's unit is unknown. */
neph_result np_check_mesh(neph_check *check, const char *path, const neph_mesh_desc *desc);

#endif
