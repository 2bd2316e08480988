/* SPDX-License-Identifier: Apache-2.0 */
/* NetCDF files of HDF5, read by a process of their own, the program nephos_netcdf_reader: HDF5 trusts files, and a
 * damaged one may crash it, keep it busy or exhaust memory. */
#ifndef NP_VOLUME_NETCDF_PROCESS_H
#define NP_VOLUME_NETCDF_PROCESS_H

#include <stdbool.h>

#include "core/parallel.h"
#include "volume/netcdf_table.h"

/* Opens a file as np_netcdf_module.open does. `monitor`, which stays until the file is closed, cancels any call: it
 * ends the process, and the call and all later ones return NEPH_ERROR_CANCELLED. NULL: none. */
neph_result np_netcdf_process_open(neph_context *context, const np_monitor *monitor, const char *path,
                                   const void *memory, size_t byte_count, np_netcdf_file **out_file,
                                   np_netcdf_error *error);

/* The other functions of the table for such a file; `open` is NULL. Whatever the process does, each call ends: with an
 * error where the process ended or took too much time, then and for all later calls. */
extern const np_netcdf_module np_netcdf_process_table;

/* Whether the process of an open file has ended. */
bool np_netcdf_process_has_ended(const np_netcdf_file *file);

/* Whether the program exists; logs nothing. */
bool np_netcdf_process_is_present(neph_context *context);

#endif
