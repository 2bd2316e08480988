/* SPDX-License-Identifier: Apache-2.0 */
/* Names that a context looks up for scenes: variables in names of files, and time zones. */
#ifndef NEPHOS_NAMES_H
#define NEPHOS_NAMES_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct neph_names_desc {
  size_t struct_size;
  const char *const *variables; /**< texts "NAME=value", the last NULL: values of ${NAME}, $NAME and, from HOME, ~ in
                                     names of files in scenes, in the form of environ (default NULL: none) */
  const char *time_zone_dir;    /**< folder of time zones, files of the tz database such as America/New_York
                                     (default NULL: /usr/share/zoneinfo) */
} neph_names_desc;

#define NEPH_NAMES_DESC_DEFAULT                                                                                        \
  { .struct_size = sizeof(neph_names_desc), .variables = NULL, .time_zone_dir = NULL }

/** Sets the names of a context, in place of earlier ones; texts are copied. Call it before other calls use the context.
 *
 * @param desc  NULL for the defaults.
 */
NEPH_API neph_result neph_context_set_names(neph_context *context, const neph_names_desc *desc) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
