/* SPDX-License-Identifier: Apache-2.0 */
#include "core/hash.h"

#include <string.h>

#include <xxhash.h>

#include "core/alloc.h"
#include "core/file.h"

struct np_hash {
  neph_context *context;
  XXH3_state_t *state;
};

np_hash *np_hash_create(neph_context *context) {
  np_hash *hash = np_alloc(context, 1, sizeof *hash);
  if (!hash) return NULL;
  hash->context = context;
  hash->state = XXH3_createState();
  if (!hash->state) {
    (void)np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory: no room for the state of a hash");
    np_alloc_free(context, hash);
    return NULL;
  }
  XXH3_128bits_reset(hash->state);
  return hash;
}

void np_hash_add(np_hash *hash, const void *bytes, size_t size) {
  if (hash) XXH3_128bits_update(hash->state, bytes, size);
}

void np_hash_add_text(np_hash *hash, const char *text) {
  const char *added = text ? text : "";
  np_hash_add(hash, added, strlen(added) + 1);
}

void np_hash_add_file(np_hash *hash, const char *path) {
  const uint64_t bytes = path ? np_file_get_size(path) : 0;
  const int64_t time_ns = path ? np_file_get_time_ns(path) : 0;
  np_hash_add_text(hash, path);
  NP_HASH_ADD(hash, bytes);
  NP_HASH_ADD(hash, time_ns);
}

neph_result np_hash_finish(np_hash *hash, char out_hex[33]) {
  if (!hash) return NEPH_ERROR_OUT_OF_MEMORY;
  static const char digits[] = "0123456789abcdef";
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(hash->state));
  for (int i = 0; i < 16; i++) {
    out_hex[2 * i] = digits[canonical.digest[i] >> 4];
    out_hex[2 * i + 1] = digits[canonical.digest[i] & 15];
  }
  out_hex[32] = '\0';
  XXH3_freeState(hash->state);
  np_alloc_free(hash->context, hash);
  return NEPH_OK;
}

uint64_t np_hash_block(const void *bytes, size_t size) { return XXH3_64bits(bytes, size); }
