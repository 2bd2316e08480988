/* SPDX-License-Identifier: Apache-2.0 */
#include "job_text.h"

#include <stdint.h>
#include <string.h>

#include "print.h"

/* ---- Characters ---- */

/* Decodes the UTF-8 character at `text`. Returns its length in bytes; 0: the byte begins no character. */
static size_t read_character(const unsigned char *text, uint32_t *out_code) {
  static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  const unsigned char first = text[0];
  const size_t length = first < 0x80 ? 1 : first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  uint32_t code = first;
  if (first >= 0xf8 || (first >= 0x80 && first < 0xc0)) return 0;
  if (length > 1) code = first & (0xffu >> (length + 1));
  for (size_t i = 1; i < length; i++) {
    if ((text[i] & 0xc0) != 0x80) return 0;
    code = code << 6 | (text[i] & 0x3fu);
  }
  *out_code = code;
  return code < least[length] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000) ? 0 : length;
}

/* Whether a character is a control of Latin-1, or missing from XML or YAML. */
static bool is_foreign(uint32_t code) { return (code >= 0x80 && code < 0xa0) || (code & 0xfffe) == 0xfffe; }

static bool is_control(unsigned char c) { return c < 0x20 || c == 0x7f; }

/* Whether a character is a line break of YAML, or its byte order mark. */
static bool is_yaml_break(uint32_t code) { return code == 0x2028 || code == 0x2029 || code == 0xfeff; }

/* ---- Faults ---- */

static void name_byte(unsigned char c, farm_text_fault *out) {
  if (c == '\n' || c == '\r' || c == '\t')
    cli_print(out->name, sizeof out->name, "a %s (0x%02X)", c == '\n' ? "line break" : c == '\r' ? "return" : "tab", c);
  else if (is_control(c))
    cli_print(out->name, sizeof out->name, "a control character (0x%02X)", c);
  else if (c < 0x80)
    cli_print(out->name, sizeof out->name, "the character %c", c);
  else
    cli_print(out->name, sizeof out->name, "a byte that is not UTF-8 (0x%02X)", c);
}

/* Whether the byte at `c` is refused by itself. */
static bool is_refused(const farm_text_rule *rule, unsigned char c) {
  return (is_control(c) && !(c == '\t' && rule->has_tabs)) || (rule->refused && strchr(rule->refused, c));
}

/* Checks a character beyond ASCII. Returns its length; 0: it is refused. */
static size_t check_character(const farm_text_rule *rule, const unsigned char *c, farm_text_fault *out) {
  uint32_t code;
  const size_t length = read_character(c, &code);
  if (!rule->is_unicode) return length ? length : 1;
  if (!length) name_byte(*c, out);
  if (!length || !is_foreign(code)) return length;
  cli_print(out->name, sizeof out->name, "a control character (U+%04X)", (unsigned)code);
  return 0;
}

bool farm_text_check(const farm_text_rule *rule, const char *text, bool is_option, farm_text_fault *out) {
  const char *reserved = is_option && rule->reserved ? strstr(text, rule->reserved) : NULL;
  for (const unsigned char *c = (const unsigned char *)text; *c;) {
    out->place = (size_t)(c - (const unsigned char *)text) + 1;
    if ((const char *)c == reserved) {
      cli_print(out->name, sizeof out->name, "%s (which the farm replaces)", rule->reserved);
      return false;
    }
    if (is_refused(rule, *c)) {
      name_byte(*c, out);
      return false;
    }
    const size_t length = *c < 0x80 ? 1 : check_character(rule, c, out);
    if (!length) return false;
    c += length;
  }
  return true;
}

/* ---- Quoting ---- */

/* Characters that have no meaning for a shell anywhere in a word. */
static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:@%=";

static bool is_split(const farm_text_rule *rule, const char *c) {
  if (!rule || !rule->split || *c != rule->split) return false;
  return !rule->split_before || (c[1] && strchr(rule->split_before, c[1]));
}

static bool is_plain(const farm_text_rule *rule, const char *text) {
  for (const char *c = text; *c; c++)
    if (is_split(rule, c) || !(strchr(plain, *c) || (*c == '#' && c > text))) return false;
  return *text != '\0';
}

void farm_text_put_word(FILE *out, const farm_text_rule *rule, const char *text) {
  if (is_plain(rule, text)) {
    fputs(text, out);
    return;
  }
  putc('\'', out);
  for (const char *c = text; *c; c++)
    if (*c == '\'')
      fputs("'\\''", out);
    else {
      putc(*c, out);
      if (is_split(rule, c)) fputs("''", out);
    }
  putc('\'', out);
}

void farm_text_put_shown(FILE *out, const char *text) {
  bool is_printable = true;
  for (const char *c = text; *c; c++) is_printable = is_printable && *c >= 0x20 && *c < 0x7f;
  if (is_printable) {
    farm_text_put_word(out, NULL, text);
    return;
  }
  fputs("$'", out);
  for (const unsigned char *c = (const unsigned char *)text; *c; c++)
    if (*c == '\'' || *c == '\\')
      fprintf(out, "\\%c", *c);
    else if (*c >= 0x20 && *c < 0x7f)
      putc(*c, out);
    else
      fprintf(out, "\\%03o", *c);
  putc('\'', out);
}

void farm_text_put_json(FILE *out, const char *text) {
  putc('"', out);
  for (const unsigned char *c = (const unsigned char *)text; *c;) {
    uint32_t code = *c;
    const size_t length = read_character(c, &code);
    if (*c == '"' || *c == '\\')
      fprintf(out, "\\%c", *c);
    else if (*c < 0x20 || is_yaml_break(code))
      fprintf(out, "\\u%04x", (unsigned)code);
    else
      fwrite(c, 1, length ? length : 1, out);
    c += length ? length : 1;
  }
  putc('"', out);
}
