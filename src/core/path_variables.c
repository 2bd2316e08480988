/* SPDX-License-Identifier: Apache-2.0 */
#include "core/path_variables.h"

#include <string.h>

#include "core/alloc.h"
#include "core/frame_name.h"

struct np_path_variables {
  size_t count;
  char **texts; /* "NAME=value" */
};

/* ---- Table ---- */

neph_result np_path_variables_create(neph_context *context, const char *const *texts, np_path_variables **out_table) {
  size_t count = 0;
  while (texts[count]) count++;
  np_path_variables *table = *out_table = np_alloc(context, 1, sizeof *table);
  if (!table) return NEPH_ERROR_OUT_OF_MEMORY;
  table->texts = np_alloc(context, count, sizeof *table->texts);
  if (!table->texts) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; i++) {
    const char *equals = strchr(texts[i], '=');
    if (!equals || equals == texts[i]) continue;
    char *copy = table->texts[table->count] = np_alloc_text(context, texts[i]);
    if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
    table->count++;
  }
  return NEPH_OK;
}

void np_path_variables_destroy(neph_context *context, np_path_variables *table) {
  if (!table) return;
  for (size_t i = 0; i < table->count; i++) np_alloc_free(context, table->texts[i]);
  np_alloc_free(context, table->texts);
  np_alloc_free(context, table);
}

/* Value of a variable; NULL: it is not set. */
static const char *get_value(const np_path_variables *table, const char *name, size_t length) {
  for (size_t i = 0; table && i < table->count; i++)
    if (!strncmp(table->texts[i], name, length) && table->texts[i][length] == '=') return table->texts[i] + length + 1;
  return NULL;
}

/* ---- Expansion ---- */

/* State of an expansion: the text so far, and the rest of the name. */
typedef struct expansion {
  neph_context *context;
  const np_path_variables *table;
  char *text;
  const char *rest;
  char **out_problem;
} expansion;

static neph_result refuse(const expansion *e, const char *format, ...) __attribute__((format(printf, 2, 3)));

static neph_result refuse(const expansion *e, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  *e->out_problem = np_alloc_printf_list(e->context, format, arguments);
  va_end(arguments);
  return *e->out_problem ? NEPH_ERROR_BAD_SCENE : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result add(expansion *e, const char *text, size_t length) {
  char *longer = np_alloc_printf(e->context, "%s%.*s", e->text, (int)length, text);
  np_alloc_free(e->context, e->text);
  e->text = longer;
  return longer ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result add_value(expansion *e, const char *name, size_t length) {
  const char *value = get_value(e->table, name, length);
  if (value && *value) return add(e, value, strlen(value));
  return refuse(e, "the variable %.*s is %s: set it, or write $$ for a dollar", (int)length, name,
                value ? "empty" : "not set");
}

static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

static size_t count_name(const char *text) {
  size_t length = is_letter(*text);
  while (length && (is_letter(text[length]) || (text[length] >= '0' && text[length] <= '9'))) length++;
  return length;
}

static neph_result add_braced(expansion *e) {
  const char *name = e->rest + 2;
  const size_t length = count_name(name);
  if (!length || name[length] != '}')
    return refuse(e, "\"%s\" is no variable, must be ${NAME} of letters, digits and _, or $$ for a dollar", e->rest);
  e->rest = name + length + 1;
  return add_value(e, name, length);
}

static neph_result add_dollar(expansion *e) {
  const char *begin = e->rest;
  const size_t place = np_frame_name_count_dollar(begin), name = count_name(begin + 1);
  const bool is_variable = !place && name;
  if (begin[1] == '{') return add_braced(e);
  e->rest += place ? place : name ? 1 + name : begin[1] == '$' ? 2 : 1;
  return is_variable ? add_value(e, begin + 1, name) : add(e, begin, (size_t)(e->rest - begin));
}

static neph_result add_home(expansion *e) {
  if (e->rest[0] != '~') return NEPH_OK;
  if (e->rest[1] && e->rest[1] != '/')
    return refuse(e,
                  "~ is followed by %s: homes of other users are not expanded; write ~/, or ./~ for a file whose "
                  "name begins so",
                  e->rest + 1);
  e->rest++;
  return add_value(e, "HOME", 4);
}

neph_result np_path_variables_expand(neph_context *context, const np_path_variables *table, const char *name,
                                     char **out_name, char **out_problem) {
  expansion e = {context, table, np_alloc_text(context, ""), name, out_problem};
  *out_name = NULL;
  *out_problem = NULL;
  neph_result result = e.text ? add_home(&e) : NEPH_ERROR_OUT_OF_MEMORY;
  while (!result && *e.rest) {
    const size_t plain = strcspn(e.rest, "$");
    result = plain ? add(&e, e.rest, plain) : add_dollar(&e);
    e.rest += plain;
  }
  if (result)
    np_alloc_free(context, e.text);
  else
    *out_name = e.text;
  return result;
}
