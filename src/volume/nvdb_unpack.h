/* SPDX-License-Identifier: Apache-2.0 */
/* Compressed grids of a .nvdb file. Inside the volume module only. */
#ifndef NP_VOLUME_NVDB_UNPACK_H
#define NP_VOLUME_NVDB_UNPACK_H

#include "volume/nvdb_layout.h"

/* Reads the first `count` bytes of a grid that is stored from the position of `bytes` on. A failure is in
 * bytes->result. The module that decompresses is loaded where the grid is compressed. */
void np_nvdb_unpack(np_vdb_bytes *bytes, const np_nvdb_grid *grid, unsigned char *out, uint64_t count);

#endif
