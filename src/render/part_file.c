/* SPDX-License-Identifier: Apache-2.0 */
#include "render/part_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "render/frame_state.h"

enum { FORMAT_VERSION = 1, HEADER_MAX = 1 << 26 };

typedef struct preamble {
  char magic[8];
  uint32_t version, header_size;
  uint64_t header_sum;
} preamble;

static const char magic[8] = {'n', 'e', 'p', 'h', 'p', 'a', 'r', 't'};

/* ---- Tiles ---- */

static unsigned min(unsigned a, unsigned b) { return a < b ? a : b; }

np_part_grid np_part_grid_make(const np_part_header *header) {
  np_part_grid grid = {(unsigned)(header->max[0] - header->min[0]), (unsigned)(header->max[1] - header->min[1]), 0, 0};
  grid.across = (grid.width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  grid.down = (grid.height + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  return grid;
}

size_t np_part_grid_get_first(const np_part_grid *grid, size_t tile, size_t *out_count) {
  const unsigned x = (unsigned)(tile % grid->across) * NP_TILE_EDGE;
  const unsigned y = (unsigned)(tile / grid->across) * NP_TILE_EDGE;
  const unsigned rows = min(NP_TILE_EDGE, grid->height - y);
  *out_count = (size_t)min(NP_TILE_EDGE, grid->width - x) * rows;
  return (size_t)y * grid->width + (size_t)x * rows;
}

size_t np_part_grid_get_index(const np_part_grid *grid, unsigned x, unsigned y) {
  size_t count;
  const size_t first =
      np_part_grid_get_first(grid, (size_t)(y / NP_TILE_EDGE) * grid->across + x / NP_TILE_EDGE, &count);
  const unsigned across = min(NP_TILE_EDGE, grid->width - x / NP_TILE_EDGE * NP_TILE_EDGE);
  return first + (size_t)(y % NP_TILE_EDGE) * across + x % NP_TILE_EDGE;
}

/* ---- Writing ---- */

static bool put(FILE *file, const void *bytes, size_t size) { return !size || fwrite(bytes, size, 1, file) == 1; }

static bool put_header(FILE *file, const char *bytes, size_t size) {
  preamble p = {.version = FORMAT_VERSION, .header_size = (uint32_t)size, .header_sum = np_hash_block(bytes, size)};
  memcpy(p.magic, magic, sizeof magic);
  return put(file, &p, sizeof p) && put(file, bytes, size);
}

static bool put_tiles(FILE *file, const np_part_header *header, const unsigned char *present, const double *records) {
  const np_part_grid grid = np_part_grid_make(header);
  const size_t reals = np_part_header_count_reals(header), count = np_part_grid_count(&grid);
  const uint64_t present_sum = np_hash_block(present, count);
  bool is_written = put(file, present, count) && put(file, &present_sum, sizeof present_sum);
  for (size_t tile = 0; tile < count && is_written; tile++) {
    if (!present[tile]) continue;
    size_t pixels;
    const double *first = records + np_part_grid_get_first(&grid, tile, &pixels) * reals;
    const uint64_t sum = np_hash_block(first, pixels * reals * sizeof *first);
    is_written = put(file, first, pixels * reals * sizeof *first) && put(file, &sum, sizeof sum);
  }
  return is_written;
}

static neph_result write_to(neph_context *context, const char *path, const char *temporary,
                            const np_part_header *header, const unsigned char *present, const double *records) {
  char *bytes = NULL;
  size_t size = 0;
  neph_result result = np_part_header_encode(context, header, &bytes, &size);
  if (result) return result;
  FILE *file = fopen(temporary, "wb");
  bool is_written = file && put_header(file, bytes, size) && put_tiles(file, header, present, records);
  int error = is_written ? 0 : errno;
  if (file && fclose(file) && !error) error = errno;
  np_alloc_free(context, bytes);
  if (!error) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: %s", path, strerror(error));
}

neph_result np_part_file_write(neph_context *context, const char *path, const np_part_header *header,
                               const atomic_bool *done, const double *records) {
  const np_part_grid grid = np_part_grid_make(header);
  const size_t count = np_part_grid_count(&grid);
  unsigned char *present = np_alloc(context, count, 1);
  if (!present) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t tile = 0; tile < count; tile++) present[tile] = atomic_load_explicit(&done[tile], memory_order_acquire);
  np_file_write write;
  neph_result result = np_file_write_begin(context, path, &write);
  if (!result) {
    result = write_to(context, path, write.temporary, header, present, records);
    if (result)
      np_file_write_abandon(&write);
    else
      result = np_file_write_commit(&write);
  }
  np_alloc_free(context, present);
  return result;
}

/* ---- Reading ---- */

struct np_part_file {
  neph_context *context;
  char *path;
  FILE *file;
  np_part_header header;
  neph_image *image; /* of the header */
  np_part_grid grid;
  unsigned char *present;
  uint64_t *offsets; /* of tiles that are there, from the start of the file */
  size_t present_count;
};

static neph_result fail_file(const np_part_file *f, const char *problem) {
  return np_fail(f->context, NEPH_ERROR_BAD_FILE, "%s: %s: render this part again", f->path, problem);
}

static bool get(np_part_file *f, void *bytes, size_t size) { return !size || fread(bytes, size, 1, f->file) == 1; }

static neph_result read_header_block(np_part_file *f, const preamble *p, char *bytes) {
  if (!get(f, bytes, p->header_size)) return fail_file(f, "the part is cut short in its header");
  if (np_hash_block(bytes, p->header_size) != p->header_sum)
    return fail_file(f, "the part's header is damaged: its checksum is wrong");
  if (np_part_header_decode(f->context, bytes, p->header_size, &f->header, &f->image)) return NEPH_OK;
  return fail_file(f, "the part's header is damaged, or was written by another build of nephos");
}

static neph_result read_header(np_part_file *f) {
  preamble p;
  if (!get(f, &p, sizeof p) || memcmp(p.magic, magic, sizeof magic))
    return np_fail(f->context, NEPH_ERROR_BAD_FILE,
                   "%s: it is no part of a picture: must be a file that nephos render --sample-range, or --checkpoint, "
                   "has written",
                   f->path);
  if (p.version != FORMAT_VERSION)
    return np_fail(f->context, NEPH_ERROR_BAD_FILE,
                   "%s: the part's format is %u, must be %d: merge it with the nephos that wrote it", f->path,
                   p.version, (int)FORMAT_VERSION);
  if (p.header_size > HEADER_MAX) return fail_file(f, "the part's header is damaged: it claims to be too long");
  char *bytes = np_alloc(f->context, (size_t)p.header_size + 1, 1);
  if (!bytes) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = read_header_block(f, &p, bytes);
  np_alloc_free(f->context, bytes);
  return result;
}

/* Offsets of the tiles, and that the file is as long as they say. */
static neph_result read_tiles(np_part_file *f) {
  const size_t count = np_part_grid_count(&f->grid), reals = np_part_header_count_reals(&f->header);
  uint64_t sum;
  f->present = np_alloc(f->context, count, 1);
  f->offsets = np_alloc(f->context, count, sizeof *f->offsets);
  if (!f->present || !f->offsets) return NEPH_ERROR_OUT_OF_MEMORY;
  if (!get(f, f->present, count) || !get(f, &sum, sizeof sum)) return fail_file(f, "the part is cut short");
  if (sum != np_hash_block(f->present, count)) return fail_file(f, "the part's list of tiles is damaged");
  uint64_t at = (uint64_t)ftello(f->file);
  for (size_t tile = 0; tile < count; tile++) {
    size_t pixels;
    (void)np_part_grid_get_first(&f->grid, tile, &pixels);
    f->offsets[tile] = at;
    f->present_count += f->present[tile] != 0;
    if (f->present[tile]) at += pixels * reals * sizeof(double) + sizeof sum;
  }
  return np_file_get_size(f->path) == at ? NEPH_OK : fail_file(f, "the part is cut short, or has grown");
}

static neph_result open_part(np_part_file *f) {
  const char *reason;
  neph_result result = np_file_probe(f->path, &reason);
  if (result) return np_fail(f->context, result, "%s: cannot be read: %s", f->path, reason);
  f->file = np_file_open_stream(f->path);
  if (!f->file) return np_fail(f->context, NEPH_ERROR_IO, "%s: cannot be read: %s", f->path, strerror(errno));
  result = read_header(f);
  if (result) return result;
  f->grid = np_part_grid_make(&f->header);
  return read_tiles(f);
}

neph_result np_part_file_open(neph_context *context, const char *path, np_part_file **out_file) {
  *out_file = NULL;
  np_part_file *f = np_alloc(context, 1, sizeof *f);
  if (!f) return NEPH_ERROR_OUT_OF_MEMORY;
  f->context = context;
  f->path = np_alloc_text(context, path);
  neph_result result = f->path ? open_part(f) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result)
    np_part_file_close(f);
  else
    *out_file = f;
  return result;
}

void np_part_file_close(np_part_file *f) {
  if (!f) return;
  if (f->file) fclose(f->file);
  neph_image_destroy(f->image);
  np_alloc_free(f->context, f->present);
  np_alloc_free(f->context, f->offsets);
  np_alloc_free(f->context, f->path);
  np_alloc_free(f->context, f);
}

const char *np_part_file_get_path(const np_part_file *f) { return f->path; }

const np_part_header *np_part_file_get_header(const np_part_file *f) { return &f->header; }

bool np_part_file_has_tile(const np_part_file *f, size_t tile) { return f->present[tile]; }

size_t np_part_file_count_tiles(const np_part_file *f) { return f->present_count; }

neph_result np_part_file_read_tile(np_part_file *f, size_t tile, double *out_records) {
  size_t pixels;
  (void)np_part_grid_get_first(&f->grid, tile, &pixels);
  const size_t size = pixels * np_part_header_count_reals(&f->header) * sizeof *out_records;
  uint64_t sum;
  if (fseeko(f->file, (off_t)f->offsets[tile], SEEK_SET) || !get(f, out_records, size) || !get(f, &sum, sizeof sum))
    return fail_file(f, "the part cannot be read to its end");
  return sum == np_hash_block(out_records, size) ? NEPH_OK
                                                 : fail_file(f, "the part is damaged: the checksum of a tile is wrong");
}
