/* SPDX-License-Identifier: Apache-2.0 */
/* The checksums of a grid in a .nvdb file: of its head, and perhaps of its nodes. Inside the volume module only. */
#ifndef NP_VOLUME_NVDB_CHECKSUM_H
#define NP_VOLUME_NVDB_CHECKSUM_H

#include "volume/nvdb_layout.h"

/* Compares what a grid states, if anything, with what stands in it. Reported where they differ. Checksums of versions
 * that are newer than 32.4, and of nodes that stand in no known order, are not compared. */
neph_result np_nvdb_checksum_check(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid);

#endif
