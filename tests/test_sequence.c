/* SPDX-License-Identifier: Apache-2.0 */
/* Imported sequences: one frame places and scales all of them, what stands still stands still, and frames that hold
 * nothing render empty. */
#include <nephos/nephos.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "test_box_files.h"
#include "test_films.h"

enum { WIDTH = 64, HEIGHT = 36, PIXELS = WIDTH * HEIGHT };

/* A block that stands still beside a jet that grows out of it along x, denser from frame to frame. */
static const test_box block = {{8, 8, 8}, {24, 24, 24}, 1.0f};
static test_box make_jet(int frame) {
  return (test_box){{24, 14, 14}, {24 + 12 * (frame - 1), 18, 18}, 0.5f * (float)frame};
}

static void write_frame(const test_fixture *f, const char *folder, int frame, float density) {
  char name[64];
  (void)snprintf(name, sizeof name, "%s%sb.%04d.vdb", folder, *folder ? "/" : "", frame);
  test_box boxes[] = {block, make_jet(frame)};
  for (int i = 0; i < 2; i++) boxes[i].value *= density;
  char *path = test_path(f->folder, name);
  test_boxes_write(f->context, path, "density", boxes, density > 0.0f ? 2 : 0);
  free(path);
}

static int set_up(void **state) {
  const int failed = test_set_up(state, 2, "b.####.vdb");
  const test_fixture *f = *state;
  for (int frame = 1; !failed && frame <= 3; frame++) write_frame(f, "", frame, 1.0f);
  return failed;
}

static const char format[] =
    "version: 1\n"
    "camera: {position: [0 m, -200 m, 32 m], look_at: [0 m, 0 m, 32 m], fov: 40 deg, resolution: [64, 36]}\n"
    "sun: {elevation: 40 deg, azimuth: 240 deg}\n"
    "atmosphere: none\n"
    "clouds: [{name: jet, vdb: \"%s\", albedo: 0.9, phase: {hg: 0.5}, %s}]\n"
    "render: {samples: 4, sun_optical_depth: march}\n"
    "output: {beauty: %s, aovs: [transmittance]}\n";

static const char placed[] = "voxel: 2 m, position: [0, 0, 16 m], optical_depth: 1";

static test_film load(const test_fixture *f, const char *pattern, const char *keys, bool has_beauty) {
  char text[4096];
  (void)snprintf(text, sizeof text, format, pattern, keys, has_beauty ? "true" : "false");
  return film_load(f->context, text, "jet.yaml");
}

static neph_image *render(test_film film, int frame) {
  neph_image *image = NULL;
  assert_int_equal(film_render(film, frame, &image), NEPH_OK);
  return image;
}

static neph_result try_render(test_film film, int frame) {
  neph_image *image = NULL;
  neph_result result = film_render(film, frame, &image);
  neph_image_destroy(image);
  return result;
}

/* Optical depth of the mean of R, G and B, along a ray. */
static const float *get_transmittance(neph_image *image) { return neph_image_get_channel(image, "transmittance"); }

static void assert_same_bits(neph_image *a, neph_image *b) {
  assert_int_equal(neph_image_get_channel_count(a), neph_image_get_channel_count(b));
  for (unsigned c = 0; c < neph_image_get_channel_count(a); c++) {
    const char *name = neph_image_get_channel_name(a, c);
    assert_memory_equal(neph_image_get_channel(a, name), neph_image_get_channel(b, name), PIXELS * sizeof(float));
  }
}

/* ---- Places ---- */

/* Rows of the picture that see the middle of the block. */
enum { ROW_FIRST = HEIGHT / 2 - 2, ROW_END = HEIGHT / 2 + 2 };

/* Mean transmittance of a column of them. */
static double measure_column(neph_image *image, unsigned column) {
  double sum = 0.0;
  for (size_t row = ROW_FIRST; row < ROW_END; row++) sum += (double)get_transmittance(image)[row * WIDTH + column];
  return sum / (ROW_END - ROW_FIRST);
}

/* The first column that lies in the block, three columns from its edge. */
static unsigned search_block(neph_image *image) {
  unsigned column = 0;
  while (column < WIDTH && measure_column(image, column) > 0.9) column++;
  assert_true(column + 3 < WIDTH);
  return column + 3;
}

/* Start of the block, in pixels: the columns before `inside` that are as clear as the sky. */
static double measure_left_edge(neph_image *image, unsigned inside) {
  const double thick = 1.0 - measure_column(image, inside);
  double covered = 0.0;
  for (unsigned column = 0; column <= inside; column++) covered += (1.0 - measure_column(image, column)) / thick;
  return inside + 1.0 - covered;
}

/* 4 rays a pixel and row start at places that differ from frame to frame: 16 of them find an edge to 0.1 pixels. Before
 * one frame placed all, the block moved by 12 m and then 24 m of 2.3 m a pixel. */
static void assert_stands_still(const test_fixture *f, const char *pattern) {
  test_film scene = load(f, pattern, placed, false);
  neph_image *first = render(scene, 1);
  const unsigned inside = search_block(first);
  const double edge = measure_left_edge(first, inside);
  for (int frame = 2; frame <= 3; frame++) {
    neph_image *image = render(scene, frame);
    const double moved = measure_left_edge(image, inside) - edge;
    print_message("frame %d: moved by %.3f pixels\n", frame, moved);
    assert_true(fabs(moved) < 0.3);
    neph_image_destroy(image);
  }
  neph_image_destroy(first);
  film_destroy(scene);
}

static void what_stands_still_stands_still(void **state) {
  const test_fixture *f = *state;
  assert_stands_still(f, f->path);
}

/* A ball beside a jet, on files of another program. */
static void a_still_ball_of_real_files_stands_still(void **state) {
  char *path = test_data_path("vdb/sequence/b.0001.vdb"), *number = strstr(path, "0001");
  memset(number, '#', strlen("0001"));
  assert_stands_still(*state, path);
  free(path);
}

/* Depth through the block, to the march's tolerance of 0.5 % of a ray's light: 0.01 at a depth of 1, 0.02 at 2. */
static double measure_depth(neph_image *image, unsigned inside) { return -log(measure_column(image, inside)); }

/* Frame 2 of twice the density is twice as thick. */
static void optical_depth_is_that_of_the_reference_frame(void **state) {
  const test_fixture *f = *state;
  write_frame(f, "", 2, 2.0f);
  test_film scene = load(f, f->path, placed, false);
  neph_image *first = render(scene, 1), *second = render(scene, 2);
  const unsigned inside = search_block(first);
  assert_near_relative(measure_depth(second, inside), 2.0 * measure_depth(first, inside), 0.02);
  neph_image_destroy(first);
  neph_image_destroy(second);
  film_destroy(scene);
}

/* Exact without a sky, whose tables are kept over a sequence within atmosphere.tolerance. */
static void a_frame_alone_is_that_of_the_sequence(void **state) {
  const test_fixture *f = *state;
  char keys[256];
  (void)snprintf(keys, sizeof keys, "%s, reference_frame: 1", placed);
  test_film alone = load(f, f->path, keys, true), named = load(f, f->path, keys, true),
            in_order = load(f, f->path, placed, true);
  for (int frame = 1; frame <= 2; frame++) {
    neph_image_destroy(render(in_order, frame));
    neph_image_destroy(render(named, frame));
  }
  neph_image *a = render(alone, 3), *b = render(in_order, 3), *c = render(named, 3);
  assert_same_bits(a, b);
  assert_same_bits(a, c);
  neph_image_destroy(a);
  neph_image_destroy(b);
  neph_image_destroy(c);
  film_destroy(alone);
  film_destroy(named);
  film_destroy(in_order);
}

/* A reference is cached by its inputs: other keys, and another file of that frame, make another one. */
static void a_changed_reference_is_read_again(void **state) {
  const test_fixture *f = *state;
  char keys[256];
  (void)snprintf(keys, sizeof keys, "%s, reference_frame: 1", placed);
  test_film scene = load(f, f->path, keys, false);
  neph_image *before = render(scene, 2);
  const unsigned inside = search_block(before);
  const double once = measure_depth(before, inside);
  write_frame(f, "", 1, 0.5f);
  neph_image *after = render(scene, 2);
  assert_near_relative(measure_depth(after, inside), 2.0 * once, 0.02);
  neph_image_destroy(after);
  assert_int_equal(neph_scene_set(scene.scene, "clouds[0].optical_depth", "0.5"), NEPH_OK);
  after = render(scene, 2);
  assert_near_relative(measure_depth(after, inside), once, 0.02);
  neph_image_destroy(after);
  neph_image_destroy(before);
  film_destroy(scene);
}

/* "x[1]" is a folder's name, though "x1" lies beside it with a denser frame 1. */
static void brackets_are_no_pattern(void **state) {
  const test_fixture *f = *state;
  static const char *const folders[] = {"x[1]", "x1"};
  for (int i = 0; i < 2; i++) {
    char *folder = test_path(f->folder, folders[i]);
    assert_int_equal(mkdir(folder, 0777), 0);
    for (int frame = 1; frame <= 2; frame++) write_frame(f, folders[i], frame, i ? 8.0f : 1.0f);
    free(folder);
  }
  char *pattern = test_path(f->folder, "x[1]/b.####.vdb");
  test_film scene = load(f, pattern, placed, false), plain = load(f, f->path, placed, false);
  for (int frame = 1; frame <= 2; frame++) {
    neph_image *image = render(scene, frame), *same = render(plain, frame);
    assert_same_bits(image, same);
    neph_image_destroy(image);
    neph_image_destroy(same);
  }
  film_destroy(scene);
  film_destroy(plain);
  free(pattern);
}

/* ---- Frames that hold nothing ---- */

static void an_empty_frame_is_an_empty_picture(void **state) {
  test_fixture *f = *state;
  write_frame(f, "", 1, 0.0f);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    test_film scene = load(f, f->path, placed, true);
    if (i == NEPH_INTEGRATOR_PATH) assert_int_equal(neph_scene_set(scene.scene, "render.integrator", "path"), NEPH_OK);
    test_log_clear(&f->log);
    neph_image *empty = render(scene, 1);
    assert_non_null(strstr(f->log.text, "b.0001.vdb: grid 'density' is empty: it has no active voxels"));
    for (size_t p = 0; p < PIXELS; p++) assert_true(get_transmittance(empty)[p] == 1.0f);
    neph_image *filled = render(scene, 2);
    assert_non_null(strstr(f->log.text, "cloud jet: frame 2 is the reference frame, the first asked for that holds"));
    (void)search_block(filled);
    neph_image *empty_again = render(scene, 1);
    if (i == NEPH_INTEGRATOR_MARCH) assert_same_bits(empty, empty_again);
    neph_image_destroy(empty);
    neph_image_destroy(filled);
    neph_image_destroy(empty_again);
    film_destroy(scene);
  }
}

/* The same as without it, to the bit. */
static void an_empty_cloud_leaves_the_others_as_they_are(void **state) {
  const test_fixture *f = *state;
  char keys[512];
  write_frame(f, "", 2, 0.0f);
  (void)snprintf(keys, sizeof keys,
                 "%s, reference_frame: 1}, {name: low, bake: {extent: 200 m, voxel: 20 m, base: 60 m, "
                 "thickness: 100 m, coverage: 1}",
                 placed);
  test_film both = load(f, f->path, keys, true);
  neph_image *image = render(both, 2);
  test_film alone = load(f, f->path, placed, true);
  assert_int_equal(neph_scene_set(alone.scene, "clouds",
                                  "[{name: low, bake: {extent: 200 m, voxel: 20 m, base: 60 m, "
                                  "thickness: 100 m, coverage: 1}}]"),
                   NEPH_OK);
  neph_image *same = render(alone, 2);
  assert_same_bits(image, same);
  neph_image_destroy(image);
  neph_image_destroy(same);
  film_destroy(both);
  film_destroy(alone);
}

static void a_reference_frame_must_hold_something(void **state) {
  test_fixture *f = *state;
  char keys[256];
  write_frame(f, "", 1, 0.0f);
  (void)snprintf(keys, sizeof keys, "%s, reference_frame: 1", placed);
  test_film scene = load(f, f->path, keys, false);
  test_log_clear(&f->log);
  assert_int_equal(try_render(scene, 2), NEPH_ERROR_BAD_SCENE);
  assert_non_null(strstr(f->log.text, "cloud jet: its reference frame 1 holds nothing"));
  film_destroy(scene);
}

/* ---- Numbers of files ---- */

/* Frame `frame` of a scene with more keys looks as frame `other` of one without them; 0: as none of the cloud. Rays go
 * by the frame's number: where that differs the mean of columns does, by up to 0.02 of noise; of frames 2 and 3 by
 * 0.05.
 */
static void assert_shows(const test_fixture *f, const char *pattern, const char *more, int frame, int other) {
  char keys[512];
  (void)snprintf(keys, sizeof keys, "%s, reference_frame: 1, %s", placed, more);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    test_film scene = load(f, pattern, keys, true), plain = load(f, f->path, placed, true);
    assert_int_equal(neph_scene_set(plain.scene, "clouds[0].reference_frame", "1"), NEPH_OK);
    for (int n = 0; n < 2 && i == NEPH_INTEGRATOR_PATH; n++) {
      assert_int_equal(neph_scene_set((n ? scene : plain).scene, "render.integrator", "path"), NEPH_OK);
      assert_int_equal(neph_scene_set((n ? scene : plain).scene, "render.samples", "128"), NEPH_OK);
    }
    neph_image *image = render(scene, frame), *same = other ? render(plain, other) : NULL;
    double difference = 0.0;
    for (unsigned column = 0; column < WIDTH; column++)
      difference += fabs(measure_column(image, column) - (same ? measure_column(same, column) : 1.0)) / WIDTH;
    print_message("frame %d beside %d: %.4f\n", frame, other, difference);
    assert_true(difference <= (frame == other || !other ? 0.0 : 0.02));
    neph_image_destroy(image);
    neph_image_destroy(same);
    film_destroy(scene);
    film_destroy(plain);
  }
}

static void a_missing_frame_is_what_the_scene_says(void **state) {
  test_fixture *f = *state;
  test_log_clear(&f->log);
  assert_shows(f, f->path, "missing: empty", 4, 0);
  assert_non_null(strstr(f->log.text, "cloud jet: frame 4 is empty: b.####.vdb has no file of number 4"));
  assert_shows(f, f->path, "missing: hold", 7, 3);
  assert_shows(f, f->path, "missing: hold", -7, 1);
  assert_shows(f, f->path, "missing: loop", 5, 2);
  assert_shows(f, f->path, "missing: loop", 0, 3);
  assert_shows(f, f->path, "missing: error", 2, 2);
  test_film scene = load(f, f->path, "extinction: 1, missing: error", true);
  assert_int_equal(try_render(scene, 4), NEPH_ERROR_NOT_FOUND);
  film_destroy(scene);
}

/* A gap is bridged from before. */
static void a_gap_is_held(void **state) {
  const test_fixture *f = *state;
  char *path = test_path(f->folder, "b.0002.vdb");
  assert_int_equal(remove(path), 0);
  assert_shows(f, f->path, "missing: hold", 2, 1);
  assert_shows(f, f->path, "missing: loop", 5, 1);
  free(path);
}

/* No sequence at all is a wrong name, whatever frames may miss. */
static void a_sequence_without_files_is_refused(void **state) {
  test_fixture *f = *state;
  static const char *const modes[] = {"empty", "hold", "loop", "error"};
  char *pattern = test_path(f->folder, "c.####.vdb"), keys[256];
  for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
    (void)snprintf(keys, sizeof keys, "extinction: 1, missing: %s", modes[i]);
    test_film scene = load(f, pattern, keys, true);
    test_log_clear(&f->log);
    assert_int_equal(try_render(scene, 1), NEPH_ERROR_NOT_FOUND);
    assert_one_error(&f->log, "c.0001.vdb");
    film_destroy(scene);
  }
  free(pattern);
}

static void numbers_go_by_offset_and_speed(void **state) {
  const test_fixture *f = *state;
  assert_shows(f, f->path, "frame_offset: 1", 2, 3);
  assert_shows(f, f->path, "frame_speed: 0.5", 5, 3);
  assert_shows(f, f->path, "frame_speed: 0.5", 4, 2); /* 2.5: the whole number below */
  assert_shows(f, f->path, "frame_speed: -1, frame_offset: 2", 3, 1);
  assert_shows(f, f->path, "frame_speed: 2", 1, 1);
}

static void frames_between_have_files_of_their_own(void **state) {
  const test_fixture *f = *state;
  char *between = test_path(f->folder, "s.1.5.vdb"), *whole = test_path(f->folder, "s.1.vdb");
  char *second = test_path(f->folder, "b.0002.vdb"), *first = test_path(f->folder, "b.0001.vdb");
  assert_int_equal(rename(second, between), 0);
  assert_int_equal(link(first, whole), 0);
  write_frame(f, "", 2, 1.0f);
  char *pattern = test_path(f->folder, "s.$FF.vdb");
  assert_shows(f, pattern, "frame_speed: 0.5", 2, 2);
  char *texts[] = {between, whole, second, first, pattern};
  for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) free(texts[i]);
}

static void other_programs_patterns_are_read(void **state) {
  const test_fixture *f = *state;
  static const char *const patterns[] = {"b.%04d.vdb", "b.$F4.vdb"};
  for (size_t i = 0; i < sizeof patterns / sizeof *patterns; i++) {
    char *pattern = test_path(f->folder, patterns[i]);
    assert_shows(f, pattern, "missing: error", 2, 2);
    free(pattern);
  }
}

/* ---- What is said ---- */

static void assert_bad(test_fixture *f, const char *cloud, const char *message) {
  neph_scene *scene = NULL;
  char text[512];
  (void)snprintf(text, sizeof text, "clouds: [{%s}]", cloud);
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_load_text(f->context, text, "s", &scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, message);
}

static void a_reference_frame_wants_a_sequence(void **state) {
  test_fixture *f = *state;
  assert_bad(f, "bake: {}, reference_frame: 3", "clouds[0].reference_frame is 3, but the cloud is baked");
  assert_bad(f, "vdb: a.vdb, extinction: 1, reference_frame: 3", "but its vdb is the same file in every frame");
}

static char *explain(test_film film, int frame, neph_text_format text_format, neph_result expected) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  char *text = NULL;
  assert_int_equal(neph_scene_get_render_desc(film.scene, &desc), NEPH_OK);
  desc.frame = frame;
  assert_int_equal(neph_renderer_explain(film.renderer, film.scene, &desc, text_format, &text), expected);
  return text;
}

static void assert_explained(const test_fixture *f, test_film film, int frame, neph_text_format text_format,
                             const char *line) {
  char *text = explain(film, frame, text_format, NEPH_OK);
  if (!strstr(text, line)) fail_msg("%s is not in\n%s", line, text);
  neph_text_destroy(f->context, text);
}

/* Decided by headers alone: an empty frame is skipped. */
static void the_plan_names_the_reference_frame(void **state) {
  const test_fixture *f = *state;
  write_frame(f, "", 1, 0.0f);
  test_film scene = load(f, f->path, placed, false);
  assert_explained(f, scene, 1, NEPH_TEXT_PLAIN,
                   "reference frames     jet none yet: no frame asked for holds anything\n");
  assert_explained(f, scene, 2, NEPH_TEXT_PLAIN, "reference frames     jet 2\n");
  assert_explained(f, scene, 3, NEPH_TEXT_PLAIN, "reference frames     jet 2\n");
  assert_explained(f, scene, 3, NEPH_TEXT_JSON, "\"frame\": 2");
  assert_int_equal(neph_scene_set(scene.scene, "clouds[0].reference_frame", "3"), NEPH_OK);
  assert_explained(f, scene, 2, NEPH_TEXT_PLAIN, "reference frames     jet 3\n");
  film_destroy(scene);
}

static void the_plan_opens_every_frame(void **state) {
  test_fixture *f = *state;
  test_film scene = load(f, f->path, "voxel: 2 m, position: [0, 0, 16 m], optical_depth: 1, missing: error", false);
  test_log_clear(&f->log);
  assert_null(explain(scene, 4, NEPH_TEXT_PLAIN, NEPH_ERROR_NOT_FOUND));
  assert_one_error(&f->log, "jet.yaml:5:27: clouds[0].vdb is ",
                   "b.0004.vdb, which cannot be read: No such file or directory");
  char *path = test_path(f->folder, "b.0004.vdb");
  test_file_write_text(path, "not a grid");
  test_log_clear(&f->log);
  assert_null(explain(scene, 4, NEPH_TEXT_PLAIN, NEPH_ERROR_BAD_FILE));
  assert_one_error(&f->log, "b.0004.vdb: ");
  assert_int_equal(neph_scene_set(scene.scene, "clouds[0].reference_frame", "9"), NEPH_OK);
  test_log_clear(&f->log);
  assert_null(explain(scene, 1, NEPH_TEXT_PLAIN, NEPH_ERROR_NOT_FOUND));
  assert_one_error(&f->log, "clouds[0].reference_frame is 9, must be the number of a file that is there");
  free(path);
  film_destroy(scene);
}

/* ---- The next frame ---- */

/* Gives a file's pages up. */
static void drop_pages(const char *path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  assert_true(file >= 0);
  (void)fdatasync(file);
  (void)posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  (void)close(file);
}

static bool is_in_memory(const char *path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  unsigned char page = 0;
  void *bytes = mmap(NULL, 1, PROT_READ, MAP_SHARED, file, 0);
  assert_true(bytes != MAP_FAILED);
  assert_int_equal(mincore(bytes, 1, &page), 0);
  (void)munmap(bytes, 1);
  (void)close(file);
  return page & 1;
}

/* Its files are read while this frame is rendered, which has the same bits; a file system in memory gives nothing up.
 */
static void the_next_frame_is_read_ahead(void **state) {
  test_fixture *f = *state;
  test_film scene = load(f, f->path, placed, false);
  neph_image *alone = render(scene, 1), *image;
  char *next = test_path(f->folder, "b.0002.vdb");
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene.scene, &desc), NEPH_OK);
  desc.frame = 1, desc.has_next_frame = true, desc.next_frame = 2;
  drop_pages(next);
  assert_int_equal(neph_renderer_render(scene.renderer, scene.scene, &desc, &image), NEPH_OK);
  for (int wait = 0; wait < 200 && !is_in_memory(next); wait++) usleep(10000);
  assert_true(is_in_memory(next));
  assert_same_bits(alone, image);
  neph_image_destroy(image);
  neph_image_destroy(alone);
  film_destroy(scene);
  free(next);
}

/* One that is damaged, or missing, is reported in its own turn. */
static void a_bad_next_frame_waits_for_its_turn(void **state) {
  test_fixture *f = *state;
  char *next = test_path(f->folder, "b.0002.vdb");
  test_film scene = load(f, f->path, "extinction: 1, missing: error", false);
  neph_image *image;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene.scene, &desc), NEPH_OK);
  desc.frame = 1, desc.has_next_frame = true, desc.next_frame = 2;
  assert_int_equal(truncate(next, 100), 0);
  for (int is_missing = 0; is_missing < 2; is_missing++) {
    if (is_missing) assert_int_equal(unlink(next), 0);
    test_log_clear(&f->log);
    assert_int_equal(neph_renderer_render(scene.renderer, scene.scene, &desc, &image), NEPH_OK);
    neph_image_destroy(image);
    assert_null(strstr(f->log.text, "b.0002.vdb"));
    assert_int_equal(try_render(scene, 2), is_missing ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_BAD_FILE);
    assert_non_null(strstr(f->log.text, "b.0002.vdb"));
  }
  film_destroy(scene);
  free(next);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(what_stands_still_stands_still, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_still_ball_of_real_files_stands_still, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(optical_depth_is_that_of_the_reference_frame, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_frame_alone_is_that_of_the_sequence, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_changed_reference_is_read_again, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(brackets_are_no_pattern, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(an_empty_frame_is_an_empty_picture, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(an_empty_cloud_leaves_the_others_as_they_are, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_reference_frame_must_hold_something, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_reference_frame_wants_a_sequence, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_plan_names_the_reference_frame, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_missing_frame_is_what_the_scene_says, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_gap_is_held, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_sequence_without_files_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(numbers_go_by_offset_and_speed, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(frames_between_have_files_of_their_own, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(other_programs_patterns_are_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_plan_opens_every_frame, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_next_frame_is_read_ahead, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_bad_next_frame_waits_for_its_turn, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
