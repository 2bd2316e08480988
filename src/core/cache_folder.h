/* SPDX-License-Identifier: Apache-2.0 */
/* The folder of a cache: `nephos-cache` inside the folder that the caller names.
 *
 * It carries a tag, CACHEDIR.TAG (bford.info/cachedir), with a line of its own. Entries stand in no other folder, and
 * nothing else is ever removed. A folder of that name without the tag is refused unless it is empty.
 *
 * Files are trusted that belong to the process's user. A folder whose group may write to it, whose others may not, and
 * whose group the process is in, is shared: files of that group are trusted as well, since none but its members could
 * put them there. Links are not followed, and pipes and devices are not opened.
 */
#ifndef NP_CORE_CACHE_FOLDER_H
#define NP_CORE_CACHE_FOLDER_H

#include <sys/stat.h>

#include "core/context_private.h"

typedef struct np_disk_cache {
  char *folder; /* path of the folder; NULL: no cache */
  int file;     /* descriptor of the open folder */
  bool is_shared;
  gid_t group; /* group of a shared folder */
  uint64_t size_max_bytes;
} np_disk_cache;

/* Creates the folder and its parents, where they are missing, and opens it. Fails, with a message, where it is not a
 * cache of nephos, belongs to another user, or cannot be written. A new folder is shared where its parent passes its
 * group on. */
neph_result np_cache_folder_open(neph_context *context, const char *parent, np_disk_cache *out_cache);
void np_cache_folder_close(neph_context *context, np_disk_cache *cache);

/* Whether an open folder is the folder of a cache, by its tag; name and owner do not matter. */
bool np_cache_folder_is_one(int folder);

/* Reason for which a file is refused as an entry; NULL: it is regular and trusted. A NULL cache trusts all owners. */
const char *np_cache_folder_check(const np_disk_cache *cache, const struct stat *status);

/* Opens a regular, trusted file without waiting and without following a link; otherwise −1 with the reason, which is
 * NULL where there is no file. `flags` are flags of open. */
int np_cache_folder_open_file(const np_disk_cache *cache, int folder, const char *name, int flags,
                              const char **out_reason);

/* Creates a file under a unique name: the six characters at the end of `name` are replaced. The umask applies to its
 * permissions. Returns −1 with errno on failure. */
int np_cache_folder_create_file(int folder, char *name);

/* Removes the least recently used entries until the cache has its allowed size, and files that killed writers left. */
void np_cache_folder_trim(neph_context *context, const np_disk_cache *cache);

/* Infix of temporary names, and ending of an entry's name. */
#define NP_CACHE_TEMPORARY ".writing."
#define NP_CACHE_ENDING ".cache"

#endif
