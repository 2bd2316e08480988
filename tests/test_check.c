/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of files with one fault each: its rule is reported with its place, and a repaired copy passes. */
#include <float.h>

#include <nephos/check.h>

#include "test_box_files.h"
#include "vdb_edit.h"

#include "core/file.h"
#include "core/frame_name.h"

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

/* ---- Findings ---- */

static neph_check *start(test_fixture *f) {
  neph_check *check = NULL;
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  return check;
}

static neph_finding get_finding(const neph_check *check, size_t index) {
  neph_finding finding = NEPH_FINDING_DEFAULT;
  assert_int_equal(neph_check_get_finding(check, index, &finding), NEPH_OK);
  return finding;
}

/* The finding of a rule; fails where there is none. */
static neph_finding search_rule(const neph_check *check, const char *rule) {
  for (size_t i = 0; i < neph_check_get_finding_count(check); i++)
    if (!strcmp(get_finding(check, i).rule, rule)) return get_finding(check, i);
  char *text = NULL;
  assert_int_equal(neph_check_describe(check, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  fail_msg("no finding of %s in:\n%s", rule, text);
  return get_finding(check, 0);
}

static size_t count_bad(const neph_check *check) {
  return neph_check_count(check, NEPH_SEVERITY_ERROR) + neph_check_count(check, NEPH_SEVERITY_WARNING);
}

static void assert_clean(test_fixture *f, const char *path) {
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, path), NEPH_OK);
  assert_int_equal(count_bad(check), 0);
  neph_check_destroy(check);
}

/* ---- Files ---- */

/* A ball of values about 1 in 32³ voxels of 10 m. */
static void make_grid(test_fixture *f, const char *name, np_sparse_grid *grid) {
  assert_int_equal(np_sparse_grid_init(f->context, name, grid), NEPH_OK);
  grid->index_to_world = (np_affine){{{10, 0, 0, 0}, {0, 10, 0, 0}, {0, 0, 10, 100}}};
  int32_t o[3];
  for (o[0] = 0; o[0] < 32; o[0] += 8)
    for (o[1] = 0; o[1] < 32; o[1] += 8)
      for (o[2] = 0; o[2] < 32; o[2] += 8) {
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, o);
        assert_non_null(leaf);
        memset(leaf->active, 0xff, sizeof leaf->active);
        for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = 0.5f + (float)(n % 7) / 14.0f;
      }
}

static void save(test_fixture *f, const char *path, const np_sparse_grid *const *grids, size_t count, bool is_half) {
  np_vdb_write_grid outputs[4] = {{0}};
  for (size_t i = 0; i < count; i++) outputs[i] = (np_vdb_write_grid){.grid = grids[i], .is_half = is_half};
  assert_int_equal(np_volume_save_grids(f->context, path, outputs, count, NULL), NEPH_OK);
}

static void save_one(test_fixture *f, const np_sparse_grid *grid) { save(f, f->path, &grid, 1, false); }

/* Voxel (1, 2, 3) of the leaf at (8, 0, 0). */
enum { BAD_LEAF = 16, BAD_VOXEL = 64 + 16 + 3 };

static void put_value(test_fixture *f, float value) {
  np_sparse_grid grid;
  make_grid(f, "density", &grid);
  grid.leaves[BAD_LEAF].values[BAD_VOXEL] = value;
  save_one(f, &grid);
  np_sparse_grid_clear(&grid);
}

/* ---- Values ---- */

static void bad_values_are_counted_and_located(void **state) {
  test_fixture *f = *state;
  static const struct {
    float value;
    const char *rule;
    neph_severity severity;
  } cases[] = {{NAN, "values.nan", NEPH_SEVERITY_ERROR},
               {INFINITY, "values.infinite", NEPH_SEVERITY_ERROR},
               {-1.0f, "values.negative", NEPH_SEVERITY_ERROR},
               {-1e-9f, "values.rounding", NEPH_SEVERITY_NOTE},
               {FLT_MIN / 2, "values.subnormal", NEPH_SEVERITY_NOTE},
               {7e4f, "values.beyond_half", NEPH_SEVERITY_NOTE},
               {1e30f, "values.absurd", NEPH_SEVERITY_WARNING}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_check *check = start(f);
    char first[32];
    put_value(f, cases[i].value);
    assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
    const neph_finding finding = search_rule(check, cases[i].rule);
    assert_int_equal(finding.severity, cases[i].severity);
    assert_string_equal(finding.grid, "density");
    const bool is_absurd = !strcmp(cases[i].rule, "values.absurd");
    snprintf(first, sizeof first, is_absurd ? "value is %g," : "first %g", (double)cases[i].value);
    assert_non_null(strstr(finding.cause, is_absurd ? "the mean of the others 0.7" : "1 value is"));
    if (!isnan(cases[i].value)) assert_non_null(strstr(finding.cause, first));
    assert_string_equal(finding.place, "voxel (9, 2, 3), (90, 20, 130)");
    neph_check_destroy(check);
  }
}

/* A file of halves cannot keep what is above 65504. */
static void an_overflow_of_halves_is_told_from_infinity(void **state) {
  test_fixture *f = *state;
  np_sparse_grid grid;
  neph_check *check = start(f);
  make_grid(f, "density", &grid);
  grid.leaves[BAD_LEAF].values[BAD_VOXEL] = INFINITY;
  const np_sparse_grid *list = &grid;
  save(f, f->path, &list, 1, false);
  np_vdb_write_grid output = {.grid = &grid, .is_half = true};
  const np_vdb_module *module;
  np_vdb_error error;
  assert_int_equal(np_vdb_module_get(f->context, &module), NEPH_OK);
  assert_int_equal(module->write(f->path, &output, 1, false, 1, NULL, NULL, &error), NEPH_OK);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  assert_non_null(search_rule(check, "values.half_overflow").remedy);
  neph_check_destroy(check);
  np_sparse_grid_clear(&grid);
}

static void backgrounds_and_emptiness_are_found(void **state) {
  test_fixture *f = *state;
  np_sparse_grid grid;
  neph_check *check = start(f);
  make_grid(f, "density", &grid);
  grid.background = 0.25f;
  save_one(f, &grid);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  assert_int_equal(search_rule(check, "values.background").severity, NEPH_SEVERITY_ERROR);
  np_sparse_grid_clear(&grid);
  assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
  grid.index_to_world = np_affine_identity();
  save_one(f, &grid);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  search_rule(check, "grid.empty");
  neph_check_destroy(check);
  np_sparse_grid_clear(&grid);
}

static void sizes_transforms_and_strays_are_found(void **state) {
  test_fixture *f = *state;
  static const struct {
    double diagonal[3];
    const char *rule;
  } cases[] = {
      {{0.01, 0.01, 0.01}, "size.small"}, {{1e5, 1e5, 1e5}, "size.large"}, {{-10, 10, 10}, "transform.mirrored"}};
  np_sparse_grid grid;
  make_grid(f, "density", &grid);
  neph_check *check = start(f);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = cases[i].diagonal[a];
    save_one(f, &grid);
    assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
    search_rule(check, cases[i].rule);
  }
  np_leaf *stray = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){8000, 0, 0});
  stray->active[0] = 1;
  stray->values[0] = 1.0f;
  save_one(f, &grid);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  assert_non_null(strstr(search_rule(check, "grid.stray").place, "voxel (8000, 0, 0)"));
  neph_check_destroy(check);
  np_sparse_grid_clear(&grid);
}

/* ---- The axis that points up ---- */

/* Puts a program's name in the place of the grid's creator, or with "" there into the file's metadata. */
static void save_by(test_fixture *f, const char *of_grid, const char *of_file) {
  np_sparse_grid grid;
  make_grid(f, "density", &grid);
  save_one(f, &grid);
  np_sparse_grid_clear(&grid);
  const test_file file = test_file_read(f->path);
  vdb_edit edit = {.data = file.bytes, .size = file.size};
  assert_true(vdb_edit_parse(&edit) && edit.grid_count == 1);
  for (size_t i = 0; i < edit.grids[0].entry_count; i++) {
    const vdb_entry *entry = &edit.grids[0].entries[i];
    if (entry->name.count == strlen("creator") && !memcmp(edit.data + entry->name.at, "creator", entry->name.count))
      assert_true(vdb_edit_replace_text(&edit, entry->value, of_grid));
  }
  assert_true(!of_file || vdb_edit_add_file_text(&edit, "creator", of_file));
  test_file_write(f->path, edit.data, edit.size);
  free(edit.data);
}

static bool has_rule(const neph_check *check, const char *rule) {
  bool has = false;
  for (size_t i = 0; i < neph_check_get_finding_count(check); i++)
    has = has || !strcmp(get_finding(check, i).rule, rule);
  return has;
}

/* Programs with y up name themselves in the grid or in the file; own files have z up. */
static void files_with_y_up_are_noted(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *of_grid, *of_file;
    bool is_noted;
  } cases[] = {{"nephos", NULL, false},
               {"Houdini 20.5.654/GEO_VDBTranslator", NULL, true},
               {"", "Houdini/SOP_OpenVDB_Write", true},
               {"nephos", "Houdini/SOP_OpenVDB_Write", false},
               {"Blender/Smoke", NULL, false}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_check *check = start(f);
    save_by(f, cases[i].of_grid, cases[i].of_file);
    assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
    assert_int_equal(has_rule(check, "transform.y_up"), cases[i].is_noted);
    assert_int_equal(count_bad(check), 0);
    neph_check_destroy(check);
  }
}

/* A scene that says which axis points up is not advised. */
static void scenes_that_say_up_are_not_advised(void **state) {
  test_fixture *f = *state;
  save_by(f, "Houdini 20.5", NULL);
  static const struct {
    const char *up;
    bool is_noted;
  } cases[] = {{"", true}, {", up: y", false}, {", up: z", false}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char text[1600];
    neph_scene *scene = NULL;
    neph_check *check = start(f);
    (void)snprintf(text, sizeof text, "clouds: [{name: c, vdb: \"%s\", extinction: 0.1%s}]\n", f->path, cases[i].up);
    assert_int_equal(neph_scene_load_text(f->context, text, "scene", &scene), NEPH_OK);
    assert_int_equal(neph_check_scene(check, scene, 1), NEPH_OK);
    assert_int_equal(has_rule(check, "transform.y_up"), cases[i].is_noted);
    neph_scene_destroy(scene);
    neph_check_destroy(check);
  }
}

static void several_densities_are_found(void **state) {
  test_fixture *f = *state;
  np_sparse_grid low, high;
  make_grid(f, "low", &low);
  make_grid(f, "high", &high);
  const np_sparse_grid *both[] = {&low, &high};
  save(f, f->path, both, 2, false);
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  assert_non_null(strstr(search_rule(check, "file.no_density").cause, "'low' (float), 'high' (float)"));
  neph_check_destroy(check);
  np_sparse_grid_clear(&low);
  np_sparse_grid_clear(&high);
}

/* ---- Mending ---- */

static void a_mended_copy_is_clean_and_keeps_the_rest(void **state) {
  test_fixture *f = *state;
  np_sparse_grid density, heat;
  make_grid(f, "density", &density);
  make_grid(f, "temperature", &heat);
  density.background = 0.25f;
  density.leaves[BAD_LEAF].values[BAD_VOXEL] = NAN;
  density.leaves[BAD_LEAF].values[BAD_VOXEL + 1] = -3.0f;
  heat.background = 300.0f;
  heat.leaves[0].values[0] = INFINITY;
  const np_sparse_grid *both[] = {&density, &heat};
  save(f, f->path, both, 2, false);
  char copy[1200], *text;
  (void)snprintf(copy, sizeof copy, "%s.mended.vdb", f->path);
  assert_int_equal(neph_check_mend_file(f->context, f->path, copy, &text), NEPH_OK);
  assert_string_equal(text, "  grid 'density': 2 values mended, background made 0\n"
                            "  grid 'temperature': 1 value mended\n");
  neph_text_destroy(f->context, text);
  assert_clean(f, copy);
  assert_int_equal(neph_volume_describe_file(f->context, copy, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_non_null(strstr(text, "grid 'temperature'"));
  assert_non_null(strstr(text, "nephos:hash"));
  neph_text_destroy(f->context, text);
  assert_int_equal(neph_check_mend_file(f->context, copy, copy, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "must be another");
  np_sparse_grid_clear(&density);
  np_sparse_grid_clear(&heat);
}

/* A repaired import has the values of the mended copy. Infinity is the largest of the others, 13/14, where a voxel is
 * active: what was above all that a file holds is no hole. */
static void repair_and_the_copy_agree(void **state) {
  test_fixture *f = *state;
  np_sparse_grid grid;
  make_grid(f, "density", &grid);
  grid.background = 0.25f;
  grid.leaves[3].values[100] = INFINITY; /* voxel (1, 4, 28) */
  grid.leaves[BAD_LEAF].values[BAD_VOXEL] = INFINITY;
  grid.leaves[BAD_LEAF].active[BAD_VOXEL / 64] &= ~(UINT64_C(1) << (BAD_VOXEL % 64));
  grid.leaves[2].values[9] = 0.25f;
  grid.leaves[2].active[0] &= ~(UINT64_C(1) << 9); /* the background again, in a leaf */
  save_one(f, &grid);
  char copy[1200];
  (void)snprintf(copy, sizeof copy, "%s.mended.vdb", f->path);
  assert_int_equal(neph_check_mend_file(f->context, f->path, copy, NULL), NEPH_OK);
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *repaired, *mended;
  assert_int_equal(neph_volume_load(f->context, copy, &desc, &mended), NEPH_OK);
  desc.policy = NEPH_IMPORT_REPAIR;
  assert_int_equal(neph_volume_load(f->context, f->path, &desc, &repaired), NEPH_OK);
  double at[3] = {10.0, 40.0, 380.0};
  float largest;
  neph_volume_sample(repaired, 1, at, &largest);
  assert_near((double)largest, 0.5 + 6.0 / 14.0, 1e-3); /* rounded to half */
  for (int i = -2; i < 40; i++) {
    float values[2];
    at[0] = 10.0 * i, at[1] = 7.0 * i, at[2] = 100.0 + 11.0 * i;
    neph_volume_sample(repaired, 1, at, &values[0]);
    neph_volume_sample(mended, 1, at, &values[1]);
    assert_true(values[0] == values[1]);
  }
  neph_volume_release(repaired);
  neph_volume_release(mended);
  np_sparse_grid_clear(&grid);
}

/* Distances to a surface are not cut off at 0 if the class is missing. */
static void a_level_set_without_its_class_is_kept(void **state) {
  test_fixture *f = *state;
  np_sparse_grid grid;
  make_grid(f, "density", &grid);
  grid.background = 3.0f;
  for (int n = 0; n < NP_LEAF_SIZE; n++) grid.leaves[0].values[n] = (float)n / 100.0f - 2.9f;
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  assert_int_equal(test_file_replace(f->path, "fog volume", "unknown   ", sizeof "fog volume" - 1), 1);
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  assert_int_equal(search_rule(check, "grid.unmarked_level_set").severity, NEPH_SEVERITY_ERROR);
  neph_check_destroy(check);
  char copy[1200], *text;
  (void)snprintf(copy, sizeof copy, "%s.mended.vdb", f->path);
  assert_int_equal(neph_check_mend_file(f->context, f->path, copy, &text), NEPH_OK);
  assert_string_equal(text, "  grid 'density': 0 values mended, unchanged\n");
  assert_non_null(strstr(f->log.text, "kept as it is: it is a level set"));
  neph_text_destroy(f->context, text);
  np_sparse_grid_clear(&grid);
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  load.policy = NEPH_IMPORT_REPAIR; /* would leave a shell */
  assert_int_equal(neph_volume_load(f->context, f->path, &load, &volume), NEPH_ERROR_BAD_FILE);
  load.level_set_voxels = 2.0;
  test_log_clear(&f->log);
  if (neph_volume_load(f->context, f->path, &load, &volume)) fail_msg("%s", f->log.text);
  const double inside[3] = {0.0, 0.0, 100.0}, outside[3] = {100.0, 0.0, 100.0};
  float value;
  neph_volume_sample(volume, 1, inside, &value);
  assert_true(value > 0.9f);
  neph_volume_sample(volume, 1, outside, &value);
  assert_true(value == 0.0f);
  neph_volume_release(volume);
}

/* NaN in a velocity is reported, and set to 0 in a copy. */
static void vectors_are_checked_and_mended(void **state) {
  test_fixture *f = *state;
  np_sparse_grid density, velocity[3];
  make_grid(f, "density", &density);
  for (int a = 0; a < 3; a++) make_grid(f, "vel", &velocity[a]);
  velocity[1].leaves[BAD_LEAF].values[BAD_VOXEL] = NAN;
  velocity[0].leaves[0].values[0] = -4.0f; /* any value works */
  const np_vdb_write_grid outputs[] = {{.grid = &density},
                                       {.grid = &velocity[0], .y = &velocity[1], .z = &velocity[2]}};
  assert_int_equal(np_volume_save_grids(f->context, f->path, outputs, 2, NULL), NEPH_OK);
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  const neph_finding finding = search_rule(check, "values.nan");
  assert_string_equal(finding.grid, "vel");
  assert_string_equal(finding.place, "voxel (9, 2, 3), (90, 20, 130)");
  assert_int_equal(count_bad(check), 1);
  neph_check_destroy(check);
  char copy[1200], *text;
  (void)snprintf(copy, sizeof copy, "%s.mended.vdb", f->path);
  assert_int_equal(neph_check_mend_file(f->context, f->path, copy, &text), NEPH_OK);
  assert_non_null(strstr(text, "grid 'vel': 1 value mended"));
  neph_text_destroy(f->context, text);
  assert_clean(f, copy);
  np_sparse_grid_clear(&density);
  for (int a = 0; a < 3; a++) np_sparse_grid_clear(&velocity[a]);
}

/* ---- Sequences ---- */

static void save_frame(test_fixture *f, const char *pattern, int number, const char *name, float gain) {
  np_sparse_grid grid;
  make_grid(f, name, &grid);
  for (size_t i = 0; i < grid.leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) grid.leaves[i].values[n] *= gain;
  char *path = np_frame_name_make(f->context, pattern, number);
  const np_sparse_grid *list = &grid;
  save(f, path, &list, 1, false);
  neph_text_destroy(f->context, path);
  np_sparse_grid_clear(&grid);
}

static void jumps_gaps_and_lost_grids_of_sequences_are_found(void **state) {
  test_fixture *f = *state;
  char pattern[1200];
  (void)snprintf(pattern, sizeof pattern, "%s.[a].####.vdb", f->path); /* brackets are no pattern of a shell's */
  save_frame(f, pattern, 1, "density", 1.0f);
  save_frame(f, pattern, 2, "density", 1.1f);
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, pattern), NEPH_OK);
  assert_int_equal(count_bad(check), 0);
  save_frame(f, pattern, 3, "density", 9.0f);
  save_frame(f, pattern, 6, "smoke", 9.0f);
  assert_int_equal(neph_check_file(check, pattern), NEPH_OK);
  assert_non_null(strstr(search_rule(check, "sequence.gap").cause, "numbers 4 to 5 are missing"));
  assert_non_null(strstr(search_rule(check, "sequence.sum").file, "0003.vdb"));
  search_rule(check, "sequence.maximum");
  assert_string_equal(search_rule(check, "sequence.grid_goes").grid, "density");
  assert_string_equal(search_rule(check, "sequence.grid_comes").grid, "smoke");
  neph_check_destroy(check);
}

/* A fault of every frame is one finding. */
static void a_fault_of_all_frames_is_told_once(void **state) {
  test_fixture *f = *state;
  char pattern[1200];
  (void)snprintf(pattern, sizeof pattern, "%s.b.####.vdb", f->path);
  for (int i = 1; i <= 5; i++) save_frame(f, pattern, i, "density", -1.0f);
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, pattern), NEPH_OK);
  assert_int_equal(neph_check_count(check, NEPH_SEVERITY_ERROR), 1);
  assert_int_equal(search_rule(check, "values.negative").frame_count, 5);
  neph_check_destroy(check);
}

/* Each file has its copy, under its own number. */
static void a_sequence_is_mended_file_by_file(void **state) {
  test_fixture *f = *state;
  char pattern[1200], copies[1200], *text;
  (void)snprintf(pattern, sizeof pattern, "%s.c.####.vdb", f->path);
  (void)snprintf(copies, sizeof copies, "%s.d.####.vdb", f->path);
  for (int i = 3; i <= 5; i++) save_frame(f, pattern, i, "density", i == 4 ? -1.0f : 1.0f);
  assert_int_equal(neph_check_mend_file(f->context, pattern, f->path, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "must be a sequence as well");
  assert_int_equal(neph_check_mend_file(f->context, pattern, copies, &text), NEPH_OK);
  assert_non_null(strstr(text, "d.0003.vdb:\n  grid 'density': 0 values mended, unchanged"));
  assert_non_null(strstr(text, "d.0004.vdb:\n  grid 'density': 32768 values mended"));
  neph_text_destroy(f->context, text);
  neph_check *check = start(f);
  assert_int_equal(neph_check_file(check, copies), NEPH_OK);
  assert_int_equal(neph_check_count(check, NEPH_SEVERITY_ERROR), 0);
  assert_string_equal(search_rule(check, "sequence.files").cause, "3 files, numbers 3 to 5");
  neph_check_destroy(check);
}

/* ---- Height fields and meshes ---- */

enum { SIDE = 1201 };

static int eval_terraces(unsigned column, unsigned row) { return (int)(column + row) / 20 * 20; }

static int eval_flat(unsigned column, unsigned row) { return (void)column, (void)row, 12; }

/* A void that is not marked: the lowest number of all but one. */
static int eval_spike(unsigned column, unsigned row) {
  return column == 7 && row == 5 ? -32767 : (int)(column * 3 + row) % 1000;
}

static int eval_voids(unsigned column, unsigned row) { return row < 100 ? -32768 : (int)(column + 2 * row); }

static void faults_of_heights_are_found(void **state) {
  test_fixture *f = *state;
  static const struct {
    int (*eval)(unsigned column, unsigned row);
    const char *rule;
  } cases[] = {{eval_terraces, "heights.terraces"},
               {eval_flat, "heights.flat"},
               {eval_spike, "heights.spike"},
               {eval_spike, "heights.absurd"},
               {eval_voids, "heights.voids"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    neph_check *check = start(f);
    char *path = test_hgt_write(f->folder, "N44W072.hgt", SIDE, cases[i].eval);
    assert_int_equal(neph_check_file(check, path), NEPH_OK);
    assert_int_equal(search_rule(check, cases[i].rule).severity, NEPH_SEVERITY_WARNING);
    free(path);
    neph_check_destroy(check);
  }
}

static void faults_of_meshes_are_found(void **state) {
  test_fixture *f = *state;
  char path[1200];
  neph_check *check = start(f);
  (void)snprintf(path, sizeof path, "%s.obj", f->path);
  FILE *file = fopen(path, "w");
  fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n", file);
  fclose(file);
  assert_int_equal(neph_check_file(check, path), NEPH_OK);
  if (neph_check_count(check, NEPH_SEVERITY_ERROR)) { /* a build without Assimp refuses the file */
    search_rule(check, "read");
  } else {
    assert_non_null(strstr(search_rule(check, "mesh.flat").cause, "1 of 2 triangles"));
    assert_non_null(strstr(search_rule(check, "mesh.size").cause, "2 m across"));
  }
  neph_check_destroy(check);
}

/* ---- The log ---- */

static void the_context_has_its_log_back(void **state) {
  test_fixture *f = *state;
  neph_check *check = start(f);
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, "sun: {elevation: 95 deg}\ncamera: {fov: 0}\n", "s.yaml", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_int_equal(neph_check_count(check, NEPH_SEVERITY_ERROR), 2);
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
  neph_check_destroy(check);
  assert_int_equal(neph_scene_load_text(f->context, "sun: {elevation: 95 deg}\n", "s.yaml", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "sun.elevation");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(bad_values_are_counted_and_located, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(an_overflow_of_halves_is_told_from_infinity, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(backgrounds_and_emptiness_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(sizes_transforms_and_strays_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(files_with_y_up_are_noted, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(scenes_that_say_up_are_not_advised, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(several_densities_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_mended_copy_is_clean_and_keeps_the_rest, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(repair_and_the_copy_agree, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_level_set_without_its_class_is_kept, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(vectors_are_checked_and_mended, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_sequence_is_mended_file_by_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(jumps_gaps_and_lost_grids_of_sequences_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_fault_of_all_frames_is_told_once, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(faults_of_heights_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(faults_of_meshes_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_context_has_its_log_back, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
