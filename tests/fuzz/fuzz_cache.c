/* SPDX-License-Identifier: Apache-2.0 */
/* Entries of a cache of every kind, forged: a picture is rendered from a cache in which one entry has other bytes and a
 * checksum that is right.
 *
 * The first byte of an input chooses the entry; each six bytes that follow are two of a place and four that are put
 * there. The place counts words: of the first kilobyte where its highest bit is 0, else of all of the entry. */
#include "fuzz_support.h"

#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nephos/image.h>
#include <nephos/render.h>
#include <nephos/scene.h>

#include "core/hash.h"
#include "volume/volume_private.h"

enum { ENTRIES_MAX = 16, HEADER = 112, HASH_AT = 32, PATCH = 6, PATCHES_MAX = 64 };

/* One cloud is baked, one that of a sequence of files, all of which are scanned. */
static const char scene_format[] =
    "version: 1\n"
    "camera: {position: [0, -2 km, 1200 m], look_at: [0, 0, 1600 m], fov: 50 deg, resolution: [4, 4]}\n"
    "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
    "clouds:\n"
    "  - {name: one, bake: {preset: cumulus_humilis, seed: 7, base: 1500 m, voxel: 60 m, extent: 800 m},\n"
    "     phase: {mie: {effective_radius: 0.5 um}}}\n"
    "  - {name: two, vdb: \"%s/two.####.vdb\", optical_depth: 2, reference_frame: all, "
    "position: [300, 0, 1500]}\n"
    "terrain: {ridges: {samples: 17, relief: 300 m}, width: 20 km}\n"
    "atmosphere: {tolerance: 0.1}\n" /* small tables: what is read of them does not depend on their size */
    "render: {integrator: march, samples: 1, sun_optical_depth: volume, multiple_scattering: ordinates}\n";

typedef struct entry {
  char path[512];
  uint8_t *bytes;
  size_t size;
} entry;

static char folder[] = "/tmp/nephos-fuzz-cache-XXXXXX", checkpoint[64], scene_text[sizeof scene_format + 64];
static entry entries[ENTRIES_MAX];
static unsigned entry_count;
static int light_state = -1, light = -1; /* the entries of these kinds */

static void ignore(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level;
  if (strchr(message, '\n')) abort();
}

/* ---- The cache ---- */

static void list_entries(void) {
  char path[128];
  snprintf(path, sizeof path, "%s/nephos-cache", folder);
  struct dirent **names;
  const int count = scandir(path, &names, NULL, alphasort);
  for (int i = 0; i < count; i++) {
    entry *e = &entries[entry_count];
    struct stat status;
    snprintf(e->path, sizeof e->path, "%s/%s", path, names[i]->d_name);
    const bool is_entry = strstr(names[i]->d_name, ".cache") && !stat(e->path, &status);
    if (is_entry && !strncmp(names[i]->d_name, "light-", 6)) light = (int)entry_count;
    if (is_entry && !strncmp(names[i]->d_name, "lightstate-", 11)) light_state = (int)entry_count;
    if (is_entry && entry_count < ENTRIES_MAX - 1) entry_count++;
    free(names[i]);
  }
  if (count >= 0) free(names);
}

static void forget_entries(void) {
  for (unsigned i = 0; i < entry_count; i++) free(entries[i].bytes);
  memset(entries, 0, sizeof entries);
  entry_count = 0;
}

static void read_entries(void) {
  for (unsigned i = 0; i < entry_count; i++) {
    entry *e = &entries[i];
    FILE *file = fopen(e->path, "rb");
    struct stat status;
    if (!file || fstat(fileno(file), &status)) abort();
    e->size = (size_t)status.st_size;
    e->bytes = malloc(e->size);
    if (!e->bytes || fread(e->bytes, 1, e->size, file) != e->size) abort();
    fclose(file);
  }
}

static void write_entry(const entry *e, const uint8_t *bytes) {
  FILE *file = fopen(e->path, "wb");
  if (!file || fwrite(bytes, 1, e->size, file) != e->size || fclose(file)) abort();
}

static void end(void) {
  char command[128];
  snprintf(command, sizeof command, "rm -rf %s", folder);
  if (system(command)) abort();
}

/* ---- The picture ---- */

/* Stops where the light is on its way. */
static bool go_on(void *user, const neph_progress *progress) {
  (void)user, (void)progress;
  entry_count = 0;
  list_entries();
  return light_state < 0;
}

static void render(bool is_stopped) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  neph_scene *scene;
  neph_image *image = NULL;
  desc.thread_count = 1;
  desc.log = ignore;
  desc.cache_dir = folder;
  if (neph_context_create(&desc, &context) || neph_scene_load_text(context, scene_text, "scene", &scene)) abort();
  neph_render_desc wanted = NEPH_RENDER_DESC_DEFAULT;
  if (neph_scene_get_render_desc(scene, &wanted)) abort();
  wanted.tile_count = 2; /* whose light is kept */
  wanted.checkpoint_path = checkpoint;
  wanted.checkpoint_interval_s = is_stopped ? 1e-9 : 1e9;
  wanted.is_resumed = true;
  if (is_stopped) wanted.progress = go_on;
  const neph_result result = neph_render_image(scene, &wanted, &image);
  if (result == NEPH_ERROR_INTERNAL) abort();
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  unlink(checkpoint);
}

/* A leaf of even voxels of 50 m, in the second file one beside it. */
static void write_sequence(void) {
  np_sparse_grid grid;
  if (np_sparse_grid_init(fuzz_get_context(), "density", &grid)) abort();
  for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = 50.0;
  for (int number = 1; number <= 2; number++) {
    np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){8 * (number - 1), 0, 0});
    char path[64];
    if (!leaf) abort();
    memset(leaf->active, 0xff, sizeof leaf->active);
    for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = 1.0f;
    const np_vdb_write_grid output = {.grid = &grid};
    snprintf(path, sizeof path, "%s/two.%04d.vdb", folder, number);
    if (np_volume_save_grids(fuzz_get_context(), path, &output, 1, NULL)) abort();
  }
  np_sparse_grid_clear(&grid);
}

/* All kinds of entries; that of light on its way goes when there is all of the light. */
static void fill_cache(void) {
  if (!mkdtemp(folder)) abort();
  atexit(end);
  snprintf(checkpoint, sizeof checkpoint, "%s/picture.npart", folder);
  snprintf(scene_text, sizeof scene_text, scene_format, folder);
  write_sequence();
  render(true);
  entry state = {.size = 0};
  if (light_state >= 0) {
    read_entries();
    state = entries[light_state];
    entries[light_state].bytes = NULL;
  }
  forget_entries();
  render(false);
  light_state = -1;
  list_entries();
  read_entries();
  if (!state.bytes) return;
  light_state = (int)entry_count;
  entries[entry_count++] = state;
}

/* ---- Forging ---- */

static void patch(const entry *e, uint8_t *bytes, const uint8_t *at) {
  const size_t words = (e->size - HEADER) / 4, place = (size_t)at[0] << 8 | at[1];
  const size_t near = words < 256 ? words : 256;
  if (words == 0) return;
  const size_t word = place & 0x8000 ? (place & 0x7fff) * 7919 % words : place % near;
  memcpy(bytes + HEADER + 4 * word, at + 2, 4);
}

static void mend_checksum(const entry *e, uint8_t *bytes) {
  np_hash *hash = np_hash_create(fuzz_get_context());
  np_hash_add(hash, bytes + HEADER, e->size - HEADER);
  if (np_hash_finish(hash, (char *)bytes + HASH_AT)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (entry_count == 0) fill_cache();
  if (size < 1 + PATCH) return 0;
  const unsigned chosen = data[0] % entry_count;
  const entry *e = &entries[chosen];
  uint8_t *bytes = malloc(e->size);
  if (!bytes) return 0;
  memcpy(bytes, e->bytes, e->size);
  for (size_t i = 0; i < PATCHES_MAX && 1 + (i + 1) * PATCH <= size; i++) patch(e, bytes, data + 1 + i * PATCH);
  mend_checksum(e, bytes);
  if ((int)chosen == light_state && light >= 0) unlink(entries[light].path);
  write_entry(e, bytes);
  render(false);
  write_entry(e, e->bytes);
  if ((int)chosen == light_state) {
    unlink(e->path);
    if (light >= 0) write_entry(&entries[light], entries[light].bytes);
  }
  free(bytes);
  return 0;
}
