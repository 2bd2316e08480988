/* SPDX-License-Identifier: Apache-2.0 */
/* The door to NanoVDB's C header: constants of its layout alone, no function of it is called. Inside the volume module
 * only. */
#ifndef NP_VOLUME_NVDB_HEADER_H
#define NP_VOLUME_NVDB_HEADER_H

#define PNANOVDB_C
#include <nanovdb/PNanoVDB.h>

#endif
