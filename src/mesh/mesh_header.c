/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_header.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/context_private.h"
#include "core/file.h"

typedef struct mesh_header {
  neph_context *context;
  const char *path;
  FILE *file;
  uint64_t byte_count; /* size of the file */
} mesh_header;

/* ---- PLY: Turk, The PLY Polygon File Format (1994): lines "element NAME COUNT" up to "end_header" ---- */

/* Headers with more lines are left to the reader. */
enum { LINE_BYTES = 256, LINES_MAX = 1000 };

static neph_result check_element(const mesh_header *h, const char *line) {
  char name[64];
  uint64_t count;
  if (sscanf(line, " element %63s %" SCNu64, name, &count) != 2 || count <= h->byte_count) return NEPH_OK;
  return np_fail(h->context, NEPH_ERROR_BAD_FILE,
                 "%s: states %" PRIu64 " elements '%s', more than its %" PRIu64 " bytes: it is truncated or damaged",
                 h->path, count, name, h->byte_count);
}

static bool is_ply_line(const char *line) {
  static const char *const words[] = {"ply", "format ", "comment", "obj_info", "element ", "property ", "end_header"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (!strncasecmp(line, words[i], strlen(words[i]))) return true;
  return false;
}

/* Reads lines to the end of the header: Assimp would search for it without end, and hang at an invalid line. */
static neph_result check_ply(const mesh_header *h) {
  static const char end[] = "end_header";
  char line[LINE_BYTES];
  neph_result result = NEPH_OK;
  for (int n = 0; n < LINES_MAX && !result; n++) {
    if (!fgets(line, sizeof line, h->file))
      return np_fail(h->context, NEPH_ERROR_BAD_FILE, "%s: its header has no line '%s': it is truncated or damaged",
                     h->path, end);
    if (!is_ply_line(line))
      return np_fail(h->context, NEPH_ERROR_BAD_FILE, "%s: line %d of its header is no line of a PLY: it is damaged",
                     h->path, n + 1);
    result = check_element(h, line);
    line[strcspn(line, "\r\n")] = '\0';
    if (!strcmp(line, end)) return result;
  }
  return result;
}

/* ---- GLB: Khronos, glTF 2.0 Specification (2021), section 4.4: a header of 12 bytes, then chunks ---- */

/* Reads a number of four bytes, little-endian. */
static uint64_t read_u32(FILE *file) {
  unsigned char bytes[4] = {0};
  if (fread(bytes, 1, sizeof bytes, file) != sizeof bytes) return 0;
  return bytes[0] | (uint64_t)bytes[1] << 8 | (uint64_t)bytes[2] << 16 | (uint64_t)bytes[3] << 24;
}

static neph_result check_glb(const mesh_header *h) {
  enum { VERSION_BYTE = 4, HEADER_BYTES = 12, CHUNK_HEADER_BYTES = 8 };
  (void)fseek(h->file, VERSION_BYTE + 4, SEEK_SET);
  uint64_t stated = read_u32(h->file), at = HEADER_BYTES;
  while (stated <= h->byte_count && at + CHUNK_HEADER_BYTES <= h->byte_count) {
    (void)fseek(h->file, (long)at, SEEK_SET);
    stated = at += CHUNK_HEADER_BYTES + read_u32(h->file);
  }
  if (stated <= h->byte_count) return NEPH_OK;
  return np_fail(h->context, NEPH_ERROR_BAD_FILE,
                 "%s: states %" PRIu64 " bytes, and holds only %" PRIu64 ": it is truncated or damaged", h->path,
                 stated, h->byte_count);
}

/* ---- OBJ: Wavefront, Advanced Visualizer, appendix B1 (1993): a line for each vertex, face and so on ---- */

/* Whether a line of an OBJ file begins a face. Files above 16 MB are left to Assimp. */
static bool may_have_face(const mesh_header *h) {
  enum { BYTES_MAX = 1 << 24 };
  bool is_begin = true;
  for (int i = 0, c; (c = getc_unlocked(h->file)) != EOF; i++) {
    if ((is_begin && c == 'f') || i == BYTES_MAX) return true;
    is_begin = c == '\n' || c == '\r' || (is_begin && (c == ' ' || c == '\t'));
  }
  return false;
}

static neph_result check_obj(const mesh_header *h) {
  if (may_have_face(h)) return NEPH_OK;
  return np_fail(h->context, NEPH_ERROR_BAD_FILE, "%s: it has no triangle, must have at least one", h->path);
}

/* ---- Formats ---- */

neph_result np_mesh_header_check(neph_context *context, const char *path) {
  static const struct {
    const char *magic; /* letters of either case, as in Assimp */
    neph_result (*check)(const mesh_header *header);
  } formats[] = {{"ply", check_ply}, {"glTF", check_glb}};
  char magic[5] = "";
  neph_result result = NEPH_OK;
  mesh_header h = {context, path, np_file_open_stream(path), np_file_get_size(path)};
  if (!h.file) return NEPH_OK; /* the reader reports the error */
  (void)!fread(magic, 1, sizeof magic - 1, h.file);
  rewind(h.file);
  bool is_known = false;
  for (size_t i = 0; i < sizeof formats / sizeof *formats && !is_known; i++) {
    is_known = !strncasecmp(magic, formats[i].magic, strlen(formats[i].magic));
    if (is_known) result = formats[i].check(&h);
  }
  if (!is_known && np_file_has_ending(path, ".obj")) result = check_obj(&h);
  fclose(h.file);
  return result;
}
