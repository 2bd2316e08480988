/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/light_checkpoint.h"

#include <dirent.h>
#include <limits.h>
#include <nephos/files.h>
#include <nephos/parts.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/set_aside.h"
#include "core/text.h"

static const char ending[] = ".light";

/* Share of the interval in which a solution is found again quickly. */
static const double quick_share = 0.1;

/* First in a file or an entry. */
typedef struct state_kind {
  uint64_t is_found; /* it holds a field, not the solver's state */
} state_kind;

/* A pipe, which would wait for its writer, a link or a folder is no light, and is set aside. */
static bool has_file(const np_light_checkpoint *c) {
  const char *reason;
  if (np_file_is_own(c->path, &reason)) return true;
  if (reason) np_file_set_aside(c->context, c->path, reason, "its light is computed again");
  return false;
}

static bool begin_read(np_light_checkpoint *c, np_cache_entry *entry, bool is_found) {
  state_kind kind;
  if (!c->is_resumed || (c->path && !has_file(c))) return false;
  const bool is_open = c->path ? np_cache_read_begin_at(c->context, c->path, c->key, entry)
                               : np_cache_read_begin(c->context, NP_LIGHT_STATE_KIND, c->key, entry);
  if (!is_open) return false;
  if (!NP_CACHE_READ(entry, kind) || !np_cache_read_check(entry, kind.is_found <= 1)) return np_cache_read_end(entry);
  if (kind.is_found == is_found) return true;
  np_cache_read_close(entry);
  return false;
}

static bool begin_write(np_light_checkpoint *c, np_cache_entry *entry, bool is_found) {
  const state_kind kind = {is_found};
  if (c->path)
    np_cache_write_begin_at(c->context, c->path, c->key, entry);
  else
    np_cache_write_begin(c->context, NP_LIGHT_STATE_KIND, c->key, entry);
  NP_CACHE_WRITE(entry, kind);
  return true;
}

static bool read_state(void *user, np_cache_entry *entry) { return begin_read(user, entry, false); }

static bool write_state(void *user, np_cache_entry *entry) { return begin_write(user, entry, false); }

bool np_light_checkpoint_open(const np_stage_part *in, const char key[33], np_light_checkpoint *out) {
  const np_light_checkpoints *wanted = &in->job->light_checkpoints;
  neph_context *context = in->context;
  *out = (np_light_checkpoint){.context = context, .monitor = in->monitor, .is_resumed = wanted->is_resumed};
  memcpy(out->key, key, sizeof out->key);
  if (!np_disk_cache_is_wanted(context)) {
    out->path = np_alloc_printf(context, "%s%s%u-%u", wanted->path, ending, wanted->block_end, in->slot);
    if (!out->path) return false;
  }
  out->start_s = np_monitor_get_seconds(in->monitor);
  out->keeper = (np_solution_keeper){wanted->interval_s, out, read_state, write_state};
  return true;
}

np_scattering_field *np_light_checkpoint_load(np_light_checkpoint *c, const np_world *world) {
  np_scattering_field *field = NULL;
  np_cache_entry entry;
  if (!c->path || !begin_read(c, &entry, true)) return NULL;
  const bool is_loaded = !np_scattering_field_load(c->context, world, &entry, &field);
  if (np_cache_read_end(&entry) && is_loaded && field) {
    np_log(c->context, NEPH_LOG_INFO, "multiple scattering: read from %s", c->path);
    return field;
  }
  np_scattering_field_destroy(field);
  return NULL;
}

void np_light_checkpoint_save(np_light_checkpoint *c, const np_scattering_field *field) {
  np_cache_entry entry;
  if (!c->path) return;
  if (np_monitor_get_seconds(c->monitor) - c->start_s < quick_share * c->keeper.interval_s) {
    (void)unlink(c->path);
  } else if (begin_write(c, &entry, true)) {
    np_scattering_field_save(field, &entry);
    np_cache_write_commit(&entry);
  }
}

void np_light_checkpoint_close(np_light_checkpoint *c) {
  np_alloc_free(c->context, c->path);
  c->path = NULL;
}

/* Whether a name goes on with the ending and "BLOCK-SLOT", and ends there. */
static bool is_light_name(const char *rest) {
  static const char digits[] = "0123456789";
  if (strncmp(rest, ending, sizeof ending - 1) != 0) return false;
  const char *block = rest + sizeof ending - 1, *dash = block + strspn(block, digits);
  const size_t slot_length = *dash == '-' ? strspn(dash + 1, digits) : 0;
  return dash > block && slot_length > 0 && !dash[1 + slot_length];
}

/* A file may also belong to an unfinished picture of another scene. */
void neph_checkpoint_clear_light(const char *checkpoint_path) {
  if (!checkpoint_path) return;
  const char *slash = strrchr(checkpoint_path, '/'), *name = slash ? slash + 1 : checkpoint_path;
  const size_t length = strlen(name);
  char folder_name[4096] = ".";
  if (slash && (size_t)(name - checkpoint_path) >= sizeof folder_name) return;
  if (slash) memcpy(folder_name, checkpoint_path, (size_t)(name - checkpoint_path));
  DIR *folder = opendir(folder_name);
  for (const struct dirent *file = folder ? readdir(folder) : NULL; file; file = readdir(folder))
    if (!strncmp(file->d_name, name, length) && is_light_name(file->d_name + length))
      (void)unlinkat(dirfd(folder), file->d_name, 0);
  if (folder) (void)closedir(folder);
}

/* Adds the names of all files of light that a picture may keep: for the frame and both ends of its block, light of sun
 * and moon in each packet. A name that is too long is left out, since no such file can be written. */
neph_result neph_files_add_light(neph_files *files, const char *checkpoint_path) {
  enum { BLOCK_ENDS = 3, LIGHTS = 2, SUFFIX = 32 };
  char path[4096];
  if (!files) return NEPH_ERROR_INVALID_ARGUMENT;
  if (!checkpoint_path || strlen(checkpoint_path) + SUFFIX > sizeof path) return NEPH_OK;
  const char *slash = strrchr(checkpoint_path, '/'), *name = slash ? slash + 1 : checkpoint_path;
  if (strlen(name) + strlen(ending) + strlen("0-0") > NAME_MAX) return NEPH_OK;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < BLOCK_ENDS * LIGHTS; i++) {
    np_print(path, sizeof path, "%s%s%u-%u", checkpoint_path, ending, i / LIGHTS, i % LIGHTS);
    result = neph_files_add(files, NEPH_FILE_WRITTEN, "light beside the checkpoint", path);
  }
  return result;
}
