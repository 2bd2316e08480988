/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures through a process of their own: the same as by the decoders themselves, and a decoder that crashes, lies or
 * never ends is a refusal with one message that leaves neither a file nor a child. */
#include "test_support.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/random.h"
#include "image/picture_decoder.h"
#include "image/picture_process.h"
#include "image/picture_sandbox.h"

enum { WIDTH = 37, HEIGHT = 23 };

static int set_up(void **state) { return test_set_up(state, 2, "picture.exr"); }

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

/* ---- The same bits ---- */

/* A header of all kinds of entries, NaN and infinities among the values, a manifest of 100 KB and an empty text. */
static void write_picture(test_fixture *f) {
  static const char *const names[] = {"R", "Z", "id.x"};
  enum { MANIFEST = 100000 };
  char *manifest = malloc(MANIFEST + 1);
  neph_image *image;
  assert_non_null(manifest);
  memset(manifest, 'm', MANIFEST);
  manifest[MANIFEST] = 0;
  assert_int_equal(neph_image_create(f->context, WIDTH, HEIGHT, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
      const uint32_t bits = (uint32_t)np_random_absorb((uint64_t)i, (uint64_t)c);
      image->channels[c].values[i] = (float)bits * 1e-6f;
    }
  image->channels[1].values[7] = NAN, image->channels[1].values[8] = -INFINITY;
  np_image_header *h = &image->header;
  h->has_camera = h->has_ndc = h->has_chromaticities = h->has_window = h->is_latlong = true;
  for (int i = 0; i < 16; i++) h->world_to_camera[i] = 0.1f * (float)i, h->world_to_ndc[i] = -0.3f * (float)i;
  for (int i = 0; i < 8; i++) h->chromaticities[i] = 0.1f * (float)i;
  h->data_min[0] = -5, h->data_min[1] = 3, h->data_max[0] = WIDTH - 6, h->data_max[1] = HEIGHT + 2;
  h->display_max[0] = 99, h->display_max[1] = 49;
  assert_int_equal(neph_image_set_attribute(image, "cryptomatte/0/manifest", manifest), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, "nephos:empty", ""), NEPH_OK);
  assert_int_equal(np_image_set_integer(image, "nephos:count", -2147483647), NEPH_OK);
  assert_int_equal(np_image_set_real(image, "nephos:third", 1.0 / 3.0), NEPH_OK);
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  free(manifest);
  test_log_clear(&f->log);
}

static void assert_same_attributes(const neph_image *a, const neph_image *b) {
  assert_int_equal(a->attribute_count, b->attribute_count);
  for (unsigned i = 0; i < a->attribute_count; i++) {
    assert_string_equal(a->attributes[i].name, b->attributes[i].name);
    assert_string_equal(a->attributes[i].value, b->attributes[i].value);
    assert_int_equal(a->attributes[i].type, b->attributes[i].type);
    assert_true(a->attributes[i].number == b->attributes[i].number);
  }
}

static void assert_same_image(const neph_image *a, const neph_image *b) {
  assert_true(a->width == b->width && a->height == b->height && a->channel_count == b->channel_count);
  for (unsigned c = 0; c < a->channel_count; c++) {
    assert_string_equal(a->channels[c].name, b->channels[c].name);
    assert_string_equal(a->channels[c].stored, b->channels[c].stored);
    assert_true(!a->channels[c].values == !b->channels[c].values);
    if (a->channels[c].values)
      assert_memory_equal(a->channels[c].values, b->channels[c].values, (size_t)a->width * a->height * sizeof(float));
  }
  assert_memory_equal(&a->header, &b->header, sizeof a->header);
  assert_same_attributes(a, b);
}

static int open_picture(const char *path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  assert_true(file >= 0);
  return file;
}

static void an_exr_is_the_same_by_its_decoder(void **state) {
  test_fixture *f = *state;
  neph_image *own, *loaded;
  np_image_exr_info info, own_info;
  write_picture(f);
  assert_int_equal(np_image_decode_exr(f->context, open_picture(f->path), f->path, &own), NEPH_OK);
  assert_int_equal(neph_image_load_exr(f->context, f->path, &loaded), NEPH_OK);
  assert_same_image(own, loaded);
  assert_int_equal(loaded->header.has_ndc + loaded->header.has_chromaticities + loaded->header.is_latlong, 3);
  neph_image_destroy(own);
  neph_image_destroy(loaded);
  assert_int_equal(np_image_decode_exr_header(f->context, open_picture(f->path), f->path, &own_info, &own), NEPH_OK);
  assert_int_equal(np_image_read_exr_header(f->context, f->path, &info, &loaded), NEPH_OK);
  assert_same_image(own, loaded);
  assert_string_equal(info.storage, own_info.storage);
  assert_string_equal(info.compression, own_info.compression);
  assert_int_equal(info.part_count, own_info.part_count);
  neph_image_destroy(own);
  neph_image_destroy(loaded);
  assert_string_equal(f->log.text, "");
  assert_no_child();
}

static void a_png_is_the_same_by_its_decoder(void **state) {
  static const char *const names[] = {"R", "G", "B"};
  test_fixture *f = *state;
  neph_image *image, *own, *loaded;
  assert_int_equal(neph_image_create(f->context, WIDTH, HEIGHT, 3, names, &image), NEPH_OK);
  for (int i = 0; i < WIDTH * HEIGHT; i++) image->channels[i % 3].values[i] = 0.01f * (float)(i % 101);
  assert_int_equal(neph_image_save_png(image, f->path, NULL), NEPH_OK);
  assert_int_equal(np_image_decode_png(f->context, open_picture(f->path), f->path, &own), NEPH_OK);
  assert_int_equal(neph_image_load_png(f->context, f->path, &loaded), NEPH_OK);
  assert_same_image(own, loaded);
  neph_image_destroy(image);
  neph_image_destroy(own);
  neph_image_destroy(loaded);
}

/* ---- Decoders that fail ---- */

static char *write_program(const test_fixture *f, const char *commands) {
  char *path = test_path(f->folder, "stub"), text[1000];
  const int length = snprintf(text, sizeof text, "#!/bin/sh\n%s\n", commands);
  test_file_write(path, text, (size_t)length);
  assert_int_equal(chmod(path, 0700), 0);
  return path;
}

static neph_result read_by(test_fixture *f, const char *program, np_monitor *monitor) {
  const np_picture_request request = {"exr", f->path, program};
  neph_image *image;
  const neph_result result = np_picture_read(f->context, &request, monitor, NULL, &image);
  assert_true(!image == (result != NEPH_OK));
  neph_image_destroy(image);
  return result;
}

static void a_decoder_may_end_in_any_way(void **state) {
  static const struct {
    const char *commands, *complaint;
    neph_result result;
  } ends[] = {
      {"kill -SEGV $$", "its decoder ended by the signal SIGSEGV: it is damaged", NEPH_ERROR_BAD_FILE},
      {"kill -XCPU $$", "its decoder took more than 10 s and 1 s for each 2 MB", NEPH_ERROR_BAD_FILE},
      {"exit 0", "its decoder ended before it was done", NEPH_ERROR_BAD_FILE},
      {"printf '\\1\\0\\0\\0'", "its decoder ended before it was done", NEPH_ERROR_BAD_FILE},
      {"exit 127", "libraries of nephos_pictures, which reads OpenEXR and PNG, are missing", NEPH_ERROR_UNSUPPORTED},
      {"printf '\\7\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0'", "of another version of nephos", NEPH_ERROR_UNSUPPORTED},
      {"printf '\\1\\0\\0\\0\\143\\0\\0\\0\\1\\0\\0\\0x'", "gave a wrong answer", NEPH_ERROR_BAD_FILE},
      {"printf '\\1\\0\\0\\0\\7\\0\\0\\0\\377\\377\\377\\377'", "gave a wrong answer", NEPH_ERROR_BAD_FILE},
      {"cat /dev/zero", "of another version of nephos", NEPH_ERROR_UNSUPPORTED}};
  test_fixture *f = *state;
  write_picture(f);
  const unsigned files = count_open_files();
  for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
    char *program = write_program(f, ends[i].commands);
    assert_int_equal(read_by(f, program, NULL), ends[i].result);
    assert_one_error(&f->log, f->path, ends[i].complaint);
    test_log_clear(&f->log);
    free(program);
  }
  assert_int_equal(read_by(f, "/no/such/program", NULL), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, "cannot start /no/such/program, which reads OpenEXR and PNG");
  assert_int_equal(test_folder_count(f->folder), 2); /* the picture and the program */
  assert_int_equal(count_open_files(), files);
  assert_no_child();
}

/* The true answer, cut short and with changed bytes: it is read, or refused with one message. */
static void answers_are_checked(void **state) {
  enum { CHANGES = 150 };
  test_fixture *f = *state;
  write_picture(f);
  char commands[600], *answer = test_path(f->folder, "answer");
  (void)snprintf(commands, sizeof commands, "exec cat %s", answer);
  char *program = write_program(f, commands);
  (void)snprintf(commands, sizeof commands, NEPHOS_TEST_MODULE_DIR "/nephos_pictures exr %s 1 <%s | cat >%s", f->path,
                 f->path, answer);
  assert_int_equal(system(commands), 0);
  test_file whole = test_file_read(answer);
  assert_int_equal(read_by(f, program, NULL), NEPH_OK);
  for (unsigned i = 0; i < CHANGES; i++) {
    const uint64_t bits = np_random_absorb(1, i);
    const size_t head = 420, at = (bits >> 16) % (i % 4 ? head : whole.size);
    const uint8_t before = whole.bytes[at];
    whole.bytes[at] = i % 3 ? 0xff : (uint8_t)bits;
    test_file_write(answer, whole.bytes, i % 5 ? whole.size : at);
    whole.bytes[at] = before;
    test_log_clear(&f->log);
    if (read_by(f, program, NULL)) assert_one_error(&f->log, "");
  }
  assert_no_child();
  free(whole.bytes);
  free(program);
  free(answer);
}

static bool cancel(void *user, const neph_progress *progress) {
  unsigned *calls = user;
  (void)progress;
  return ++*calls < 3;
}

static void cancelling_ends_a_decoder(void **state) {
  test_fixture *f = *state;
  write_picture(f);
  char *program = write_program(f, "exec sleep 1000");
  np_monitor monitor;
  unsigned calls = 0;
  np_monitor_start(&monitor, f->context, cancel, &calls);
  assert_int_equal(read_by(f, program, &monitor), NEPH_ERROR_CANCELLED);
  assert_string_equal(f->log.text, "");
  assert_no_child();
  free(program);
}

/* ---- The sandbox ---- */

/* Calls of a process within; the number of the first that it may make, 0: none. */
static int count_open_doors(void) {
  const np_picture_sandbox sandbox = np_picture_sandbox_begin();
  np_picture_sandbox_limit(&sandbox, 100 << 20, 10);
  char *const words[] = {NULL};
  if (open("/dev/null", O_RDONLY) >= 0 || dup(0) >= 0) return 1;
  if (socket(AF_INET, SOCK_STREAM, 0) >= 0) return 2;
  if (mmap(NULL, 200 << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED) return 3;
  if (!kill(getppid(), 0) || !unlink("/nowhere") || errno != EPERM) return 4;
  (void)execv("/bin/true", words);
  return errno == EPERM ? 0 : 5;
}

static void a_decoder_opens_nothing(void **state) {
  (void)state;
  const pid_t child = fork();
  if (child == 0) _exit(count_open_doors());
  int status;
  assert_int_equal(waitpid(child, &status, 0), child);
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(an_exr_is_the_same_by_its_decoder), TEST(a_png_is_the_same_by_its_decoder),
      TEST(a_decoder_may_end_in_any_way),      TEST(answers_are_checked),
      TEST(cancelling_ends_a_decoder),         TEST(a_decoder_opens_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
