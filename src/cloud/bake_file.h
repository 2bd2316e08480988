/* SPDX-License-Identifier: Apache-2.0 */
/* Bakes as files. */
#ifndef NP_CLOUD_BAKE_FILE_H
#define NP_CLOUD_BAKE_FILE_H

#include <nephos/cloud.h>

/* Whether a file was baked from this cloud for this planet and in these levels of detail, as its nephos:params say, and
 * all levels are there; it may have been pruned, or be of a region. Files without parameters, not ours, are taken to
 * be. */
neph_result np_cloud_file_is_current(neph_context *context, const char *path, const neph_cloud_desc *cloud,
                                     const neph_bake_desc *bake, bool *out_is_current);

#endif
