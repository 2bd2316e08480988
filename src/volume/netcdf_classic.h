/* SPDX-License-Identifier: Apache-2.0 */
/* The header of a NetCDF file of the classic format. libnetcdf reads what lies beyond the end of such a file as zeros,
 * so that the places of all values are checked before. Inside the volume module only. */
#ifndef NP_VOLUME_NETCDF_CLASSIC_H
#define NP_VOLUME_NETCDF_CLASSIC_H

#include "volume/vdb_bytes.h"

/* Whether the first eight bytes of a file are those of the classic format, of 64-bit offsets or of 64-bit data. */
bool np_netcdf_classic_has_magic(uint64_t magic);

/* Checks that the header is whole, and that the values of all variables lie within the file. */
neph_result np_netcdf_classic_check(np_vdb_bytes *bytes);

#endif
