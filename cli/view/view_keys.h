/* SPDX-License-Identifier: Apache-2.0 */
/* Keys that an edit may set, by the schema. */
#ifndef NEPHOS_CLI_VIEW_KEYS_H
#define NEPHOS_CLI_VIEW_KEYS_H

#include <stdbool.h>

typedef enum cli_view_key_use {
  CLI_VIEW_KEY_PLAIN,  /* any value may be set */
  CLI_VIEW_KEY_FILE,   /* its value names a file */
  CLI_VIEW_KEY_MAPPING /* its value may hold other keys: a word alone, such as none, may be set */
} cli_view_key_use;

/* The use of a key; `schema` is the JSON of neph_schema_describe. A key that is not in it, such as an old name, counts
 * as a mapping. */
cli_view_key_use cli_view_key_get_use(const char *schema, const char *key);

/* Whether a value is a word alone. */
bool cli_view_value_is_word(const char *value);

/* Whether a key changes the pixels of a picture alone, not its radiance: exposure, view. */
bool cli_view_key_is_display(const char *schema, const char *key);

#endif
