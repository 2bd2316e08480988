/* SPDX-License-Identifier: Apache-2.0 */
/* .nvdb files from strangers: whatever stands in them, they are read, or refused with one message, within bounds. */
#include "test_tools.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

#include <nephos/nephos.h>

#define VDB NEPHOS_TEST_SOURCE_DIR "/data/vdb/blosc.vdb"

/* Positions of NanoVDB 32.4, of a file's head, then of a grid's. */
enum {
  META = 16,
  META_STORED_BYTES = META + 8,
  META_NAME_BYTES = META + 136,
  META_BYTES = 176,
  GRID_SIZE = 32,
  GRID_TYPE = 636,
  BLIND_COUNT = 648,
  TREE = 672,
  ROOT_OFFSET = TREE + 24,
  LEAF_COUNT = TREE + 32,
  ROOT = TREE + 64,
  ROOT_TILE_COUNT = ROOT + 24,
  ROOT_TILE = ROOT + 64,
  ROOT_TILE_CHILD = ROOT_TILE + 8
};

static int set_up(void **state) {
  test_require_tool("nanovdb_convert --version >/dev/null 2>&1", "libnanovdb-tools");
  return test_set_up(state, 1, "cloud.nvdb");
}

static void convert(const test_fixture *f, const char *options) {
  char *command;
  assert_true(asprintf(&command, "nanovdb_convert -f %s " VDB " %s", options, f->path) >= 0);
  assert_int_equal(system(command), 0);
  free(command);
}

static neph_result load(neph_context *context, const char *path) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  desc.policy = NEPH_IMPORT_REPAIR;
  const neph_result result = neph_volume_load(context, path, &desc, &volume);
  neph_volume_release(volume);
  return result;
}

static neph_result describe(neph_context *context, const char *path) {
  char *text;
  const neph_result result = neph_volume_describe_file(context, path, NEPH_TEXT_JSON, &text);
  neph_text_destroy(context, text);
  return result;
}

static long get_peak_kilobytes(void) {
  struct rusage usage;
  assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
  return usage.ru_maxrss;
}

/* A bad file may take 64 times its bytes and 256 MB, and 5 s. Sanitizers keep what was freed, and shadows of it. */
static void assert_within_bounds(long kilobytes_before, clock_t clock_before, uint64_t file_bytes) {
#ifndef __SANITIZE_ADDRESS__
  assert_in_range(get_peak_kilobytes() - kilobytes_before, 0, 256000 + 64 * file_bytes / 1000);
#else
  (void)kilobytes_before, (void)file_bytes;
#endif
  assert_true(clock() - clock_before < 5 * CLOCKS_PER_SEC);
}

/* ---- Single faults ---- */

static size_t get_grid_begin(const test_file *file) {
  uint32_t name_bytes;
  memcpy(&name_bytes, file->bytes + META_NAME_BYTES, sizeof name_bytes);
  return META + META_BYTES + name_bytes;
}

typedef struct fault {
  size_t at;
  bool is_of_grid; /* `at` counts from the grid */
  unsigned bytes;
  uint64_t value;
  neph_result result;
  const char *word;
} fault;

static void assert_refused(test_fixture *f, const test_file *file, const fault *wrong) {
  uint8_t kept[sizeof(uint64_t)];
  uint8_t *at = file->bytes + wrong->at + (wrong->is_of_grid ? get_grid_begin(file) : 0);
  const long kilobytes = get_peak_kilobytes();
  const clock_t start = clock();
  memcpy(kept, at, wrong->bytes);
  memcpy(at, &wrong->value, wrong->bytes);
  test_file_write(f->path, file->bytes, file->size);
  memcpy(at, kept, wrong->bytes);
  if (load(f->context, f->path) != wrong->result) fail_msg("byte %zu, %s: %s", wrong->at, wrong->word, f->log.text);
  assert_one_error(&f->log, f->path, wrong->word);
  if (describe(f->context, f->path)) assert_one_error(&f->log, f->path, wrong->word);
  test_log_clear(&f->log);
  assert_within_bounds(kilobytes, start, file->size);
}

static const uint64_t much = UINT64_C(1) << 60;

/* Each names what is wrong. The checksum of the head is taken out: it would be wrong before all else. */
static void faults_of_the_structure_are_refused(void **state) {
  const fault faults[] = {
      {0, false, 8, 0x4e616e6f56444230, NEPH_ERROR_UNSUPPORTED, "byte order"},
      {8, false, 4, 33u << 21, NEPH_ERROR_UNSUPPORTED, "version 33.0 of NanoVDB is too new"},
      {8, false, 4, 29u << 21, NEPH_ERROR_UNSUPPORTED, "version 29.0 of NanoVDB is too old"},
      {14, false, 2, 7, NEPH_ERROR_BAD_FILE, "compression is 7"},
      {12, false, 2, 60000, NEPH_ERROR_BAD_FILE, "damaged"},
      {META, false, 8, much, NEPH_ERROR_BAD_FILE, "stored in"},
      {META, false, 8, 100, NEPH_ERROR_BAD_FILE, "stored in"},
      {META_STORED_BYTES, false, 8, much, NEPH_ERROR_BAD_FILE, "stored in"},
      {META_NAME_BYTES, false, 4, UINT32_MAX, NEPH_ERROR_BAD_FILE, "truncated"},
      {0, true, 8, much, NEPH_ERROR_BAD_FILE, "must begin with"},
      {16, true, 4, 33u << 21, NEPH_ERROR_UNSUPPORTED, "too new"},
      {GRID_SIZE, true, 8, much, NEPH_ERROR_BAD_FILE, "by its own head"},
      {GRID_TYPE, true, 4, 2, NEPH_ERROR_BAD_FILE, "type 2 by its own head"},
      {BLIND_COUNT, true, 4, UINT32_MAX, NEPH_ERROR_BAD_FILE, "blind data"},
      {ROOT_OFFSET, true, 8, much, NEPH_ERROR_BAD_FILE, "its root stands"},
      {ROOT_OFFSET, true, 8, 65, NEPH_ERROR_BAD_FILE, "its root stands"},
      {ROOT_OFFSET, true, 8, UINT64_C(0) - 96, NEPH_ERROR_BAD_FILE, "damaged"},
      {LEAF_COUNT, true, 4, UINT32_MAX, NEPH_ERROR_BAD_FILE, "do not fit"},
      {LEAF_COUNT, true, 4, 0, NEPH_ERROR_BAD_FILE, "more than the 0 leaves"},
      {LEAF_COUNT + 4, true, 4, 0, NEPH_ERROR_BAD_FILE, "more than the 0 lower nodes"},
      {LEAF_COUNT + 8, true, 4, 0, NEPH_ERROR_BAD_FILE, "more than the 0 upper nodes"},
      {ROOT_TILE_COUNT, true, 4, UINT32_MAX, NEPH_ERROR_BAD_FILE, "tiles, more than fit"},
      {ROOT_TILE_COUNT, true, 4, 0, NEPH_ERROR_BAD_FILE, "nodes of level 0, and states"},
      {ROOT_TILE, true, 8, UINT64_MAX, NEPH_ERROR_BAD_FILE, "key"},
      {ROOT_TILE, true, 8, UINT64_C(1) << 20, NEPH_ERROR_BAD_FILE, "key"},
      {ROOT_TILE_CHILD, true, 8, much, NEPH_ERROR_BAD_FILE, "a node of its tree stands at byte"},
      {ROOT_TILE_CHILD, true, 8, UINT64_C(0) - 4096, NEPH_ERROR_BAD_FILE, "a node of its tree stands at byte"},
      {ROOT_TILE_CHILD, true, 8, 33, NEPH_ERROR_BAD_FILE, "multiple of 32"},
      {ROOT_TILE_CHILD, true, 8, INT64_MAX, NEPH_ERROR_BAD_FILE, "multiple of 32"},
  };
  test_fixture *f = *state;
  convert(f, "-c none");
  const test_file file = test_file_read(f->path);
  for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
    assert_refused(f, &file, &faults[i]);
  free(file.bytes);
}

static void faults_of_chunks_are_refused(void **state) {
  static const char *const options[] = {"-z", "-b"};
  static const fault faults[] = {
      {META, false, 8, UINT64_C(1) << 40, NEPH_ERROR_BAD_FILE, "less than one in 64"},
      {META, false, 8, 8, NEPH_ERROR_BAD_FILE, "stored in"},
      {0, true, 8, UINT64_MAX, NEPH_ERROR_BAD_FILE, "chunk"},
      {0, true, 8, 0, NEPH_ERROR_BAD_FILE, "chunk"},
      {0, true, 8, 9, NEPH_ERROR_BAD_FILE, "decompressed"},
      {8, true, 8, UINT64_MAX, NEPH_ERROR_BAD_FILE, "decompressed"},
  };
  test_fixture *f = *state;
  for (size_t o = 0; o < sizeof options / sizeof *options; o++) {
    convert(f, options[o]);
    const test_file file = test_file_read(f->path);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) assert_refused(f, &file, &faults[i]);
    free(file.bytes);
  }
}

/* The tool writes the sum of nodes by its option for it. */
static void checksums_are_compared(void **state) {
  test_fixture *f = *state;
  convert(f, "-c full");
  const test_file file = test_file_read(f->path);
  const fault head = {560, true, 1, 0xa5, NEPH_ERROR_BAD_FILE, "checksum of its head"};
  fault node = {file.size - 100, false, 1, 0xa5, NEPH_ERROR_BAD_FILE, "checksum of its nodes"};
  assert_refused(f, &file, &head);
  node.value = file.bytes[node.at] ^ 1u;
  assert_refused(f, &file, &node);
  free(file.bytes);
}

/* ---- Many faults ---- */

static void files_that_end_early_are_refused(void **state) {
  static const char *const options[] = {"", "-z", "-b"};
  test_fixture *f = *state;
  for (size_t o = 0; o < sizeof options / sizeof *options; o++) {
    convert(f, options[o]);
    const test_file file = test_file_read(f->path);
    for (size_t i = 0; i < 40; i++) {
      test_file_write(f->path, file.bytes, i < 20 ? 13 * i : file.size * (i - 19) / 21 - 1);
      assert_int_equal(load(f->context, f->path), NEPH_ERROR_BAD_FILE);
      assert_one_error(&f->log, f->path, "truncated");
    }
    free(file.bytes);
  }
}

/* Heads, the root and the first nodes; then everything. */
static void changed_bytes_do_no_harm(void **state) {
  static const char *const options[] = {"-c none", "-c full", "--fpN -c none", "-z", "-b"};
  test_fixture *f = *state;
  const long kilobytes = get_peak_kilobytes();
  const clock_t start = clock();
  for (size_t o = 0; o < sizeof options / sizeof *options; o++) {
    convert(f, options[o]);
    assert_survives_changed_bytes(f, 1100, 60, describe);
    assert_survives_changed_bytes(f, 1100, 60, load);
    assert_survives_changed_bytes(f, SIZE_MAX, 30, load);
  }
  assert_true(clock() - start < 750 * 5 * CLOCKS_PER_SEC);
  assert_within_bounds(kilobytes, clock(), 0);
}

static neph_result attempt(neph_context *context, void *user) { return load(context, user); }

static void memory_may_run_out_anywhere(void **state) {
  test_fixture *f = *state;
  convert(f, "");
  assert_survives_failed_allocations(attempt, f->path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(faults_of_the_structure_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(faults_of_chunks_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(checksums_are_compared, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(files_that_end_early_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(changed_bytes_do_no_harm, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(memory_may_run_out_anywhere, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
