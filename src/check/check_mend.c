/* SPDX-License-Identifier: Apache-2.0 */
/* Mended copies of files and of sequences. */
#include <nephos/check.h>

#include "core/alloc.h"
#include "core/frame_name.h"
#include "core/given.h"
#include "volume/volume_facts.h"

/* Mends each file of a sequence, and writes it with its number under another name. */
static neph_result mend_sequence(neph_context *context, const char *pattern, const char *out_pattern, char **out_text) {
  np_frame_numbers there;
  neph_result result = np_frame_name_list(context, pattern, &there);
  if (!result && !there.count)
    result = np_fail(context, NEPH_ERROR_NOT_FOUND, "%s: no file has a name of this pattern", pattern);
  *out_text = np_alloc_text(context, "");
  for (size_t i = 0; !result && i < there.count; i++) {
    char *path = np_frame_name_make(context, pattern, there.numbers[i]), *changes = NULL;
    char *out_path = np_frame_name_make(context, out_pattern, there.numbers[i]);
    result = path && out_path && *out_text ? np_volume_mend_file(context, path, out_path, NULL, &changes)
                                           : NEPH_ERROR_OUT_OF_MEMORY;
    char *longer = result ? NULL : np_alloc_printf(context, "%s%s:\n%s", *out_text, out_path, changes);
    if (!result) {
      np_alloc_free(context, *out_text);
      *out_text = longer;
    }
    np_alloc_free(context, changes);
    np_alloc_free(context, out_path);
    np_alloc_free(context, path);
  }
  np_alloc_free(context, there.numbers);
  return !result && !*out_text ? NEPH_ERROR_OUT_OF_MEMORY : result;
}

neph_result neph_check_mend_file(neph_context *context, const char *path, const char *out_path, char **out_text) {
  if (out_text) *out_text = NULL;
  if (NP_LACKS(context, path, out_path)) return NEPH_ERROR_INVALID_ARGUMENT;
  char *text = NULL;
  const bool is_sequence = np_frame_name_is_pattern(path);
  neph_result result = NEPH_OK;
  if (is_sequence != np_frame_name_is_pattern(out_path))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s: a mended copy of %s must be %s", out_path, path,
                   is_sequence ? "a sequence as well, with #### in its name" : "one file, without a number's place");
  result = is_sequence ? mend_sequence(context, path, out_path, &text)
                       : np_volume_mend_file(context, path, out_path, NULL, &text);
  if (out_text && !result)
    *out_text = text;
  else
    np_alloc_free(context, text);
  return result;
}
