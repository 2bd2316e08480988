/* SPDX-License-Identifier: Apache-2.0 */
#include "view_watch.h"

#include <ctype.h>
#include <libgen.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include "print.h"
#include "view_keys.h"

enum { FILES_MAX = 256 };

/* A file that the scene reads, as it was when the scene began to read it. */
typedef struct watched_file {
  char *path;
  struct stat state; /* zeroed: it is not there */
} watched_file;

struct cli_view_watch {
  int descriptor;
  const char *scene_name; /* borrowed: name in its folder */
  watched_file files[FILES_MAX];
  size_t file_count;
};

static bool watch_folder(const cli_view_watch *watch, const char *path) {
  char *copy = strdup(path);
  const bool is_watched =
      copy && inotify_add_watch(watch->descriptor, dirname(copy), IN_CLOSE_WRITE | IN_MOVED_TO) >= 0;
  free(copy);
  return is_watched;
}

cli_view_watch *cli_view_watch_create(const char *scene_path) {
  const char *slash = strrchr(scene_path, '/');
  cli_view_watch *watch = calloc(1, sizeof *watch);
  if (!watch) return NULL;
  watch->scene_name = slash ? slash + 1 : scene_path;
  watch->descriptor = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (watch->descriptor >= 0 && watch_folder(watch, scene_path)) return watch;
  cli_view_watch_destroy(watch);
  return NULL;
}

static void clear_files(cli_view_watch *watch) {
  while (watch->file_count) free(watch->files[--watch->file_count].path);
}

void cli_view_watch_destroy(cli_view_watch *watch) {
  if (!watch) return;
  clear_files(watch);
  if (watch->descriptor >= 0) close(watch->descriptor);
  free(watch);
}

int cli_view_watch_get(const cli_view_watch *watch) { return watch ? watch->descriptor : -1; }

/* ---- Files of the scene ---- */

static struct stat read_state(const char *path) {
  struct stat state;
  return stat(path, &state) ? (struct stat){0} : state;
}

static bool is_same(const struct stat *a, const struct stat *b) {
  return a->st_ino == b->st_ino && a->st_dev == b->st_dev && a->st_size == b->st_size &&
         a->st_mtim.tv_sec == b->st_mtim.tv_sec && a->st_mtim.tv_nsec == b->st_mtim.tv_nsec;
}

/* Puts the number of a frame in place of the first group of '#'. */
static char *number_path(const char *path, int frame) {
  const size_t before = strcspn(path, "#"), digits = strspn(path + before, "#");
  cli_text text = {0};
  if (!digits) return strdup(path);
  cli_text_add(&text, "%.*s%0*d%s", (int)before, path, (int)digits, frame, path + before + digits);
  if (text.has_failed) cli_text_clear(&text);
  return text.characters;
}

static void add_file(cli_view_watch *watch, const char *path, int frame) {
  char *numbered = watch->file_count < FILES_MAX ? number_path(path, frame) : NULL;
  if (numbered && watch_folder(watch, numbered))
    watch->files[watch->file_count++] = (watched_file){numbered, read_state(numbered)};
  else
    free(numbered);
}

void cli_view_watch_set_files(cli_view_watch *watch, const char *schema, const char *described, int frame) {
  if (!watch) return;
  clear_files(watch);
  char *copy = strdup(described), *rest = NULL;
  for (char *line = copy ? strtok_r(copy, "\n", &rest) : NULL; line; line = strtok_r(NULL, "\n", &rest)) {
    char *key, *path;
    if (!cli_view_split_text(line, &key, &path) || cli_view_key_get_use(schema, key) != CLI_VIEW_KEY_FILE) continue;
    if (strncmp(key, "output.", strlen("output."))) add_file(watch, path, frame);
  }
  free(copy);
}

/* ---- Changes ---- */

static bool take_events(const cli_view_watch *watch) {
  _Alignas(struct inotify_event) char buffer[4096];
  bool is_scene = false;
  for (ssize_t size; (size = read(watch->descriptor, buffer, sizeof buffer)) > 0;)
    for (ssize_t at = 0; at < size;) {
      const struct inotify_event *event = (const void *)(buffer + at);
      is_scene |= event->len && !strcmp(event->name, watch->scene_name);
      at += (ssize_t)sizeof *event + event->len;
    }
  return is_scene;
}

cli_view_changes cli_view_watch_take(cli_view_watch *watch) {
  cli_view_changes changes = {.is_scene = watch && take_events(watch)};
  for (size_t i = 0; watch && i < watch->file_count; i++) {
    const struct stat now = read_state(watch->files[i].path);
    if (is_same(&now, &watch->files[i].state)) continue;
    watch->files[i].state = now;
    changes.is_file = true;
  }
  return changes;
}
