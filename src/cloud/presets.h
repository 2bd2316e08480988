/* SPDX-License-Identifier: Apache-2.0 */
/* Presets of clouds. */
#ifndef NP_CLOUD_PRESETS_H
#define NP_CLOUD_PRESETS_H

#include <nephos/cloud.h>

#include "core/text.h"

bool np_cloud_has_preset(const char *name);

/* Whether a preset's clouds are of ice. */
bool np_cloud_preset_is_ice(const char *name);

/* Whether a preset's clouds are a sheet that covers the sky as far as it is seen. */
bool np_cloud_preset_is_sheet(const char *name);

/* Extent of a preset's field, which is square; 0: no such preset. */
double np_cloud_preset_get_extent(const char *name);

/* Name of a preset; NULL behind the last. */
const char *np_cloud_get_preset_name(size_t index);

/* Lists their names, separated by ", ". */
void np_cloud_list_presets(np_text *out);

#endif
