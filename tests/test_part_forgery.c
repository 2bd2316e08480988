/* SPDX-License-Identifier: Apache-2.0 */
/* Forged parts and checkpoints: every field of the header is forged with valid checksums, and refused by its name; a
 * frame whose checkpoint is forged or damaged restarts and gets its bits. */
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nephos/nephos.h>

#include "core/random.h"
#include "part_forge.h"
#include "test_support.h"

/* Channels of rules that need opacity, mattes, and a band. */
static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0 m, 0 m, 500 m], look_at: [0 m, 1 km, 700 m], resolution: [9, 17]}\n"
    "sun: {irradiance: 0}\n"
    "atmosphere: none\n"
    "environment: {radiance: 0.5, planet: none}\n"
    "render: {samples: 2, integrator: march, multiple_scattering: octaves}\n"
    "output: {aovs: [position, variance, cryptomatte]}\n";

typedef struct order {
  const char *part, *checkpoint;
  bool is_resumed;
  const char *key, *value;
} order;

static neph_image *render(test_fixture *f, const order *o) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, "test.yaml", &scene), NEPH_OK);
  if (o->key) assert_int_equal(neph_scene_set(scene, o->key, o->value), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.part_path = o->part;
  desc.checkpoint_path = o->checkpoint;
  desc.is_resumed = o->is_resumed;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* A good part in the fixture's path, and its bytes. */
static test_file make_part(test_fixture *f) {
  neph_image_destroy(render(f, &(order){.part = f->path}));
  test_log_clear(&f->log);
  return test_file_read(f->path);
}

static neph_result merge(test_fixture *f) {
  neph_image *image = NULL;
  const char *path = f->path;
  const neph_result result = neph_parts_merge(f->context, &path, 1, NULL, &image);
  neph_image_destroy(image);
  return result;
}

static void write_mended(test_fixture *f, const test_file *part) {
  part_forge_mend(f->context, part->bytes, part->size);
  test_file_write(f->path, part->bytes, part->size);
}

/* ---- Every field ---- */

/* Values that no field may have: the largest, negative ones as integers, and what is no number. */
static void forge(uint8_t *at, size_t size, unsigned way) {
  static const double reals[] = {(double)NAN, -1.0};
  memset(at, way == 0 ? 0xff : 0x81, size);
  if (size == 8) memcpy(at, &reals[way], size);
}

/* A field may be harmless at one of the two values, as scatterings are at the largest, which is all of them. The text
 * of a name, unlike its length, may be any. */
static bool is_allowed(const part_field *field, unsigned way) {
  return (!strcmp(field->name, "scatterings") && way == 0) ||
         (!strcmp(field->name, "channels: name") && field->size != 4) ||
         (way == 1 && (!strcmp(field->name, "image: camera") || !strcmp(field->name, "image: camera of a plane") ||
                       !strcmp(field->name, "image: chromaticities") ||
                       !strcmp(field->name, "channels: matte identifiers") || !strcmp(field->name, "version")));
}

static void forged_fields_are_refused_by_name(void **state) {
  test_fixture *f = *state;
  test_file part = make_part(f);
  part_field fields[PART_FIELDS_MAX];
  const unsigned count = part_forge_list(part.bytes, part.size, fields);
  assert_true(count > 40);
  for (unsigned i = 0; i < count; i++)
    for (unsigned way = 0; way < 2; way++) {
      uint8_t kept[64];
      if (is_allowed(&fields[i], way) || fields[i].size > sizeof kept) continue;
      memcpy(kept, part.bytes + fields[i].at, fields[i].size);
      forge(part.bytes + fields[i].at, fields[i].size, way);
      write_mended(f, &part);
      if (merge(f) != NEPH_ERROR_BAD_FILE) fail_msg("%s at %zu was not refused", fields[i].name, fields[i].at);
      assert_one_error(&f->log, "file", fields[i].name);
      memcpy(part.bytes + fields[i].at, kept, fields[i].size);
    }
  write_mended(f, &part);
  assert_int_equal(merge(f), NEPH_OK);
  free(part.bytes);
}

/* Values near the right one, which only other fields can distinguish; a few may pass for a valid part. */
static void drawn_forgeries_are_read_or_refused(void **state) {
  test_fixture *f = *state;
  test_file part = make_part(f);
  part_field fields[PART_FIELDS_MAX];
  const unsigned count = part_forge_list(part.bytes, part.size, fields);
  np_random random = np_random_start(5, 0, 0, 0, 0);
  for (unsigned draw = 0; draw < 2000; draw++) {
    const part_field *field = &fields[(unsigned)(np_random_double(&random) * count)];
    const size_t at = field->at + (size_t)(np_random_double(&random) * (double)field->size);
    const uint8_t kept = part.bytes[at];
    part.bytes[at] = (uint8_t)(np_random_double(&random) * 256.0);
    write_mended(f, &part);
    const neph_result result = merge(f);
    if (result) assert_one_error(&f->log, "file");
    assert_true(!result || result == NEPH_ERROR_BAD_FILE || result == NEPH_ERROR_NOT_FOUND ||
                result == NEPH_ERROR_INVALID_ARGUMENT);
    part.bytes[at] = kept;
  }
  free(part.bytes);
}

/* A record's number of samples, its first double, behind the list of tiles and its checksum. */
static void forged_records_are_refused(void **state) {
  static const double counts[] = {0.0, -2.0, 1.5, 3.0, 1e300, (double)NAN};
  test_fixture *f = *state;
  test_file part = make_part(f);
  uint32_t header_size;
  memcpy(&header_size, part.bytes + 12, sizeof header_size);
  const size_t tiles = 2 * 3, at = 24 + header_size + tiles + 8;
  for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
    memcpy(part.bytes + at, &counts[i], sizeof *counts);
    write_mended(f, &part);
    assert_int_equal(merge(f), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "file", "samples, must have 2");
  }
  free(part.bytes);
}

/* ---- Checkpoints ---- */

static void assert_same_values(const neph_image *a, const neph_image *b) {
  assert_int_equal(neph_image_get_channel_count(a), neph_image_get_channel_count(b));
  for (unsigned c = 0; c < neph_image_get_channel_count(a); c++) {
    const char *name = neph_image_get_channel_name(a, c);
    assert_memory_equal(neph_image_get_values(a, name), neph_image_get_values(b, name), 9 * 17 * sizeof(float));
  }
}

/* The frame begins anew, to its bits, and what stood at the path is renamed. */
static void check_begins_anew(test_fixture *f, const neph_image *whole, const char *word) {
  char *bad = test_path(f->folder, "file.bad");
  (void)unlink(bad);
  test_log_clear(&f->log);
  neph_image *image = render(f, &(order){.checkpoint = f->path, .is_resumed = true});
  assert_one_warning(&f->log, "file", "file.bad", "begins anew", word);
  assert_int_equal(access(f->path, F_OK), -1);
  struct stat status;
  assert_int_equal(lstat(bad, &status), 0);
  assert_same_values(image, whole);
  neph_image_destroy(image);
  free(bad);
}

static void forged_checkpoints_are_set_aside(void **state) {
  test_fixture *f = *state;
  test_file part = make_part(f);
  neph_image *whole = render(f, &(order){.part = NULL});
  part_field fields[PART_FIELDS_MAX];
  const unsigned count = part_forge_list(part.bytes, part.size, fields);
  for (unsigned i = 0; i < count; i += 3) {
    uint8_t kept[64];
    if (is_allowed(&fields[i], 0) || fields[i].size > sizeof kept) continue;
    memcpy(kept, part.bytes + fields[i].at, fields[i].size);
    forge(part.bytes + fields[i].at, fields[i].size, 0);
    write_mended(f, &part);
    check_begins_anew(f, whole, fields[i].name);
    memcpy(part.bytes + fields[i].at, kept, fields[i].size);
  }
  neph_image_destroy(whole);
  free(part.bytes);
}

static void damaged_checkpoints_are_set_aside(void **state) {
  test_fixture *f = *state;
  test_file part = make_part(f);
  neph_image *whole = render(f, &(order){.part = NULL});
  for (size_t at = 0; at < part.size; at += part.size / 12) {
    part.bytes[at] ^= 0x20;
    test_file_write(f->path, part.bytes, part.size);
    check_begins_anew(f, whole, "renamed");
    part.bytes[at] ^= 0x20;
    test_file_write(f->path, part.bytes, at);
    check_begins_anew(f, whole, "renamed");
  }
  neph_image_destroy(whole);
  free(part.bytes);
}

/* A part of another picture; a pipe, which would wait for its writer; a folder. */
static void strangers_are_set_aside(void **state) {
  test_fixture *f = *state;
  neph_image *whole = render(f, &(order){.part = NULL});
  neph_image_destroy(render(f, &(order){.part = f->path, .key = "environment.radiance", .value = "0.25"}));
  check_begins_anew(f, whole, "another scene");
  assert_int_equal(mkfifo(f->path, 0600), 0);
  check_begins_anew(f, whole, "a pipe");
  (void)unlink(f->path);
  char *bad = test_path(f->folder, "file.bad");
  (void)unlink(bad);
  assert_int_equal(mkdir(f->path, 0700), 0);
  check_begins_anew(f, whole, "a folder");
  assert_int_equal(rmdir(bad), 0);
  neph_image_destroy(whole);
  free(bad);
}

/* ---- Known attacks ---- */

static void known_attacks_are_refused(void **state) {
  static const struct {
    const char *file, *word;
  } rows[] = {{"part_samples_4294967295.npart", "'samples' is 0-4294967295 of 4294967295"},
              {"merge_whole_window_8x13.exr", "'window' is 0 to 48 along x, must be 0 to 8, all"}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char *path = test_path(NEPHOS_TEST_SOURCE_DIR "/data/parts", rows[i].file);
    neph_image *image = NULL;
    assert_int_equal(neph_parts_merge(f->context, (const char *const *)&path, 1, NULL, &image), NEPH_ERROR_BAD_FILE);
    assert_null(image);
    assert_one_error(&f->log, rows[i].file, rows[i].word);
    free(path);
  }
}

static int set_up(void **state) { return test_set_up(state, 1, "file"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(forged_fields_are_refused_by_name), TEST(drawn_forgeries_are_read_or_refused),
                                     TEST(forged_records_are_refused),        TEST(forged_checkpoints_are_set_aside),
                                     TEST(damaged_checkpoints_are_set_aside), TEST(strangers_are_set_aside),
                                     TEST(known_attacks_are_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
