/* SPDX-License-Identifier: Apache-2.0 */
#include "print.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nephos/text.h>

void cli_text_add_list(cli_text *text, const char *format, va_list arguments) {
  va_list again;
  va_copy(again, arguments);
  const int length = vsnprintf(NULL, 0, format, arguments);
  const size_t size = text->length + (size_t)(length < 0 ? 0 : length) + 1;
  char *longer = text->has_failed || length < 0 ? NULL : realloc(text->characters, size);
  text->has_failed = !longer;
  if (longer) text->characters = longer;
  if (longer && vsnprintf(longer + text->length, size - text->length, format, again) == length) text->length = size - 1;
  va_end(again);
}

void cli_text_add(cli_text *text, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  cli_text_add_list(text, format, arguments);
  va_end(arguments);
}

const char *cli_text_get(const cli_text *text) { return text->length ? text->characters : ""; }

void cli_text_clear(cli_text *text) {
  free(text->characters);
  *text = (cli_text){0};
}

void cli_put_line(FILE *out, const char *before, const char *format, va_list arguments) {
  cli_text text = {0};
  cli_text_add_list(&text, format, arguments);
  neph_text_clean(text.characters);
  fprintf(out, "%s%s\n", before, cli_text_get(&text));
  cli_text_clear(&text);
}

void cli_complain(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  flockfile(stderr);
  cli_put_line(stderr, "nephos: ", format, arguments);
  funlockfile(stderr);
  va_end(arguments);
}

void cli_say(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  cli_put_line(stdout, "", format, arguments);
  va_end(arguments);
}

void cli_show(const char *name) {
  cli_text text = {0};
  cli_text_add(&text, "%s", name);
  neph_text_clean(text.characters);
  fputs(cli_text_get(&text), stdout);
  cli_text_clear(&text);
}

void cli_clean_lines(char *text) {
  for (char *line = text; *line;) {
    char *end = line + strcspn(line, "\n\t"), mark = *end;
    *end = '\0';
    neph_text_clean(line);
    *end = mark;
    line = mark ? end + 1 : end;
  }
}

void cli_put_json_text(FILE *out, const char *text) {
  putc('"', out);
  for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
    if (*c == '"' || *c == '\\')
      fprintf(out, "\\%c", *c);
    else if (*c < 0x20)
      fprintf(out, "\\u%04x", *c);
    else
      putc(*c, out);
  }
  putc('"', out);
}

void cli_print_json_text(const char *text) { cli_put_json_text(stdout, text); }

size_t cli_print(char *out, size_t size, const char *format, ...) {
  static const char dots[] = "...";
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(out, size, format, arguments);
  va_end(arguments);
  const bool fits = length >= 0 && (size_t)length < size;
  assert(fits);
  if (!fits && size >= sizeof dots) memcpy(out + size - sizeof dots, dots, sizeof dots);
  return fits ? (size_t)length : strlen(out);
}
