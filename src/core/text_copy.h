/* SPDX-License-Identifier: Apache-2.0 */
/* Short copies of texts from outside, also for modules and programs that are not linked with the library. */
#ifndef NP_CORE_TEXT_COPY_H
#define NP_CORE_TEXT_COPY_H

#include <stddef.h>
#include <string.h>

#define NP_DOTS "..."

/* Ends a text that fills its array in "...", behind a whole character of UTF-8. Returns the length. */
static inline size_t np_text_end_short(char *out, size_t size) {
  if (size < sizeof NP_DOTS) return size ? size - 1 : 0;
  size_t end = size - sizeof NP_DOTS;
  while (end && ((unsigned char)out[end] & 0xC0) == 0x80) end--;
  memcpy(out + end, NP_DOTS, sizeof NP_DOTS);
  return end + sizeof NP_DOTS - 1;
}

/* Copies a text of any length, to show it in a message: control characters become '?', and a longer text ends in "...".
 * Returns the length. */
static inline size_t np_text_copy_short(char *out, size_t size, const char *text) {
  const size_t length = strlen(text), copied = length < size ? length : size - 1;
  memcpy(out, text, copied);
  out[copied] = '\0';
  for (unsigned char *c = (unsigned char *)out; *c; c++)
    if (*c < ' ' || *c == 127) *c = '?';
  return length < size ? length : np_text_end_short(out, size);
}

#endif
