/* SPDX-License-Identifier: Apache-2.0 */
/* Fingerprints of content (xxHash, 128 bits): the same for the same values on every machine. */
#ifndef NP_CORE_HASH_H
#define NP_CORE_HASH_H

#include "core/context_private.h"

typedef struct np_hash np_hash;

np_hash *np_hash_create(neph_context *context); /* NULL: no memory */
void np_hash_destroy(np_hash *hash);
void np_hash_add(np_hash *hash, const void *bytes, size_t size);
void np_hash_finish(const np_hash *hash, char out_hex[33]); /* 32 hexadecimal digits and a zero */

#endif
