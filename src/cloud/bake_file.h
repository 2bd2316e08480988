/* SPDX-License-Identifier: Apache-2.0 */
/* Bakes as .vdb files. */
#ifndef NP_CLOUD_BAKE_FILE_H
#define NP_CLOUD_BAKE_FILE_H

#include <nephos/cloud.h>

/* Whether a file was baked from this cloud for this planet with these levels of detail, by its metadata nephos:params,
 * and all level files exist; it may be pruned, or cover a region. Files without parameters, from other programs, count
 * as current. */
neph_result np_cloud_file_is_current(neph_context *context, const char *path, const neph_cloud_desc *cloud,
                                     const neph_bake_desc *bake, bool *out_is_current);

#endif
