/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of .vdb files, and of sequences of them. */
#ifndef NP_CHECK_CHECK_VOLUME_H
#define NP_CHECK_CHECK_VOLUME_H

#include "check/findings.h"
#include "volume/volume_facts.h"

/* Measures a file and applies the rules. `use` is a scene's use of it; NULL: none. OpenVDB's own checks are listed for
 * a single file, or the first of a sequence. `out_facts` receives the measures, which the caller clears; NULL is
 * allowed. */
neph_result np_check_volume(neph_check *check, const char *path, bool is_first, const np_file_use *use,
                            np_file_facts *out_facts);

/* Checks all files of a pattern, each by itself and against the one before. */
neph_result np_check_sequence(neph_check *check, const char *pattern, const np_file_use *use);

#endif
