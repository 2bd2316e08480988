/* SPDX-License-Identifier: Apache-2.0 */
#include "view_watch.h"

#include <libgen.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <unistd.h>

int cli_view_watch_open(const char *path) {
  char *copy = strdup(path);
  int watch = copy ? inotify_init1(IN_NONBLOCK | IN_CLOEXEC) : -1;
  if (watch >= 0 && inotify_add_watch(watch, dirname(copy), IN_CLOSE_WRITE | IN_MOVED_TO) < 0) {
    close(watch);
    watch = -1;
  }
  free(copy);
  return watch;
}

bool cli_view_watch_take(int watch, const char *path) {
  _Alignas(struct inotify_event) char buffer[4096];
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  bool has_changed = false;
  for (ssize_t size; (size = read(watch, buffer, sizeof buffer)) > 0;)
    for (ssize_t at = 0; at < size;) {
      const struct inotify_event *event = (const void *)(buffer + at);
      has_changed |= event->len && !strcmp(event->name, name);
      at += (ssize_t)sizeof *event + event->len;
    }
  return has_changed;
}
