/* SPDX-License-Identifier: Apache-2.0 */
/* The table of nephos_gdal.so, loaded on first need. */
#include "terrain/gdal_module.h"

#include "core/module.h"

/* Address space of GDAL, PROJ and the libraries that they load: 214 MB measured. */
static const np_module_kind gdal_kind = {.file = NP_GDAL_MODULE_FILE,
                                         .function = NP_GDAL_MODULE_FUNCTION,
                                         .version = NP_GDAL_MODULE_VERSION,
                                         .purpose = "reads GeoTIFF and other georeferenced height fields by GDAL",
                                         .library_bytes = 256 << 20,
                                         .library_threads = 0};

bool np_gdal_module_is_present(neph_context *context) { return np_module_is_present(context, &gdal_kind); }

neph_result np_gdal_module_get(neph_context *context, const np_gdal_module **out_module) {
  const void *table;
  neph_result result = np_module_get(context, &gdal_kind, &table);
  *out_module = table;
  return result;
}
