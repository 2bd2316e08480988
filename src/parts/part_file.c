/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/hash.h"
#include "parts/part_code.h"
#include "parts/part_rules.h"

enum { FORMAT_VERSION = 1, HEADER_MAX = 1 << 26 };

typedef struct preamble {
  char magic[8];
  uint32_t version, header_size;
  uint64_t header_sum;
} preamble;

static const char magic[8] = {'n', 'e', 'p', 'h', 'p', 'a', 'r', 't'};

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
  neph_result result = np_part_code_encode(context, header, &bytes, &size);
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
  uint64_t size;        /* bytes of the file */
  np_part_fault *fault; /* fault of the present call */
  np_part_header header;
  neph_image *image; /* picture that holds the header */
  np_part_grid grid;
  unsigned char *present;
  uint64_t *offsets; /* places of the present tiles, from the start of the file */
  size_t present_count;
};

static uint64_t get_position(const np_part_file *f) {
  const off_t at = ftello(f->file);
  return at < 0 ? f->size : (uint64_t)at;
}

static bool get(np_part_file *f, void *bytes, size_t size) { return !size || fread(bytes, size, 1, f->file) == 1; }

/* Whether the file has `size` further bytes. It is checked before memory is allocated for them. */
static bool has_bytes(np_part_file *f, const char *name, uint64_t size) {
  const uint64_t at = get_position(f);
  if (size <= f->size - at) return true;
  return np_part_fault_set(f->fault,
                           "the part is cut short in its %s: the file has %llu bytes, must have at least %llu", name,
                           (unsigned long long)f->size, (unsigned long long)(at + size));
}

static bool fail_read(np_part_file *f) {
  return np_part_fault_set_file(f->fault, NEPH_ERROR_IO, "it cannot be read to its end: %s",
                                ferror(f->file) ? strerror(errno) : "it is cut short while it is read");
}

static bool read_header_block(np_part_file *f, const preamble *p, char *bytes) {
  if (!get(f, bytes, p->header_size)) return fail_read(f);
  if (np_hash_block(bytes, p->header_size) != p->header_sum)
    return np_part_fault_set(f->fault, "the part's header is damaged: its checksum is wrong");
  return np_part_code_decode(f->context, bytes, p->header_size, f->fault, &f->header, &f->image);
}

static bool read_header(np_part_file *f) {
  preamble p;
  if (!get(f, &p, sizeof p) || memcmp(p.magic, magic, sizeof magic))
    return np_part_fault_set_file(f->fault, NEPH_ERROR_BAD_FILE,
                                  "it is no part of a picture: must be a file that nephos render --sample-range, or "
                                  "--checkpoint, has written");
  if (p.version != FORMAT_VERSION)
    return np_part_fault_set_file(f->fault, NEPH_ERROR_BAD_FILE,
                                  "the part's format is %u, must be %d: merge it with the nephos that wrote it",
                                  p.version, (int)FORMAT_VERSION);
  if (p.header_size > HEADER_MAX)
    return np_part_fault_set(f->fault, "its field 'header size' is %u, must be at most %d", p.header_size,
                             (int)HEADER_MAX);
  if (!has_bytes(f, "header", p.header_size)) return false;
  char *bytes = np_alloc(f->context, (size_t)p.header_size + 1, 1);
  if (!bytes) return np_part_fault_set_memory(f->fault);
  const bool is_read = read_header_block(f, &p, bytes);
  np_alloc_free(f->context, bytes);
  return is_read;
}

static bool read_present(np_part_file *f, size_t count) {
  uint64_t sum;
  if (!get(f, f->present, count) || !get(f, &sum, sizeof sum)) return fail_read(f);
  if (sum != np_hash_block(f->present, count))
    return np_part_fault_set(f->fault, "the part's list of tiles is damaged: its checksum is wrong");
  for (size_t tile = 0; tile < count; tile++)
    if (f->present[tile] > 1)
      return np_part_fault_set(f->fault, "its field 'tiles' is %u at tile %zu of %zu, must be 0 or 1", f->present[tile],
                               tile, count);
  return true;
}

/* Offsets of the tiles, and that the file is as long as they say. */
static bool read_tiles(np_part_file *f) {
  const size_t count = np_part_grid_count(&f->grid), reals = np_part_header_count_reals(&f->header);
  if (!has_bytes(f, "list of tiles", count + sizeof(uint64_t))) return false;
  f->present = np_alloc(f->context, count, 1);
  f->offsets = np_alloc(f->context, count, sizeof *f->offsets);
  if (!f->present || !f->offsets) return np_part_fault_set_memory(f->fault);
  if (!read_present(f, count)) return false;
  uint64_t at = get_position(f);
  for (size_t tile = 0; tile < count; tile++) {
    size_t pixels;
    (void)np_part_grid_get_first(&f->grid, tile, &pixels);
    f->offsets[tile] = at;
    f->present_count += f->present[tile];
    if (f->present[tile]) at += pixels * reals * sizeof(double) + sizeof(uint64_t);
  }
  if (f->size == at) return true;
  return np_part_fault_set(
      f->fault,
      "the part is cut short, or has grown: it has %llu bytes, must have %llu for %zu of %zu tiles "
      "of %u x %u pixels with %zu sums each",
      (unsigned long long)f->size, (unsigned long long)at, f->present_count, count, f->grid.width, f->grid.height,
      reals);
}

static bool open_part(np_part_file *f) {
  const char *reason;
  const neph_result result = np_file_probe(f->path, &reason);
  if (result) return np_part_fault_set_file(f->fault, result, "cannot be read: %s", reason);
  f->file = np_file_open_stream(f->path);
  struct stat status;
  if (!f->file || fstat(fileno(f->file), &status))
    return np_part_fault_set_file(f->fault, NEPH_ERROR_IO, "cannot be read: %s", strerror(errno));
  f->size = (uint64_t)status.st_size;
  if (!read_header(f)) return false;
  f->grid = np_part_grid_make(&f->header);
  return read_tiles(f);
}

bool np_part_file_open(neph_context *context, const char *path, np_part_fault *fault, np_part_file **out_file) {
  *out_file = NULL;
  np_part_file *f = np_alloc(context, 1, sizeof *f);
  if (!f) return np_part_fault_set_memory(fault);
  f->context = context;
  f->fault = fault;
  f->path = np_alloc_text(context, path);
  const bool is_open = f->path ? open_part(f) : np_part_fault_set_memory(fault);
  if (is_open)
    *out_file = f;
  else
    np_part_file_close(f);
  return is_open;
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

bool np_part_file_read_tile(np_part_file *f, size_t tile, np_part_fault *fault, double *out_records) {
  f->fault = fault;
  size_t pixels;
  (void)np_part_grid_get_first(&f->grid, tile, &pixels);
  const size_t reals = np_part_header_count_reals(&f->header), size = pixels * reals * sizeof *out_records;
  uint64_t sum;
  if (fseeko(f->file, (off_t)f->offsets[tile], SEEK_SET) || !get(f, out_records, size) || !get(f, &sum, sizeof sum))
    return fail_read(f);
  if (sum != np_hash_block(out_records, size))
    return np_part_fault_set(f->fault, "the part is damaged: the checksum of tile %zu is wrong", tile);
  for (size_t i = 0; i < pixels; i++)
    if (!np_part_rules_check_record(&f->header, out_records + i * reals, f->fault)) return false;
  return true;
}
