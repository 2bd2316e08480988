/* SPDX-License-Identifier: Apache-2.0 */
/* The module that reads NetCDF files. */
#ifndef NP_VOLUME_NETCDF_MODULE_H
#define NP_VOLUME_NETCDF_MODULE_H

#include <stdbool.h>

#include "volume/netcdf_table.h"

/* The module's table, loaded on first need; fails with a message that lists the searched folders. */
neph_result np_netcdf_module_get(neph_context *context, const np_netcdf_module **out_module);

/* Whether np_netcdf_module_get succeeds, and the program for files of HDF5 exists; logs nothing. */
bool np_netcdf_module_is_present(neph_context *context);

#endif
