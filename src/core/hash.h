/* SPDX-License-Identifier: Apache-2.0 */
/* Fingerprints of content (xxHash, 128 bits): the same for the same values on every machine. */
#ifndef NP_CORE_HASH_H
#define NP_CORE_HASH_H

#include "core/context_private.h"

typedef struct np_hash np_hash;

np_hash *np_hash_create(neph_context *context); /* NULL, which np_hash_add and np_hash_finish accept: no memory */
void np_hash_add(np_hash *hash, const void *bytes, size_t size);
void np_hash_add_text(np_hash *hash, const char *text); /* NULL counts as "" */
void np_hash_add_file(np_hash *hash, const char *path); /* path, size and time of change; NULL counts as "" */

/* Adds a variable or an array without padding. */
#define NP_HASH_ADD(hash, variable) np_hash_add(hash, &(variable), sizeof(variable))

/* Writes 32 hexadecimal digits and a zero, and destroys the hash; fails if its memory could not be allocated. */
neph_result np_hash_finish(np_hash *hash, char out_hex[33]);

/* 64-bit hash of one block, for checksums. */
uint64_t np_hash_block(const void *bytes, size_t size);

#endif
