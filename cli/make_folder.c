/* SPDX-License-Identifier: Apache-2.0 */
#include "make_folder.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "print.h"
#include "session.h"

void cli_folder_make_parents(const char *path) {
  char *prefix = strdup(path);
  for (char *at = prefix ? prefix + 1 : NULL; at && at[-1] && (at = strchr(at, '/')); at++) {
    *at = '\0';
    (void)mkdir(prefix, 0777); /* A failure is reported where the path itself is used. */
    *at = '/';
  }
  free(prefix);
}

bool cli_folder_make(const char *path, bool *out_is_made) {
  struct stat status;
  *out_is_made = false;
  if (!stat(path, &status) && S_ISDIR(status.st_mode)) return true;
  cli_folder_make_parents(path);
  *out_is_made = !mkdir(path, 0777);
  if (*out_is_made || (errno == EEXIST && !stat(path, &status) && S_ISDIR(status.st_mode))) return true;
  cli_complain("%s: the folder cannot be made: %s", path, strerror(errno));
  return false;
}
