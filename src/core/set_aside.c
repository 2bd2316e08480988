/* SPDX-License-Identifier: Apache-2.0 */
#include "core/set_aside.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "core/alloc.h"

enum { NAMES_MAX = 9 };

/* Name for a file set aside: PATH.bad, PATH.bad2, …; NULL: no memory. */
static char *name_aside(neph_context *context, const char *path, int number) {
  return number == 1 ? np_alloc_printf(context, "%s.bad", path) : np_alloc_printf(context, "%s.bad%d", path, number);
}

/* Renames to the first possible name. Returns 0, with the name, or the errno of the first refusal. */
static int rename_aside(neph_context *context, const char *path, char **out_name) {
  int error = 0;
  for (int number = 1; number <= NAMES_MAX; number++) {
    *out_name = name_aside(context, path, number);
    if (!*out_name) return ENOMEM;
    if (!rename(path, *out_name)) return 0;
    if (!error) error = errno;
    np_alloc_free(context, *out_name);
    *out_name = NULL;
  }
  return error;
}

void np_file_set_aside(neph_context *context, const char *path, const char *reason, const char *outcome) {
  char *name = NULL;
  const int error = rename_aside(context, path, &name);
  if (error)
    np_log(context, NEPH_LOG_WARNING, "%s: %s: it cannot be renamed to %s.bad (%s), is not used, and %s", path, reason,
           path, strerror(error), outcome);
  else
    np_log(context, NEPH_LOG_WARNING, "%s: %s: it is renamed to %s, and %s", path, reason, name, outcome);
  np_alloc_free(context, name);
}

bool np_file_is_own(const char *path, const char **out_reason) {
  struct stat status;
  *out_reason = NULL;
  if (lstat(path, &status)) return false;
  if (S_ISREG(status.st_mode)) return true;
  *out_reason = S_ISLNK(status.st_mode)   ? "it is a link"
                : S_ISDIR(status.st_mode) ? "it is a folder"
                                          : "it is a device, a pipe or a socket";
  return false;
}
