/* SPDX-License-Identifier: Apache-2.0 */
/* Short copies of texts from outside, also for modules and programs that are not linked with the library. */
#ifndef NP_CORE_TEXT_COPY_H
#define NP_CORE_TEXT_COPY_H

#include <stddef.h>
#include <string.h>

#define NP_DOTS "..."

/* Ends a text that fills its array with "...", after a whole UTF-8 character. Returns the length. */
static inline size_t np_text_end_short(char *out, size_t size) {
  if (size < sizeof NP_DOTS) return size ? size - 1 : 0;
  size_t end = size - sizeof NP_DOTS;
  while (end && ((unsigned char)out[end] & 0xC0) == 0x80) end--;
  memcpy(out + end, NP_DOTS, sizeof NP_DOTS);
  return end + sizeof NP_DOTS - 1;
}

/* Length in bytes of the UTF-8 character at the start of a text; 0: there is none, or it is a control character.
 * Overlong forms, surrogates and code points beyond U+10FFFF are invalid. */
static inline size_t np_text_measure(const unsigned char *c) {
  static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
  if (*c < 0x80) return *c >= ' ' && *c != 127;
  const size_t length = *c >= 0xF0 ? 4 : *c >= 0xE0 ? 3 : 2;
  if (*c < 0xC2 || *c > 0xF4) return 0;
  unsigned code = *c & (0x7Fu >> length);
  for (size_t i = 1; i < length; i++) {
    if ((c[i] & 0xC0) != 0x80) return 0;
    code = code << 6 | (c[i] & 0x3Fu);
  }
  const int is_surrogate = code >= 0xD800 && code < 0xE000, is_control = code < 0xA0;
  return code >= least[length] && code <= 0x10FFFF && !is_surrogate && !is_control ? length : 0;
}

/* Replaces control characters, of one byte or two, and bytes that are not UTF-8 by '?'. */
static inline void np_text_clean(char *text) {
  for (unsigned char *c = (unsigned char *)text; *c;) {
    const size_t length = np_text_measure(c);
    if (!length) *c = '?';
    c += length ? length : 1;
  }
}

/* Copies a text of any length for a message: clean, and a longer text ends in "...". Returns the length. */
static inline size_t np_text_copy_short(char *out, size_t size, const char *text) {
  const size_t length = strlen(text), copied = length < size ? length : size - 1;
  memcpy(out, text, copied);
  out[copied] = '\0';
  const size_t shown = length < size ? length : np_text_end_short(out, size);
  np_text_clean(out);
  return shown;
}

#endif
