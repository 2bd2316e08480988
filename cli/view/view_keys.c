/* SPDX-License-Identifier: Apache-2.0 */
#include "view_keys.h"

#include <ctype.h>
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

bool cli_view_key_is_display(const char *schema, const char *key) {
  return is_text(search_member(schema, key, "cost"), "\"display\"");
}

bool cli_view_value_is_word(const char *value) {
  for (const char *c = value; *c; c++)
    if (!isalpha((unsigned char)*c) && (c == value || !strchr("-_", *c))) return false;
  return *value;
}
