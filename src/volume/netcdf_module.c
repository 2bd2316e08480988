/* SPDX-License-Identifier: Apache-2.0 */
/* The table of nephos_netcdf.so, loaded on first need. */
#include "volume/netcdf_module.h"

#include "core/module.h"
#include "volume/netcdf_process.h"

/* Address space of libnetcdf, HDF5, libcurl and the libraries that they load: 60 MB measured. */
static const np_module_kind netcdf_kind = {.file = NP_NETCDF_MODULE_FILE,
                                           .function = NP_NETCDF_MODULE_FUNCTION,
                                           .version = NP_NETCDF_MODULE_VERSION,
                                           .purpose = "reads NetCDF files of atmospheric models",
                                           .library_bytes = 64 << 20,
                                           .library_threads = 0};

bool np_netcdf_module_is_present(neph_context *context) {
  return np_module_is_present(context, &netcdf_kind) && np_netcdf_process_is_present(context);
}

neph_result np_netcdf_module_get(neph_context *context, const np_netcdf_module **out_module) {
  const void *table;
  neph_result result = np_module_get(context, &netcdf_kind, &table);
  *out_module = table;
  return result;
}
