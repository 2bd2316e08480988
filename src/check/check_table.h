/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of tables of numbers. */
#ifndef NP_CHECK_CHECK_TABLE_H
#define NP_CHECK_CHECK_TABLE_H

#include "check/findings.h"

/* Checks a .csv by its columns: a phase function, places, a camera, or a star catalogue. */
neph_result np_check_table(neph_check *check, const char *path);

/* Checks a camera by frame, such as a .chan, which has no names of columns. */
neph_result np_check_camera_table(neph_check *check, const char *path);

#endif
