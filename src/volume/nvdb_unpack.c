/* SPDX-License-Identifier: Apache-2.0 */
/* Method: NanoVDB 32.4, util/IO.h, Internal::read: a chunk is a length and its bytes; of Blosc, one for each GB. */
#include "volume/nvdb_unpack.h"

#include "core/alloc.h"
#include "volume/volume_private.h"

static const uint64_t blosc_chunk_bytes = UINT64_C(1) << 30;

/* A grid may have this many bytes, and this many more for each byte in which it is stored. */
static const uint64_t bytes_free = UINT64_C(128000000), bytes_per_byte = 64;

static void unpack_chunk(np_vdb_bytes *bytes, const np_vdb_module *module, np_nvdb_codec codec, uint64_t packed_bytes,
                         unsigned char *out, uint64_t count) {
  unsigned char *packed = np_alloc(bytes->context, packed_bytes, 1);
  np_vdb_error error;
  if (!packed) {
    bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
    return;
  }
  np_vdb_bytes_read(bytes, packed, packed_bytes);
  if (!bytes->result && module->unpack(codec == NP_NVDB_BLOSC, packed, packed_bytes, out, count, &error)) {
    if (error.result == NEPH_ERROR_BAD_FILE)
      np_vdb_bytes_fail(bytes, "%s", error.message);
    else
      bytes->result = np_fail(bytes->context, error.result, "%s: %s", bytes->path, error.message);
  }
  np_alloc_free(bytes->context, packed);
}

static void unpack_chunks(np_vdb_bytes *bytes, const np_vdb_module *module, const np_nvdb_grid *grid,
                          unsigned char *out, uint64_t count) {
  const int64_t end = grid->begin + (int64_t)grid->stored_bytes;
  while (count > 0 && !bytes->result) {
    const uint64_t packed_bytes = (uint64_t)np_vdb_bytes_read_i64(bytes);
    const uint64_t piece = grid->codec == NP_NVDB_BLOSC && count > blosc_chunk_bytes ? blosc_chunk_bytes : count;
    if (!packed_bytes || packed_bytes > (uint64_t)(end - bytes->position))
      np_vdb_bytes_fail(bytes, "a compressed chunk has %llu bytes, %lld are left", (unsigned long long)packed_bytes,
                        (long long)(end - bytes->position));
    if (!bytes->result) unpack_chunk(bytes, module, grid->codec, packed_bytes, out, piece);
    out += piece;
    count -= piece;
  }
}

void np_nvdb_unpack(np_vdb_bytes *bytes, const np_nvdb_grid *grid, unsigned char *out, uint64_t count) {
  const np_vdb_module *module;
  if (grid->codec == NP_NVDB_NONE) {
    np_vdb_bytes_read(bytes, out, count);
    return;
  }
  if (grid->bytes > bytes_free && (grid->bytes - bytes_free) / bytes_per_byte > grid->stored_bytes)
    np_vdb_bytes_fail(bytes, "it has %llu bytes, stored in %llu, less than one in %llu",
                      (unsigned long long)grid->bytes, (unsigned long long)grid->stored_bytes,
                      (unsigned long long)bytes_per_byte);
  if (bytes->result) return;
  bytes->result = np_vdb_module_get(bytes->context, &module);
  if (!bytes->result) unpack_chunks(bytes, module, grid, out, count);
}
