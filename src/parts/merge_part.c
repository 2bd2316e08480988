/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/merge_part.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "parts/merge_error.h"
#include "parts/merge_property.h"
#include "parts/merge_tile.h"

/* ---- Files of parts ---- */

static neph_result read_part(np_merge_part *p) {
  np_part_fault fault = {.context = p->context};
  if (!np_part_file_open(p->context, p->path, &fault, &p->file) ||
      !np_merge_error_check(np_part_file_get_header(p->file)->image, &fault) ||
      !np_merge_property_check(np_part_file_get_header(p->file)->image, &fault))
    return np_part_fault_fail(&fault, p->path);
  const np_part_header *h = np_part_file_get_header(p->file);
  p->header = *h;
  p->grid = np_part_grid_make(h);
  const size_t done = np_part_file_count_tiles(p->file), count = np_part_grid_count(&p->grid);
  if (done < count)
    return np_fail(p->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: it is a checkpoint with %.3g %% of its pixels: finish it by nephos render --resume", p->path,
                   100.0 * (double)done / (double)count);
  p->rows = np_alloc(p->context, (size_t)p->grid.width * NP_TILE_EDGE, np_part_header_count_reals(h) * sizeof *p->rows);
  return p->rows ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Both ---- */

/* OpenEXR files by their first four bytes. */
static bool is_exr(const char *path) {
  static const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01};
  unsigned char bytes[4] = {0};
  FILE *file = np_file_open_stream(path);
  const bool is_read = file && fread(bytes, sizeof bytes, 1, file) == 1;
  if (file) fclose(file);
  return is_read && !memcmp(bytes, magic, sizeof magic);
}

neph_result np_merge_part_open(neph_context *context, const char *path, np_merge_part *out_part) {
  *out_part = (np_merge_part){.context = context, .path = path, .row = -1};
  return is_exr(path) ? np_merge_tile_read(out_part) : read_part(out_part);
}

void np_merge_part_close(np_merge_part *part) {
  np_part_file_close(part->file);
  neph_image_destroy(part->tile);
  if (part->rows) np_alloc_free(part->context, part->rows);
}

/* ---- Whether two are of one picture ---- */

static neph_result compare_attribute(const np_merge_part *part, const np_merge_part *first, const char *name,
                                     const char *meaning) {
  const char *a = neph_image_get_attribute(part->header.image, name),
             *b = neph_image_get_attribute(first->header.image, name);
  if (!strcmp(a ? a : "", b ? b : "")) return NEPH_OK;
  return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: its %s is %s, that of %s is %s: parts must be of one "
                 "picture",
                 part->path, meaning, a ? a : "none", first->path, b ? b : "none");
}

/* Fields that only files of parts have. */
static neph_result compare_fields(const np_merge_part *part, const np_merge_part *first) {
  const char *field = part->file && first->file ? np_part_header_compare(&part->header, &first->header) : NULL;
  if (!field) return NEPH_OK;
  return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: its field '%s' is not that of %s: parts must be of one picture", part->path, field, first->path);
}

/* Pictures with a target error have other numbers in each tile. */
static neph_result compare_samples(const np_merge_part *part, const np_merge_part *first) {
  const bool has_target = neph_image_get_attribute(part->header.image, "nephos:targetNoise") ||
                          neph_image_get_attribute(first->header.image, "nephos:targetNoise");
  if (has_target || part->header.sample_count == first->header.sample_count) return NEPH_OK;
  return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: its samples are %u a pixel, those of %s are %u: parts must be of one picture", part->path,
                 part->header.sample_count, first->path, first->header.sample_count);
}

static neph_result compare_windows(const np_merge_part *part, const np_merge_part *first) {
  if (!memcmp(part->header.whole_min, first->header.whole_min, sizeof part->header.whole_min) &&
      !memcmp(part->header.whole_max, first->header.whole_max, sizeof part->header.whole_max))
    return NEPH_OK;
  return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: it is part of a picture of %d x %d pixels, that of %s has %d x %d", part->path,
                 part->header.whole_max[0] - part->header.whole_min[0],
                 part->header.whole_max[1] - part->header.whole_min[1], first->path,
                 first->header.whole_max[0] - first->header.whole_min[0],
                 first->header.whole_max[1] - first->header.whole_min[1]);
}

static neph_result compare_channels(const np_merge_part *part, const np_merge_part *first) {
  bool is_same = part->header.image->channel_count == first->header.image->channel_count;
  for (unsigned i = 0; i < first->header.image->channel_count && is_same; i++) {
    bool has = false;
    for (unsigned j = 0; j < part->header.image->channel_count; j++)
      has = has || !strcmp(part->header.image->channels[j].name, first->header.image->channels[i].name);
    is_same = has;
  }
  return is_same ? NEPH_OK
                 : np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: its channels are others than those of %s",
                           part->path, first->path);
}

/* Compares version, frame, seed and level before the hash that contains them, so that the message names the difference;
 * then the light, which each part has computed itself. */
neph_result np_merge_part_compare(const np_merge_part *part, const np_merge_part *first) {
  static const char *const named[][2] = {
      {"nephos:frame", "frame"}, {"nephos:seed", "seed"}, {"nephos:isa", "instruction-set level"}};
  if (*part->header.version && *first->header.version && strcmp(part->header.version, first->header.version) != 0)
    return np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: it was rendered by nephos %s, %s by nephos %s: parts must be of one version", part->path,
                   part->header.version, first->path, first->header.version);
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < sizeof named / sizeof *named && !result; i++)
    result = compare_attribute(part, first, named[i][0], named[i][1]);
  if (!result) result = compare_windows(part, first);
  if (!result && strcmp(part->header.hash, first->header.hash) != 0)
    result = np_fail(part->context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s: its scene, input files or settings are others than those of %s: the hash is %s, not %s",
                     part->path, first->path, part->header.hash, first->header.hash);
  if (!result) result = compare_channels(part, first);
  if (!result) result = compare_samples(part, first);
  if (!result) result = compare_fields(part, first);
  if (!result) result = np_merge_property_compare(part, first);
  if (!result) result = compare_attribute(part, first, "nephos:lightResidual", "residual of multiple scattering");
  return result ? result : compare_attribute(part, first, "nephos:lightError", "error of multiple scattering");
}

/* ---- Records ---- */

neph_result np_merge_part_load_row(np_merge_part *part, int y) {
  const int row = (y - part->header.min[1]) / NP_TILE_EDGE;
  if (!part->file || part->row == row) return NEPH_OK;
  const size_t reals = np_part_header_count_reals(np_part_file_get_header(part->file));
  const size_t first_tile = (size_t)row * part->grid.across;
  size_t pixels;
  const size_t first = np_part_grid_get_first(&part->grid, first_tile, &pixels);
  np_part_fault fault = {.context = part->context};
  bool is_read = true;
  for (size_t tile = first_tile; tile < first_tile + part->grid.across && is_read; tile++)
    is_read = np_part_file_read_tile(part->file, tile, &fault,
                                     part->rows + (np_part_grid_get_first(&part->grid, tile, &pixels) - first) * reals);
  part->row = is_read ? row : -1;
  return is_read ? NEPH_OK : np_part_fault_fail(&fault, part->path);
}

const double *np_merge_part_get_record(const np_merge_part *part, int x, int y) {
  const size_t reals = np_part_header_count_reals(np_part_file_get_header(part->file));
  const unsigned column = (unsigned)(x - part->header.min[0]), line = (unsigned)(y - part->header.min[1]);
  size_t pixels;
  const size_t first = np_part_grid_get_first(&part->grid, (size_t)part->row * part->grid.across, &pixels);
  return part->rows + (np_part_grid_get_index(&part->grid, column, line) - first) * reals;
}
