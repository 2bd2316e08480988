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
 * alone, and has no secret: a reader checks each number of an entry that it goes by.
 */
#ifndef NP_CORE_DISK_CACHE_H
#define NP_CORE_DISK_CACHE_H

#include "core/cache_folder.h"
#include "core/hash.h"

/* Opens the folder of a cache, and brings it to its size. A NULL `parent` is none. */
neph_result np_disk_cache_open(neph_context *context, const char *parent, uint64_t size_max_bytes,
                               np_disk_cache *out_cache);
void np_disk_cache_close(neph_context *context, np_disk_cache *cache);

/* An entry being read or written. Calls after a failure do nothing. */
typedef struct np_cache_entry {
  neph_context *context;
  const np_disk_cache *cache; /* NULL: it stands outside, and is not counted in its size */
  char *path, *temporary;     /* as they are printed; the latter of one that is written */
  char key[40], sum[40];      /* the latter is the checksum of one that is read, as its header gives it */
  int file;
  size_t size, at; /* bytes of the file, or, of one that is written, those behind its header */
  np_hash *hash;
  bool is_good;
} np_cache_entry;

/* Starts to write. `key` is 32 hexadecimal digits, `kind` a word. Ends with one of the two below. */
void np_cache_write_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *out_entry);
void np_cache_write(np_cache_entry *entry, const void *bytes, size_t size);

/* Puts the entry in its place, and removes those that were not used for longest while the cache is too large. */
void np_cache_write_commit(np_cache_entry *entry);
void np_cache_write_abandon(np_cache_entry *entry);

/* Starts to read; false: there is no such entry. */
bool np_cache_read_begin(neph_context *context, const char *kind, const char *key, np_cache_entry *out_entry);

/* The same of a file that stands outside the cache, by its path: no cache is needed. It goes by the same rules, but for
 * the cache's size. */
void np_cache_write_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *out_entry);
bool np_cache_read_begin_at(neph_context *context, const char *path, const char *key, np_cache_entry *out_entry);

/* Leaves an entry that was begun to be read as it is. */
void np_cache_read_close(np_cache_entry *entry);

/* Removes an entry, if there is one. */
void np_cache_remove(neph_context *context, const char *kind, const char *key);

/* The next bytes. False: there are not so many. */
bool np_cache_read(np_cache_entry *entry, void *out_bytes, size_t size);

/* The same, to be read again. */
bool np_cache_peek(np_cache_entry *entry, void *out_bytes, size_t size);

/* The next `count` elements in memory of their own, to be freed with np_alloc_free; NULL: there are not so many, or no
 * memory. */
void *np_cache_read_block(np_cache_entry *entry, size_t count, size_t size);

/* The same of floats, all of which must be finite. */
float *np_cache_read_floats(np_cache_entry *entry, size_t count);
bool np_cache_are_finite(const float *values, size_t count);
bool np_cache_are_doubles_finite(const double *values, size_t count);

/* The same of halves. */
uint16_t *np_cache_read_halves(np_cache_entry *entry, size_t count);

/* Product of three sides; 0 where one is below 1, or it is beyond all that an entry may hold. */
size_t np_cache_count_cells(const int32_t size[3]);

/* Reads all of an entry for its checksum, for one that is used before its end. False: the entry is refused. */
bool np_cache_read_verify(np_cache_entry *entry);

/* Refuses an entry whose numbers are none that a result can have. Returns whether it is still good. */
bool np_cache_read_check(np_cache_entry *entry, bool is_right);

/* True if all of it was read, its checksum is right, and nothing failed. Else the entry is refused, with a warning. */
bool np_cache_read_end(np_cache_entry *entry);

/* Whether the context keeps results. */
static inline bool np_disk_cache_is_wanted(const neph_context *context) { return context->disk_cache->folder; }

/* Starts a key of a kind of entries: with the format of their contents, and, where that makes their bits, the context's
 * instruction-set level. */
void np_cache_key_begin(neph_context *context, const char *kind, bool has_isa, np_hash *key);

/* A variable without pointers. */
#define NP_CACHE_WRITE(entry, variable) np_cache_write(entry, &(variable), sizeof(variable))
#define NP_CACHE_READ(entry, variable) np_cache_read(entry, &(variable), sizeof(variable))

#endif
