/* SPDX-License-Identifier: Apache-2.0 */
/* Optional parts of the library. */
#include "core/context_private.h"
#include "image/ocio_view.h"
#include "mesh/assimp_process.h"
#include "terrain/gdal_module.h"
#include "volume/netcdf_module.h"
#include "volume/volume_private.h"

bool neph_feature_is_present(neph_context *context, neph_feature feature) {
  static bool (*const checks[])(neph_context * context) = {[NEPH_FEATURE_VDB] = np_vdb_module_is_present,
                                                           [NEPH_FEATURE_GDAL] = np_gdal_module_is_present,
                                                           [NEPH_FEATURE_ASSIMP] = np_assimp_is_present,
                                                           [NEPH_FEATURE_NETCDF] = np_netcdf_module_is_present,
                                                           [NEPH_FEATURE_OCIO] = np_ocio_module_is_present};
  return context && (unsigned)feature < sizeof checks / sizeof *checks && checks[feature](context);
}
