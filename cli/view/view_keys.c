/* SPDX-License-Identifier: Apache-2.0 */
#include "view_keys.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "print.h"

/* Copies a key without the numbers of its lists: "clouds[].vdb". NULL: no memory. */
static char *strip_indices(const char *key) {
  char *copy = strdup(key), *to = copy;
  for (const char *from = key; copy && *from; from++) {
    *to++ = *from;
    if (*from == '[') from += strspn(from + 1, "0123456789");
  }
  if (copy) *to = '\0';
  return copy;
}

/* A member of a key's entry, as its text goes on behind the name of the member; NULL: the key is not in the schema, or
 * has no such member. */
static const char *search_member(const char *schema, const char *key, const char *member) {
  char *plain = strpbrk(key, "\"\\") ? NULL : strip_indices(key);
  cli_text entry = {0}, name = {0};
  cli_text_add(&entry, "\"key\": \"%s\",", plain ? plain : "");
  cli_text_add(&name, "\"%s\": ", member);
  const bool is_complete = plain && !entry.has_failed && !name.has_failed;
  const char *place = is_complete ? strstr(schema, cli_text_get(&entry)) : NULL;
  const char *end = place ? strstr(place + entry.length, "\"key\": ") : NULL;
  const char *found = place ? strstr(place, cli_text_get(&name)) : NULL;
  const char *text = found && (!end || found < end) ? found + name.length : NULL;
  cli_text_clear(&entry);
  cli_text_clear(&name);
  free(plain);
  return text;
}

static bool is_text(const char *json, const char *quoted) { return json && !strncmp(json, quoted, strlen(quoted)); }

cli_view_key_use cli_view_key_get_use(const char *schema, const char *key) {
  const char *type = search_member(schema, key, "type");
  if (!type || is_text(type, "\"section\"") || is_text(type, "\"list\"")) return CLI_VIEW_KEY_MAPPING;
  return is_text(type, "\"file\"") ? CLI_VIEW_KEY_FILE : CLI_VIEW_KEY_PLAIN;
}

cli_view_cost cli_view_key_get_cost(const char *schema, const char *key) {
  const char *cost = search_member(schema, key, "cost");
  if (is_text(cost, "\"display\"")) return CLI_VIEW_COST_DISPLAY;
  return is_text(cost, "\"view\"") || is_text(cost, "\"light\"") ? CLI_VIEW_COST_RENDER : CLI_VIEW_COST_BAKE;
}

bool cli_view_split_text(char *line, char **out_key, char **out_text) {
  static const char middle[] = "\": \"\\\"", end[] = "\\\"\"";
  char *quote = strchr(line, '"'), *value = quote ? strstr(quote + 1, middle) : NULL;
  char *last = value ? strstr(value + sizeof middle - 1, end) : NULL;
  if (!last) return false;
  *value = *last = '\0';
  *out_key = quote + 1;
  *out_text = value + sizeof middle - 1;
  return !strchr(*out_text, '\\');
}

unsigned cli_view_get_samples_min(const char *described) {
  static const char *const errors[] = {"standard_error", "variance"};
  const char *channels = strstr(described, "\"output.aovs\": ");
  const char *end = channels ? channels + strcspn(channels, "\n") : NULL;
  for (size_t i = 0; channels && i < sizeof errors / sizeof *errors; i++) {
    const char *found = strstr(channels, errors[i]);
    if (found && found < end) return 2;
  }
  return 1;
}

bool cli_view_read_numbers(const char *text, size_t count, double *out) {
  const char *at = text;
  char *end;
  for (size_t i = 0; i < count; i++, at = end) {
    out[i] = strtod(at, &end);
    if (end == at || !isfinite(out[i])) return false;
  }
  return !*at;
}

bool cli_view_value_is_word(const char *value) {
  for (const char *c = value; *c; c++)
    if (!isalpha((unsigned char)*c) && (c == value || !strchr("-_", *c))) return false;
  return *value;
}
