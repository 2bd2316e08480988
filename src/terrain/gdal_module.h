/* SPDX-License-Identifier: Apache-2.0 */
/* The module that reads georeferenced rasters. */
#ifndef NP_TERRAIN_GDAL_MODULE_H
#define NP_TERRAIN_GDAL_MODULE_H

#include <stdbool.h>

#include <nephos/context.h>

#include "terrain/gdal_table.h"

/* The module's table, loaded on first need; fails with a message that lists the searched folders. */
neph_result np_gdal_module_get(neph_context *context, const np_gdal_module **out_module);

/* Whether np_gdal_module_get succeeds; logs nothing. */
bool np_gdal_module_is_present(neph_context *context);

#endif
