/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_splice.h"

#include <string.h>

#include "core/alloc.h"

static neph_result reserve(np_splices *s) {
  if (s->count < s->capacity) return NEPH_OK;
  const size_t capacity = s->capacity ? 2 * s->capacity : 16;
  np_splice *list = np_alloc(s->context, capacity, sizeof *list);
  if (!list) return NEPH_ERROR_OUT_OF_MEMORY;
  if (s->count) memcpy(list, s->list, s->count * sizeof *list);
  np_alloc_free(s->context, s->list);
  s->list = list;
  s->capacity = capacity;
  return NEPH_OK;
}

/* Inserts a splice behind those that begin no later. */
static void insert(np_splices *s, np_splice splice) {
  size_t at = s->count++;
  for (; at > 0 && s->list[at - 1].begin > splice.begin; at--) s->list[at] = s->list[at - 1];
  s->list[at] = splice;
}

void np_splices_add(np_splices *splices, size_t begin, size_t end, np_text *text) {
  np_splice splice = {begin, end, NULL};
  neph_result result = np_text_finish(text, &splice.text);
  if (!result) result = reserve(splices);
  if (!result)
    insert(splices, splice);
  else
    np_alloc_free(splices->context, splice.text);
  if (!splices->result) splices->result = result;
}

neph_result np_splices_apply(np_splices *splices, const char *text, size_t size, char **out_text) {
  np_text out = {.context = splices->context};
  size_t at = 0;
  bool is_overlapping = false;
  *out_text = NULL;
  if (splices->result) return splices->result;
  for (size_t i = 0; i < splices->count && !is_overlapping; i++) {
    const np_splice *splice = &splices->list[i];
    is_overlapping = splice->begin < at || splice->end > size;
    if (is_overlapping) break;
    np_text_add(&out, "%.*s%s", (int)(splice->begin - at), text + at, splice->text);
    at = splice->end;
  }
  if (is_overlapping) return np_text_end(&out, NEPH_ERROR_INTERNAL);
  np_text_add(&out, "%.*s", (int)(size - at), text + at);
  return np_text_finish(&out, out_text);
}

void np_splices_clear(np_splices *splices) {
  for (size_t i = 0; i < splices->count; i++) np_alloc_free(splices->context, splices->list[i].text);
  np_alloc_free(splices->context, splices->list);
}
