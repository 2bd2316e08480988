/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture: tiles and ranges of samples that merge to its bits, their files, and checkpoints. */
#include <stdlib.h>
#include <unistd.h>

#include <nephos/nephos.h>

#include "test_support.h"

enum { WIDTH = 12, HEIGHT = 18, PARTS_MAX = 12 };

/* A small cumulus in the void, with a channel of each rule by which pixels are finished. */
static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0 m, -3 km, 1100 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [12, 18]}\n"
    "sun: {elevation: 50 deg, azimuth: 110 deg}\n"
    "atmosphere: {preset: none}\n"
    "environment: {planet: none}\n"
    "clouds:\n"
    "  - name: cumulus\n"
    "    bake: {preset: cumulus_mediocris, seed: 4, extent: [3 km, 3 km], base: 1200 m, voxel: 120 m, coverage: 0.6}\n"
    "    albedo: 0.9\n"
    "    phase: {hg: 0.6}\n"
    "render: {samples: 48, integrator: march, multiple_scattering: octaves}\n"
    "output: {aovs: [variance, standard_error, sample_count, albedo, mean_distance, position, transmittance, "
    "distance,\n"
    "                shadow, mattes, cryptomatte]}\n";

typedef struct part {
  unsigned tile, tile_count, sample_begin, sample_end;
} part;

/* A part, and settings that not all parts share. */
typedef struct order {
  part part;
  neph_integrator integrator;
  unsigned sample_count;
  uint64_t seed;
  int frame;
  const char *path, *checkpoint, *key, *value; /* NULL: none */
  bool is_resumed;
  neph_tile_fn tile;
  void *user;
  neph_isa isa;
} order;

static const order plain = {
    .part = {0, 1, 0, NEPH_SAMPLES_ALL}, .sample_count = 48, .frame = 1, .isa = NEPH_ISA_X86_64_V4};

static neph_result render(test_fixture *f, const order *o, neph_image **out_image) {
  neph_scene *scene = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, "test.yaml", &scene), NEPH_OK);
  if (o->key) assert_int_equal(neph_scene_set(scene, o->key, o->value), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.integrator = o->integrator;
  desc.sample_count = o->sample_count;
  desc.seed = o->seed;
  desc.frame = o->frame;
  desc.tile_index = o->part.tile;
  desc.tile_count = o->part.tile_count;
  desc.sample_begin = o->part.sample_begin;
  desc.sample_end = o->part.sample_end;
  desc.part_path = o->path;
  desc.checkpoint_path = o->checkpoint;
  desc.is_resumed = o->is_resumed;
  desc.tile = o->tile;
  desc.tile_user = o->user;
  neph_result result = neph_render_image(scene, &desc, out_image);
  neph_scene_destroy(scene);
  return result;
}

static neph_image *render_whole(test_fixture *f, neph_integrator integrator, unsigned samples) {
  order o = plain;
  neph_image *image = NULL;
  o.integrator = integrator;
  o.sample_count = samples;
  assert_int_equal(render(f, &o, &image), NEPH_OK);
  return image;
}

/* Renders a part into a file of the folder, whose path is to be freed. */
static char *render_part(test_fixture *f, const order *like, part p, unsigned number) {
  char name[32];
  (void)snprintf(name, sizeof name, "%u.npart", number);
  char *path = test_path(f->folder, name);
  order o = *like;
  neph_image *image = NULL;
  o.part = p;
  o.path = path;
  assert_int_equal(render(f, &o, &image), NEPH_OK);
  neph_image_destroy(image);
  return path;
}

static const char *get(const neph_image *image, const char *name) {
  const char *text = neph_image_get_attribute(image, name);
  return text ? text : "";
}

/* Every channel, and what the header says of the samples. */
static void assert_same_picture(const neph_image *merged, const neph_image *whole) {
  static const char *const names[] = {"nephos:mean",       "nephos:meanStandardError", "nephos:samples",
                                      "nephos:pixelError", "nephos:sceneHash",         "nephos:seed",
                                      "nephos:integrator"};
  assert_int_equal(neph_image_get_width(merged), neph_image_get_width(whole));
  assert_int_equal(neph_image_get_height(merged), neph_image_get_height(whole));
  assert_int_equal(neph_image_get_channel_count(merged), neph_image_get_channel_count(whole));
  for (unsigned c = 0; c < neph_image_get_channel_count(whole); c++) {
    const char *name = neph_image_get_channel_name(whole, c);
    assert_memory_equal(neph_image_get_values(merged, name), neph_image_get_values(whole, name),
                        (size_t)WIDTH * HEIGHT * sizeof(float));
  }
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    assert_string_equal(get(merged, names[i]), get(whole, names[i]));
}

static void free_paths(char *paths[PARTS_MAX]) {
  for (unsigned i = 0; i < PARTS_MAX; i++) free(paths[i]);
}

static neph_result merge(test_fixture *f, char *paths[PARTS_MAX], unsigned count, neph_image **out_image) {
  return neph_parts_merge(f->context, (const char *const *)paths, count, NULL, out_image);
}

/* ---- The bits of the whole ---- */

static void check_merge(test_fixture *f, neph_integrator integrator, unsigned samples, const part *parts,
                        unsigned count) {
  order like = plain;
  char *paths[PARTS_MAX] = {NULL};
  like.integrator = integrator;
  like.sample_count = samples;
  neph_image *whole = render_whole(f, integrator, samples), *merged = NULL;
  for (unsigned i = 0; i < count; i++) paths[i] = render_part(f, &like, parts[i], i);
  assert_int_equal(merge(f, paths, count, &merged), NEPH_OK);
  assert_same_picture(merged, whole);
  neph_image_destroy(merged);
  neph_image_destroy(whole);
  free_paths(paths);
}

/* 90 samples end in a ragged leaf; the parts are given out of order. */
static void ranges_of_samples_merge_to_the_whole(void **state) {
  static const part parts[] = {{0, 1, 16, 64}, {0, 1, 64, NEPH_SAMPLES_ALL}, {0, 1, 0, 16}};
  check_merge(*state, NEPH_INTEGRATOR_MARCH, 90, parts, 3);
  check_merge(*state, NEPH_INTEGRATOR_PATH, 90, parts, 3);
}

/* 18 rows in four bands of 4, 5, 4 and 5: no edge is one of the film's tiles. */
static void tiles_merge_to_the_whole(void **state) {
  static const part parts[] = {{0, 4, 0, NEPH_SAMPLES_ALL},
                               {3, 4, 0, NEPH_SAMPLES_ALL},
                               {1, 4, 0, NEPH_SAMPLES_ALL},
                               {2, 4, 0, NEPH_SAMPLES_ALL}};
  check_merge(*state, NEPH_INTEGRATOR_MARCH, 5, parts, 4);
  check_merge(*state, NEPH_INTEGRATOR_PATH, 5, parts, 4);
}

/* Tiles of their own number beside ranges of samples, each in its own tiles. */
static void tiles_and_ranges_mix(void **state) {
  static const part parts[] = {
      {0, 2, 0, 32}, {0, 2, 32, 48}, {2, 4, 0, NEPH_SAMPLES_ALL}, {3, 4, 16, 48}, {3, 4, 0, 16}};
  check_merge(*state, NEPH_INTEGRATOR_MARCH, 48, parts, 5);
}

/* A part of all is the whole. */
static void one_part_may_be_all(void **state) {
  static const part parts[] = {{0, 1, 0, NEPH_SAMPLES_ALL}};
  check_merge(*state, NEPH_INTEGRATOR_PATH, 3, parts, 1);
}

static void pictures_of_tiles_merge_too(void **state) {
  test_fixture *f = *state;
  char *paths[PARTS_MAX] = {NULL};
  neph_image *whole = render_whole(f, NEPH_INTEGRATOR_MARCH, 4), *merged = NULL;
  for (unsigned i = 0; i < 3; i++) {
    char name[16];
    (void)snprintf(name, sizeof name, "%u.exr", i);
    order o = plain;
    neph_image *tile = NULL;
    o.sample_count = 4;
    o.part = (part){i, 3, 0, NEPH_SAMPLES_ALL};
    assert_int_equal(render(f, &o, &tile), NEPH_OK);
    assert_int_equal(neph_image_save_exr(tile, paths[i] = test_path(f->folder, name), NEPH_PIXEL_FLOAT), NEPH_OK);
    neph_image_destroy(tile);
  }
  assert_int_equal(merge(f, paths, 3, &merged), NEPH_OK);
  for (unsigned c = 0; c < neph_image_get_channel_count(whole); c++) {
    const char *name = neph_image_get_channel_name(whole, c);
    assert_memory_equal(neph_image_get_values(merged, name), neph_image_get_values(whole, name),
                        (size_t)WIDTH * HEIGHT * sizeof(float));
  }
  /* Headers of tiles have six digits of each mean. */
  assert_near_relative(atof(get(merged, "nephos:mean")), atof(get(whole, "nephos:mean")), 1e-5);
  assert_string_equal(get(merged, "nephos:sceneHash"), get(whole, "nephos:sceneHash"));
  neph_image_destroy(merged);
  neph_image_destroy(whole);
  free_paths(paths);
}

/* ---- Refusals ---- */

static void what_is_missing_is_listed(void **state) {
  test_fixture *f = *state;
  char *paths[PARTS_MAX] = {NULL};
  neph_image *merged = NULL;
  paths[0] = render_part(f, &plain, (part){0, 3, 0, NEPH_SAMPLES_ALL}, 0);
  paths[1] = render_part(f, &plain, (part){2, 3, 16, 32}, 1);
  assert_int_equal(merge(f, paths, 2, &merged), NEPH_ERROR_NOT_FOUND);
  assert_null(merged);
  assert_one_error(&f->log, "tile 2/3; tile 3/3, samples 0-16; tile 3/3, samples 32-48");
  free_paths(paths);
}

static void overlaps_are_refused(void **state) {
  test_fixture *f = *state;
  char *paths[PARTS_MAX] = {NULL};
  neph_image *merged = NULL;
  paths[0] = render_part(f, &plain, (part){0, 1, 0, 32}, 0);
  paths[1] = render_part(f, &plain, (part){0, 1, 16, 48}, 1);
  assert_int_equal(merge(f, paths, 2, &merged), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "0.npart", "1.npart", "overlap in rows 0 to 17");
  free_paths(paths);
}

/* Parts of two pictures, and a word of the message for the difference. */
static void check_strangers(test_fixture *f, const order *other, const char *word) {
  char *paths[PARTS_MAX] = {NULL};
  neph_image *merged = NULL;
  paths[0] = render_part(f, &plain, (part){0, 1, 0, 32}, 0);
  paths[1] = render_part(f, other, (part){0, 1, 32, 48}, 1);
  assert_int_equal(merge(f, paths, 2, &merged), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "1.npart", word);
  free_paths(paths);
}

static void parts_of_another_picture_are_refused(void **state) {
  test_fixture *f = *state;
  order seed = plain, frame = plain, scene = plain;
  seed.seed = 7;
  check_strangers(f, &seed, "seed is 7");
  frame.frame = 2;
  check_strangers(f, &frame, "frame is 2");
  scene.key = "sun.elevation";
  scene.value = "51 deg";
  check_strangers(f, &scene, "scene, input files or settings");
  scene.key = "render.samples"; /* the scene's own are not those that are taken */
  scene.value = "64";
  check_strangers(f, &scene, "scene, input files or settings");
}

static void expect_refusal(test_fixture *f, order o, const char *word) {
  neph_image *image = NULL;
  char *path = test_path(f->folder, "no.npart");
  o.path = path;
  assert_int_equal(render(f, &o, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, word);
  assert_null(image);
  free(path);
}

static void parts_that_cannot_be_kept_are_refused(void **state) {
  test_fixture *f = *state;
  order o = plain;
  o.part = (part){0, 1, 8, 16};
  expect_refusal(f, o, "multiple of 16");
  o.part = (part){0, 1, 16, 40};
  expect_refusal(f, o, "multiple of 16");
  o.part = (part){0, 1, 48, 64};
  expect_refusal(f, o, "ends at 64, must end at 48 at most");
  o.part = (part){0, 1, 0, 49};
  expect_refusal(f, o, "ends at 49, must end at 48 at most");
  o.part = (part){0, 1, 48, NEPH_SAMPLES_ALL};
  expect_refusal(f, o, "48 to 48 of 48");
  o.part = (part){18, 19, 0, NEPH_SAMPLES_ALL};
  expect_refusal(f, o, "1 to 18");
  o.part = (part){0, 1, 0, 16};
  o.key = "render.target_error";
  o.value = "0.1";
  expect_refusal(f, o, "target error");
  o.key = "render.time_limit";
  o.value = "10 s";
  expect_refusal(f, o, "time limit");
  o.key = "output.deep";
  o.value = "deep.exr";
  expect_refusal(f, o, "deep pixels");
}

/* ---- The file ---- */

static neph_result merge_one(neph_context *context, const char *path) {
  neph_image *image = NULL;
  neph_result result = neph_parts_merge(context, &path, 1, NULL, &image);
  neph_image_destroy(image);
  return result;
}

/* Every length up to a header and a tile, and some beyond. */
static void a_part_cut_short_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = render_part(f, &plain, (part){0, 1, 0, NEPH_SAMPLES_ALL}, 0);
  test_file whole = test_file_read(path);
  for (size_t size = 0; size < whole.size; size += size < 64 ? 1 : 997) {
    test_file_write(path, whole.bytes, size);
    assert_int_equal(merge_one(f->context, path), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "0.npart");
  }
  free(whole.bytes);
  free(path);
}

/* Checksums see every changed byte. */
static void a_damaged_part_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = render_part(f, &plain, (part){0, 1, 0, NEPH_SAMPLES_ALL}, 0);
  test_file whole = test_file_read(path);
  for (size_t at = 0; at < whole.size; at += at < 64 ? 1 : 1009) {
    whole.bytes[at] ^= 0x10;
    test_file_write(path, whole.bytes, whole.size);
    assert_int_equal(merge_one(f->context, path), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "0.npart");
    whole.bytes[at] ^= 0x10;
  }
  free(whole.bytes);
  free(path);
}

static void other_files_are_refused(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "other.npart");
  assert_int_equal(merge_one(f->context, path), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "other.npart", "No such file");
  test_file_write_text(path, "a text that is longer than what comes before a part's header");
  assert_int_equal(merge_one(f->context, path), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "other.npart", "no part of a picture");
  free(path);
}

/* ---- Checkpoints ---- */

/* Cancels once so many rows of tiles are there. */
typedef struct stopper {
  unsigned rows;
} stopper;

static bool stop_at(void *user, const neph_tile *tile) { return tile->max[1] < ((stopper *)user)->rows; }

/* A checkpoint that is not used is set aside, and the frame has the same bits. */
static void assert_none_is_set_aside(const char *path) {
  char bad[1200];
  (void)snprintf(bad, sizeof bad, "%s.bad", path);
  assert_int_not_equal(access(bad, F_OK), 0);
}

static void a_cancelled_frame_is_resumed_to_the_same_bits(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "check.npart");
  neph_image *whole = NULL, *image = NULL;
  order o = plain;
  stopper at = {.rows = 8};
  o.integrator = NEPH_INTEGRATOR_PATH;
  o.key = "camera.resolution"; /* so high that tiles are left when the first are shown */
  o.value = "[12, 240]";
  assert_int_equal(render(f, &o, &whole), NEPH_OK);
  o.checkpoint = path;
  o.tile = stop_at;
  o.user = &at;
  assert_int_equal(render(f, &o, &image), NEPH_ERROR_CANCELLED);
  assert_int_equal(merge_one(f->context, path), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "checkpoint with", "--resume");
  o.tile = NULL;
  o.is_resumed = true;
  assert_int_equal(render(f, &o, &image), NEPH_OK);
  assert_none_is_set_aside(path);
  assert_same_picture(image, whole);
  neph_image_destroy(image);
  neph_image_destroy(whole);
  free(path);
}

/* Ranges of samples are resumed as well, and merge to the whole after that. */
static void a_cancelled_range_is_resumed(void **state) {
  test_fixture *f = *state;
  char *paths[PARTS_MAX] = {test_path(f->folder, "resumed.npart"), NULL};
  neph_image *whole = render_whole(f, NEPH_INTEGRATOR_MARCH, 48), *image = NULL, *merged = NULL;
  order o = plain;
  stopper at = {.rows = 8};
  o.part = (part){0, 1, 16, 48};
  o.path = o.checkpoint = paths[0];
  o.tile = stop_at;
  o.user = &at;
  assert_int_equal(render(f, &o, &image), NEPH_ERROR_CANCELLED);
  o.tile = NULL;
  o.is_resumed = true;
  assert_int_equal(render(f, &o, &image), NEPH_OK);
  assert_none_is_set_aside(paths[0]);
  paths[1] = render_part(f, &plain, (part){0, 1, 0, 16}, 1);
  assert_int_equal(merge(f, paths, 2, &merged), NEPH_OK);
  assert_same_picture(merged, whole);
  neph_image_destroy(merged);
  neph_image_destroy(image);
  neph_image_destroy(whole);
  free_paths(paths);
}

static void a_checkpoint_of_another_picture_is_not_taken_up(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "check.npart");
  order o = plain;
  neph_image *whole = render_whole(f, NEPH_INTEGRATOR_MARCH, 48), *image = NULL;
  stopper at = {.rows = 8};
  o.seed = 3;
  o.checkpoint = path;
  o.tile = stop_at;
  o.user = &at;
  assert_int_equal(render(f, &o, &image), NEPH_ERROR_CANCELLED);
  o.seed = 0;
  o.tile = NULL;
  o.is_resumed = true;
  test_log_clear(&f->log);
  assert_int_equal(render(f, &o, &image), NEPH_OK);
  assert_one_warning(&f->log, "check.npart", "another scene");
  assert_same_picture(image, whole);
  neph_image_destroy(image);
  neph_image_destroy(whole);
  free(path);
}

/* ---- The hash ---- */

static void compute_hash(test_fixture *f, const char *text, const char *key, const char *value,
                         char out[NEPH_HASH_SIZE]) {
  neph_scene *scene = NULL;
  assert_int_equal(neph_scene_load_text(f->context, text, "test.yaml", &scene), NEPH_OK);
  if (key) assert_int_equal(neph_scene_set(scene, key, value), NEPH_OK);
  assert_int_equal(neph_render_compute_hash(scene, NULL, out), NEPH_OK);
  assert_int_equal(strlen(out), NEPH_HASH_SIZE - 1);
  neph_scene_destroy(scene);
}

/* Names of files and the look of previews change no value; the order of keys neither. */
static void the_hash_follows_the_bits(void **state) {
  static const char ordered[] = "version: 1\ncamera: {position: [0, 0, 1 km], look_at: [0, 1, 1 km]}\nsun: {elevation: "
                                "50 deg, azimuth: 110 deg}\nrender: {samples: 2}\n",
                    turned[] = "version: 1\ncamera: {look_at: [0, 1, 1 km], position: [0, 0, 1 km]}\nrender: {samples: "
                               "2}\nsun: {azimuth: 110 deg, elevation: 50 deg}\n";
  test_fixture *f = *state;
  char base[NEPH_HASH_SIZE], other[NEPH_HASH_SIZE];
  compute_hash(f, scene_text, NULL, NULL, base);
  compute_hash(f, scene_text, "output.image", "a.exr", other);
  assert_string_equal(base, other);
  compute_hash(f, scene_text, "output.exposure", "2", other);
  assert_string_equal(base, other);
  compute_hash(f, scene_text, "clouds[0].albedo", "0.91", other);
  assert_string_not_equal(base, other);
  compute_hash(f, ordered, NULL, NULL, base);
  compute_hash(f, turned, NULL, NULL, other);
  assert_string_equal(base, other);
}

/* Contents count, and where the file lies does not. */
static void the_hash_is_of_the_contents_of_files(void **state) {
  static const char text[] =
      "version: 1\nclouds:\n  - {name: a, bake: {extent: [1 km, 1 km]}, phase: {table: p.csv}}\n";
  test_fixture *f = *state;
  char first[NEPH_HASH_SIZE], second[NEPH_HASH_SIZE];
  char *one = test_path(f->folder, "p.csv"), *other_folder = test_folder_create(),
       *two = test_path(other_folder, "p.csv");
  test_file_write_text(one, "0,1\n180,1\n");
  test_file_write_text(two, "0,1\n180,1\n");
  compute_hash(f, text, "clouds[0].phase.table", one, first);
  compute_hash(f, text, "clouds[0].phase.table", two, second);
  assert_string_equal(first, second);
  test_file_write_text(two, "0,1\n180,2\n");
  compute_hash(f, text, "clouds[0].phase.table", two, second);
  assert_string_not_equal(first, second);
  free(one);
  free(two);
  test_folder_destroy(other_folder);
}

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(ranges_of_samples_merge_to_the_whole),
                                     TEST(tiles_merge_to_the_whole),
                                     TEST(tiles_and_ranges_mix),
                                     TEST(one_part_may_be_all),
                                     TEST(pictures_of_tiles_merge_too),
                                     TEST(what_is_missing_is_listed),
                                     TEST(overlaps_are_refused),
                                     TEST(parts_of_another_picture_are_refused),
                                     TEST(parts_that_cannot_be_kept_are_refused),
                                     TEST(a_part_cut_short_is_refused),
                                     TEST(a_damaged_part_is_refused),
                                     TEST(other_files_are_refused),
                                     TEST(a_cancelled_frame_is_resumed_to_the_same_bits),
                                     TEST(a_cancelled_range_is_resumed),
                                     TEST(a_checkpoint_of_another_picture_is_not_taken_up),
                                     TEST(the_hash_follows_the_bits),
                                     TEST(the_hash_is_of_the_contents_of_files)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
