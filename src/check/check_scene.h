/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of scenes with all their files. */
#ifndef NP_CHECK_CHECK_SCENE_H
#define NP_CHECK_CHECK_SCENE_H

#include "check/findings.h"

/* Checks the scene of a file, in frame 1; where a key fails, the files that it names, each by itself. */
neph_result np_check_scene_file(neph_check *check, const char *path);

#endif
