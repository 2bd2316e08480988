/* SPDX-License-Identifier: Apache-2.0 */
#include "render/merge_part.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "render/render_header.h"
#include "render/scene_hash.h"

/* ---- Files of parts ---- */

static neph_result read_part(np_merge_part *p) {
  neph_result result = np_part_file_open(p->context, p->path, &p->file);
  if (result) return result;
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

/* ---- Files of tiles ---- */

static neph_result fail_tile(const np_merge_part *p, const char *problem) {
  return np_fail(p->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: %s", p->path, problem);
}

static neph_result check_tile(const np_merge_part *p) {
  if (!neph_image_get_attribute(p->tile, NP_SCENE_HASH))
    return fail_tile(p, "it has no attribute " NP_SCENE_HASH ", by which parts of one picture are known: must be a "
                        "finished picture of this version of nephos");
  if (neph_image_get_attribute(p->tile, NP_HEADER_RANGE))
    return fail_tile(p, "it is the picture of a range of samples, which cannot be merged: give the part's own file");
  if (neph_image_get_attribute(p->tile, "nephos:sampling"))
    return fail_tile(p, "its samples were cut by a time limit, which no other part repeats: render it without");
  return NEPH_OK;
}

static void read_window(np_merge_part *p) {
  const np_image_header *h = &p->tile->header;
  const char *tile = neph_image_get_attribute(p->tile, NP_HEADER_TILE);
  const char *whole = neph_image_get_attribute(p->tile, NP_HEADER_WHOLE);
  const unsigned size[2] = {p->tile->width, p->tile->height};
  for (int k = 0; k < 2; k++) {
    p->header.min[k] = p->header.whole_min[k] = h->has_window ? h->data_min[k] : 0;
    p->header.max[k] = p->header.whole_max[k] = p->header.min[k] + (int)size[k];
  }
  p->header.tile_count = 1;
  if (!tile || !whole || sscanf(tile, "%u/%u", &p->header.tile_index, &p->header.tile_count) != 2) return;
  (void)sscanf(whole, "%d %d %d %d", &p->header.whole_min[0], &p->header.whole_min[1], &p->header.whole_max[0],
               &p->header.whole_max[1]);
  p->header.tile_index--;
}

static neph_result read_tile(np_merge_part *p) {
  neph_result result = np_image_load_exr(p->context, p->path, NULL, &p->tile);
  if (!result) result = check_tile(p);
  if (result) return result;
  p->header.image = p->tile;
  p->header.is_complete = true;
  const char *software = neph_image_get_attribute(p->tile, "software");
  if (software && !strncmp(software, "nephos ", 7))
    (void)snprintf(p->header.version, sizeof p->header.version, "%s", software + 7);
  (void)snprintf(p->header.hash, sizeof p->header.hash, "%s", neph_image_get_attribute(p->tile, NP_SCENE_HASH));
  read_window(p);
  return NEPH_OK;
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
  return is_exr(path) ? read_tile(out_part) : read_part(out_part);
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

/* Version, frame, seed and level before the hash that they are in, for a message that says what differs; after it the
 * light, which each part computed for itself. */
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
  neph_result result = NEPH_OK;
  for (size_t tile = first_tile; tile < first_tile + part->grid.across && !result; tile++)
    result = np_part_file_read_tile(part->file, tile,
                                    part->rows + (np_part_grid_get_first(&part->grid, tile, &pixels) - first) * reals);
  part->row = result ? -1 : row;
  return result;
}

const double *np_merge_part_get_record(const np_merge_part *part, int x, int y) {
  const size_t reals = np_part_header_count_reals(np_part_file_get_header(part->file));
  const unsigned column = (unsigned)(x - part->header.min[0]), line = (unsigned)(y - part->header.min[1]);
  size_t pixels;
  const size_t first = np_part_grid_get_first(&part->grid, (size_t)part->row * part->grid.across, &pixels);
  return part->rows + (np_part_grid_get_index(&part->grid, column, line) - first) * reals;
}
