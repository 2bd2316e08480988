/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/netcdf_classic.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"

enum { DIMENSIONS_MAX = 1024, VARIABLES_MAX = 8192, RANK_MAX = 1024, NAME_MAX_BYTES = 256 };
enum { TAG_DIMENSION = 10, TAG_VARIABLE = 11, TAG_ATTRIBUTE = 12 };

typedef struct classic_variable {
  char name[48]; /* shortened for messages */
  double size;   /* bytes, of one record */
  double begin;
  bool is_record;
} classic_variable;

typedef struct header {
  np_vdb_bytes *bytes;
  unsigned version; /* 1, 2 or 5 */
  double record_count;
  size_t dimension_count, variable_count;
  uint64_t lengths[DIMENSIONS_MAX]; /* 0: the dimension of records */
  classic_variable *variables;      /* owned */
} header;

bool np_netcdf_classic_has_magic(uint64_t magic) {
  unsigned char bytes[sizeof magic];
  memcpy(bytes, &magic, sizeof magic);
  return !memcmp(bytes, "CDF", 3) && (bytes[3] == 1 || bytes[3] == 2 || bytes[3] == 5);
}

/* ---- Numbers ---- */

static uint64_t read_bytes(header *h, unsigned count) {
  uint64_t value = 0;
  for (unsigned i = 0; i < count; i++) value = value << 8 | np_vdb_bytes_read_u8(h->bytes);
  return value;
}

static uint32_t read_word(header *h) { return (uint32_t)read_bytes(h, 4); }

/* A count or a length. */
static uint64_t read_count(header *h) { return read_bytes(h, h->version == 5 ? 8 : 4); }

static uint64_t pad(uint64_t size) { return (size + 3) & ~UINT64_C(3); }

/* Number of elements of a list, which is absent where its tag is 0. */
static uint64_t read_list(header *h, uint32_t tag, uint64_t limit, const char *what) {
  const uint32_t own = read_word(h);
  const uint64_t count = read_count(h);
  if (own == 0 && count == 0) return 0;
  if (own != tag || count > limit) {
    np_vdb_bytes_fail(h->bytes, "a list of %s has the tag %u and %llu elements", what, (unsigned)own,
                      (unsigned long long)count);
    return 0;
  }
  return count;
}

static void read_name(header *h, char *out, size_t size) {
  char name[NAME_MAX_BYTES + 1] = "";
  const uint64_t length = read_count(h);
  if (length > NAME_MAX_BYTES)
    np_vdb_bytes_fail(h->bytes, "a name is of %llu bytes, more than %d", (unsigned long long)length, NAME_MAX_BYTES);
  if (h->bytes->result) return;
  np_vdb_bytes_read(h->bytes, name, length);
  np_vdb_bytes_skip(h->bytes, pad(length) - length);
  if (out) np_print_short(out, size, name);
}

/* Bytes of a value; 0: no type. */
static unsigned get_type_size(uint32_t type) {
  static const unsigned sizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
  return type < sizeof sizes / sizeof *sizes ? sizes[type] : 0;
}

static unsigned read_type(header *h) {
  const uint32_t type = read_word(h);
  const unsigned size = get_type_size(type);
  if (!size) np_vdb_bytes_fail(h->bytes, "%u is not a type of values", (unsigned)type);
  return size;
}

/* ---- Lists ---- */

static void skip_attributes(header *h) {
  const uint64_t count = read_list(h, TAG_ATTRIBUTE, UINT32_MAX, "attributes");
  for (uint64_t i = 0; i < count && !h->bytes->result; i++) {
    read_name(h, NULL, 0);
    const unsigned size = read_type(h);
    const uint64_t values = read_count(h);
    if (values > (uint64_t)h->bytes->size)
      np_vdb_bytes_fail(h->bytes, "an attribute has %llu values", (unsigned long long)values);
    else
      np_vdb_bytes_skip(h->bytes, pad(values * size));
  }
}

static void read_dimensions(header *h) {
  h->dimension_count = (size_t)read_list(h, TAG_DIMENSION, DIMENSIONS_MAX, "dimensions");
  for (size_t i = 0; i < h->dimension_count && !h->bytes->result; i++) {
    read_name(h, NULL, 0);
    h->lengths[i] = read_count(h);
  }
}

static void read_shape(header *h, classic_variable *v) {
  const uint64_t rank = read_count(h);
  if (rank > RANK_MAX) np_vdb_bytes_fail(h->bytes, "a variable has %llu dimensions", (unsigned long long)rank);
  v->size = 1.0;
  for (uint64_t d = 0; d < rank && !h->bytes->result; d++) {
    const uint64_t dimension = read_count(h);
    if (dimension >= h->dimension_count)
      np_vdb_bytes_fail(h->bytes, "a variable has dimension %llu of %zu", (unsigned long long)dimension,
                        h->dimension_count);
    else if (h->lengths[dimension] > 0)
      v->size *= (double)h->lengths[dimension];
    else if (d == 0)
      v->is_record = true;
    else
      np_vdb_bytes_fail(h->bytes, "records are dimension %llu of a variable, must be its first", (unsigned long long)d);
  }
}

static void read_variables(header *h) {
  const uint64_t count = read_list(h, TAG_VARIABLE, VARIABLES_MAX, "variables");
  h->variables = np_alloc(h->bytes->context, count, sizeof *h->variables);
  if (!h->variables) h->bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
  for (; h->variable_count < count && !h->bytes->result; h->variable_count++) {
    classic_variable *v = &h->variables[h->variable_count];
    read_name(h, v->name, sizeof v->name);
    read_shape(h, v);
    skip_attributes(h);
    v->size *= read_type(h);
    (void)read_count(h); /* its size, which wraps around in large files */
    v->begin = (double)read_bytes(h, h->version == 1 ? 4 : 8);
  }
}

/* ---- Places ---- */

/* Bytes of a record of all variables. A single one is not padded. */
static double get_record_size(const header *h) {
  double sum = 0.0, last = 0.0;
  unsigned count = 0;
  for (size_t i = 0; i < h->variable_count; i++) {
    if (!h->variables[i].is_record) continue;
    last = h->variables[i].size;
    sum += 4.0 * ceil(0.25 * last);
    count++;
  }
  return count == 1 ? last : sum;
}

static void check_places(header *h) {
  const double record = get_record_size(h), size = (double)h->bytes->size;
  for (size_t i = 0; i < h->variable_count && !h->bytes->result; i++) {
    const classic_variable *v = &h->variables[i];
    if (v->is_record && h->record_count < 1.0) continue;
    const double end = v->begin + v->size + (v->is_record ? (h->record_count - 1.0) * record : 0.0);
    if (end <= size) continue;
    h->bytes->result =
        np_fail(h->bytes->context, NEPH_ERROR_BAD_FILE,
                "%s: variable '%s' reaches to byte %.0f, and the file ends at byte %.0f: it is truncated or damaged",
                h->bytes->path, v->name, end, size);
  }
}

neph_result np_netcdf_classic_check(np_vdb_bytes *bytes) {
  header *h = np_alloc(bytes->context, 1, sizeof *h);
  if (!h) return NEPH_ERROR_OUT_OF_MEMORY;
  h->bytes = bytes;
  np_vdb_bytes_seek(bytes, 3);
  h->version = np_vdb_bytes_read_u8(bytes);
  h->record_count = (double)read_count(h);
  const bool is_streamed = h->record_count >= (h->version == 5 ? 18446744073709551615.0 : 4294967295.0);
  read_dimensions(h);
  skip_attributes(h);
  read_variables(h);
  if (is_streamed) h->record_count = 0.0; /* the file holds an unknown number */
  check_places(h);
  np_alloc_free(bytes->context, h->variables);
  np_alloc_free(bytes->context, h);
  return bytes->result;
}
