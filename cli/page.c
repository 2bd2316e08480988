/* SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <ctype.h>
#include <string.h>

#include <nephos/base.h>

enum { WIDTH = 100, TERM_WIDTH = 28 };

/* ---- Text for a terminal ---- */

/* Number of UTF-8 characters in `length` bytes. */
static int count_letters(const char *text, int length) {
  int count = 0;
  for (int i = 0; i < length; i++) count += ((unsigned char)text[i] & 0xC0) != 0x80;
  return count;
}

/* Prints words up to a line end, in lines of WIDTH; the first begins in `column`, the others in `indent`. */
static void wrap(FILE *out, const char *text, int column, int indent) {
  bool is_first = true;
  while (*text && *text != '\n') {
    const int length = (int)strcspn(text, " \n"), letters = count_letters(text, length);
    if (!is_first && column + 1 + letters > WIDTH) {
      fprintf(out, "\n%*s", indent, "");
      column = indent;
      is_first = true;
    }
    column += fprintf(out, "%s%.*s", is_first ? "" : " ", length, text) - length + letters;
    is_first = false;
    text += length;
    text += strspn(text, " ");
  }
  fputc('\n', out);
}

/* ---- Roff ---- */

/* Decodes the code point at `*text`, and moves `*text` past it. */
static unsigned take_code_point(const char **text) {
  const unsigned char *c = (const unsigned char *)*text;
  const int more = *c >= 0xF0 ? 3 : *c >= 0xE0 ? 2 : *c >= 0xC0 ? 1 : 0;
  unsigned code = more ? *c & (0x3Fu >> more) : *c;
  for (int i = 1; i <= more && c[i]; i++) code = code << 6 | (c[i] & 0x3Fu);
  *text += 1 + more;
  return code;
}

/* Prints text on one line, with all characters escaped that roff interprets. */
static void put_roff(FILE *out, const char *text, bool is_upper) {
  if (*text == '.' || *text == '\'') fputs("\\&", out);
  while (*text && *text != '\n') {
    const unsigned code = take_code_point(&text);
    if (code == '\\')
      fputs("\\e", out);
    else if (code == '-')
      fputs("\\-", out);
    else if (code == '\'' || code == '`' || code == '^' || code == '~')
      fprintf(out, "\\(%s", code == '\'' ? "aq" : code == '`' ? "ga" : code == '^' ? "ha" : "ti");
    else if (code >= 0x80)
      fprintf(out, "\\[u%04X]", code);
    else
      fputc(is_upper ? toupper((int)code) : (int)code, out);
  }
}

static void put_roff_line(FILE *out, const char *before, const char *text, const char *behind) {
  fputs(before, out);
  put_roff(out, text, false);
  fputs(behind, out);
}

/* Prints the name of a command's page: "nephos-render" for "nephos render". */
static void put_page_name(FILE *out, const char *command, bool is_upper) {
  for (; *command && *command != ' '; command++) fputc(is_upper ? toupper((unsigned char)*command) : *command, out);
  if (*command) fputs("\\-", out), put_roff(out, command + 1, is_upper);
}

static void begin_man(const cli_page *page, const char *command, int section, const char *arguments,
                      const char *summary) {
  fputs(".TH ", page->out);
  put_page_name(page->out, command, true);
  fprintf(page->out, " %d \"\" \"nephos %s\" \"nephos manual\"\n.nh\n.SH NAME\n", section, neph_version_get_text());
  put_page_name(page->out, command, false);
  put_roff_line(page->out, " \\- ", summary, "\n");
  if (!arguments) return;
  put_roff_line(page->out, ".SH SYNOPSIS\n.B ", command, "\n");
  put_roff_line(page->out, "", arguments, "\n");
}

/* ---- Both ---- */

void cli_page_begin(const cli_page *page, const char *command, int section, const char *arguments,
                    const char *summary) {
  if (page->is_man) {
    begin_man(page, command, section, arguments, summary);
    fputs(".SH DESCRIPTION\n", page->out);
    return;
  }
  if (arguments) fprintf(page->out, "usage: %s %s\n", command, arguments);
  fprintf(page->out, "%s\n\n", summary);
}

void cli_page_add_section(const cli_page *page, const char *title) {
  fputs(page->is_man ? ".SH " : "\n", page->out);
  if (page->is_man)
    put_roff(page->out, title, true);
  else
    fprintf(page->out, "%s:", title);
  fputc('\n', page->out);
}

void cli_page_add_text(const cli_page *page, const char *text) {
  for (bool is_first = true; *text; is_first = false) {
    if (!is_first) fputs(page->is_man ? ".PP\n" : "\n", page->out);
    if (page->is_man)
      put_roff_line(page->out, "", text, "\n");
    else
      wrap(page->out, text, 0, 0);
    text += strcspn(text, "\n");
    text += strspn(text, "\n");
  }
}

void cli_page_add_item(const cli_page *page, const char *term, const char *text) {
  if (page->is_man) {
    put_roff_line(page->out, ".TP\n\\fB", term, "\\fR\n");
    put_roff_line(page->out, "", text, "\n");
    return;
  }
  const int length = count_letters(term, (int)strlen(term));
  fprintf(page->out, "  %s", term);
  if (length + 3 > TERM_WIDTH)
    fprintf(page->out, "\n%*s", TERM_WIDTH, "");
  else
    fprintf(page->out, "%*s", TERM_WIDTH - length - 2, "");
  wrap(page->out, text, TERM_WIDTH, TERM_WIDTH);
}

void cli_page_add_command(const cli_page *page, const char *command, const char *meaning) {
  if (page->is_man) {
    put_roff_line(page->out, ".PP\n", meaning, ":\n.PP\n.nf\n.RS\n");
    put_roff_line(page->out, "", command, "\n.RE\n.fi\n");
    return;
  }
  fprintf(page->out, "  %s\n      ", command);
  wrap(page->out, meaning, 6, 6);
}
