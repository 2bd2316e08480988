/* SPDX-License-Identifier: Apache-2.0 */
/* A .vdb file that stays readable while its parts change. An input is a list of changes to one of a few synthetic
 * files: of values, tiles, names, metadata, transforms and headers, whose sizes and offsets are corrected, and of keys
 * of the scene. The file is then loaded as a cloud with its emission and colours, measured along columns, and rendered.
 */
#include "fuzz_support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nephos/nephos.h>

#include "core/random.h"
#include "volume/volume_private.h"

#include "../vdb_edit.h"

enum { FILES = 3, CHANGES_MAX = 24, CHANGE_BYTES = 8, VALUES_MAX = 64 };

static vdb_edit files[FILES];
static unsigned long run_count, loaded_count, rendered_count;

/* ---- Files ---- */

static void check(bool is_right) {
  if (!is_right) abort();
}

static void fill(np_sparse_grid *grid, np_random *random, double scale, double share) {
  const int32_t size = 2;
  int32_t at[3];
  for (at[0] = 0; at[0] < size; at[0]++)
    for (at[1] = 0; at[1] < size; at[1]++)
      for (at[2] = 0; at[2] < size; at[2]++) {
        const int32_t origin[3] = {8 * at[0], 8 * at[1], 8 * at[2]};
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, origin);
        check(leaf);
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          if (np_random_double(random) > share) continue;
          leaf->values[n] = (float)(scale * np_random_double(random));
          leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
        }
      }
}

static void make_grid(const char *name, np_random *random, double scale, np_sparse_grid *grid) {
  check(!np_sparse_grid_init(fuzz_get_context(), name, grid));
  for (int a = 0; a < 3; a++) grid->index_to_world.m[a][a] = 20.0;
  fill(grid, random, scale, 0.5);
  check(np_sparse_grid_add_tile(grid, (const int32_t[3]){16, 0, 0}, 8, (float)scale, true));
  np_sparse_grid_sort(grid);
}

static void read_file(const char *path, vdb_edit *out) {
  FILE *file = fopen(path, "rb");
  check(file && !fseek(file, 0, SEEK_END));
  out->size = (size_t)ftell(file);
  rewind(file);
  out->data = malloc(out->size);
  check(out->data && fread(out->data, 1, out->size, file) == out->size);
  fclose(file);
  check(vdb_edit_parse(out));
}

/* Values are random, so that they are stored as they are: compression does not shorten them. */
static void make_file(bool is_half, bool is_frustum, vdb_edit *out) {
  static const double map[8] = {0, 0, 0, 16, 16, 16, 0.7, 2.0};
  static const double matrix[16] = {100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 1};
  np_random random = np_random_start(is_half, is_frustum, 0, 0, 0);
  np_sparse_grid grids[3];
  make_grid("density", &random, 0.05, &grids[0]);
  make_grid("temperature", &random, 2000.0, &grids[1]);
  make_grid("flame", &random, 1.0, &grids[2]);
  const np_vdb_attribute attributes[] = {{.name = "units", .text = "1/m"},
                                         {.name = "nephos:extinction_per_value", .number = 1.0},
                                         {.name = "nephos:level", .number = 0.0}};
  const np_vdb_write_grid outputs[] = {
      {.grid = &grids[0], .is_half = is_half, .attributes = attributes, .attribute_count = 3},
      {.grid = &grids[1], .is_half = is_half},
      {.grid = &grids[2], .is_half = is_half}};
  const char *path = fuzz_write_file("base.vdb", (const uint8_t *)"", 0);
  check(!np_volume_save_grids(fuzz_get_context(), path, outputs, 3, NULL));
  read_file(path, out);
  for (size_t g = 0; is_frustum && g < out->grid_count; g++) check(vdb_edit_set_frustum(out, g, map, matrix));
  for (int g = 0; g < 3; g++) np_sparse_grid_clear(&grids[g]);
}

static void make_files(void) {
  if (files[0].data) return;
  for (int n = 0; n < FILES; n++) make_file(n == 1, n == 2, &files[n]);
}

/* ---- Changes ---- */

/* Eight bytes: a kind, the grid, and numbers. */
typedef struct change {
  uint8_t kind, grid, choice, value;
  uint32_t place;
} change;

static const double numbers[] = {0.0,    1.0,   -1.0, 0.5,  -0.01, 1e-3,     1e-9,      1e-30,
                                 1e-45,  1e3,   1e9,  1e30, 3e38,  1e300,    NAN,       -NAN,
                                 1e-300, 65504, 7.0,  20.0, 1e6,   INFINITY, -INFINITY, 300.0};

static const char *const names[] = {"density",
                                    "temperature",
                                    "flame",
                                    "fuel",
                                    "v",
                                    "vel.x",
                                    "Cd",
                                    "",
                                    "density[0]",
                                    "smoke",
                                    "Density",
                                    "class",
                                    "units",
                                    "file_bbox_min",
                                    "file_voxel_count",
                                    "nephos:level",
                                    "nephos:level_count",
                                    "is_saved_as_half_float",
                                    "nephos:extinction_per_value",
                                    "vector_type"};

static double get_number(const change *c) { return numbers[c->value % (sizeof numbers / sizeof *numbers)]; }

static const char *get_name(const change *c) { return names[c->value % (sizeof names / sizeof *names)]; }

static void put(vdb_edit *e, size_t at, const void *bytes, size_t count) {
  if (at + count <= e->size) memcpy(e->data + at, bytes, count);
}

/* A value of a leaf or a tile, as a float or a half; or, of either part, plain bits. */
static void change_value(vdb_edit *e, const vdb_span *part, const change *c) {
  const float number = (float)get_number(c);
  const uint16_t half = (uint16_t)(c->place >> 8);
  if (part->count < 8) return;
  const size_t at = part->at + c->place % (part->count - 4);
  if (c->choice % 4 == 0)
    put(e, at, &half, sizeof half);
  else
    put(e, at, &number, sizeof number);
}

/* Many values of one run, as a bad simulation leaves them. */
static void change_values(vdb_edit *e, const vdb_span *part, const change *c) {
  for (unsigned n = 0; n < VALUES_MAX; n++) {
    change one = *c;
    one.choice = 1;
    one.place += 4 * n;
    change_value(e, part, &one);
  }
}

static void change_metadata(vdb_edit *e, const vdb_edit_grid *grid, const change *c) {
  if (!grid->entry_count) return;
  const vdb_entry *entry = &grid->entries[c->choice % grid->entry_count];
  const float number = (float)get_number(c);
  const double wide = get_number(c);
  if (c->place % 4 == 0) {
    (void)vdb_edit_replace_text(e, entry->name, get_name(c));
  } else if (entry->value.count == sizeof wide) {
    put(e, entry->value.at, &wide, sizeof wide);
  } else if (entry->value.count >= sizeof number) {
    put(e, entry->value.at + c->place % (entry->value.count - 3), &number, sizeof number);
  } else if (entry->value.count) {
    put(e, entry->value.at, &c->value, 1);
  }
}

static void change_transform(vdb_edit *e, size_t index, const change *c) {
  static const double plain[8] = {0, 0, 0, 16, 16, 16, 0.7, 2.0};
  static const double matrix[16] = {50, 0, 0, 0, 0, 50, 0, 0, 0, 0, 50, 0, 0, 0, 0, 1};
  const vdb_span transform = e->grids[index].transform;
  const double number = get_number(c);
  if (c->choice % 8 == 0) {
    double map[8], own[16];
    memcpy(map, plain, sizeof map), memcpy(own, matrix, sizeof own);
    map[c->place % 8] = number;
    own[c->place / 8 % 12] *= c->place & 1 ? number : 1.0;
    (void)vdb_edit_set_frustum(e, index, map, own);
  } else if (transform.count > 32) {
    const size_t count = (transform.count - 24) / sizeof number;
    put(e, transform.at + transform.count - sizeof number * (1 + c->place % count), &number, sizeof number);
  }
}

/* The background of a tree, behind the number of its buffers, and the values of its tiles in the root. */
static void change_tiles(vdb_edit *e, const vdb_edit_grid *grid, const change *c) {
  const float number = (float)get_number(c);
  const int32_t origin = (int32_t)(c->place << 8);
  if (grid->topology.count < 64) return;
  if (c->choice % 4 == 0)
    put(e, grid->topology.at + 4, &number, sizeof number);
  else if (c->choice % 4 == 1)
    put(e, grid->topology.at + 16 + 4 * (c->place % 3), &origin, sizeof origin);
  else
    change_value(e, &grid->topology, c);
}

static void change_header(vdb_edit *e, const change *c) {
  const uint32_t version = 220 + c->value % 6;
  if (c->choice % 2)
    put(e, 8, &version, sizeof version);
  else
    put(e, 12 + 4 * (c->place % 2), &c->value, 1);
}

static void apply(vdb_edit *e, const change *c) {
  const size_t index = c->grid % e->grid_count;
  const vdb_edit_grid grid = e->grids[index];
  switch (c->kind % 8) {
  case 0:
  case 1:
    change_value(e, &grid.buffers, c);
    return;
  case 2:
    change_values(e, &grid.buffers, c);
    return;
  case 3:
    change_metadata(e, &grid, c);
    return;
  case 4:
    change_transform(e, index, c);
    return;
  case 5:
    change_tiles(e, &grid, c);
    return;
  case 6:
    (void)vdb_edit_replace_text(e, grid.name, get_name(c));
    return;
  default:
    if (c->choice % 8 == 0) change_header(e, c);
  }
}

static bool make_input(const uint8_t *data, size_t size, vdb_edit *out) {
  const vdb_edit *file = &files[data[0] % FILES];
  *out = *file;
  out->data = malloc(file->size);
  check(out->data);
  memcpy(out->data, file->data, file->size);
  for (size_t i = 0; i < CHANGES_MAX && (i + 1) * CHANGE_BYTES <= size && !out->is_broken && out->grid_count; i++) {
    change c = {data[i * CHANGE_BYTES], data[i * CHANGE_BYTES + 1], data[i * CHANGE_BYTES + 2],
                data[i * CHANGE_BYTES + 3], 0};
    memcpy(&c.place, data + i * CHANGE_BYTES + 4, 4);
    apply(out, &c);
  }
  return !out->is_broken;
}

/* ---- Scenes ---- */

/* Keys of a cloud, by a bit each. */
static void write_scene(uint8_t keys, uint8_t more, const char *path, char *out, size_t room) {
  static const char *const units[] = {"", "extinction: 1 1/m, ", "optical_depth: 5, ", "mean_free_path: 10 m, "};
  (void)snprintf(out, room,
                 "{version: 1, atmosphere: none, environment: {radiance: 0.1, planet: none}, sun: {elevation: 40 deg}, "
                 "camera: {position: [0, -900, 200], look_at: [0, 0, 150], resolution: [4, 3]}, "
                 "clouds: [{name: c, vdb: \"%s\", %s%s%s%s%s%s}], "
                 "render: {integrator: march, samples: 1, multiple_scattering: none}, output: {image: x.exr}}",
                 path, units[keys & 3], keys & 4 ? "import: repair, " : "", keys & 8 ? "level_set: 2, " : "",
                 keys & 16 ? "position: [0, 0, 100], " : "", keys & 32 ? "voxel: 10 m, " : "",
                 more & 1   ? "emission: {}"
                 : more & 2 ? "detail: {}"
                            : "up: y");
}

static void render(const char *path, uint8_t keys, uint8_t more) {
  neph_context *context = fuzz_get_context();
  char text[1024];
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  write_scene(keys, more, path, text, sizeof text);
  neph_result result = neph_scene_load_text(context, text, "fuzz.yaml", &scene);
  check(!result);
  result = neph_render_image(scene, NULL, &image);
  fuzz_expect_any(result);
  rendered_count += !result;
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

static void load(const char *path, uint8_t keys) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume = NULL;
  desc.policy = keys & 4 ? NEPH_IMPORT_REPAIR : NEPH_IMPORT_REFUSE;
  desc.level_set_voxels = keys & 8 ? 2.0 : 0.0;
  const neph_result result = neph_volume_load(fuzz_get_context(), path, &desc, &volume);
  fuzz_expect(result);
  loaded_count += !result;
  neph_volume_release(volume);
}

static void print_counts(void) {
  fprintf(stderr, "fuzz_vdb_values: %lu inputs, %lu loaded, %lu rendered\n", run_count, loaded_count, rendered_count);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  vdb_edit input;
  if (size < CHANGE_BYTES) return 0;
  make_files();
  if (!run_count++) atexit(print_counts);
  if (make_input(data, size, &input)) {
    const char *path = fuzz_write_file("cloud.vdb", input.data, input.size);
    load(path, data[size - 1]);
    render(path, data[size - 1], data[size - 2]);
  }
  free(input.data);
  return 0;
}
