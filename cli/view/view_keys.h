/* SPDX-License-Identifier: Apache-2.0 */
/* Keys that an edit may set, by the schema. */
#ifndef NEPHOS_CLI_VIEW_KEYS_H
#define NEPHOS_CLI_VIEW_KEYS_H

#include <stdbool.h>
#include <stddef.h>

typedef enum cli_view_key_use {
  CLI_VIEW_KEY_PLAIN,  /* any value may be set */
  CLI_VIEW_KEY_FILE,   /* its value names a file */
  CLI_VIEW_KEY_MAPPING /* its value may hold other keys: a word alone, such as none, may be set */
} cli_view_key_use;

/* The use of a key; `schema` is the JSON of neph_schema_describe. A key that is not in it, such as an old name, counts
 * as a mapping. */
cli_view_key_use cli_view_key_get_use(const char *schema, const char *key);

/* Splits a line of neph_scene_describe's JSON whose value is a quoted text, in place, into key and text; false: it is
 * another. */
bool cli_view_split_text(char *line, char **out_key, char **out_text);

/* The least number of samples a pixel that the channels of a scene need: two for an error. `described` is the JSON of
 * neph_scene_describe. */
unsigned cli_view_get_samples_min(const char *described);

/* Reads numbers, with spaces between, that fill a text; false: there are more, or fewer. */
bool cli_view_read_numbers(const char *text, size_t count, double *out);

/* Whether a value is a word alone. */
bool cli_view_value_is_word(const char *value);

/* The work that the edit of a key causes. */
typedef enum cli_view_cost {
  CLI_VIEW_COST_DISPLAY, /* pixels are developed anew: exposure, view */
  CLI_VIEW_COST_RENDER,  /* rays and light */
  CLI_VIEW_COST_BAKE     /* clouds or ground */
} cli_view_cost;

cli_view_cost cli_view_key_get_cost(const char *schema, const char *key);

#endif
