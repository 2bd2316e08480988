/* SPDX-License-Identifier: Apache-2.0 */
/* Results kept on disk, from process to process, under a key of all that they depend on.
 *
 * An entry is a file of the cache's folder (cache_folder.h): a header with a format number, the size and a checksum,
 * then the bytes of the result. It is written under a temporary name, synced and renamed, so that it is there whole or
 * not at all, whatever ends the process. Processes may share a folder: each writes files of its own, and one that reads
 * an entry keeps it open when another removes it. A bad entry is removed, or, outside the cache, set aside, with a
 * warning, and computed again. Nothing that goes wrong with a cache stops a render.
 *
 * Entries are read, not mapped: one that shrinks meanwhile is cut short, and no more. The checksum is known at the end
 * alone, and has no secret: a reader checks each number of an entry that it depends on.
 */
#ifndef NP_CORE_DISK_CACHE_H
#define NP_CORE_DISK_CACHE_H

#include "core/cache_folder.h"
#include "core/hash.h"

/* Opens the folder of a cache, and trims it to its size. `parent` NULL: no cache. */
neph_result np_disk_cache_open(neph_context *context, const char *parent, uint64_t size_max_bytes,
                               np_disk_cache *out_cache);
void np_disk_cache_close(neph_context *context, np_disk_cache *cache);

/* An entry that is being read or written. After a failure, further calls do nothing. */
typedef struct np_cache_entry {
  neph_context *context;
  const np_disk_cache *cache; /* NULL: the file is outside the cache, and not counted in its size */
  char *path, *temporary;     /* path as printed in messages, and the temporary path while it is written */
  char key[40], sum[40];      /* key; checksum of a read entry, from its header */
  int file;
  size_t size, at; /* size and position in bytes: in the file while reading, after the header while writing */
  np_hash *hash;
  bool is_good;
} np_cache_entry;

/* Starts to write an entry. `key` is 32 hexadecimal digits, `kind` a word. np_cache_write_commit or
 * np_cache_write_abandon ends it. */
void np_cache_write_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *out_entry);
void np_cache_write(np_cache_entry *entry, const void *bytes, size_t size);

/* Completes the entry, and removes the least recently used entries while the cache is too large. */
void np_cache_write_commit(np_cache_entry *entry);
void np_cache_write_abandon(np_cache_entry *entry);

/* Starts to read an entry; false: there is none. */
bool np_cache_read_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *out_entry);

/* Start to write or read a file outside the cache by its path; no cache is needed. The same checks apply, but for the
 * cache's size. */
void np_cache_write_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *out_entry);
bool np_cache_read_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *out_entry);

/* Stops reading an entry, and keeps it. */
void np_cache_read_close(np_cache_entry *entry);

/* Removes an entry, if there is one. */
void np_cache_remove(neph_context *context, const char *kind, const char *key);

/* Reads the next bytes. False: there are fewer. */
bool np_cache_read(np_cache_entry *entry, void *out_bytes, size_t size);

/* Reads the next bytes without moving on. */
bool np_cache_peek(np_cache_entry *entry, void *out_bytes, size_t size);

/* Reads the next `count` elements into new memory, which np_alloc_free frees; NULL: there are fewer, or no memory. */
void *np_cache_read_block(np_cache_entry *entry, size_t count, size_t size);

/* Reads the next `count` floats as np_cache_read_block does; all must be finite. */
float *np_cache_read_floats(np_cache_entry *entry, size_t count);
bool np_cache_are_finite(const float *values, size_t count);
bool np_cache_are_doubles_finite(const double *values, size_t count);

/* Reads the next `count` halves as np_cache_read_block does; all must be finite. */
uint16_t *np_cache_read_halves(np_cache_entry *entry, size_t count);

/* Product of three sides; 0 where one is below 1, or the product exceeds the limit of an entry. */
size_t np_cache_count_cells(const int32_t size[3]);

/* Reads the rest of an entry for its checksum, so that its values can be used before its end. False: the entry is
 * refused. */
bool np_cache_read_verify(np_cache_entry *entry);

/* Refuses an entry unless `is_right`, the result of a check of its values. Returns whether the entry is still valid. */
bool np_cache_read_check(np_cache_entry *entry, bool is_right);

/* Ends reading. True if all bytes were read, the checksum is right, and nothing failed; otherwise the entry is refused,
 * with a warning. */
bool np_cache_read_end(np_cache_entry *entry);

/* Whether the context has a cache. */
static inline bool np_disk_cache_is_wanted(const neph_context *context) { return context->disk_cache->folder; }

/* Starts a key of a kind of entries: it includes the format of entries, and, where results depend on it, the context's
 * instruction-set level. */
void np_cache_key_begin(neph_context *context, const char *kind, bool has_isa, np_hash *key);

/* Writes or reads a variable without pointers. */
#define NP_CACHE_WRITE(entry, variable) np_cache_write(entry, &(variable), sizeof(variable))
#define NP_CACHE_READ(entry, variable) np_cache_read(entry, &(variable), sizeof(variable))

#endif
