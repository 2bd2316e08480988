/* SPDX-License-Identifier: Apache-2.0 */
/* Names of clouds in messages. */
#ifndef NP_CLOUD_CLOUD_NAME_H
#define NP_CLOUD_CLOUD_NAME_H

#include <nephos/cloud.h>

/* Beginning of messages: "clouds[0].bake". */
static inline const char *np_cloud_desc_name(const neph_cloud_desc *desc) { return desc->name ? desc->name : "cloud"; }

#endif
