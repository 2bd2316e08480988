/* SPDX-License-Identifier: Apache-2.0 */
#include "core/folder.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>

/* Creates one folder. Returns 0, or an errno. For an existing folder some file systems give another error than
 * EEXIST. */
static int make_one(const char *path) {
  struct stat status;
  if (!mkdir(path, 0777)) return 0;
  const int error = errno;
  if (!stat(path, &status)) return S_ISDIR(status.st_mode) ? 0 : ENOTDIR;
  return error;
}

/* Length of `path` up to the end of its next name after `at`. */
static size_t skip_name(const char *path, size_t at) {
  at += strspn(path + at, "/");
  return at + strcspn(path + at, "/");
}

int np_folder_make(const char *path, size_t *out_length) {
  char prefix[PATH_MAX];
  const size_t length = strlen(path);
  int error = length == 0 ? ENOENT : length < sizeof prefix ? 0 : ENAMETOOLONG;
  *out_length = error ? length : 0;
  while (!error && path[*out_length]) {
    *out_length = skip_name(path, *out_length);
    memcpy(prefix, path, *out_length);
    prefix[*out_length] = '\0';
    error = make_one(prefix);
  }
  return error;
}
