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

/* The type of a key, as its JSON goes on behind the key; NULL: the key is not in the schema. */
static const char *search_type(const char *schema, const char *plain_key) {
  static const char lead[] = "\"type\": \"";
  cli_text entry = {0};
  cli_text_add(&entry, "\"key\": \"%s\",", plain_key);
  const char *place = entry.has_failed ? NULL : strstr(schema, cli_text_get(&entry));
  if (place) place += entry.length + strspn(place + entry.length, " \n");
  cli_text_clear(&entry);
  return place && !strncmp(place, lead, sizeof lead - 1) ? place + sizeof lead - 1 : NULL;
}

cli_view_key_use cli_view_key_get_use(const char *schema, const char *key) {
  char *plain = strpbrk(key, "\"\\") ? NULL : strip_indices(key);
  const char *type = plain ? search_type(schema, plain) : NULL;
  free(plain);
  if (!type || !strncmp(type, "section\"", 8) || !strncmp(type, "list\"", 5)) return CLI_VIEW_KEY_MAPPING;
  return strncmp(type, "file\"", 5) ? CLI_VIEW_KEY_PLAIN : CLI_VIEW_KEY_FILE;
}

bool cli_view_value_is_word(const char *value) {
  for (const char *c = value; *c; c++)
    if (!isalpha((unsigned char)*c) && (c == value || !strchr("-_", *c))) return false;
  return *value;
}

bool cli_view_key_is_view(const char *key) { return !strcmp(key, "output.exposure") || !strcmp(key, "output.view"); }
