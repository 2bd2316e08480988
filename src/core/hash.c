/* SPDX-License-Identifier: Apache-2.0 */
#include "core/hash.h"

#include <xxhash.h>

#include "core/alloc.h"

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

void np_hash_destroy(np_hash *hash) {
  if (!hash) return;
  XXH3_freeState(hash->state);
  np_alloc_free(hash->context, hash);
}

void np_hash_add(np_hash *hash, const void *bytes, size_t size) { XXH3_128bits_update(hash->state, bytes, size); }

void np_hash_finish(const np_hash *hash, char out_hex[33]) {
  static const char digits[] = "0123456789abcdef";
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(hash->state));
  for (int i = 0; i < 16; i++) {
    out_hex[2 * i] = digits[canonical.digest[i] >> 4];
    out_hex[2 * i + 1] = digits[canonical.digest[i] & 15];
  }
  out_hex[32] = '\0';
}
