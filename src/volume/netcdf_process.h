/* SPDX-License-Identifier: Apache-2.0 */
/* NetCDF files of HDF5, read by a process of their own, the program nephos_netcdf_reader: HDF5 trusts files, and a
 * damaged one may crash it, keep it busy or exhaust memory. */
#ifndef NP_VOLUME_NETCDF_PROCESS_H
#define NP_VOLUME_NETCDF_PROCESS_H

#include "volume/netcdf_table.h"

/* Opens a file as np_netcdf_module.open does. */
neph_result np_netcdf_process_open(neph_context *context, const char *path, const void *memory, size_t byte_count,
                                   np_netcdf_file **out_file, np_netcdf_error *error);

/* The other functions of the table for such a file; `open` is NULL. Whatever the process does, each call ends: with an
 * error where the process ended or took too much time, then and for all later calls. */
extern const np_netcdf_module np_netcdf_process_table;

#endif
