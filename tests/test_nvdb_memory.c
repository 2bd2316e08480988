/* SPDX-License-Identifier: Apache-2.0 */
/* NanoVDB's grids in memory: volumes of the file's values, at any address; faults are refused. */
#include "test_tools.h"

#include <stdlib.h>

#include <nephos/nephos.h>

#define DATA NEPHOS_TEST_SOURCE_DIR "/data/vdb"

/* Positions of NanoVDB 32.4: a segment's head, the description of a grid, a grid. */
enum { GRID_COUNT = 12, META = 16, META_NAME_BYTES = 136, META_BYTES = 176, CHECKSUM = 8, INDEX = 24, SIZE = 32 };

static int set_up(void **state) {
  test_require_tool("nanovdb_convert --version >/dev/null 2>&1", "libnanovdb-tools");
  test_require_tool("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1", "python3-openvdb");
  return test_set_up(state, 2, "cloud.nvdb");
}

static uint64_t get(const uint8_t *at, size_t bytes) {
  uint64_t value = 0;
  memcpy(&value, at, bytes);
  return value;
}

/* Leaves the grids of a file without compression, one behind the other, as GridHandle::data() has them. */
static void strip_segments(test_file *file) {
  size_t in = 0, out = 0;
  while (in < file->size) {
    const size_t count = get(file->bytes + in + GRID_COUNT, 2);
    for (in += META; get(file->bytes + in, 8) != UINT64_C(0x304244566f6e614e);)
      in += META_BYTES + get(file->bytes + in + META_NAME_BYTES, 4);
    for (size_t i = 0; i < count; i++) {
      const size_t bytes = get(file->bytes + in + SIZE, 8);
      memmove(file->bytes + out, file->bytes + in, bytes);
      in += bytes;
      out += bytes;
    }
  }
  file->size = out;
}

/* States in each grid its place among all, and no checksum. */
static void number_grids(const test_file *grids) {
  uint32_t place[2] = {0, 0};
  for (size_t at = 0; at < grids->size; at += get(grids->bytes + at + SIZE, 8)) place[1]++;
  for (size_t at = 0; at < grids->size; at += get(grids->bytes + at + SIZE, 8), place[0]++) {
    memset(grids->bytes + at + CHECKSUM, 0xff, 8);
    memcpy(grids->bytes + at + INDEX, place, sizeof place);
  }
}

static void assert_same_volume(neph_volume *a, neph_volume *b) {
  neph_volume_info infos[2] = {NEPH_VOLUME_INFO_DEFAULT, NEPH_VOLUME_INFO_DEFAULT};
  assert_int_equal(neph_volume_get_info(a, &infos[0]), NEPH_OK);
  assert_int_equal(neph_volume_get_info(b, &infos[1]), NEPH_OK);
  assert_string_equal(infos[0].name, infos[1].name);
  assert_memory_equal(infos[0].bounds_max_m, infos[1].bounds_max_m, sizeof infos[0].bounds_max_m);
  assert_int_equal(infos[0].active_voxel_count, infos[1].active_voxel_count);
  for (int n = 0; n < 8000; n++) {
    double position[3];
    float values[2];
    for (int axis = 0; axis < 3; axis++) {
      const double share = (n / (axis == 2 ? 400 : axis ? 20 : 1) % 20 + 0.3) / 19.7;
      position[axis] = infos[0].bounds_min_m[axis] * (1.0 - share) + infos[0].bounds_max_m[axis] * share;
    }
    neph_volume_sample(a, 1, position, &values[0]);
    neph_volume_sample(b, 1, position, &values[1]);
    assert_memory_equal(&values[0], &values[1], sizeof values[0]);
  }
}

static void assert_memory_is_file(const test_fixture *f, const test_file *memory, const char *path, const char *grid) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *expected, *actual;
  desc.grid = grid;
  assert_int_equal(neph_volume_load(f->context, path, &desc, &expected), NEPH_OK);
  for (size_t shift = 0; shift < 2; shift++) { /* an odd address too, without a byte to spare */
    uint8_t *bytes = malloc(memory->size + shift);
    assert_non_null(bytes);
    memcpy(bytes + shift, memory->bytes, memory->size);
    assert_int_equal(neph_volume_load_memory(f->context, bytes + shift, memory->size, &desc, &actual), NEPH_OK);
    free(bytes);
    assert_same_volume(expected, actual);
    neph_volume_release(actual);
  }
  neph_volume_release(expected);
}

/* Floats, quantised values and vectors' neighbours, in a segment of each codec, and without a segment. */
static void volumes_are_those_of_the_file(void **state) {
  static const char *const options[] = {"-c none", "-c full", "--fp8", "--fpN", "-z", "-b"};
  test_fixture *f = *state;
  for (size_t o = 0; o < sizeof options / sizeof *options; o++) {
    test_run_command("nanovdb_convert -f %s " DATA "/blosc.vdb %s", options[o], f->path);
    test_file file = test_file_read(f->path);
    assert_memory_is_file(f, &file, f->path, NULL);
    if (options[o][1] != 'z' && options[o][1] != 'b') {
      strip_segments(&file);
      assert_memory_is_file(f, &file, f->path, NULL);
      test_file_write(f->path, file.bytes, file.size); /* a file of grids alone */
      assert_memory_is_file(f, &file, f->path, "odd");
    }
    free(file.bytes);
  }
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR] + f->log.counts[NEPH_LOG_WARNING], 0);
}

static void files_of_openvdb_are_read_too(void **state) {
  test_fixture *f = *state;
  const test_file file = test_file_read(DATA "/blosc.vdb");
  assert_memory_is_file(f, &file, DATA "/blosc.vdb", NULL);
  free(file.bytes);
}

/* Three grids of one handle, and bytes behind them, as a buffer may have. */
static void a_grid_of_several_is_chosen(void **state) {
  static const char *const names[] = {"DENSITY", "Smoke", "fuel", "DENSITY + Smoke"};
  test_fixture *f = *state;
  char *vdb = test_path(f->folder, "parts.vdb");
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  test_run_command("/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/write_vdb.py %s", f->folder);
  test_run_command("nanovdb_convert -f -c none %s %s", vdb, f->path);
  test_file file = test_file_read(f->path);
  strip_segments(&file);
  number_grids(&file);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) assert_memory_is_file(f, &file, f->path, names[i]);
  desc.grid = "soot";
  assert_int_equal(neph_volume_load_memory(f->context, file.bytes, file.size, &desc, &volume), NEPH_ERROR_BAD_FILE);
  assert_null(volume);
  assert_one_error(&f->log, "buffer: ", "no grid 'soot'", "'Smoke'", "'fuel'");
  assert_int_equal(neph_volume_load_memory(f->context, file.bytes, file.size - 1, NULL, &volume), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "buffer: ", "the buffer ends at byte");
  free(file.bytes);
  free(vdb);
}

/* The finest of several levels is no whole cloud. */
static void levels_of_detail_are_refused(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  neph_volume *volume;
  assert_int_equal(neph_cloud_get_preset(f->context, "cumulus_humilis", &cloud), NEPH_OK);
  cloud.extent_m[0] = cloud.extent_m[1] = 1500.0;
  cloud.voxel_m = 20.0;
  cloud.thickness_m = 1000.0;
  desc.lod_count = 2;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, &desc, "density", f->path), NEPH_OK);
  const test_file file = test_file_read(f->path);
  assert_int_equal(neph_volume_load_memory(f->context, file.bytes, file.size, NULL, &volume), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "buffer: ", "first of 2 files, levels of detail", "load it by its path");
  free(file.bytes);
}

/* ---- Faults ---- */

static neph_result load(const test_fixture *f, const uint8_t *bytes, size_t size) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  desc.policy = NEPH_IMPORT_REPAIR;
  const neph_result result = neph_volume_load_memory(f->context, bytes, size, &desc, &volume);
  assert_int_equal(result == NEPH_OK, volume != NULL);
  neph_volume_release(volume);
  return result;
}

static test_file make_grid(const test_fixture *f) {
  test_run_command("nanovdb_convert -f -c none " DATA "/blosc.vdb %s", f->path);
  test_file file = test_file_read(f->path);
  strip_segments(&file);
  return file;
}

/* Every length of the heads, then some. The copy ends where the buffer does, so that sanitizers see a read beyond. What
 * is too short for the first fields of a grid is taken for a segment, whose version would be there. */
static void buffers_that_end_early_are_refused(void **state) {
  test_fixture *f = *state;
  const test_file grid = make_grid(f);
  for (size_t size = 0; size < grid.size; size += size < 1100 ? 1 : 997) {
    uint8_t *bytes = malloc(size ? size : 1);
    assert_non_null(bytes);
    memcpy(bytes, grid.bytes, size);
    const bool is_segment = size >= 12 && size < SIZE;
    assert_int_equal(load(f, bytes, size), is_segment ? NEPH_ERROR_UNSUPPORTED : NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "buffer: ", is_segment ? "version" : "the buffer ends at byte");
    free(bytes);
  }
  free(grid.bytes);
}

/* The checksum is taken out: it would be wrong before all else. */
static void changed_bytes_do_no_harm(void **state) {
  test_fixture *f = *state;
  const test_file grid = make_grid(f);
  unsigned random = 1;
  memset(grid.bytes + CHECKSUM, 0xff, 8);
  for (size_t n = 0; n < 1500; n++) {
    random = random * 1664525u + 1013904223u;
    const size_t at = n < 1100 ? n : (random >> 4) % grid.size;
    const uint8_t kept = grid.bytes[at];
    grid.bytes[at] = (uint8_t)(kept ^ (random >> 24 | 1u));
    if (load(f, grid.bytes, grid.size)) assert_one_error(&f->log, "buffer: ");
    test_log_clear(&f->log);
    grid.bytes[at] = kept;
  }
  assert_int_equal(load(f, grid.bytes, grid.size), NEPH_OK);
  free(grid.bytes);
}

static void other_bytes_are_refused(void **state) {
  test_fixture *f = *state;
  const test_file grid = make_grid(f);
  assert_int_equal(load(f, (const uint8_t *)"no grid at all", 15), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "buffer: ", "not a VDB file");
  for (size_t i = 0; i < 4; i++) {
    const uint8_t byte = grid.bytes[i];
    grid.bytes[i] = grid.bytes[7 - i];
    grid.bytes[7 - i] = byte;
  }
  assert_int_equal(load(f, grid.bytes, grid.size), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, "buffer: ", "byte order");
  free(grid.bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(volumes_are_those_of_the_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(files_of_openvdb_are_read_too, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_grid_of_several_is_chosen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(levels_of_detail_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(buffers_that_end_early_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(changed_bytes_do_no_harm, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(other_bytes_are_refused, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
