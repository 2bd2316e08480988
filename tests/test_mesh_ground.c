/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes as ground: known triangles, the same ground as mesh and as height field, places of one mesh, and files that
 * are refused. */
#include <nephos/nephos.h>

#include <stdlib.h>

#include "core/units.h"
#include "mesh/mesh_file.h"
#include "terrain/terrain_private.h"
#include "terrain/terrain_source.h"
#include "test_meshes.h"

static int set_up(void **state) { return test_set_up_meshes(state, 2, "ground.obj"); }

static void write_text(const char *path, const char *text) {
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  assert_true(fputs(text, file) >= 0);
  assert_int_equal(fclose(file), 0);
}

static neph_terrain *load(test_fixture *f, const neph_mesh_desc *mesh) {
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain *terrain = NULL;
  desc.mesh_file = f->path;
  desc.mesh = mesh;
  assert_int_equal(neph_terrain_load_mesh(f->context, &desc, &terrain), NEPH_OK);
  return terrain;
}

static const neph_mesh_desc z_up = {.struct_size = sizeof z_up, .up = NEPH_MESH_UP_Z, .unit_m = 1.0};

static const double above_m = 9e3;

static np_terrain_hit hit_below(const neph_terrain *terrain, double x, double y) {
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(terrain, np_dvec3_make(x, y, above_m), np_vec3_make(0, 0, -1), INFINITY, &hit));
  return hit;
}

/* ---- Places ---- */

/* Two of the four triangles of a square about its middle, at 7: north and south. */
static const char bow_tie[] = "v -10 -10 7\nv 10 -10 7\nv 10 10 7\nv -10 10 7\nv 0 0 7\nf 1 2 5\nf 3 4 5\n";

static void both_sides_are_ground_and_holes_are_open(void **state) {
  test_fixture *f = test_get_meshes(state);
  write_text(f->path, bow_tie);
  neph_terrain *terrain = load(f, &z_up);
  np_terrain_hit hit = hit_below(terrain, 1.0, 5.0);
  assert_near(hit.distance, 8993.0, 1e-9); /* all numbers are whole */
  assert_near(hit.normal.z, 1.0, 1e-6);
  assert_true(np_terrain_intersect(terrain, np_dvec3_make(1, 5, 0), np_vec3_make(0, 0, 1), INFINITY, &hit));
  assert_near(hit.distance, 7.0, 1e-9);
  assert_near(hit.normal.z, -1.0, 1e-6);
  assert_false(np_terrain_intersect(terrain, np_dvec3_make(5, 1, 9), np_vec3_make(0, 0, -1), INFINITY, &hit));
  assert_near(neph_terrain_get_elevation_m(terrain, 1.0, 5.0), 7.0, 1e-5); /* (1² + 5²)/2R */
  assert_near(neph_terrain_get_elevation_m(terrain, 5.0, 1.0), 0.0, 0.0);
  neph_terrain_release(terrain);
}

/* A point of the file, [1, 2, −3], of a triangle around it. */
static void axes_units_and_position_are_as_described(void **state) {
  test_fixture *f = test_get_meshes(state);
  write_text(f->path, "v 0 2 -4\nv 2 2 -4\nv 1 2 -1\nf 1 2 3\n");
  neph_mesh_desc desc = NEPH_MESH_DESC_DEFAULT;
  desc.up = NEPH_MESH_UP_Y;
  desc.unit_m = 100.0;
  neph_terrain *terrain = load(f, &desc);
  assert_near(above_m - hit_below(terrain, 100.0, 300.0).distance, 200.0, 1e-4); /* floats of 300: 3e-5 */
  neph_terrain_release(terrain);
  desc.rotation_rad = 0.5 * NP_PI;
  terrain = load(f, &desc);
  assert_near(above_m - hit_below(terrain, -300.0, 100.0).distance, 200.0, 1e-4);
  neph_terrain_release(terrain);
  const double heights[] = {
      [NEPH_MESH_PIVOT_BASE] = 50.0, [NEPH_MESH_PIVOT_CENTER] = 50.0, [NEPH_MESH_PIVOT_ORIGIN] = 250.0};
  desc.rotation_rad = 0.0;
  desc.has_position = true;
  desc.position_m[2] = 50.0;
  for (unsigned pivot = 0; pivot <= NEPH_MESH_PIVOT_ORIGIN; pivot++) {
    desc.pivot = (neph_mesh_pivot)pivot;
    terrain = load(f, &desc);
    const double x = pivot == NEPH_MESH_PIVOT_ORIGIN ? 100.0 : 0.0, y = pivot == NEPH_MESH_PIVOT_ORIGIN ? 300.0 : 0.0;
    assert_near(above_m - hit_below(terrain, x, y).distance, heights[pivot], 1e-4);
    neph_terrain_release(terrain);
  }
}

/* An L of one polygon, in either sense: its notch is open. Vertices that faces share are stored once. */
static void polygons_are_cut_into_triangles(void **state) {
  static const char *const faces[] = {"f 1 2 3 4 5 6\n", "f 6 5 4 3 2 1\n", "f 4 3 2 1 6 5\n"};
  test_fixture *f = test_get_meshes(state);
  for (size_t i = 0; i < sizeof faces / sizeof *faces; i++) {
    char text[200];
    np_mesh_file file;
    (void)snprintf(text, sizeof text, "v 0 0 1\nv 4 0 1\nv 4 1 1\nv 1 1 1\nv 1 4 1\nv 0 4 1\n%s", faces[i]);
    write_text(f->path, text);
    assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &file), NEPH_OK);
    assert_int_equal(file.meshes[0].triangle_count, 4);
    assert_int_equal(file.meshes[0].vertex_count, 6);
    np_mesh_file_clear(&file);
    neph_terrain *terrain = load(f, &z_up);
    np_terrain_hit hit;
    assert_near(hit_below(terrain, 3.5, 0.5).distance, above_m - 1.0, 1e-9);
    assert_near(hit_below(terrain, 0.5, 3.5).distance, above_m - 1.0, 1e-9);
    assert_false(np_terrain_intersect(terrain, np_dvec3_make(1.5, 1.5, 9), np_vec3_make(0, 0, -1), INFINITY, &hit));
    neph_terrain_release(terrain);
  }
}

/* ---- Beside a height field ---- */

/* The triangles of a height field, about each sample: where rays meet the one they meet the other. */
static void write_field(const char *path, const neph_terrain *ground) {
  const np_heightfield *field = np_terrain_get_field(ground);
  const np_globe globe = np_globe_make(6360e3, 0.0, 0.0);
  const unsigned width = field->width;
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  for (unsigned row = 0; row < field->height; row++)
    for (unsigned column = 0; column < width; column++) {
      const np_dvec3 p = np_heightfield_to_world(field, &globe, (np_field_position){column, row},
                                                 (double)field->elevation_m[(size_t)row * width + column]);
      (void)fprintf(file, "v %.9g %.9g %.9g\n", p.x, p.y, p.z);
    }
  for (unsigned row = 0; row + 1 < field->height; row++)
    for (unsigned column = 0; column + 1 < width; column++) {
      const unsigned a = row * width + column + 1;
      (void)fprintf(file, "f %u %u %u\nf %u %u %u\n", a, a + 1, a + width, a + width + 1, a + width, a + 1);
    }
  assert_int_equal(fclose(file), 0);
}

static neph_terrain *make_ridges(test_fixture *f, const char *mesh_file, const neph_mesh_desc *mesh) {
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain *terrain = NULL;
  ridges.sample_count = 65;
  desc.edge = NEPH_TERRAIN_EDGE_FADE;
  desc.mesh_file = mesh_file;
  desc.mesh = mesh;
  assert_int_equal(neph_terrain_create_ridges(f->context, &ridges, &desc, &terrain), NEPH_OK);
  return terrain;
}

static double get_noise(unsigned i) { return fmod((i + 1) * 0.61803398874989485, 1.0); }

static void a_mesh_is_met_where_its_height_field_is(void **state) {
  test_fixture *f = test_get_meshes(state);
  neph_terrain *field = make_ridges(f, NULL, NULL);
  write_field(f->path, field);
  neph_terrain *mesh = load(f, &z_up);
  for (unsigned i = 0; i < 2000; i++) {
    const np_dvec3 from = np_dvec3_make(2e4 * (get_noise(3 * i) - 0.5), 2e4 * (get_noise(5 * i) - 0.5), 5e3);
    const np_vec3 towards =
        np_vec3_normalize(np_vec3_make((float)get_noise(7 * i) - 0.5f, (float)get_noise(11 * i) - 0.5f, -1.0f));
    np_terrain_hit a, b;
    const bool is_met = np_terrain_intersect(field, from, towards, INFINITY, &a);
    assert_int_equal(np_terrain_intersect(mesh, from, towards, INFINITY, &b), is_met);
    /* Vertices are floats up to 15 km from the anchor, 5e-4 m each, in the file once more; slopes reach 60°. */
    if (is_met) assert_near(b.distance, a.distance, 5e-3);
    if (is_met) assert_near(np_vec3_dot(a.facet, b.facet), 1.0, 1e-4);
    if (is_met) assert_true(np_vec3_dot(a.normal, b.normal) > 0.97f); /* means over neighbours, in different ways */
  }
  neph_terrain_release(field);
  neph_terrain_release(mesh);
}

/* A table over the mountains is met from above, and the mountains beside it. */
static void a_mesh_stands_on_a_height_field(void **state) {
  test_fixture *f = test_get_meshes(state);
  write_text(f->path, "v -1000 -1000 3000\nv 1000 -1000 3000\nv 1000 1000 3000\nv -1000 1000 3000\nf 1 2 3 4\n");
  neph_terrain *field = make_ridges(f, NULL, NULL), *both = make_ridges(f, f->path, &z_up);
  assert_true(hit_below(both, 10.0, 20.0).is_of_mesh);
  assert_near(hit_below(both, 10.0, 20.0).distance, 6000.0, 1e-6);
  assert_false(hit_below(both, 5010.0, 20.0).is_of_mesh);
  assert_near(hit_below(both, 5010.0, 20.0).distance, hit_below(field, 5010.0, 20.0).distance, 0.0);
  assert_true(np_terrain_covers(both, 0.0, 0.0));
  assert_true(np_terrain_is_occluded(both, np_dvec3_make(0, 0, 2900), np_vec3_make(0, 0, 1), INFINITY));
  neph_terrain_release(field);
  neph_terrain_release(both);
}

/* ---- Far away ---- */

/* A tilted plane 200 km wide: from a hit lifted off by NP_TERRAIN_LIFT_M no ray meets it again, and hits lie on the
 * plane through its float vertices. z = x/20 + y/50. */
static void hits_are_exact_at_a_hundred_kilometres(void **state) {
  enum { SIDE = 21 };
  test_fixture *f = test_get_meshes(state);
  FILE *file = fopen(f->path, "w");
  assert_non_null(file);
  for (int r = 0; r < SIDE; r++)
    for (int c = 0; c < SIDE; c++) {
      const double x = 1e4 * (c - SIDE / 2) + 0.1, y = 1e4 * (r - SIDE / 2) + 0.1;
      (void)fprintf(file, "v %.3f %.3f %.4f\n", x, y, x / 20.0 + y / 50.0);
    }
  for (int r = 0; r + 1 < SIDE; r++)
    for (int c = 0; c + 1 < SIDE; c++) {
      const int a = r * SIDE + c + 1;
      (void)fprintf(file, "f %d %d %d %d\n", a, a + 1, a + SIDE + 1, a + SIDE);
    }
  assert_int_equal(fclose(file), 0);
  neph_terrain *terrain = load(f, &z_up);
  for (unsigned i = 0; i < 4000; i++) {
    const double x = 1.9e5 * (get_noise(2 * i) - 0.5), y = 1.9e5 * (get_noise(3 * i) - 0.5);
    const double z = x / 20.0 + y / 50.0;
    const np_terrain_hit hit = hit_below(terrain, x, y);
    const np_dvec3 at = np_dvec3_make(x, y, above_m - hit.distance);
    assert_near(at.z, z, 0.01); /* two float roundings at 1e5 on a slope of 1/20 in the file and to the anchor */
    const np_dvec3 lifted = np_dvec3_along(at, hit.normal, NP_TERRAIN_LIFT_M);
    const np_vec3 along = np_vec3_normalize(np_vec3_make(1.0f, (float)get_noise(i) - 0.5f, 0.055f));
    assert_false(np_terrain_is_occluded(terrain, lifted, along, 1e6) && along.z > 0.0501f + along.y * 0.02f);
  }
  neph_terrain_release(terrain);
}

/* ---- One mesh, many places ---- */

enum { SIDE = 30 };

/* In a grid 10 m apart, each scaled. */
static void write_place(FILE *file, int node) {
  (void)fprintf(file, "{\"mesh\":0,\"translation\":[%d,%d,%d],\"scale\":[%d,1,2]}", 10 * (node % SIDE), node,
                -10 * (node / SIDE), 1 + node % 3);
}

/* A square of a metre, y up. */
static void write_places(const char *path) {
  static const float square[4][3] = {{-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0, -0.5f}, {-0.5f, 0, -0.5f}};
  static const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
  test_write_gltf(path, &(const test_gltf){square, corners, 4, 6, "places.bin", SIDE * SIDE, write_place});
}

static void a_mesh_is_stored_once_for_all_places(void **state) {
  test_fixture *f = test_get_meshes(state);
  free(f->path);
  f->path = test_path(f->folder, "places.gltf");
  write_places(f->path);
  np_mesh_file file;
  assert_int_equal(np_mesh_file_load(f->context, f->path, true, NULL, &file), NEPH_OK);
  assert_int_equal(file.mesh_count, 1);
  assert_int_equal(file.place_count, SIDE * SIDE);
  np_mesh_file_clear(&file);
  neph_terrain *terrain = load(f, NULL);
  for (int i = 0; i < SIDE * SIDE; i++) {
    const double x = 10.0 * (i % SIDE), y = 10.0 * (i / SIDE), half = 0.5 * (1 + i % 3);
    const np_terrain_hit hit = hit_below(terrain, x + 0.9 * half, y + 0.9);
    assert_near(above_m - hit.distance, i, 1e-4); /* floats of 900 */
    assert_near(hit.normal.z, 1.0, 1e-6);
    np_terrain_hit missed;
    assert_false(np_terrain_intersect(terrain, np_dvec3_make(x + 1.1 * half, y, 9e3), np_vec3_make(0, 0, -1), INFINITY,
                                      &missed));
  }
  neph_terrain_release(terrain);
}

/* ---- Pictures ---- */

static neph_image *render(test_fixture *f, const char *integrator, const char *terrain) {
  char text[900];
  (void)snprintf(text, sizeof text,
                 "version: 1\n"
                 "camera: {position: [0 m, 0 m, 60 m], look_at: [0, 1 m, 0], fov: 50 deg, resolution: [16, 9]}\n"
                 "sun: {elevation: 30 deg, azimuth: 90 deg}\n"
                 "terrain: %s\n"
                 "render: {integrator: %s, samples: 64}\n"
                 "output: {aovs: [depth], pixel_type: float}\n",
                 terrain, integrator);
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  char *path = test_path(f->folder, "scene.yaml");
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.seed", "3"), NEPH_OK); /* the scene is rebuilt */
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  free(path);
  return image;
}

static double compute_mean(const neph_image *image, const char *channel) {
  const float *values = neph_image_get_channel((neph_image *)(uintptr_t)image, channel);
  assert_non_null(values);
  double sum = 0.0;
  for (size_t i = 0; i < 16 * 9; i++) sum += (double)values[i] / (16 * 9);
  return sum;
}

/* Level ground as a mesh half a metre above the sphere looks as the sphere does, whatever its normals. */
static void level_ground_looks_like_the_sphere(void **state) {
  static const char *const integrators[] = {"march", "path"}, *const normals[] = {"smooth", "flat"},
                           *const ups[] = {"z", "y"};
  test_fixture *f = test_get_meshes(state);
  for (int i = 0; i < 2; i++) {
    neph_image *sphere = render(f, integrators[i], "{ridges: {relief: 0 m, samples: 65}, albedo: 0.4}");
    for (int n = 0; n < 2; n++) {
      char terrain[200];
      write_text(f->path, n ? "v -500 0.5 -500\nv 500 0.5 -500\nv 500 0.5 500\nv -500 0.5 500\nf 1 4 3 2\n"
                            : "v -500 -500 0.5\nv 500 -500 0.5\nv 500 500 0.5\nv -500 500 0.5\nf 1 2 3 4\n");
      (void)snprintf(terrain, sizeof terrain, "{mesh: {file: ground.obj, up: %s, normals: %s}, albedo: 0.4}", ups[n],
                     normals[n]);
      neph_image *mesh = render(f, integrators[i], terrain);
      assert_near(compute_mean(sphere, "Z") - compute_mean(mesh, "Z"), 0.5, 0.02); /* depth to the facets of ridges */
      /* Half a metre of air; paths of 64 samples with one noise: measured 1e-4. */
      assert_near_relative(compute_mean(mesh, "G"), compute_mean(sphere, "G"), i ? 0.01 : 1e-3);
      neph_image_destroy(mesh);
    }
    neph_image_destroy(sphere);
  }
}

/* ---- Refusals ---- */

static neph_result try_load(test_fixture *f, const char *text, const neph_mesh_desc *mesh) {
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain *terrain = NULL;
  write_text(f->path, text);
  desc.mesh_file = f->path;
  desc.mesh = mesh;
  const neph_result result = neph_terrain_load_mesh(f->context, &desc, &terrain);
  assert_null(terrain);
  return result;
}

static void bad_files_are_refused(void **state) {
  test_fixture *f = test_get_meshes(state);
  assert_int_equal(try_load(f, "", &z_up), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "ground.obj", "no triangle");
  assert_int_equal(try_load(f, "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n", &z_up), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "ground.obj", "no triangle");
  assert_int_equal(try_load(f, "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", &z_up), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "vertex", "finite");
  assert_int_equal(try_load(f, "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", &z_up), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "one point");
  assert_int_equal(try_load(f, "v 0 0 0\nv 4e6 0 0\nv 0 5e6 0\nf 1 2 3\n", &z_up), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "5000 km", "terrain.mesh.position", "terrain.mesh.unit");
  static const char *const headers[][2] = {
      {"ply\nformat ascii 1.0\nelement vertex 1000\nend_header\n0 0 0\n", "1000 elements 'vertex'"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nl ?t x\nend_header\n0 0 0\n", "line 4"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nend_header0 0 0\n", "no line 'end_header'"}};
  for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
    assert_int_equal(try_load(f, headers[i][0], &z_up), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "ground.obj", headers[i][1]);
  }
  assert_int_equal(try_load(f, bow_tie, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "terrain.mesh.up to y or z");
  char *path = f->path;
  f->path = test_path(f->folder, "ground.off");
  assert_int_equal(try_load(f, "OFF\n0 0 0\n", &z_up), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, "ground.off", ".glb");
  free(f->path);
  f->path = path;
  neph_mesh_desc desc = z_up;
  desc.unit_m = 0.0;
  assert_int_equal(try_load(f, bow_tie, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "terrain.mesh.unit");
}

static void doubtful_meshes_draw_warnings(void **state) {
  test_fixture *f = test_get_meshes(state);
  write_text(f->path, "v 0 0 -3\nv 9 0 -3\nv 0 9 5\nf 1 2 3\n");
  neph_terrain_release(load(f, &z_up));
  assert_one_warning(&f->log, "3 m below sea level", "terrain.mesh.position");
  write_text(f->path, "v 0 0 3\nv 0.09 0 3\nv 0 0.09 3\nf 1 2 3\n");
  neph_terrain_release(load(f, &z_up));
  assert_one_warning(&f->log, "0.09 m wide", "terrain.mesh.unit");
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down_meshes)

/* Without a run of Assimp: a GLB that is cut short, and vertices alone. */
static void headers_refuse_files_without_triangles(void **state) {
  test_fixture *f = test_get_meshes(state);
  static const char glb[] = "glTF\2\1\1\1\377\1\1\1JSON";
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  char *path = test_path(f->folder, "ground.glb");
  desc.mesh = &z_up;
  desc.mesh_file = path;
  write_text(path, glb);
  assert_int_equal(np_terrain_check_mesh(f->context, &desc), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "ground.glb", "truncated or damaged");
  desc.mesh_file = f->path;
  write_text(f->path, "# of\nv 0 0 0\nv 1 0 0\nvn 0 0 1\nl 1 2\n");
  assert_int_equal(np_terrain_check_mesh(f->context, &desc), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "ground.obj", "no triangle");
  write_text(f->path, bow_tie);
  assert_int_equal(np_terrain_check_mesh(f->context, &desc), NEPH_OK);
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(both_sides_are_ground_and_holes_are_open),
      TEST(axes_units_and_position_are_as_described),
      TEST(polygons_are_cut_into_triangles),
      TEST(a_mesh_is_met_where_its_height_field_is),
      TEST(a_mesh_stands_on_a_height_field),
      TEST(hits_are_exact_at_a_hundred_kilometres),
      TEST(a_mesh_is_stored_once_for_all_places),
      TEST(level_ground_looks_like_the_sphere),
      TEST(bad_files_are_refused),
      TEST(headers_refuse_files_without_triangles),
      TEST(doubtful_meshes_draw_warnings),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
