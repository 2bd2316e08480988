/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of a cloud against clouds of their own in the same places: shadows on the ground, mattes and depths, copies
 * that are held out, and light that a cache on disk keeps. */
#include "test_layers.h"

enum { COPIES = 5 };

/* Sums of floats about 1. */
static const double rounding = 2e-6;

/* The same picture by places, and by a row a copy. */
typedef struct herd {
  test_log log;
  char *folder, *csv, *places, *rows;
} herd;

/* Over hills, seen from above; the last two overlap. */
static const struct {
  int x, y, turn;
  double scale;
} copies[COPIES] = {
    {-1400, 300, 0, 0.8}, {-500, -200, 40, 1.0}, {200, 600, 130, 0.7}, {900, -100, 200, 0.9}, {1150, 100, 300, 0.6}};

static const char head[] =
    "version: 1\n"
    "camera: {position: [-600 m, -4 km, 2600 m], look_at: [0, 0, 400 m], fov: 45 deg, resolution: [32, 18]}\n"
    "sun: {elevation: 40 deg, azimuth: 220 deg}\n"
    "terrain: {ridges: {seed: 2, samples: 33, relief: 100 m}, width: 12 km}\n"
    "render: {samples: 4, seed: 5}\n"
    "output: {pixel_type: float}\n"
    "clouds:\n";

/* Crisp: paths through the thin edges of several copies end by roulette, whose random numbers go by the order in which
 * the copies are met, that of a hierarchy or of a list. Over 200 seeds mattes of frayed ones differ by -0.018 ± 0.014
 * of a pixel a picture, the mean of shadows by (2.4 ± 1.2)e-5. */
static const char bake[] =
    "bake: {preset: cumulus_humilis, seed: 3, extent: 700 m, base: 500 m, thickness: 350 m, voxel: 43 m, coverage: 1,"
    " extinction: 0.02 1/m, wispiness: 0, erosion: 0.2, billow: 480 m}";

static char *make_rows(void) {
  char text[4096];
  size_t length = (size_t)snprintf(text, sizeof text, "%s", head);
  for (int i = 0; i < COPIES; i++)
    length += (size_t)snprintf(text + length, sizeof text - length,
                               "  - {name: c%d, %s, position: [%d m, %d m, 700 m], rotation: %d deg, scale: %g}\n", i,
                               bake, copies[i].x, copies[i].y, copies[i].turn, copies[i].scale);
  return strdup(text);
}

static void write_places(const char *path) {
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fprintf(file, "x_m,y_m,z_m,rotation_deg,scale\n");
  for (int i = 0; i < COPIES; i++)
    fprintf(file, "%d,%d,700,%d,%g\n", copies[i].x, copies[i].y, copies[i].turn, copies[i].scale);
  assert_int_equal(fclose(file), 0);
}

static int set_up(void **state) {
  herd *h = calloc(1, sizeof *h);
  char text[4096];
  assert_non_null(h);
  test_log_start(&h->log);
  h->folder = test_folder_create();
  h->csv = test_path(h->folder, "places.csv");
  write_places(h->csv);
  (void)snprintf(text, sizeof text, "%s  - {name: herd, %s, places: %s}\n", head, bake, h->csv);
  h->places = strdup(text);
  h->rows = make_rows();
  *state = h;
  return 0;
}

static int tear_down_herd(void **state) {
  herd *h = *state;
  test_folder_destroy(h->folder);
  free(h->csv);
  free(h->places);
  free(h->rows);
  free(h);
  return 0;
}

/* A key and its value, and another, up to NULL. */
static neph_image *render_text(herd *h, const char *text, const char *cache, const char *const keys[]) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  desc.thread_count = 2;
  desc.module_dir = NEPHOS_TEST_MODULE_DIR;
  desc.cache_dir = cache;
  desc.log = test_log_receive;
  desc.log_user = &h->log;
  desc.log_level_max = NEPH_LOG_DEBUG;
  test_log_clear(&h->log);
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  neph_result result = neph_scene_load_text(context, text, "dir/scene.yaml", &scene);
  for (; !result && keys[0]; keys += 2) result = neph_scene_set(scene, keys[0], keys[1]);
  if (!result) result = neph_render_image(scene, NULL, &image);
  if (result) fail_msg("%s", h->log.text);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return image;
}

static double compare(const neph_image *a, const neph_image *b, const char *channel) {
  double most = 0.0;
  for (size_t p = 0; p < count_pixels(a); p++)
    most = fmax(most, fabs(get_value(a, channel, p) - get_value(b, channel, p)));
  return most;
}

static double get_least(const neph_image *image, const char *channel) {
  double least = INFINITY;
  for (size_t p = 0; p < count_pixels(image); p++) least = fmin(least, get_value(image, channel, p));
  return least;
}

/* Two pictures; their light, too, is the same in the mean. */
typedef struct couple {
  neph_image *places, *rows;
} couple;

/* Paths go on from the cloud at random, and see no lattice: their means agree within 2 % with this noise. */
static void assert_same_mean(const couple *c, bool is_march) {
  assert_near_relative(get_mean(c->places, "G"), get_mean(c->rows, "G"), is_march ? 1e-3 : 0.02);
}

static void couple_clear(couple *c) {
  neph_image_destroy(c->places);
  neph_image_destroy(c->rows);
}

/* Each march keeps its tolerance of 2 %, from other random offsets, since steps are cut where boxes are entered: the
 * mean of 576 pixels is a hundred times closer. Paths sum transmittances exactly. */
static void check_shadows(const couple *c, bool is_march) {
  assert_true(get_least(c->rows, "shadow") < 0.3);
  assert_true(get_mean(c->rows, "shadow") < 0.98);
  assert_true(compare(c->places, c->rows, "shadow") <= (is_march ? 2 * 0.02 : rounding));
  assert_near(get_mean(c->places, "shadow"), get_mean(c->rows, "shadow"), is_march ? 4e-4 : rounding);
}

static double sum_mattes(const neph_image *rows, size_t pixel) {
  double sum = 0.0;
  for (int c = 0; c < COPIES; c++) {
    char name[8];
    (void)snprintf(name, sizeof name, "c%d", c);
    sum += get_coverage(rows, np_cryptomatte_get_id(name), pixel);
  }
  return sum;
}

/* Three thousandths: what the march's Russian roulette leaves of a ray. */
static const double roulette = 3e-3;

static void check_mattes(const couple *c, bool is_march) {
  double most = 0.0;
  for (size_t p = 0; p < count_pixels(c->places); p++) {
    const double sum = sum_mattes(c->rows, p);
    assert_near(get_coverage(c->places, np_cryptomatte_get_id("herd"), p), sum, is_march ? roulette : rounding);
    most = fmax(most, sum);
  }
  assert_true(most > 0.8);
}

/* Z, where the transmittance falls below ½, is the same but where a ray is in several boxes, whose pieces are cut
 * elsewhere: in 6 pixels of 576, and by less than half a voxel. */
static void check_depths(const couple *c) {
  unsigned apart = 0, near = 0;
  for (size_t p = 0; p < count_pixels(c->places); p++) {
    const double here = get_value(c->places, "Z", p), there = get_value(c->rows, "Z", p);
    apart += !(here == there);
    near += there < 5000.0;
    assert_true(here == there || fabs(here - there) < 25.0);
  }
  assert_true(apart <= 2 * 6);
  assert_true(near > count_pixels(c->places) / 20);
}

static void copies_are_clouds_of_their_own(void **state) {
  herd *h = *state;
  for (int i = 0; i < 2; i++) {
    const char *const keys[] = {"render.integrator", integrators[i], "output.aovs", "[shadow, cryptomatte]", NULL};
    couple c = {render_text(h, h->places, NULL, keys), render_text(h, h->rows, NULL, keys)};
    assert_same_mean(&c, !i);
    check_shadows(&c, !i);
    check_mattes(&c, !i);
    check_depths(&c);
    couple_clear(&c);
  }
}

static void copies_that_are_held_out_hide_the_ground(void **state) {
  herd *h = *state;
  for (int i = 0; i < 2; i++) {
    const char *keys[3 + 2 * COPIES] = {"render.integrator", integrators[i]};
    char names[COPIES][32];
    for (int n = 0; n < COPIES; n++) {
      (void)snprintf(names[n], sizeof names[n], "clouds[%d].holdout", n);
      keys[2 + 2 * n] = names[n], keys[3 + 2 * n] = "true";
    }
    couple c = {.rows = render_text(h, h->rows, NULL, keys)};
    keys[4] = NULL; /* one row alone */
    c.places = render_text(h, h->places, NULL, keys);
    assert_true(get_least(c.rows, "A") < 0.2); /* behind the densest there is no ground to see */
    assert_true(compare(c.places, c.rows, "A") <= (i ? rounding : roulette));
    assert_same_mean(&c, !i);
    couple_clear(&c);
  }
}

static bool has_read(const herd *h, const char *what) {
  char line[64];
  (void)snprintf(line, sizeof line, "%s: read from the cache", what);
  return strstr(h->log.text, line) != NULL;
}

/* A second process reads the light of copies, to the bit; that of rows is another, and is not taken for it. */
static void caches_on_disk_keep_the_light_of_copies(void **state) {
  static const char *const light[] = {"sun optical depth", "multiple scattering"};
  herd *h = *state;
  char *cache = test_path(h->folder, "cache");
  const char *const keys[] = {"render.integrator", "march", NULL};
  neph_image *images[3], *rows;
  for (int i = 0; i < 3; i++) {
    images[i] = render_text(h, h->places, i ? cache : NULL, keys);
    for (int n = 0; n < 2; n++) assert_int_equal(has_read(h, light[n]), i == 2);
    assert_near(compare(images[0], images[i], "G"), 0.0, 0.0);
  }
  rows = render_text(h, h->rows, cache, keys);
  assert_false(has_read(h, light[0]));
  assert_same_mean(&(couple){images[2], rows}, true);
  for (int i = 0; i < 3; i++) neph_image_destroy(images[i]);
  neph_image_destroy(rows);
  free(cache);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(copies_are_clouds_of_their_own),
      cmocka_unit_test(copies_that_are_held_out_hide_the_ground),
      cmocka_unit_test(caches_on_disk_keep_the_light_of_copies),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down_herd);
}
