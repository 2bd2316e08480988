/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of a given shape: distances to meshes, and bakes on spheres, curves, meshes and height maps. */
#include "test_clouds.h"

#include <nephos/image.h>

#include "cloud/bake_file.h"
#include "mesh/mesh_tree.h"
#include "core/random.h"
#include "core/units.h"

static const double ring_m = 1.0, tube_m = 0.36;

static void write_corner(FILE *file, double a, double b) {
  const double away = ring_m + tube_m * cos(b);
  (void)fprintf(file, "v %.9f %.9f %.9f\n", away * cos(a), tube_m * sin(b), away * sin(a));
}

/* A torus that stands upright where z is up, without its first `missing` faces. */
static void write_torus(const char *path, int missing) {
  enum { AROUND = 64, ACROSS = 32 };
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  for (int i = 0; i < AROUND; i++)
    for (int j = 0; j < ACROSS; j++) write_corner(file, 2 * NP_PI * i / AROUND, 2 * NP_PI * j / ACROSS);
  for (int n = missing; n < AROUND * ACROSS; n++) {
    const int i = n / ACROSS, j = n % ACROSS, right = (i + 1) % AROUND, up = (j + 1) % ACROSS;
    const int corners[4] = {i * ACROSS + j, i * ACROSS + up, right * ACROSS + up, right * ACROSS + j};
    (void)fprintf(file, "f %d %d %d %d\n", corners[3] + 1, corners[2] + 1, corners[1] + 1, corners[0] + 1);
  }
  assert_int_equal(fclose(file), 0);
}

static double compute_torus_distance(const double p[3]) { return hypot(hypot(p[0], p[2]) - ring_m, p[1]) - tube_m; }

static neph_cloud_desc make_desc(void) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.model = NEPH_CLOUD_MODEL_THERMALS;
  desc.extent_m[0] = desc.extent_m[1] = 4000;
  desc.thickness_m = 2000;
  desc.voxel_m = 50;
  return desc;
}

static int set_up(void **state) { return test_set_up(state, 2, "torus.obj"); }

static neph_cloud_desc make_torus(const test_fixture *f) {
  neph_cloud_desc desc = make_desc();
  desc.shape.mesh_file = f->path;
  desc.shape.mesh_up = NEPH_MESH_UP_Z;
  return desc;
}

static neph_cloud_desc make_curves(void) {
  static const neph_cloud_point points[5] = {
      {-1200, 0, 200, 300}, {0, 500, 900, 200}, {1200, 0, 300, 350}, {-500, -900, 300, 250}, {600, -900, 1300, 120}};
  static const size_t ends[2] = {3, 5};
  static const neph_cloud_point spheres[2] = {{0, -200, 500, 480}, {-600, 300, 800, 300}};
  neph_cloud_desc desc = make_desc();
  desc.shape.curves = (neph_cloud_points){points, 5, ends, 2};
  desc.shape.spheres = (neph_cloud_points){spheres, 2, NULL, 0};
  return desc;
}

/* ---- Trees ---- */

static neph_result load_tree(neph_context *context, const char *path, np_mesh_tree *out_tree) {
  const np_affine identity = np_affine_identity();
  np_mesh_file file;
  neph_result result = np_mesh_file_load(context, path, false, NULL, &file);
  if (result) return result;
  result = np_mesh_tree_collect(&file, &identity, out_tree);
  np_mesh_file_clear(&file);
  return result ? result : np_mesh_tree_build(out_tree);
}

/* A chord of 1/32 of a turn is 0.5 % of the tube's radius inside the circle, one of 1/64 of the ring 0.12 % of 1.36;
 * nodes beyond twice their radius, as dipoles, are wrong by less than 0.1 in all, a fifth of what would turn a sign. */
static void a_tree_knows_distance_and_inside_of_a_torus(void **state) {
  test_fixture *f = *state;
  np_mesh_tree tree;
  np_random random = np_random_start(1, 0, 0, 0, 0);
  write_torus(f->path, 0);
  assert_int_equal(load_tree(f->context, f->path, &tree), NEPH_OK);
  double worst = 0, worst_winding = 0;
  for (int i = 0; i < 20000; i++) {
    double p[3];
    for (int a = 0; a < 3; a++) p[a] = 4.0 * ((double)np_random_float(&random) - 0.5);
    const np_vec3 at = np_vec3_make((float)p[0], (float)p[1], (float)p[2]);
    const double exact = compute_torus_distance(p);
    const double found = (double)np_mesh_tree_compute_distance(&tree, at, 1e9f);
    worst = fmax(worst, fabs(found - fabs(exact)));
    const double winding = fabs((double)np_mesh_tree_compute_winding(&tree, at)); /* whichever way its faces turn */
    if (fabs(exact) > 0.005) worst_winding = fmax(worst_winding, fabs(winding - (exact < 0)));
  }
  print_message("distance within %.4f, winding number within %.4f\n", worst, worst_winding);
  assert_true(worst < 0.0036);
  assert_true(worst_winding < 0.1);
  np_mesh_tree_clear(&tree);
}

static void open_edges_are_counted(void **state) {
  test_fixture *f = *state;
  const size_t expected[3] = {0, 4, 6};
  for (int missing = 0; missing < 3; missing++) {
    np_mesh_tree tree;
    np_vec3 first;
    size_t count;
    write_torus(f->path, missing);
    assert_int_equal(load_tree(f->context, f->path, &tree), NEPH_OK);
    assert_int_equal(np_mesh_tree_count_open_edges(&tree, &count, &first), NEPH_OK);
    assert_int_equal(count, expected[missing]);
    np_mesh_tree_clear(&tree);
  }
}

/* ---- Grids ---- */

/* Trilinear between nodes at most 50 m apart on a torus whose tube is 450 m: second differences of the distance, at
 * most h²/8 over the lesser radius of curvature each way, 3 m near the surface; the mesh itself is 3 m inside. */
static void the_grid_of_a_torus_is_its_distance(void **state) {
  test_fixture *f = *state;
  const neph_cloud_desc desc = make_torus(f);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  np_cloud_model model;
  write_torus(f->path, 0);
  assert_int_equal(np_cloud_model_build(f->context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  assert_non_null(model.shape);
  const double unit_m = 0.5 * (4000 - 2 * 0.75 * 450) / (ring_m + tube_m); /* it would fit in height as well */
  const double scale_m = fmin(unit_m, (2000 - 0.45 * 450) / (2 * (ring_m + tube_m)));
  double worst = 0;
  for (int i = 0; i < 20000; i++) {
    const float at_m[3] = {3000 * (np_random_float(&random) - 0.5f), 1000 * (np_random_float(&random) - 0.5f),
                           1900 * np_random_float(&random)};
    const double p[3] = {(double)at_m[0] / scale_m, (double)at_m[1] / scale_m,
                         ((double)at_m[2] / scale_m) - (ring_m + tube_m)};
    const double exact_m = scale_m * compute_torus_distance(p);
    if (fabs(exact_m) < 100) worst = fmax(worst, fabs((double)np_shape_grid_sample(model.shape, at_m, NULL) - exact_m));
  }
  print_message("distance within %.2f m\n", worst);
  assert_true(worst < 6);
  np_cloud_model_clear(&model);
}

/* A hole of one face in 2048 is closed with a word; half of the torus is refused. */
static void small_holes_are_closed_and_open_meshes_refused(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = make_torus(f);
  np_cloud_model model;
  desc.voxel_m = 80;
  write_torus(f->path, 0);
  np_sparse_grid whole = test_bake(f->context, &desc);
  write_torus(f->path, 1);
  test_log_clear(&f->log);
  np_sparse_grid holed = test_bake(f->context, &desc);
  assert_non_null(strstr(f->log.text, "4 edges do not join two triangles"));
  assert_non_null(strstr(f->log.text, "its holes are taken as closed"));
  assert_near_relative((double)holed.leaf_count, (double)whole.leaf_count, 0.02);
  np_sparse_grid_clear(&whole);
  np_sparse_grid_clear(&holed);
  write_torus(f->path, 1024);
  test_log_clear(&f->log);
  assert_int_equal(np_cloud_model_build(f->context, &desc, 6.36e6, NULL, &model), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "is not closed: 64 edges", "close its holes");
}

/* ---- Clouds ---- */

static void threads_and_levels_give_the_same_bits(void **state) {
  test_fixture *f = *state;
  const neph_cloud_desc torus = make_torus(f), curves = make_curves();
  write_torus(f->path, 0);
  test_check_bits(2, &torus, 50);
  test_check_bits(2, &curves, 50);
}

static bool has_cloud(const np_cloud_model *model, const np_cloud_box *box) {
  float x[64], y[64], z[64], extinction[64];
  for (int n = 0; n < 64; n++) {
    x[n] = np_mixf(box->min_m[0], box->max_m[0], (float)(n / 16) / 3);
    y[n] = np_mixf(box->min_m[1], box->max_m[1], (float)(n / 4 % 4) / 3);
    z[n] = np_mixf(box->min_m[2], box->max_m[2], (float)(n % 4) / 3);
  }
  np_cloud_model_eval(model, &(np_cloud_points){64, x, y, z}, extinction);
  for (int n = 0; n < 64; n++)
    if (extinction[n] > 0) return true;
  return false;
}

/* Boxes from below the rain to above the top, and beyond the sides. */
static void check_boxes(neph_context *context, const neph_cloud_desc *desc) {
  np_random random = np_random_start(7, 0, 0, 0, 0);
  const float span_m[3] = {5000, 5000, 3500}, low_m[3] = {-2500, -2500, -1300};
  np_cloud_model model;
  int empty = 0, cloudy = 0;
  assert_int_equal(np_cloud_model_build(context, desc, 6.36e6, NULL, &model), NEPH_OK);
  for (int run = 0; run < 4000; run++) {
    np_cloud_box box;
    for (int a = 0; a < 3; a++) {
      box.min_m[a] = low_m[a] + span_m[a] * np_random_float(&random);
      box.max_m[a] = box.min_m[a] + span_m[a] * (0.003f + 0.06f * np_random_float(&random));
    }
    const bool is_cloudy = has_cloud(&model, &box), is_empty = np_cloud_model_is_empty(&model, &box);
    if (is_empty && is_cloudy) fail_msg("a box called empty holds cloud, at %d", run);
    empty += is_empty;
    cloudy += is_cloudy;
  }
  print_message("%d boxes called empty, %d hold cloud\n", empty, cloudy);
  assert_true(empty > 1000 && cloudy > 100);
  np_cloud_model_clear(&model);
}

static void no_box_called_empty_holds_cloud(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc descs[2] = {make_torus(f), make_curves()};
  write_torus(f->path, 1);
  for (int i = 0; i < 2; i++) {
    descs[i].turbulence = descs[i].erosion = descs[i].wispiness = 1;
    descs[i].precipitation = 0.8;
    check_boxes(f->context, &descs[i]);
  }
}

/* Spheres without noise: voxels inside all of them are full, as in an adiabatic parcel those above 0.4 of the thickness
 * are, and none is farther out than the largest billow. */
static void spheres_are_where_they_are_said(void **state) {
  test_fixture *f = *state;
  static const neph_cloud_point sphere[1] = {{300, -200, 900, 700}};
  neph_cloud_desc desc = make_desc();
  desc.shape.spheres = (neph_cloud_points){sphere, 1, NULL, 0};
  desc.turbulence = desc.erosion = desc.wispiness = desc.age = 0;
  np_cloud_model model;
  np_random random = np_random_start(3, 0, 0, 0, 0);
  assert_int_equal(np_cloud_model_build(f->context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  int inside = 0, outside = 0;
  for (int i = 0; i < 4000; i++) {
    const float x = 4000 * (np_random_float(&random) - 0.5f), y = 4000 * (np_random_float(&random) - 0.5f),
                z = 2000 * np_random_float(&random);
    const double away_m = sqrt(pow((double)x - 300, 2) + pow((double)y + 200, 2) + pow((double)z - 900, 2)) - 700;
    float extinction;
    np_cloud_model_eval(&model, &(np_cloud_points){1, &x, &y, &z}, &extinction);
    if (away_m < -100 && z > 800) {
      inside++;
      assert_true((double)extinction >= 0.99 * desc.extinction_per_m);
    }
    if (away_m > 450) {
      outside++;
      assert_true(extinction == 0);
    }
  }
  assert_true(inside > 60 && outside > 1000);
  np_cloud_model_clear(&model);
}

/* A ramp from west to east, 400 pixels long: tops follow it. */
static void tops_follow_a_height_map(void **state) {
  test_fixture *f = *state;
  enum { WIDTH = 100, HEIGHT = 12 }; /* a plane: any number of pixels has it */
  static const char *const names[] = {"Y"};
  neph_image *image;
  char *path = test_path(f->folder, "tops.exr");
  assert_int_equal(neph_image_create(f->context, WIDTH, HEIGHT, 1, names, &image), NEPH_OK);
  for (int i = 0; i < WIDTH * HEIGHT; i++)
    neph_image_get_channel(image, "Y")[i] = 0.2f + 0.8f * ((float)(i % WIDTH) + 0.5f) / WIDTH;
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  neph_cloud_desc desc = make_desc();
  desc.shape.height_map = path;
  desc.shape.has_height = true;
  desc.shape.height_m = 1400;
  np_cloud_model model;
  assert_int_equal(np_cloud_model_build(f->context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  const float half_m = 0.5f * (4000 - 2 * 0.75f * 450);
  for (int i = 1; i < 10; i++) {
    const float share = (float)i / 10, x_m = half_m * (2 * share - 1), top_m = 1400 * (0.2f + 0.8f * share);
    for (int side = -1; side <= 1; side += 2) {
      const float at_m[3] = {x_m, 100, top_m + 80.0f * (float)side};
      assert_int_equal(np_shape_grid_sample(model.shape, at_m, NULL) > 0, side > 0);
    }
  }
  np_cloud_model_clear(&model);
  free(path);
}

/* Rain falls from below the shape, and beside it not. */
static void rain_falls_from_a_shape(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = make_curves();
  desc.precipitation = 1;
  np_cloud_model model;
  assert_int_equal(np_cloud_model_build(f->context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  const float x[2] = {0, 1800}, y[2] = {-200, 1800}, z[2] = {-300, -300};
  float extinction[2];
  np_cloud_model_eval(&model, &(np_cloud_points){2, x, y, z}, extinction);
  assert_true(extinction[0] > 0 && extinction[1] == 0);
  np_cloud_model_clear(&model);
}

/* ---- Files ---- */

static void files_remember_their_shape(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc descs[2] = {make_torus(f), make_curves()};
  char *path = test_path(f->folder, "shape.vdb");
  write_torus(f->path, 0);
  for (int i = 0; i < 2; i++) {
    bool is_same = false, is_current = false;
    descs[i].voxel_m = 80;
    assert_int_equal(neph_cloud_bake_file(f->context, &descs[i], NULL, "density", path), NEPH_OK);
    assert_int_equal(neph_cloud_verify_file(f->context, path, NULL, NULL, &is_same), NEPH_OK);
    assert_true(is_same);
    const neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
    assert_int_equal(np_cloud_file_is_current(f->context, path, &descs[i], &bake, &is_current), NEPH_OK);
    assert_true(is_current);
    if (i == 0)
      write_torus(f->path, 1);
    else
      descs[i].shape.spheres.count = 1;
    assert_int_equal(np_cloud_file_is_current(f->context, path, &descs[i], &bake, &is_current), NEPH_OK);
    assert_false(is_current);
  }
  free(path);
}

static void refuse(test_fixture *f, const neph_cloud_desc *desc, neph_result expected, const char *one,
                   const char *other) {
  neph_volume *volume;
  test_log_clear(&f->log);
  assert_int_equal(neph_cloud_bake(f->context, desc, NULL, &volume), expected);
  assert_one_error(&f->log, one, other);
}

static void wrong_shapes_are_refused(void **state) {
  test_fixture *f = *state;
  neph_cloud_point points[2] = {{0, 0, 500, 0}, {0, 0, 900, 200}};
  const size_t ends[1] = {1};
  neph_cloud_desc desc = make_desc();
  desc.shape.spheres = (neph_cloud_points){points, 2, NULL, 0};
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "the radius of point 0 is 0 m", "must be in (0,");
  points[0].radius_m = 700;
  points[0].x_m = 1500;
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "to 2200 m in x", "enlarge extent");
  points[0].x_m = 0;
  points[1].z_m = 1900;
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "to 2100 m in height", "enlarge thickness");
  points[0].z_m = points[1].z_m = -800;
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "ends 100 m below the base", "move it up");
  desc.model = NEPH_CLOUD_MODEL_CELLS;
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "shape goes with model thermals or hero", "set model");
  desc = make_desc();
  desc.shape.curves = (neph_cloud_points){points, 1, ends, 1};
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "ends at point 1 of 1", "at least 2 points");
  desc = make_torus(f);
  desc.shape.mesh_up = NEPH_MESH_UP_FILE;
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "torus.obj", "set clouds[].bake.shape.mesh.up to y or z");
  desc = make_torus(f);
  desc.shape.mesh_file = "nowhere.obj";
  refuse(f, &desc, NEPH_ERROR_NOT_FOUND, "nowhere.obj", "");
  desc.shape.height_map = "tops.png";
  refuse(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "both mesh and height_map", "another cloud");
  desc.shape.mesh_file = NULL;
  refuse(f, &desc, NEPH_ERROR_NOT_FOUND, "tops.png", "no such file");
}

#define WITH_TORUS(test) cmocka_unit_test_setup_teardown(test, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      WITH_TORUS(a_tree_knows_distance_and_inside_of_a_torus),
      WITH_TORUS(open_edges_are_counted),
      WITH_TORUS(the_grid_of_a_torus_is_its_distance),
      WITH_TORUS(small_holes_are_closed_and_open_meshes_refused),
      WITH_TORUS(threads_and_levels_give_the_same_bits),
      WITH_TORUS(no_box_called_empty_holds_cloud),
      WITH_TORUS(spheres_are_where_they_are_said),
      WITH_TORUS(tops_follow_a_height_map),
      WITH_TORUS(rain_falls_from_a_shape),
      WITH_TORUS(files_remember_their_shape),
      WITH_TORUS(wrong_shapes_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
