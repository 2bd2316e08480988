/* SPDX-License-Identifier: Apache-2.0 */
/* Files of HDF5 that are damaged, and readers of them that end: an error, and nothing is left behind. */
#include "test_models.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
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

/* A child that a thread of a process has started; 0: none. */
static pid_t get_child_of(pid_t process, const char *thread) {
  char path[64];
  int child = 0;
  (void)snprintf(path, sizeof path, "/proc/%d/task/%.20s/children", (int)process, thread);
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  if (fscanf(file, "%d", &child) != 1) child = 0;
  (void)fclose(file);
  return child;
}

/* The only child of this process. */
static pid_t get_child(void) {
  DIR *threads = opendir("/proc/self/task");
  pid_t child = 0;
  assert_non_null(threads);
  for (const struct dirent *entry; !child && (entry = readdir(threads));)
    if (entry->d_name[0] != '.') child = get_child_of(getpid(), entry->d_name);
  closedir(threads);
  assert_true(child > 0);
  return child;
}

static np_netcdf_file *open_field(test_fixture *f, const np_monitor *monitor) {
  np_netcdf_error error;
  np_netcdf_file *file;
  assert_int_equal(np_netcdf_process_open(f->context, monitor, f->path, NULL, 0, &file, &error), NEPH_OK);
  assert_true(np_netcdf_process_table.count(file) > 3);
  return file;
}

/* A signal is what is left of a crash, or of the limit of CPU time. Sanitizers leave SIGABRT as it is. */
static void ended_readers_are_errors(void **state) {
  static const struct {
    int signal;
    const char *message;
  } ends[] = {{SIGABRT, "ended by the signal SIGABRT"}, {SIGXCPU, "took more than 20 s"}, {SIGKILL, "SIGKILL"}};
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

enum { WAITS_MAX = 1000, WAIT_NS = 10000000 };

static void wait_a_little(void) { (void)nanosleep(&(struct timespec){.tv_nsec = WAIT_NS}, NULL); }

/* Whether a process runs; one that has ended may wait for its parent, in the state Z. */
static bool is_running(pid_t process) {
  char path[64], state = 'Z';
  (void)snprintf(path, sizeof path, "/proc/%d/stat", (int)process);
  FILE *file = fopen(path, "r");
  if (!file) return false;
  if (fscanf(file, "%*d (%*[^)]) %c", &state) != 1) state = 'Z';
  (void)fclose(file);
  return state != 'Z';
}

/* A process that is killed while its reader is busy: here HDF5 opens a pipe, and waits for ever. */
static void readers_end_with_their_process(void **state) {
  test_fixture *f = *state;
  char thread[20];
  pid_t reader = 0;
  assert_int_equal(mkfifo(f->path, 0600), 0);
  const pid_t process = fork();
  assert_true(process >= 0);
  if (!process) {
    np_netcdf_file *file;
    np_netcdf_error error;
    (void)np_netcdf_process_open(f->context, NULL, f->path, NULL, 0, &file, &error);
    _exit(EXIT_FAILURE);
  }
  (void)snprintf(thread, sizeof thread, "%d", (int)process);
  for (int n = 0; !reader && n < WAITS_MAX; n++, wait_a_little()) reader = get_child_of(process, thread);
  assert_true(reader > 0);
  for (int n = 0; n < 30; n++) wait_a_little();
  assert_true(is_running(reader));
  assert_int_equal(kill(process, SIGKILL), 0);
  assert_int_equal(waitpid(process, NULL, 0), process);
  for (int n = 0; is_running(reader) && n < WAITS_MAX; n++) wait_a_little();
  assert_false(is_running(reader));
}

/* ---- Calls that are interrupted ---- */

/* Stops the reader at the first wait for it, and interrupts the call a few waits later. */
static bool stop_reader(void *user) {
  enum { WAITS = 5 };
  unsigned *calls = user;
  if (!*calls) assert_int_equal(kill(get_child(), SIGSTOP), 0);
  return ++*calls > WAITS;
}

static neph_result describe(neph_context *context, const char *path) {
  char *text = NULL;
  const neph_result result = neph_volume_describe_file(context, path, NEPH_TEXT_PLAIN, &text);
  neph_text_destroy(context, text);
  return result;
}

static neph_result export_cloud(neph_context *context, const char *path) {
  char text[600], out_path[300];
  neph_scene *scene;
  neph_exported_cloud cloud = NEPH_EXPORTED_CLOUD_DEFAULT;
  (void)snprintf(text, sizeof text,
                 "version: 1\ncamera: {position: [0 m, -9 km, 1 km]}\nsun: {elevation: 30 deg}\n"
                 "clouds: [{name: model, netcdf: %.300s}]\n",
                 path);
  (void)snprintf(out_path, sizeof out_path, "%.250s.vdb", path);
  assert_int_equal(neph_scene_load_text(context, text, "scene.yaml", &scene), NEPH_OK);
  const neph_result result = neph_scene_export_cloud(scene, 0, 1, NULL, out_path, &cloud);
  neph_scene_destroy(scene);
  assert_int_equal(access(out_path, F_OK), -1);
  return result;
}

static neph_result load(neph_context *context, const char *path) {
  neph_volume *volume = NULL;
  const neph_result result = neph_volume_load(context, path, NULL, &volume);
  assert_null(volume);
  return result;
}

/* No call waits for a reader that stands still longer than its context allows, with or without a progress callback. */
static void interrupted_calls_end(void **state) {
  neph_result (*const calls[])(neph_context *, const char *) = {describe, export_cloud, load};
  test_fixture *f = *state;
  write_field(f);
  const unsigned files = count_files();
  for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
    unsigned waits = 0;
    neph_context *context;
    neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
    desc.thread_count = 2;
    desc.is_interrupted = stop_reader;
    desc.interrupt_user = &waits;
    assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
    assert_int_equal(calls[i](context, f->path), NEPH_ERROR_CANCELLED);
    assert_true(waits > 1);
    neph_context_destroy(context);
    check_nothing_is_left(files);
  }
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
      cmocka_unit_test_setup_teardown(readers_end_with_their_process, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(interrupted_calls_end, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(damaged_files_are_read_or_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(memory_and_disk_agree, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
