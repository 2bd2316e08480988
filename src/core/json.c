/* SPDX-License-Identifier: Apache-2.0 */
#include "core/json.h"

#include <assert.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

enum {
  DEPTH_MAX = 32,
  REAL_DIGITS = 15 /* digits that every double keeps: 0.1 is written as 0.1 */
};

struct np_json {
  neph_context *context;
  json_t *open[DEPTH_MAX]; /* containers that are open, the outermost first; it owns the others */
  int depth;
  bool has_failed;
};

np_json *np_json_create(neph_context *context) {
  np_json *json = np_alloc(context, 1, sizeof *json);
  if (!json) return NULL;
  json->context = context;
  json->open[0] = json_object();
  json->depth = 1;
  json->has_failed = !json->open[0];
  return json;
}

void np_json_destroy(np_json *json) {
  if (!json) return;
  json_decref(json->open[0]);
  np_alloc_free(json->context, json);
}

/* Copy of a text with other bytes than UTF-8 replaced: file names and metadata may hold any bytes. */
static char *copy_ascii(neph_context *context, const char *text) {
  char *copy = np_alloc_text(context, text);
  for (char *c = copy; c && *c; c++)
    if ((unsigned char)*c > 127) *c = '?';
  return copy;
}

/* Sets a member. jansson refuses a key or a text only where it is not UTF-8. */
static int set_member(np_json *json, json_t *object, const char *key, json_t *value) {
  if (!json_object_set(object, key, value)) return 0;
  char *ascii = key && value ? copy_ascii(json->context, key) : NULL;
  const int error = ascii ? json_object_set(object, ascii, value) : -1;
  np_alloc_free(json->context, ascii);
  return error;
}

/* Puts a value into the innermost container, which takes ownership of it. */
static void put_value(np_json *json, const char *key, json_t *value) {
  assert(json->depth >= 1 && json->depth <= DEPTH_MAX);
  json_t *container = json->has_failed ? NULL : json->open[json->depth - 1];
  int error = json_is_array(container) ? json_array_append(container, value) : set_member(json, container, key, value);
  json_decref(value);
  if (error) json->has_failed = true;
}

static void begin_container(np_json *json, const char *key, json_t *container) {
  if (json->depth == DEPTH_MAX) json->has_failed = true;
  json_incref(container); /* put_value drops a container that it cannot place */
  put_value(json, key, container);
  if (!json->has_failed) json->open[json->depth++] = container;
  json_decref(container);
}

void np_json_begin_object(np_json *json, const char *key) { begin_container(json, key, json_object()); }

void np_json_begin_array(np_json *json, const char *key) { begin_container(json, key, json_array()); }

void np_json_end(np_json *json) {
  if (json->depth > 1)
    json->depth--;
  else
    json->has_failed = true;
}

static json_t *make_text(neph_context *context, const char *value) {
  json_t *made = json_string(value);
  if (made) return made;
  char *ascii = copy_ascii(context, value);
  made = ascii ? json_string(ascii) : NULL;
  np_alloc_free(context, ascii);
  return made;
}

void np_json_put_text(np_json *json, const char *key, const char *value) {
  put_value(json, key, value ? make_text(json->context, value) : json_null());
}

static json_t *make_real(double value) { return isfinite(value) ? json_real(value) : json_null(); }

void np_json_put_real(np_json *json, const char *key, double value) { put_value(json, key, make_real(value)); }

void np_json_put_integer(np_json *json, const char *key, int64_t value) { put_value(json, key, json_integer(value)); }

void np_json_put_bool(np_json *json, const char *key, bool value) { put_value(json, key, json_boolean(value)); }

void np_json_put_reals(np_json *json, const char *key, const double *values, size_t count) {
  json_t *array = json_array();
  for (size_t i = 0; i < count; i++)
    if (json_array_append_new(array, make_real(values[i]))) json->has_failed = true;
  put_value(json, key, array);
}

neph_result np_json_finish(np_json *json, char **out_text) {
  *out_text = NULL;
  neph_context *context = json->context;
  const bool is_whole = !json->has_failed && json->depth == 1;
  char *dumped = is_whole ? json_dumps(json->open[0], JSON_INDENT(2) | JSON_REAL_PRECISION(REAL_DIGITS)) : NULL;
  neph_result result = NEPH_OK;
  if (dumped) {
    *out_text = np_alloc_text(context, dumped);
    if (!*out_text) result = NEPH_ERROR_OUT_OF_MEMORY;
  } else {
    result = np_fail(context, NEPH_ERROR_INTERNAL, "JSON text cannot be made: out of memory, or badly nested");
  }
  free(dumped);
  np_json_destroy(json);
  return result;
}

/* ---- Reading ---- */

/* Value of a key; np_json_value is json_t under a name of the library. */
static const json_t *get_value(const np_json_value *value, const char *key) {
  return json_object_get((const json_t *)(const void *)value, key);
}

np_json_value *np_json_read(const char *text) {
  json_t *value = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
  if (json_is_object(value)) return (np_json_value *)(void *)value;
  json_decref(value);
  return NULL;
}

void np_json_value_destroy(np_json_value *value) { json_decref((json_t *)(void *)value); }

const char *np_json_get_text(const np_json_value *value, const char *key) {
  return json_string_value(get_value(value, key));
}

const np_json_value *np_json_get_element(const np_json_value *value, const char *key, size_t index) {
  const json_t *element = json_array_get(get_value(value, key), index);
  return json_is_object(element) ? (const np_json_value *)(const void *)element : NULL;
}

bool np_json_get_reals(const np_json_value *value, const char *key, double *out, size_t count) {
  const json_t *found = get_value(value, key);
  if (count == 1 && json_is_number(found)) return *out = json_number_value(found), true;
  if (json_array_size(found) != count) return false;
  for (size_t i = 0; i < count; i++) {
    const json_t *item = json_array_get(found, i);
    if (!json_is_number(item)) return false;
    out[i] = json_number_value(item);
  }
  return true;
}

bool np_json_get_bool(const np_json_value *value, const char *key, bool *out) {
  const json_t *found = get_value(value, key);
  *out = json_is_true(found);
  return json_is_boolean(found);
}
