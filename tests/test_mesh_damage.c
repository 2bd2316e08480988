/* SPDX-License-Identifier: Apache-2.0 */
/* Files that crash Assimp or make it take all memory are refused with one message, and leave this process as it was:
 * neither a file nor a child stays. */
#include <nephos/nephos.h>

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/child.h"
#include "mesh/camera_file.h"
#include "mesh/mesh_file.h"
#include "test_meshes.h"

static int set_up(void **state) { return test_set_up_meshes(state, 2, "damaged.ply"); }

static unsigned count_open_files(void) {
  DIR *folder = opendir("/proc/self/fd");
  unsigned count = 0;
  assert_non_null(folder);
  while (readdir(folder)) count++;
  closedir(folder);
  return count;
}

static void assert_no_child(void) {
  errno = 0;
  assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
  assert_int_equal(errno, ECHILD);
}

/* ---- Children ---- */

/* Nothing interrupts its waits. */
static neph_context patient;

static void output_of_a_child_is_read(void **state) {
  (void)state;
  const unsigned files = count_open_files();
  char text[6] = "";
  np_child child;
  /* It has the three files that every program has, and the folder in which it looks for them. */
  const char *const words[] = {"-c", "set -- /proc/$$/fd/*; printf hello%s $#", NULL};
  assert_int_equal(np_child_start("/bin/sh", words, &child), 0);
  assert_int_equal(np_child_read(&child, &patient, NULL, text, 5), NEPH_OK);
  assert_string_equal(text, "hello");
  memset(text, 0, sizeof text);
  assert_int_equal(np_child_read(&child, &patient, NULL, text, 1), NEPH_OK);
  assert_string_equal(text, "4");
  assert_int_equal(np_child_read(&child, &patient, NULL, text, 1), NEPH_ERROR_BAD_FILE);
  assert_int_equal(np_child_wait(&child), 0);
  np_child_end(&child);
  assert_int_equal(count_open_files(), files);
  assert_no_child();
}

static void a_child_may_end_in_any_way(void **state) {
  (void)state;
  const unsigned files = count_open_files();
  char byte;
  np_child child;
  assert_int_equal(np_child_start("/no/such/program", (const char *[]){NULL}, &child), ENOENT);
  np_child_end(&child);
  assert_int_equal(np_child_start("/bin/sh", (const char *[]){"-c", "kill -SEGV $$", NULL}, &child), 0);
  assert_int_equal(np_child_read(&child, &patient, NULL, &byte, 1), NEPH_ERROR_BAD_FILE);
  const int status = np_child_wait(&child);
  assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV);
  np_child_end(&child);
  assert_int_equal(np_child_start("/bin/sleep", (const char *[]){"1000", NULL}, &child), 0);
  np_child_end(&child);
  assert_int_equal(count_open_files(), files);
  assert_no_child();
}

/* ---- Files ---- */

static const char ply_header[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";

static void write_ply(const char *path, const char *face) {
  char text[500];
  const int length = snprintf(text, sizeof text, "%s%s\n", ply_header, face);
  test_file_write(path, text, (size_t)length);
}

static void assert_refused(test_fixture *f, const char *reason) {
  const unsigned files = count_open_files();
  np_mesh_file mesh;
  np_camera_file camera;
  assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &mesh), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, reason, "Assimp", "it is damaged");
  test_log_clear(&f->log);
  assert_int_equal(np_camera_file_load(f->context, f->path, NULL, 24.0, &camera), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, reason);
  test_log_clear(&f->log);
  assert_int_equal(count_open_files(), files);
  assert_no_child();
}

/* A list of four thousand million vertices in a file of 200 bytes, for which Assimp makes room. */
static void memory_beyond_the_file_is_refused(void **state) {
  test_fixture *f = test_get_meshes(state);
  write_ply(f->path, "4000000000 0 1 2");
  np_mesh_file mesh;
  assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &mesh), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "Assimp", "it is damaged");
  assert_no_child();
}

/* Brackets within brackets, which Assimp follows to the end of its stack. */
static void a_crash_is_refused(void **state) {
  enum { DEPTH = 200000 };
  static const char start[] = "{\"asset\":{\"version\":\"2.0\"},\"scenes\":", end[] = "}";
  test_fixture *f = test_get_meshes(state);
  free(f->path);
  f->path = test_path(f->folder, "damaged.gltf");
  FILE *file = fopen(f->path, "w");
  assert_non_null(file);
  (void)fputs(start, file);
  for (int i = 0; i < 2 * DEPTH; i++) (void)fputc(i < DEPTH ? '[' : ']', file);
  (void)fputs(end, file);
  assert_int_equal(fclose(file), 0);
  assert_refused(f, "");
}

/* A buffer above the mesh's folder, and one that a link leads to. */
static void files_outside_the_folder_are_refused(void **state) {
  static const char *const names[] = {"../out.bin", "link.bin"};
  static const unsigned char triangle[44] = {0};
  test_fixture *f = test_get_meshes(state);
  char *outside = test_path(f->folder, "out.bin"), *inside = test_path(f->folder, "in"),
       *link = test_path(f->folder, "in/link.bin");
  assert_int_equal(mkdir(inside, 0777) + symlink("../out.bin", link), 0);
  test_file_write(outside, triangle, sizeof triangle);
  free(f->path);
  f->path = test_path(f->folder, "in/mesh.gltf");
  for (size_t i = 0; i < 2; i++) {
    char text[700];
    const int length = snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"buffers\":[{\"uri\":\"%s\",\"byteLength\":44}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\"}]}",
        names[i]);
    np_mesh_file mesh;
    test_file_write(f->path, text, (size_t)length);
    assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &mesh), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, f->path, names[i], "a mesh may name files in its own folder and below it alone");
    test_log_clear(&f->log);
  }
  assert_no_child();
  free(link);
  free(inside);
  free(outside);
}

/* A file that takes Assimp longer than its limit: each object's name is compared with those of all before it. */
static void write_slow_file(test_fixture *f) {
  enum { OBJECTS = 100000 };
  free(f->path);
  f->path = test_path(f->folder, "damaged.obj");
  FILE *file = fopen(f->path, "w");
  assert_non_null(file);
  (void)fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\n", file);
  for (int i = 0; i < OBJECTS; i++) (void)fprintf(file, "o object_with_a_long_name_%06d\nf 1 2 3\n", i);
  assert_int_equal(fclose(file), 0);
}

/* The limit that this process hands on, 1 s, is lower than the reader's own. */
static void time_beyond_the_limit_is_refused(void **state) {
  test_fixture *f = test_get_meshes(state);
  struct rlimit before, lower;
  write_slow_file(f);
  void (*const action)(int) = signal(SIGXCPU, SIG_IGN); /* this process may have used its limit up */
  assert_int_equal(getrlimit(RLIMIT_CPU, &before), 0);
  lower = before;
  lower.rlim_cur = 1;
  assert_int_equal(setrlimit(RLIMIT_CPU, &lower), 0);
  np_mesh_file mesh;
  const neph_result result = np_mesh_file_load(f->context, f->path, true, NULL, &mesh);
  assert_int_equal(setrlimit(RLIMIT_CPU, &before), 0);
  (void)signal(SIGXCPU, action);
  assert_int_equal(result, NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "Assimp took more than", "1 s a megabyte");
  assert_no_child();
}

/* Cancels at the fourth report, when the reader is at work. */
static bool cancel(void *user, const neph_progress *progress) {
  unsigned *calls = user;
  (void)progress;
  return ++*calls < 4;
}

static double get_readers_s(void) {
  struct rusage of_children;
  assert_int_equal(getrusage(RUSAGE_CHILDREN, &of_children), 0);
  return (double)of_children.ru_utime.tv_sec + 1e-6 * (double)of_children.ru_utime.tv_usec;
}

/* The reader would run for 10 s and more; nothing of it remains, and its end is no error. Its CPU time shows that it
 * was not waited for: 2 s for both leave room for a busy machine. */
static void cancelling_ends_a_reader(void **state) {
  test_fixture *f = test_get_meshes(state);
  const unsigned files = count_open_files();
  const double before_s = get_readers_s();
  write_slow_file(f);
  for (unsigned threads = 1; threads <= 2; threads++) {
    neph_context *context = test_context_create(threads, &f->log);
    np_monitor monitor;
    np_mesh_file mesh;
    unsigned calls = 0;
    np_monitor_start(&monitor, context, cancel, &calls);
    assert_int_equal(np_mesh_file_load(context, f->path, true, &monitor, &mesh), NEPH_ERROR_CANCELLED);
    assert_string_equal(f->log.text, "");
    neph_context_destroy(context);
    assert_no_child();
  }
  print_message("readers took %.2f s\n", get_readers_s() - before_s);
  assert_true(get_readers_s() - before_s < 2.0);
  assert_int_equal(count_open_files(), files);
}

/* A program may let the system forget its children: files are read all the same. */
static void a_program_may_ignore_its_children(void **state) {
  test_fixture *f = test_get_meshes(state);
  void (*const before)(int) = signal(SIGCHLD, SIG_IGN);
  write_ply(f->path, "3 0 1 2");
  np_mesh_file mesh;
  assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &mesh), NEPH_OK);
  assert_int_equal(mesh.meshes[0].triangle_count, 1);
  np_mesh_file_clear(&mesh);
  write_ply(f->path, "4000000000 0 1 2");
  assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &mesh), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "Assimp", "it is damaged");
  (void)signal(SIGCHLD, before);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(output_of_a_child_is_read),
      cmocka_unit_test(a_child_may_end_in_any_way),
      cmocka_unit_test_setup_teardown(memory_beyond_the_file_is_refused, set_up, test_tear_down_meshes),
      cmocka_unit_test_setup_teardown(a_crash_is_refused, set_up, test_tear_down_meshes),
      cmocka_unit_test_setup_teardown(files_outside_the_folder_are_refused, set_up, test_tear_down_meshes),
      cmocka_unit_test_setup_teardown(time_beyond_the_limit_is_refused, set_up, test_tear_down_meshes),
      cmocka_unit_test_setup_teardown(cancelling_ends_a_reader, set_up, test_tear_down_meshes),
      cmocka_unit_test_setup_teardown(a_program_may_ignore_its_children, set_up, test_tear_down_meshes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
