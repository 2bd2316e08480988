/* SPDX-License-Identifier: Apache-2.0 */
/* JSON by jansson. A writer builds one value in order and turns it into text; a reader parses it. */
#ifndef NP_CORE_JSON_H
#define NP_CORE_JSON_H

#include "core/context_private.h"

typedef struct np_json np_json;

/* Starts a writer with an open object. Failures are remembered and reported by np_json_finish, so that calls need no
 * checks. */
np_json *np_json_create(neph_context *context);
void np_json_destroy(np_json *json);

/* `key` is ignored inside an array (pass NULL there). */
void np_json_begin_object(np_json *json, const char *key);
void np_json_begin_array(np_json *json, const char *key);
void np_json_end(np_json *json);
void np_json_put_text(np_json *json, const char *key, const char *value); /* NULL becomes null */
void np_json_put_real(np_json *json, const char *key, double value);      /* non-finite numbers become null */
void np_json_put_integer(np_json *json, const char *key, int64_t value);
void np_json_put_bool(np_json *json, const char *key, bool value);
void np_json_put_reals(np_json *json, const char *key, const double *values, size_t count);

/* Finishes the text, indented, which np_alloc_free frees. Destroys `json` in any case. */
neph_result np_json_finish(np_json *json, char **out_text);

/* A parsed object; NULL when the text is no object. */
typedef struct np_json_value np_json_value;

np_json_value *np_json_read(const char *text);
void np_json_value_destroy(np_json_value *value); /* NULL is allowed */

/* Text of a key, valid as long as the object; NULL: there is no such text. */
const char *np_json_get_text(const np_json_value *value, const char *key);

/* Element of an array of objects, valid as long as the object; NULL: there is none. */
const np_json_value *np_json_get_element(const np_json_value *value, const char *key, size_t index);

/* Reads an array of numbers. False, with `out` undefined, when there is no array of this length. */
bool np_json_get_reals(const np_json_value *value, const char *key, double *out, size_t count);
bool np_json_get_bool(const np_json_value *value, const char *key, bool *out);

#endif
