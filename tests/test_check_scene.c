/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of scenes apply the scene's settings to its files: there is an error if and only if a render fails. */
#include <sys/stat.h>

#include <nephos/nephos.h>

#include "test_frusta.h"
#include "test_tools.h"

#include "volume/volume_private.h"

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

/* ---- Files ---- */

enum { GRIDS_MAX = 4 };

/* One grid of a file: a block of voxels of 10 m, of even value but in one voxel. */
typedef struct block {
  const char *name;
  float value, odd_value;
  bool is_vector;
} block;

static np_sparse_grid make_grid(test_fixture *f, const block *of) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(f->context, of->name, &grid), NEPH_OK);
  for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = 10.0;
  np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){0, 0, 0});
  memset(leaf->active, 0xff, sizeof leaf->active);
  for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = of->value;
  leaf->values[219] = of->odd_value; /* voxel (3, 3, 3) */
  return grid;
}

static void write_blocks(test_fixture *f, const block blocks[GRIDS_MAX]) {
  np_sparse_grid grids[GRIDS_MAX];
  np_vdb_write_grid outputs[GRIDS_MAX] = {{NULL}};
  size_t count = 0;
  for (; count < GRIDS_MAX && blocks[count].name; count++) {
    grids[count] = make_grid(f, &blocks[count]);
    outputs[count].grid = &grids[count];
    if (blocks[count].is_vector) outputs[count].y = outputs[count].z = &grids[count];
  }
  assert_int_equal(np_volume_save_grids(f->context, f->path, outputs, count, NULL), NEPH_OK);
  for (size_t i = 0; i < count; i++) np_sparse_grid_clear(&grids[i]);
}

/* ---- Scenes ---- */

static neph_scene *load_scene(test_fixture *f, const char *vdb, const char *cloud) {
  char text[2048];
  neph_scene *scene;
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0, -300 m, 40 m], look_at: [0, 0, 40 m], fov: 60 deg, resolution: [8, 6]}\n"
                 "atmosphere: none\nrender: {samples: 1, multiple_scattering: none}\n"
                 "clouds: [{name: low, vdb: \"%s\", position: [0, 0, 0], extinction: 0.1 1/m%s}]\n",
                 vdb, cloud);
  assert_int_equal(neph_scene_load_text(f->context, text, "scene.yaml", &scene), NEPH_OK);
  return scene;
}

static neph_result render(neph_scene *scene) {
  neph_image *image = NULL;
  const neph_result result = neph_render_image(scene, NULL, &image);
  neph_image_destroy(image);
  return result;
}

/* Fails, with all findings, unless there is one of the rule, and errors where the render fails. */
static void compare(test_fixture *f, neph_scene *scene, const char *rule, bool is_rendered) {
  neph_check *check = NULL;
  char *text = NULL;
  bool is_found = !rule;
  test_log_clear(&f->log);
  const bool is_done = !render(scene);
  if (is_done != is_rendered) fail_msg("rendered: %d, expected: %d\n%s", is_done, is_rendered, f->log.text);
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  assert_int_equal(neph_check_scene(check, scene, 1), NEPH_OK);
  assert_int_equal(neph_check_describe(check, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  for (size_t i = 0; i < neph_check_get_finding_count(check); i++) {
    neph_finding finding = NEPH_FINDING_DEFAULT;
    assert_int_equal(neph_check_get_finding(check, i, &finding), NEPH_OK);
    is_found = is_found || !strcmp(finding.rule, rule);
  }
  if (!is_found) fail_msg("no finding of %s in:\n%s", rule, text);
  if ((neph_check_count(check, NEPH_SEVERITY_ERROR) == 0) != is_rendered) fail_msg("rendered: %d\n%s", is_done, text);
  if (neph_check_count(check, NEPH_SEVERITY_ERROR) > 1) fail_msg("a fault is told twice:\n%s", text);
  neph_text_destroy(f->context, text);
  neph_check_destroy(check);
}

/* ---- Tests ---- */

static void checks_agree_with_renders(void **state) {
  test_fixture *f = *state;
  const struct {
    block blocks[GRIDS_MAX];
    const char *cloud, *rule;
    bool is_rendered, is_open; /* the shutter, for which velocities are read */
  } cases[] = {
      {{{"density", 0.5f, 0.5f, false}}, "", NULL, true, false},
      {{{"density", 0.5f, NAN, false}}, "", "values.nan", false, false},
      {{{"density", 0.5f, NAN, false}}, ", import: repair", "values.nan", true, false},
      {{{"density", 0.5f, -1.0f, false}}, "", "values.negative", false, false},
      {{{"density", 0.5f, INFINITY, false}}, ", import: repair", "values.infinite", true, false},
      /* three of one name: which is meant? */
      {{{"density", 0.5f, 0.5f, false}, {"density", 0.5f, 0.5f, false}, {"density", 0.5f, 0.5f, false}},
       "",
       "file.no_density",
       false,
       false},
      {{{"density", 0.5f, NAN, false}, {"density", 0.5f, 0.5f, false}},
       ", grid: \"density[1]\"",
       "file.same_names",
       true,
       false},
      {{{"density", 0.5f, NAN, false}, {"density", 0.5f, 0.5f, false}},
       ", grid: \"density[0]\"",
       "values.nan",
       false,
       false},
      /* fields are no densities, and count where they are used */
      {{{"smoke", 0.5f, 0.5f, false}, {"temp", 2.0f, 2.0f, false}}, "", NULL, true, false},
      {{{"smoke", 0.5f, 0.5f, false}, {"temperature", 2.0f, NAN, false}}, "", NULL, true, false},
      {{{"smoke", 0.5f, 0.5f, false}, {"temperature", 2.0f, NAN, false}},
       ", emission: {kelvin: 1000 K}",
       "values.nan",
       false,
       false},
      {{{"fuel", 0.5f, 0.5f, false}, {"burn", 2.0f, 2.0f, false}}, "", "file.no_density", false, false},
      {{{"fuel", 0.5f, 0.5f, false}, {"burn", 2.0f, 2.0f, false}}, ", grid: fuel+burn", NULL, true, false},
      /* colours and velocities */
      {{{"density", 0.5f, 0.5f, false}, {"Cd", 0.5f, NAN, true}}, "", "values.nan", false, false},
      {{{"density", 0.5f, 0.5f, false}, {"Cd", 0.5f, NAN, true}}, ", color: none", NULL, true, false},
      {{{"density", 0.5f, 0.5f, false}}, ", color: paint", "read", false, false},
      {{{"density", 0.5f, 0.5f, false}, {"vel", 0.5f, NAN, true}}, "", NULL, true, false},
      {{{"density", 0.5f, 0.5f, false}, {"vel", 0.5f, NAN, true}}, "", "values.nan", false, true},
      {{{"density", 0.5f, 0.5f, false}}, ", velocity: speed", "read", false, true},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    print_message("case %zu: '%s'\n", i, cases[i].cloud);
    write_blocks(f, cases[i].blocks);
    neph_scene *scene = load_scene(f, f->path, cases[i].cloud);
    if (cases[i].is_open) assert_int_equal(neph_scene_set(scene, "camera.motion_blur.shutter", "0.5"), NEPH_OK);
    compare(f, scene, cases[i].rule, cases[i].is_rendered);
    neph_scene_destroy(scene);
  }
}

/* A grid that the scene does not use is not read. */
static void damage_of_unused_grids_is_no_fault(void **state) {
  static const struct {
    const char *cloud;
    bool is_rendered;
  } cases[] = {{"", true}, {", emission: {temperature: heat}", false}};
  test_fixture *f = *state;
  struct stat status;
  write_blocks(f, (const block[GRIDS_MAX]){{"density", 0.5f, 0.5f, false}, {"heat", 2.0f, 3.0f, false}});
  assert_int_equal(stat(f->path, &status), 0);
  FILE *file = fopen(f->path, "r+b"); /* the last quarter holds the heat */
  fseek(file, status.st_size / 4 * 3, SEEK_SET);
  for (off_t n = status.st_size / 4 * 3; n < status.st_size - 8; n++) fputc(0xff, file);
  fclose(file);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_scene *scene = load_scene(f, f->path, cases[i].cloud);
    compare(f, scene, NULL, cases[i].is_rendered);
    neph_scene_destroy(scene);
  }
}

/* The files of write_vdb.py. */
static void grids_of_other_kinds_agree_too(void **state) {
  test_fixture *f = *state;
  char command[1024];
  test_require_tool("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1", "python3-openvdb");
  (void)snprintf(command, sizeof command, "/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/write_vdb.py %s", f->folder);
  assert_int_equal(system(command), 0);
  static const struct {
    const char *file, *cloud, *rule;
    bool is_rendered;
  } cases[] = {{"ball.vdb", "", "file.no_density", false},
               {"ball.vdb", ", level_set: 2", NULL, true},
               {"mark.vdb", "", NULL, true},
               {"view.vdb", "", "transform.frustum", true}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char *path = test_path(f->folder, cases[i].file);
    neph_scene *scene = load_scene(f, path, cases[i].cloud);
    print_message("%s: %s\n", cases[i].file, cases[i].cloud);
    compare(f, scene, cases[i].rule, cases[i].is_rendered);
    neph_scene_destroy(scene);
    free(path);
  }
}

/* Faults of a place have rules of their own, and name the cloud. */
static void places_have_rules(void **state) {
  static const struct {
    const char *cloud, *rule;
  } cases[] = {{"position: [0, 0, 0], voxel: 1 cm", "cloud.small"}, {"voxel: 1000 km", "cloud.large"},
               {"position: [0, -9 km, 0]", "cloud.out_of_view"},    {"position: [0, -300 m, 0]", "cloud.before_near"},
               {"position: [0, 900 m, 0]", "cloud.beyond_far"},     {"position: [0, 0, -900 m]", "cloud.below_ground"}};
  static const char bounds[] = "the cloud reaches from (-0.035, -0.035, 0) to (0.035, 0.035, 0.07) m";
  unsigned bound_count = 0;
  test_fixture *f = *state;
  write_blocks(f, (const block[GRIDS_MAX]){{"density", 0.5f, 0.5f, false}});
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char text[1024];
    neph_scene *scene;
    neph_check *check;
    bool is_found = false;
    (void)snprintf(text, sizeof text,
                   "camera: {position: [0, -300 m, 40 m], look_at: [0, 0, 40 m], fov: 60 deg, near: 200 m, far: 1 km}\n"
                   "clouds: [{name: low, vdb: \"%s\", extinction: 0.1 1/m, %s}]\n",
                   f->path, cases[i].cloud);
    assert_int_equal(neph_scene_load_text(f->context, text, "scene.yaml", &scene), NEPH_OK);
    assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
    assert_int_equal(neph_check_scene(check, scene, 1), NEPH_OK);
    for (size_t n = 0; n < neph_check_get_finding_count(check); n++) {
      neph_finding finding = NEPH_FINDING_DEFAULT;
      assert_int_equal(neph_check_get_finding(check, n, &finding), NEPH_OK);
      if (!strcmp(finding.rule, "cloud.bounds") && i == 0) bound_count += !strcmp(finding.cause, bounds);
      if (strcmp(finding.rule, cases[i].rule) != 0) continue;
      is_found = true;
      assert_string_equal(finding.place, "cloud low");
      assert_non_null(finding.remedy);
      assert_int_equal(finding.severity, NEPH_SEVERITY_WARNING);
    }
    if (!is_found) fail_msg("no finding of %s", cases[i].rule);
    neph_check_destroy(check);
    neph_scene_destroy(scene);
  }
  assert_int_equal(bound_count, 1);
}

/* A scene that is none for an error of a key still has its files checked. */
static void files_are_checked_beside_errors_of_keys(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "scene.yaml");
  neph_check *check;
  unsigned found = 0;
  write_blocks(f, (const block[GRIDS_MAX]){{"density", 0.5f, NAN, false}});
  test_file_write_text(path, "camera: {fov: 400 deg}\nclouds: [{vdb: cloud.vdb, extinction: 0.1 1/m}]\n");
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  assert_int_equal(neph_check_file(check, path), NEPH_OK);
  for (size_t i = 0; i < neph_check_get_finding_count(check); i++) {
    neph_finding finding = NEPH_FINDING_DEFAULT;
    assert_int_equal(neph_check_get_finding(check, i, &finding), NEPH_OK);
    found |= !strcmp(finding.rule, "values.nan") ? 1u : 0u;
    found |= strstr(finding.cause, "camera.fov") ? 2u : 0u;
  }
  assert_int_equal(found, 3u);
  neph_check_destroy(check);
  free(path);
}

/* ---- Tables and pictures alone ---- */

static size_t count_bad(const neph_check *check) {
  return neph_check_count(check, NEPH_SEVERITY_ERROR) + neph_check_count(check, NEPH_SEVERITY_WARNING);
}

/* The findings of a file, as text, and how many are errors or warnings. */
static char *describe_findings(test_fixture *f, const char *name, size_t *out_bad) {
  neph_check *check;
  char *path = test_path(f->folder, name), *text = NULL;
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  assert_int_equal(neph_check_file(check, path), NEPH_OK);
  assert_int_equal(neph_check_describe(check, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  *out_bad = count_bad(check);
  neph_check_destroy(check);
  free(path);
  return text;
}

static void assert_findings(test_fixture *f, const char *name, size_t bad, const char *rule) {
  size_t count;
  char *text = describe_findings(f, name, &count);
  if (count != bad || (rule && !strstr(text, rule))) fail_msg("%s:\n%s", name, text);
  neph_text_destroy(f->context, text);
}

static void write_text(test_fixture *f, const char *name, const char *text) {
  char *path = test_path(f->folder, name);
  test_file_write_text(path, text);
  free(path);
}

static void tables_are_told_apart(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *text, *rule;
    size_t bad;
  } cases[] = {{"angle_deg,value\n0,0.0795775\n180,0.0795775\n", NULL, 0},
               {"x_m,y_m,z_m\n1,2,3\n", NULL, 0},
               {"x_m,y_m,z_m\n1,2,tall\n", "tall", 1},
               {"frame,x,y,z,rx,ry,rz\n1,0,0,2,0,0,0\n2,0,1,2,0,0,0\n", NULL, 0},
               {"frame,x,y,z,rx,ry,rz\n1,0,0,2,0,0,0\n1,0,1,2,0,0,0\n", "frames must rise", 1},
               {"ra_deg,dec_deg,v_mag\n10,20,3\n", NULL, 0},
               {"ra_deg,dec_deg,v_mag\n10,200,3\n", "200", 1},
               {"left,right\n1,2\n", "table.kind", 1}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    write_text(f, "table.csv", cases[i].text);
    assert_findings(f, "table.csv", cases[i].bad, cases[i].rule);
  }
}

static void a_picture_of_8_bits_is_no_height_field(void **state) {
  test_fixture *f = *state;
  static const char *const names[] = {"R", "G", "B"};
  neph_image *image = NULL;
  char *path = test_path(f->folder, "map.png");
  assert_int_equal(neph_image_create(f->context, 4, 4, 3, names, &image), NEPH_OK);
  assert_int_equal(neph_image_save_png(image, path, NULL), NEPH_OK);
  neph_image_destroy(image);
  assert_findings(f, "map.png", 0, "picture.kind");
  free(path);
}

/* A raster may be laid around a scene's place. */
static void a_raster_need_not_say_where_it_lies(void **state) {
  test_fixture *f = *state;
  if (!neph_feature_is_present(f->context, NEPH_FEATURE_GDAL)) return;
  char text[4096] = "ncols 9\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 30\n";
  for (int i = 0; i < 81; i++) (void)snprintf(text + strlen(text), sizeof text - strlen(text), "%d.5\n", 100 + i * i);
  write_text(f, "h.asc", text);
  assert_findings(f, "h.asc", 0, "heights.place");
}

/* Whole numbers over a low range have few heights of themselves; fractions do not. */
static void few_heights_of_floats_are_terraces(void **state) {
  test_fixture *f = *state;
  if (!neph_feature_is_present(f->context, NEPH_FEATURE_GDAL)) return;
  char text[4096] = "ncols 9\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 30\n";
  for (int i = 0; i < 81; i++) (void)snprintf(text + strlen(text), sizeof text - strlen(text), "%d.5\n", 100 + i % 10);
  write_text(f, "h.asc", text);
  assert_findings(f, "h.asc", 1, "heights.terraces");
}

/* A field of a few samples has few heights, and one whose unit the scene gives needs none of its own. */
static void rules_of_heights_know_their_limits(void **state) {
  test_fixture *f = *state;
  static const char *const units[] = {"", ", vertical_unit: metre", ", vertical_unit: foot"};
  if (!neph_feature_is_present(f->context, NEPH_FEATURE_GDAL)) return;
  write_text(f, "h.asc", "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 30\n1.5 2 3\n400 5 6\n7 8 9\n");
  for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
    char scene[200];
    size_t bad;
    (void)snprintf(scene, sizeof scene, "version: 1\nterrain: {heightfield: h.asc, width: 1 km%s}\n", units[i]);
    write_text(f, "scene.yaml", scene);
    char *text = describe_findings(f, "scene.yaml", &bad);
    assert_non_null(strstr(text, "heights.place"));
    if (!strstr(text, "heights.unit") != (i > 0) || strstr(text, "heights.terraces")) fail_msg("%s", text);
    neph_text_destroy(f->context, text);
  }
}

/* Frustums: one that fits, one of which even voxels would take gigabytes, and one with voxels behind its eye. */
static void frustums_are_told_as_they_are_rendered(void **state) {
  test_fixture *f = *state;
  static const struct {
    test_frustum map;
    int32_t origin[3], edge;
    const char *rule;
    bool is_rendered;
  } cases[] = {{{{16, 16, 16}, 2.0, 4.0, 20.0, 0.0, {0, 0, 0}}, {0, 0, 8}, 8, "transform.frustum", true},
               {{{128, 128, 128}, 0.5, 100.0, 1.0, 0.0, {0, 0, 0}}, {0, 0, 0}, 128, "transform.frustum_large", false},
               {{{64, 64, 64}, 1.0, 2.0, 1.0, 0.0, {0, 0, 0}}, {0, 0, -72}, 8, "transform.frustum_point", false}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    np_sparse_grid grid;
    assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
    (void)np_sparse_grid_add_tile(&grid, cases[i].origin, cases[i].edge, 1.0f, true);
    const np_vdb_write_grid output = {.grid = &grid};
    test_frustum_write(f, &cases[i].map, &output, 1);
    np_sparse_grid_clear(&grid);
    neph_scene *scene = load_scene(f, f->path, "");
    compare(f, scene, cases[i].rule, cases[i].is_rendered);
    neph_scene_destroy(scene);
  }
}

/* A sequence of which the first file has a temperature alone. */
static void a_frame_without_its_density_is_told(void **state) {
  test_fixture *f = *state;
  char *const pattern = test_path(f->folder, "c.####.vdb"), *const own = f->path;
  static const char *const names[] = {"temperature", "density"};
  for (int n = 0; n < 2; n++) {
    f->path = test_path(f->folder, n ? "c.0002.vdb" : "c.0001.vdb");
    write_blocks(f, (const block[GRIDS_MAX]){{.name = names[n], .value = 0.5f, .odd_value = 0.5f}});
    free(f->path);
  }
  f->path = own;
  neph_scene *scene = load_scene(f, pattern, "");
  compare(f, scene, "sequence.no_density", true);
  neph_scene_destroy(scene);
  free(pattern);
}

static void a_cloud_in_the_system_of_the_raster_is_told(void **state) {
  test_fixture *f = *state;
  char text[2048], *raster = test_path(f->folder, "ground.asc");
  neph_scene *scene;
  if (!neph_feature_is_present(f->context, NEPH_FEATURE_GDAL)) skip();
  test_file_write_text(raster, "ncols 3\nnrows 2\nxllcenter 400000\nyllcenter 3762100\ncellsize 1000\n1 2 3\n4 5 6\n");
  np_sparse_grid grid = make_grid(f, &(block){.name = "density", .value = 0.01f, .odd_value = 0.01f});
  grid.index_to_world.m[0][3] = 401000.0, grid.index_to_world.m[1][3] = 3762600.0, grid.index_to_world.m[2][3] = 500.0;
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0, -300 m, 500 m], look_at: [0, 0, 500 m], resolution: [8, 6]}\n"
                 "atmosphere: none\nrender: {samples: 1, multiple_scattering: none}\n"
                 "terrain: {heightfield: \"%s\", crs: \"EPSG:32611\"}\n"
                 "clouds: [{name: low, vdb: \"%s\", extinction: 0.1 1/m}]\n",
                 raster, f->path);
  assert_int_equal(neph_scene_load_text(f->context, text, "scene.yaml", &scene), NEPH_OK);
  compare(f, scene, "cloud.georeferenced", true);
  neph_scene_destroy(scene);
  free(raster);
}

/* A block of 80 m, two thousand kilometres from hills of 200 m. */
static void a_cloud_too_far_away_is_told(void **state) {
  test_fixture *f = *state;
  char text[2048];
  static const char *const rules[] = {"cloud.below_pixel", "cloud.far_from_terrain"};
  write_blocks(f, (const block[GRIDS_MAX]){{.name = "density", .value = 0.5f, .odd_value = 0.5f}});
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0, -300 m, 40 m], look_at: [0, 0, 40 m], fov: 60 deg, resolution: [8, 6]}\n"
                 "atmosphere: none\nrender: {samples: 1, multiple_scattering: none}\n"
                 "terrain: {ridges: {samples: 17, relief: 1 m}, width: 200 m}\n"
                 "clouds: [{name: low, vdb: \"%s\", position: [0, 2000 km, 10 m], extinction: 0.1 1/m}]\n",
                 f->path);
  for (int n = 0; n < 2; n++) {
    neph_scene *scene;
    assert_int_equal(neph_scene_load_text(f->context, text, "scene.yaml", &scene), NEPH_OK);
    compare(f, scene, rules[n], true);
    neph_scene_destroy(scene);
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(checks_agree_with_renders),
                                     TEST(frustums_are_told_as_they_are_rendered),
                                     TEST(a_frame_without_its_density_is_told),
                                     TEST(a_cloud_in_the_system_of_the_raster_is_told),
                                     TEST(a_cloud_too_far_away_is_told),
                                     TEST(damage_of_unused_grids_is_no_fault),
                                     TEST(grids_of_other_kinds_agree_too),
                                     TEST(places_have_rules),
                                     TEST(files_are_checked_beside_errors_of_keys),
                                     TEST(tables_are_told_apart),
                                     TEST(a_picture_of_8_bits_is_no_height_field),
                                     TEST(a_raster_need_not_say_where_it_lies),
                                     TEST(few_heights_of_floats_are_terraces),
                                     TEST(rules_of_heights_know_their_limits)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
