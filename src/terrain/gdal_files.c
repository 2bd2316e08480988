/* SPDX-License-Identifier: Apache-2.0 */
/* A file system of GDAL's over that of the machine. A folder that ends in "/." in a name is one that files are confined
 * to: a link in it must not lead out. ".." is no part of any name. */
#include "terrain/gdal_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gdal/cpl_conv.h>
#include <gdal/cpl_error.h>
#include <gdal/cpl_string.h>
#include <gdal/cpl_vsi.h>

static const char prefix[] = "/vsinephos/";
static const char confined[] = "/./";

/* ---- Names ---- */

static int has_step_back(const char *path) {
  const size_t length = strlen(path);
  return strstr(path, "/../") != NULL || (length >= 3 && !strcmp(path + length - 3, "/.."));
}

/* Whether a path, all links resolved, is below the folder to which it is confined. */
static int is_inside(const char *path) {
  const char *mark = strstr(path, confined);
  char folder[PATH_MAX], root[PATH_MAX], real[PATH_MAX];
  if (!mark) return 1;
  if (snprintf(folder, sizeof folder, "%.*s/", (int)(mark - path), path) >= PATH_MAX) return 0;
  if (!realpath(folder, root) || !realpath(path, real)) return 0;
  const size_t length = strcmp(root, "/") ? strlen(root) : 0;
  return !strncmp(real, root, length) && real[length] == '/';
}

/* Path of the machine for a name without its prefix; 0: it is too long. */
static int get_path(const char *rest, char out[PATH_MAX]) {
  const int length = snprintf(out, PATH_MAX, "/%s", rest);
  return length > 0 && length < PATH_MAX;
}

static const char *get_refusal(const char *rest, int is_folder_allowed) {
  char path[PATH_MAX];
  struct stat status;
  if (!get_path(rest, path)) return "its name is too long";
  if (has_step_back(path)) return "a raster reads no file outside its own folder";
  if (stat(path, &status)) return "there is no such file";
  if (S_ISDIR(status.st_mode) && !is_folder_allowed) return "it is a folder";
  if (!S_ISDIR(status.st_mode) && !S_ISREG(status.st_mode)) return "it is a device, a pipe or a socket";
  return is_inside(path) ? NULL : "it is a link that leads out of the raster's folder";
}

const char *np_gdal_files_get_refusal(const char *name) {
  const size_t length = strlen(prefix);
  return strncmp(name, prefix, length) ? NULL : get_refusal(name + length, 0);
}

/* The caller has named the raster, so that the last part of each name is enough. */
void np_gdal_files_clean_message(char *message) {
  for (char *at = message; (at = strstr(at, prefix));) {
    char *last = at;
    for (char *c = at; *c && !strchr("'\":\n", *c); c++)
      if (*c == '/') last = c + 1;
    memmove(at, last, strlen(last) + 1);
  }
}

/* A .vrt is named by the target of its links; other files by the folder in their name. */
char *np_gdal_files_name(const char *path, int is_confined) {
  char real[PATH_MAX], folder[PATH_MAX];
  const char *slash = strrchr(path, '/');
  const int length = slash ? (int)(slash - path) + 1 : 0;
  const int printed = snprintf(folder, sizeof folder, "%.*s", length ? length : 2, length ? path : "./");
  if (printed >= PATH_MAX || !realpath(is_confined ? path : folder, real)) {
    CPLError(CE_Failure, CPLE_OpenFailed, "its folder cannot be read");
    return NULL;
  }
  if (!is_confined) return CPLStrdup(CPLSPrintf("%s%s/%s", prefix, strcmp(real, "/") ? real + 1 : ".", path + length));
  const char *base = strrchr(real, '/');
  const int folder_length = base > real ? (int)(base - real) - 1 : 0;
  return CPLStrdup(CPLSPrintf("%s%.*s%s%s", prefix, folder_length, real + 1, confined, base + 1));
}

/* ---- Callbacks ---- */

static int stat_name(void *user, const char *rest, VSIStatBufL *out_status, int flags) {
  char path[PATH_MAX];
  (void)user, (void)flags;
  if (get_refusal(rest, 1) || !get_path(rest, path)) return -1;
  return VSIStatL(path, out_status);
}

/* Opens without waiting, and checks the open file, which another may have replaced. */
static void *open_name(void *user, const char *rest, const char *access) {
  char path[PATH_MAX];
  struct stat status;
  (void)user;
  if (strpbrk(access, "wa+") || get_refusal(rest, 0) || !get_path(rest, path)) return NULL;
  const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return NULL;
  FILE *stream = !fstat(file, &status) && S_ISREG(status.st_mode) ? fdopen(file, "rb") : NULL;
  if (!stream) close(file);
  return stream;
}

static char **read_folder(void *user, const char *rest, int count_max) {
  char path[PATH_MAX];
  char **names = NULL;
  (void)user;
  DIR *folder = !get_refusal(rest, 1) && get_path(rest, path) ? opendir(path) : NULL;
  if (!folder) return NULL;
  const struct dirent *entry;
  for (int count = 0; (entry = readdir(folder)); count++) {
    names = CSLAddString(names, entry->d_name);
    if (count_max > 0 && count > count_max) break;
  }
  closedir(folder);
  return names;
}

static vsi_l_offset get_offset(void *file) { return (vsi_l_offset)ftello(file); }

static int seek(void *file, vsi_l_offset offset, int whence) { return fseeko(file, (off_t)offset, whence); }

static size_t read_blocks(void *file, void *out, size_t size, size_t count) { return fread(out, size, count, file); }

static int is_at_end(void *file) { return feof((FILE *)file); }

static int close_file(void *file) { return fclose(file); }

/* Installs the file system once, when the module is loaded: GDAL's table of file systems belongs to the whole
 * process. */
__attribute__((constructor)) static void install(void) {
  VSIFilesystemPluginCallbacksStruct *callbacks = VSIAllocFilesystemPluginCallbacksStruct();
  if (!callbacks) return;
  callbacks->stat = stat_name;
  callbacks->read_dir = read_folder;
  callbacks->open = open_name;
  callbacks->tell = get_offset;
  callbacks->seek = seek;
  callbacks->read = read_blocks;
  callbacks->eof = is_at_end;
  callbacks->close = close_file;
  (void)VSIInstallPluginHandler(prefix, callbacks);
  VSIFreeFilesystemPluginCallbacksStruct(callbacks);
}
