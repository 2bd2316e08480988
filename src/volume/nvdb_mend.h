/* SPDX-License-Identifier: Apache-2.0 */
/* Repaired copies of .nvdb files. Inside the volume module only. */
#ifndef NP_VOLUME_NVDB_MEND_H
#define NP_VOLUME_NVDB_MEND_H

#include "volume/volume_file.h"

/* np_volume_format.mend. Grids are read whole, as floats or vectors of floats, and written anew without compression:
 * files with grids of other types are refused. */
neph_result np_nvdb_mend(const np_volume_file *file, np_vdb_mending *mendings, const char *path);

#endif
