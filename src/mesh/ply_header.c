/* SPDX-License-Identifier: Apache-2.0 */
/* Method: Turk, The PLY Polygon File Format (1994): lines "element NAME COUNT" up to "end_header". */
#include "mesh/ply_header.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/context_private.h"
#include "core/file.h"

/* Headers of more lines are left to the reader. */
enum { LINE_BYTES = 256, LINES_MAX = 1000 };

static neph_result check_element(neph_context *context, const char *path, const char *line, uint64_t byte_count) {
  char name[64];
  uint64_t count;
  if (sscanf(line, " element %63s %" SCNu64, name, &count) != 2 || count <= byte_count) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: states %" PRIu64 " elements '%s', more than its %" PRIu64 " bytes: it is truncated or damaged",
                 path, count, name, byte_count);
}

/* Reads lines to the end of the header, for which Assimp would search without end. */
static neph_result check_lines(neph_context *context, const char *path, FILE *file) {
  static const char end[] = "end_header";
  const uint64_t byte_count = np_file_get_size(path);
  char line[LINE_BYTES];
  neph_result result = NEPH_OK;
  for (int n = 0; n < LINES_MAX && !result; n++) {
    if (!fgets(line, sizeof line, file))
      return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: its header has no line '%s': it is truncated or damaged", path,
                     end);
    if (!strncmp(line, end, strlen(end))) return NEPH_OK;
    result = check_element(context, path, line, byte_count);
  }
  return result;
}

neph_result np_ply_header_check(neph_context *context, const char *path) {
  char magic[4] = "";
  FILE *file = fopen(path, "rb");
  if (!file) return NEPH_OK; /* which the reader reports */
  const bool is_ply = fgets(magic, sizeof magic, file) && !strcmp(magic, "ply");
  const neph_result result = is_ply ? check_lines(context, path, file) : NEPH_OK;
  fclose(file);
  return result;
}
