/* SPDX-License-Identifier: Apache-2.0 */
/* Description of a preview's file from the texts in it. Chunks before the pixels are read (PNG specification, third
 * edition, section 5.3), and no pixel is decoded. */
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/json.h"
#include "core/text.h"
#include "image/preview.h"

enum { TEXT_MAX = 128, CHUNKS_MAX = 64 };

typedef struct preview_facts {
  unsigned width, height, bits;
  char frame[TEXT_MAX], exposure[TEXT_MAX], view[TEXT_MAX]; /* "": not in the file */
} preview_facts;

static uint32_t get_number(const uint8_t *bytes) {
  return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Stores a text of printable ASCII, since it is shown on a terminal. `chunk` ends with a zero after its value. */
static void take_text(const char *chunk, preview_facts *out) {
  const struct {
    const char *key;
    char *value;
  } rows[] = {{NP_PREVIEW_FRAME, out->frame}, {NP_PREVIEW_EXPOSURE, out->exposure}, {NP_PREVIEW_VIEW, out->view}};
  const char *value = chunk + strlen(chunk) + 1;
  for (const char *c = value; *c; c++)
    if (*c < 0x20 || *c > 0x7e) return;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    if (!strcmp(chunk, rows[i].key)) np_print(rows[i].value, TEXT_MAX, "%s", value);
}

/* Reads a chunk after its length and type. False: pixels begin, or the format is unknown. */
static bool read_chunk(FILE *file, preview_facts *out) {
  uint8_t head[8];
  char body[TEXT_MAX + 2] = "";
  if (fread(head, 1, sizeof head, file) != sizeof head || !memcmp(head + 4, "IDAT", 4)) return false;
  const uint32_t length = get_number(head);
  const bool is_header = !memcmp(head + 4, "IHDR", 4), is_text = !memcmp(head + 4, "tEXt", 4);
  if (length > INT32_MAX) return false;
  if ((!is_header && !is_text) || length > TEXT_MAX) return !fseek(file, (long)length + 4, SEEK_CUR);
  if (fread(body, 1, length, file) != length || fseek(file, 4, SEEK_CUR)) return false;
  if (is_text && strlen(body) < length) take_text(body, out);
  if (!is_header || length < 9) return true;
  out->width = get_number((const uint8_t *)body);
  out->height = get_number((const uint8_t *)body + 4);
  out->bits = (uint8_t)body[8];
  return true;
}

static void read_facts(FILE *file, preview_facts *out) {
  static const char signature[] = "\x89PNG\r\n\x1a\n";
  char begin[8];
  if (fread(begin, 1, sizeof begin, file) != sizeof begin || memcmp(begin, signature, sizeof begin)) return;
  for (int i = 0; i < CHUNKS_MAX && read_chunk(file, out); i++) continue;
}

/* ---- Texts ---- */

static neph_result describe_plain(neph_context *context, const preview_facts *facts, char **out_text) {
  *out_text = np_alloc_printf(context,
                              "kind        preview, which nephos has written: for the eye, no height field\n"
                              "size        %u x %u pixels, %u bits\nframe       %s\nexposure    %s stops\n"
                              "view        %s\n",
                              facts->width, facts->height, facts->bits, facts->frame[0] ? facts->frame : "not stated",
                              facts->exposure[0] ? facts->exposure : "not stated", facts->view);
  return *out_text ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result describe_json(neph_context *context, const preview_facts *facts, char **out_text) {
  np_json *json = np_json_create(context);
  np_json_put_text(json, "kind", "preview");
  np_json_put_integer(json, "width", facts->width);
  np_json_put_integer(json, "height", facts->height);
  np_json_put_integer(json, "bits", facts->bits);
  if (facts->frame[0]) np_json_put_integer(json, "frame", strtol(facts->frame, NULL, 10));
  if (facts->exposure[0]) np_json_put_real(json, "exposure_ev", strtod(facts->exposure, NULL));
  np_json_put_text(json, "view", facts->view);
  return np_json_finish(json, out_text);
}

neph_result np_preview_describe_file(neph_context *context, const char *path, neph_text_format format,
                                     char **out_text) {
  preview_facts facts = {0};
  FILE *file = np_file_open_stream(path);
  *out_text = NULL;
  if (!file) return NEPH_OK; /* the reader of height fields reports the error */
  read_facts(file, &facts);
  fclose(file);
  if (!facts.view[0]) return NEPH_OK;
  return format == NEPH_TEXT_JSON ? describe_json(context, &facts, out_text)
                                  : describe_plain(context, &facts, out_text);
}
