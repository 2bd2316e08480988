/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of files of triangles. */
#ifndef NP_CHECK_CHECK_MESH_H
#define NP_CHECK_CHECK_MESH_H

#include "check/findings.h"

neph_result np_check_mesh(neph_check *check, const char *path);

#endif
