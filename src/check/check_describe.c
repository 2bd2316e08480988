/* SPDX-License-Identifier: Apache-2.0 */
/* Findings in words and in JSON. */
#include <stdio.h>
#include <stdlib.h>

#include "check/findings.h"
#include "core/alloc.h"
#include "core/given.h"
#include "core/json.h"

static const char *const severities[] = {"note", "warning", "error"};

static void print_count(FILE *out, size_t count, const char *what, const char *separator) {
  fprintf(out, "%s%zu %s%s", separator, count, what, count == 1 ? "" : "s");
}

/* Prints a name without bytes that a terminal would obey: grids may have any name. */
static void print_safely(FILE *out, const char *text) {
  for (; *text; text++) {
    const unsigned char c = (unsigned char)*text;
    fputc(c < ' ' || c == 127 ? '?' : c, out);
  }
}

/* Whether a place is "12:3", of a scene, which follows the name as in compilers' messages. */
static bool is_line(const char *place) { return *place >= '0' && *place <= '9'; }

static void print_finding(FILE *out, const np_finding *f) {
  if (f->file) fprintf(out, "%s%s%s: ", f->file, is_line(f->place) ? ":" : "", is_line(f->place) ? f->place : "");
  fprintf(out, "%s: ", severities[f->severity]);
  if (f->grid[0]) {
    fputs("grid '", out);
    print_safely(out, f->grid);
    fputs("': ", out);
  }
  print_safely(out, f->cause);
  if (f->place[0] && !is_line(f->place)) fprintf(out, "; at %s", f->place);
  if (f->frame_count > 1) fprintf(out, "; so in %u files", f->frame_count);
  if (f->remedy) fprintf(out, " -> %s", f->remedy);
  fprintf(out, " [%s]\n", f->rule);
}

static void print_all(const neph_check *check, FILE *out) {
  for (size_t i = 0; i < check->listed; i++) print_finding(out, &check->findings[i]);
  print_count(out, check->counts[NEPH_SEVERITY_ERROR], "error", "");
  print_count(out, check->counts[NEPH_SEVERITY_WARNING], "warning", ", ");
  print_count(out, check->counts[NEPH_SEVERITY_NOTE], "note", ", ");
  const size_t all = check->counts[0] + check->counts[1] + check->counts[2];
  fprintf(out, all > check->listed ? ", of which %zu are listed\n" : "\n", check->listed);
}

static neph_result describe_plain(const neph_check *check, char **out_text) {
  char *lines = NULL;
  size_t size = 0;
  FILE *out = open_memstream(&lines, &size);
  if (out) print_all(check, out);
  const bool is_written = out && !fclose(out);
  if (is_written) *out_text = np_alloc_text(check->context, lines);
  free(lines);
  if (*out_text) return NEPH_OK;
  return is_written ? NEPH_ERROR_OUT_OF_MEMORY
                    : np_fail(check->context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory: no room for text");
}

static void put_finding(np_json *json, const np_finding *f) {
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "severity", severities[f->severity]);
  np_json_put_text(json, "rule", f->rule);
  np_json_put_text(json, "file", f->file);
  np_json_put_text(json, "grid", f->grid[0] ? f->grid : NULL);
  np_json_put_text(json, "place", f->place[0] ? f->place : NULL);
  np_json_put_text(json, "cause", f->cause);
  np_json_put_text(json, "remedy", f->remedy);
  if (f->sequence) np_json_put_integer(json, "files", f->frame_count);
  np_json_end(json);
}

static neph_result describe_json(const neph_check *check, char **out_text) {
  np_json *json = np_json_create(check->context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_integer(json, "errors", (int64_t)check->counts[NEPH_SEVERITY_ERROR]);
  np_json_put_integer(json, "warnings", (int64_t)check->counts[NEPH_SEVERITY_WARNING]);
  np_json_put_integer(json, "notes", (int64_t)check->counts[NEPH_SEVERITY_NOTE]);
  np_json_begin_array(json, "findings");
  for (size_t i = 0; i < check->listed; i++) put_finding(json, &check->findings[i]);
  np_json_end(json);
  return np_json_finish(json, out_text);
}

neph_result neph_check_describe(const neph_check *check, neph_text_format format, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(check), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  return format == NEPH_TEXT_JSON ? describe_json(check, out_text) : describe_plain(check, out_text);
}
