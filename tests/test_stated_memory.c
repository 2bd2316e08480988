/* SPDX-License-Identifier: Apache-2.0 */
/* The memory that the program states is its own, also where a large program starts it. */
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "test_support.h"

/* A render of 16 × 9 pixels takes some 20 MB, under sanitizers more. */
static const size_t parent_bytes = 300 << 20;

static const char scene[] = "camera: {position: [0, 0, 1 km], look_at: [0, 6 km, 1500 m], resolution: [16, 9]}\n"
                            "sun: {elevation: 20 deg}\n";

/* The standard output of the program, which a fork of this process becomes; `arguments` end in NULL. */
static void run(const char *const *arguments, char *out, size_t size) {
  int ends[2], status;
  assert_int_equal(pipe(ends), 0);
  const pid_t child = fork();
  if (!child) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv(NEPHOS_TEST_PROGRAM, (char *const *)(uintptr_t)arguments);
    _exit(127);
  }
  close(ends[1]);
  size_t length = 0;
  for (ssize_t count = 1; count > 0 && length<size - 1; length += count> 0 ? (size_t)count : 0)
    count = read(ends[0], out + length, size - 1 - length);
  out[length] = '\0';
  close(ends[0]);
  assert_int_equal(waitpid(child, &status, 0), child);
  assert_int_equal(status, 0);
}

static double read_number(const char *text, const char *before) {
  const char *at = strstr(text, before);
  assert_non_null(at);
  return strtod(at + strlen(before), NULL);
}

static void a_large_parent_is_not_counted(void **state) {
  test_fixture *f = *state;
  test_file_write_text(f->path, scene);
  char *picture = test_path(f->folder, "out.exr"), *memory = malloc(parent_bytes), out[4096];
  assert_non_null(memory);
  memset(memory, 1, parent_bytes);
  const char *const json[] = {"nephos", "render", f->path, "-q", "-t", "1", "--json", "-o", picture, NULL};
  const char *const plain[] = {"nephos", "render", f->path, "-q", "-t", "1", "-o", picture, NULL};
  run(json, out, sizeof out);
  const double stated = read_number(out, "\"memory_bytes\": ");
  run(plain, out, sizeof out);
  const double plain_mb = read_number(out, " s, ");
  assert_int_equal(((volatile char *)memory)[parent_bytes / 2], 1); /* it was there all the time */
  free(memory);
  free(picture);
  struct rusage children;
  assert_int_equal(getrusage(RUSAGE_CHILDREN, &children), 0);
  assert_true(1024.0 * (double)children.ru_maxrss > (double)parent_bytes); /* which the other measure includes */
  assert_true(stated > 1e6 && stated < 0.5 * (double)parent_bytes);
  assert_true(plain_mb > 1.0 && 1e6 * plain_mb < 0.5 * (double)parent_bytes);
}

static int set_up(void **state) { return test_set_up(state, 1, "scene.yaml"); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_large_parent_is_not_counted, set_up, test_tear_down)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
