/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of .vdb files, and of sequences of them. */
#ifndef NP_CHECK_CHECK_VOLUME_H
#define NP_CHECK_CHECK_VOLUME_H

#include "check/findings.h"
#include "volume/volume_facts.h"

/* Measures a file and puts it to the rules. `use` is what a scene takes of it; NULL: there is none. OpenVDB's own
 * checks are listed if it is the first of a sequence, or of none. `out_facts` gets its measures, which the caller
 * clears; NULL: unwanted. */
neph_result np_check_volume(neph_check *check, const char *path, bool is_first, const np_file_use *use,
                            np_file_facts *out_facts);

/* Checks all files of a pattern, each by itself and against the one before. */
neph_result np_check_sequence(neph_check *check, const char *pattern, const np_file_use *use);

#endif
