/* SPDX-License-Identifier: Apache-2.0 */
/* Descriptions of clouds: validation, and JSON. */
#ifndef NP_CLOUD_CLOUD_DESC_H
#define NP_CLOUD_CLOUD_DESC_H

#include <nephos/cloud.h>

/* Copies a caller's description (NULL: the defaults) and checks every field. */
neph_result np_cloud_desc_read(neph_context *context, const neph_cloud_desc *desc, neph_cloud_desc *out_desc);

/* The description, and the settings of the bake that affect values, as JSON; freed with np_alloc_free. */
neph_result np_cloud_desc_to_json(neph_context *context, const neph_cloud_desc *desc, const neph_bake_desc *bake,
                                  char **out_text);

/* Reads such JSON; `file` is its source, for messages. The result is not checked. */
neph_result np_cloud_desc_from_json(neph_context *context, const char *file, const char *text,
                                    neph_cloud_desc *out_desc, neph_bake_desc *bake);

/* Frees the texts of a description from np_cloud_desc_from_json. */
void np_cloud_desc_clear(neph_context *context, neph_cloud_desc *desc);

#endif
