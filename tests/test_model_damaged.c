/* SPDX-License-Identifier: Apache-2.0 */
/* Files of HDF5 that are damaged, and readers of them that end: an error, and nothing is left behind. */
#include "test_models.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nephos/nephos.h>

#include "core/random.h"
#include "volume/netcdf_process.h"

static int set_up(void **state) { return test_set_up(state, 2, "field.nc"); }

static void write_field(const test_fixture *f) {
  static const model_file plain = {.levels = LEVELS_EVEN, .step_count = 1};
  model_write(f->path, model_get_case("MicroHH"), &plain);
}

static unsigned count_files(void) {
  DIR *folder = opendir("/proc/self/fd");
  unsigned count = 0;
  assert_non_null(folder);
  while (readdir(folder)) count++;
  closedir(folder);
  return count;
}

/* No file is left open, and no process has not been waited for. */
static void check_nothing_is_left(unsigned files_before) {
  assert_int_equal(count_files(), files_before);
  assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
  assert_int_equal(errno, ECHILD);
}

/* ---- Readers that end ---- */

/* The only child of this process. */
static pid_t get_child(void) {
  char path[64];
  int child = 0;
  (void)snprintf(path, sizeof path, "/proc/self/task/%d/children", (int)getpid());
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  assert_int_equal(fscanf(file, "%d", &child), 1);
  (void)fclose(file);
  return child;
}

static np_netcdf_file *open_field(test_fixture *f, const np_monitor *monitor) {
  np_netcdf_error error;
  np_netcdf_file *file;
  assert_int_equal(np_netcdf_process_open(f->context, monitor, f->path, NULL, 0, &file, &error), NEPH_OK);
  assert_true(np_netcdf_process_table.count(file) > 3);
  return file;
}

/* A signal is what is left of a crash, or of the limit of CPU time. */
static void ended_readers_are_errors(void **state) {
  static const struct {
    int signal;
    const char *message;
  } ends[] = {{SIGSEGV, "ended by the signal SIGSEGV"}, {SIGXCPU, "took more than 20 s"}, {SIGKILL, "SIGKILL"}};
  test_fixture *f = *state;
  write_field(f);
  const unsigned files = count_files();
  for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
    np_netcdf_variable variable;
    np_netcdf_error error;
    double number;
    np_netcdf_file *file = open_field(f, NULL);
    assert_int_equal(np_netcdf_process_table.describe(file, 0, &variable, &error), NEPH_OK);
    assert_int_equal(kill(get_child(), ends[i].signal), 0);
    assert_int_equal(np_netcdf_process_table.describe(file, 0, &variable, &error), NEPH_ERROR_BAD_FILE);
    assert_non_null(strstr(error.message, ends[i].message));
    assert_true(np_netcdf_process_has_ended(file));
    assert_int_equal(np_netcdf_process_table.describe(file, 0, &variable, &error), NEPH_ERROR_BAD_FILE);
    assert_non_null(strstr(error.message, ends[i].message)); /* the first reason is repeated */
    assert_int_equal(np_netcdf_process_table.read_number(file, 0, "scale_factor", &number), 0);
    np_netcdf_process_table.close(file);
    check_nothing_is_left(files);
  }
}

/* A reader that stands still is ended by a cancel, and not waited for. */
static void stopped_readers_are_cancelled(void **state) {
  test_fixture *f = *state;
  np_netcdf_variable variable;
  np_netcdf_error error;
  np_monitor monitor;
  write_field(f);
  const unsigned files = count_files();
  np_monitor_start(&monitor, f->context, NULL, NULL);
  np_netcdf_file *file = open_field(f, &monitor);
  assert_int_equal(kill(get_child(), SIGSTOP), 0);
  atomic_store(&monitor.is_cancelled, true);
  assert_int_equal(np_netcdf_process_table.describe(file, 0, &variable, &error), NEPH_ERROR_CANCELLED);
  assert_int_equal(np_netcdf_process_table.describe(file, 0, &variable, &error), NEPH_ERROR_CANCELLED);
  np_netcdf_process_table.close(file);
  check_nothing_is_left(files);
}

/* ---- Damaged files ---- */

/* Bytes of a whole file, owned by the caller. */
static unsigned char *read_bytes(const char *path, size_t *out_count) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  *out_count = (size_t)ftell(file);
  rewind(file);
  unsigned char *bytes = malloc(*out_count);
  assert_non_null(bytes);
  assert_int_equal(fread(bytes, 1, *out_count, file), *out_count);
  (void)fclose(file);
  return bytes;
}

static void write_bytes(const char *path, const unsigned char *bytes, size_t count) {
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, count, file), count);
  assert_int_equal(fclose(file), 0);
}

/* Up to four bytes changed, or the end cut off. */
static void damage(unsigned variant, unsigned char *bytes, size_t *count) {
  uint64_t draw = np_random_mix(variant + 1);
  if (variant % 8 == 7) *count = 8 + draw % (*count - 8);
  for (unsigned n = 0; n <= variant % 4; n++) {
    draw = np_random_mix(draw + n);
    bytes[8 + draw % (*count - 8)] = (unsigned char)(draw >> 32);
  }
}

/* Each file is read, or refused by one error that names it. */
static void damaged_files_are_read_or_refused(void **state) {
  enum { VARIANTS = 96 };
  test_fixture *f = *state;
  unsigned refused = 0;
  size_t count;
  write_field(f);
  unsigned char *whole = read_bytes(f->path, &count), *bytes = malloc(count);
  assert_non_null(bytes);
  const unsigned files = count_files();
  for (unsigned variant = 0; variant < VARIANTS; variant++) {
    size_t left = count;
    neph_volume *volume;
    memcpy(bytes, whole, count);
    damage(variant, bytes, &left);
    write_bytes(f->path, bytes, left);
    test_log_clear(&f->log);
    if (neph_volume_load(f->context, f->path, NULL, &volume)) {
      assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 1);
      assert_non_null(strstr(f->log.text, "field.nc"));
      refused++;
    }
    neph_volume_release(volume);
  }
  print_message("%u of %d files are refused\n", refused, VARIANTS);
  assert_true(refused > VARIANTS / 4 && refused < VARIANTS);
  check_nothing_is_left(files);
  free(bytes);
  free(whole);
}

/* ---- Bytes in memory ---- */

/* A file from memory, which the reader gets by its input, has the values of that on disk. */
static void memory_and_disk_agree(void **state) {
  test_fixture *f = *state;
  size_t count;
  write_field(f);
  unsigned char *bytes = read_bytes(f->path, &count);
  np_netcdf_error error;
  np_netcdf_file *files[2] = {open_field(f, NULL), NULL};
  assert_int_equal(np_netcdf_process_open(f->context, NULL, f->path, bytes, count, &files[1], &error), NEPH_OK);
  const int variables = np_netcdf_process_table.count(files[0]);
  assert_int_equal(np_netcdf_process_table.count(files[1]), variables);
  for (int v = 0; v < variables; v++) {
    static const size_t starts[NP_NETCDF_RANK_MAX] = {0};
    np_netcdf_variable info[2];
    double *values[2];
    size_t number = 1;
    for (int k = 0; k < 2; k++)
      assert_int_equal(np_netcdf_process_table.describe(files[k], v, &info[k], &error), NEPH_OK);
    assert_memory_equal(&info[0], &info[1], sizeof info[0]);
    for (int d = 0; d < info[0].rank; d++) number *= info[0].sizes[d];
    for (int k = 0; k < 2; k++) {
      values[k] = forge_alloc(number);
      assert_int_equal(np_netcdf_process_table.read(files[k], v, starts, info[k].sizes, values[k], &error), NEPH_OK);
    }
    assert_memory_equal(values[0], values[1], number * sizeof *values[0]);
    for (int k = 0; k < 2; k++) free(values[k]);
  }
  for (int k = 0; k < 2; k++) np_netcdf_process_table.close(files[k]);
  free(bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(ended_readers_are_errors, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(stopped_readers_are_cancelled, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(damaged_files_are_read_or_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(memory_and_disk_agree, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
