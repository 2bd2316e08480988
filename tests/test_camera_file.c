/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras of glTF files: poses at whole frames, through the nodes that hold them, and in the axes of a scene. */
#include <nephos/nephos.h>

#include <stdlib.h>
#include <string.h>

#include "core/units.h"
#include "mesh/camera_file.h"
#include "scene/scene_private.h"
#include "test_meshes.h"

/* ---- Files ---- */

enum { KEYS = 3 };

/* Times, positions and rotations of keys, as a buffer has them: with `has_tangents` each value stands between two. */
typedef struct shot_keys {
  float seconds[KEYS], position[KEYS][3], rotation[KEYS][4];
} shot_keys;

static const float half_turn = 0.70710678f; /* quaternion component of a rotation by 90 deg */

/* Moves 10 m up and 20 m to the right from the origin within a second; then turns right within half a second. */
static shot_keys make_keys(void) {
  return (shot_keys){.seconds = {0.0f, 1.0f, 1.5f},
                     .position = {{0, 0, 0}, {20, 10, 0}, {20, 10, 0}},
                     .rotation = {{0, 0, 0, 1}, {0, 0, 0, 1}, {0, -half_turn, 0, half_turn}}};
}

static size_t pack(const void *values, size_t width, bool has_tangents, unsigned char *out) {
  size_t used = 0;
  for (int k = 0; k < KEYS; k++)
    for (int part = 0; part < (has_tangents ? 3 : 1); part++) {
      const bool is_value = !has_tangents || part == 1;
      if (is_value) memcpy(out + used, (const char *)values + (size_t)k * width, width);
      used += width;
    }
  return used;
}

/* A camera "shot" that moves, held by a node of another place, and one, "still", that does not. */
static const char document[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0%s]}],\"nodes\":["
    "{\"name\":\"crane\",\"translation\":[100,0,0],\"children\":[1]},{\"name\":\"shot\",\"camera\":0},"
    "{\"name\":\"still\",\"camera\":1,\"translation\":[1,2,3]}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.6,\"znear\":0.1,\"aspectRatio\":1.5}},"
    "{\"type\":\"perspective\",\"perspective\":{\"yfov\":1.0,\"znear\":0.1}}],"
    "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1,\"interpolation\":\"%s\"},"
    "{\"input\":0,\"output\":2,\"interpolation\":\"%s\"}],\"channels\":["
    "{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"translation\"}},"
    "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"rotation\"}}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"SCALAR\",\"min\":[0],\"max\":[1.5]}"
    ","
    "{\"bufferView\":1,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},"
    "{\"bufferView\":2,\"componentType\":5126,\"count\":%d,\"type\":\"VEC4\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":12},"
    "{\"buffer\":0,\"byteOffset\":12,\"byteLength\":%zu},{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}],"
    "\"buffers\":[{\"byteLength\":%zu%s%s%s}]}";

typedef struct file_kind {
  const char *interpolation;
  bool is_binary, has_second; /* a .glb; with the camera that stands still */
  const char *buffer;         /* URI of a file for the keys, which the test writes; NULL: they are in this one */
} file_kind;

static void write_number(FILE *file, size_t number) {
  const uint32_t word = (uint32_t)number;
  assert_int_equal(fwrite(&word, sizeof word, 1, file), 1);
}

/* A chunk is filled up to four bytes. */
static void write_chunk(FILE *file, const char *kind, const void *bytes, size_t size, char filling) {
  const size_t rest = (4 - size % 4) % 4;
  write_number(file, size + rest);
  (void)fwrite(kind, 4, 1, file);
  (void)fwrite(bytes, size, 1, file);
  for (size_t i = 0; i < rest; i++) (void)fputc(filling, file);
}

static void write_shot(const char *path, file_kind kind) {
  unsigned char buffer[300] = {0};
  char text[4096], base64[512];
  const shot_keys keys = make_keys();
  const bool has_tangents = !strcmp(kind.interpolation, "CUBICSPLINE");
  size_t at = pack(keys.seconds, sizeof(float), false, buffer);
  const size_t moves = pack(keys.position, sizeof *keys.position, has_tangents, buffer + at), turns_at = at + moves;
  const size_t turns = pack(keys.rotation, sizeof *keys.rotation, has_tangents, buffer + turns_at);
  const size_t all = turns_at + turns;
  test_encode_base64(buffer, all, base64);
  const char *start = kind.buffer ? ",\"uri\":\"" : ",\"uri\":\"data:application/octet-stream;base64,";
  const int values = has_tangents ? 3 * KEYS : KEYS;
  (void)snprintf(text, sizeof text, document, kind.has_second ? ",2" : "", kind.interpolation, kind.interpolation,
                 values, values, moves, turns_at, turns, all, kind.is_binary ? "" : start,
                 kind.is_binary ? ""
                 : kind.buffer  ? kind.buffer
                                : base64,
                 kind.is_binary ? "" : "\"");
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  if (kind.is_binary) {
    const size_t length = strlen(text), filled = (length + 3) / 4 * 4;
    (void)fwrite("glTF", 4, 1, file);
    write_number(file, 2);
    write_number(file, 12 + 8 + filled + 8 + (all + 3) / 4 * 4);
    write_chunk(file, "JSON", text, length, ' ');
    write_chunk(file, "BIN", buffer, all, 0);
  } else {
    (void)fputs(text, file);
  }
  (void)fclose(file);
}

static int set_up(void **state) { return test_set_up_meshes(state, 1, "shot.gltf"); }

/* ---- Poses ---- */

/* Positions are floats of ten metres: 1e-5; rotations by a quaternion of floats: 1e-6. */
static void assert_vector(np_dvec3 v, double x, double y, double z, double tolerance) {
  assert_near(v.x, x, tolerance);
  assert_near(v.y, y, tolerance);
  assert_near(v.z, z, tolerance);
}

static void assert_shot(neph_context *context, const char *path, const char *name) {
  np_camera_file file;
  assert_int_equal(np_camera_file_load(context, path, name, 10.0, &file), NEPH_OK);
  assert_int_equal(file.count, 16); /* 0 to 1.5 s */
  assert_near(file.vertical_fov_rad, 0.6, 1e-6);
  for (size_t i = 0; i < file.count; i++) assert_near(file.poses[i].frame, (double)i, 0.0);
  assert_vector(file.poses[0].at, 100.0, 0.0, 0.0, 1e-5);
  assert_vector(file.poses[5].at, 110.0, 5.0, 0.0, 1e-5);
  assert_vector(file.poses[5].forward, 0.0, 0.0, -1.0, 1e-6);
  assert_vector(file.poses[15].at, 120.0, 10.0, 0.0, 1e-5);
  assert_vector(file.poses[15].forward, 1.0, 0.0, 0.0, 1e-6);
  assert_vector(file.poses[15].up, 0.0, 1.0, 0.0, 1e-6);
  const double angle = 36.0 * NP_DEGREE; /* two fifths of the turn */
  assert_vector(file.poses[12].forward, sin(angle), 0.0, -cos(angle), 1e-6);
  np_camera_file_clear(&file);
}

/* Whatever the file says of the way between keys: Assimp passes values on alone. */
static void poses_are_those_of_whole_frames(void **state) {
  static const char *const interpolations[] = {"LINEAR", "STEP", "CUBICSPLINE"};
  test_fixture *f = test_get_meshes(state);
  for (size_t i = 0; i < sizeof interpolations / sizeof *interpolations; i++) {
    write_shot(f->path, (file_kind){.interpolation = interpolations[i]});
    assert_shot(f->context, f->path, NULL);
  }
  char *binary = test_path(f->folder, "shot.glb");
  write_shot(binary, (file_kind){.interpolation = "LINEAR", .is_binary = true, .has_second = true});
  assert_shot(f->context, binary, "shot");
  free(binary);
}

static void one_of_several_has_a_name(void **state) {
  test_fixture *f = test_get_meshes(state);
  np_camera_file file;
  write_shot(f->path, (file_kind){.interpolation = "LINEAR", .has_second = true});
  assert_int_equal(np_camera_file_load(f->context, f->path, "still", 0.0, &file), NEPH_OK);
  assert_int_equal(file.count, 1);
  assert_vector(file.poses[0].at, 1.0, 2.0, 3.0, 1e-6);
  np_camera_file_clear(&file);
  assert_int_equal(np_camera_file_load(f->context, f->path, NULL, 24.0, &file), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "2 cameras are in it: choose one by camera.motion.camera: shot, still");
  test_log_clear(&f->log);
  assert_int_equal(np_camera_file_load(f->context, f->path, "none", 24.0, &file), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "it has no camera none");
  test_log_clear(&f->log);
  assert_int_equal(np_camera_file_load(f->context, f->path, "shot", 0.0, &file), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "set frame_rate");
}

static void what_is_no_gltf_is_refused(void **state) {
  test_fixture *f = test_get_meshes(state);
  np_camera_file file;
  assert_int_equal(np_camera_file_load(f->context, f->path, NULL, 24.0, &file), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "shot.gltf");
  test_log_clear(&f->log);
  FILE *broken = fopen(f->path, "w");
  (void)fputs("{\"asset\": {\"version\": \"2.0\"", broken);
  (void)fclose(broken);
  assert_int_equal(np_camera_file_load(f->context, f->path, NULL, 24.0, &file), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "Assimp");
}

/* ---- In a scene ---- */

/* Its x is east, its y up, −z north; frame 1 is at the end of the first second of a film of one frame a second. */
static void a_scene_looks_through_it(void **state) {
  test_fixture *f = test_get_meshes(state);
  char text[512];
  neph_scene *scene;
  write_shot(f->path, (file_kind){.interpolation = "LINEAR"});
  (void)snprintf(text, sizeof text,
                 "{frame_rate: 2, camera: {resolution: [20, 10], motion: {file: \"%s\", unit: 10 m, offset: 1}}}",
                 f->path);
  assert_int_equal(neph_scene_load_text(f->context, text, "/scene.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set_frame(scene, 4), NEPH_OK);
  const double *at = scene->camera.position_m, *to = scene->camera.look_at_m;
  assert_vector(np_dvec3_make(at[0], at[1], at[2]), 1200.0, 0.0, 100.0, 1e-4);
  assert_vector(np_dvec3_make(to[0], to[1], to[2]), 2200.0, 0.0, 100.0, 2e-3);
  assert_near(scene->camera.roll_rad, 0.0, 1e-6);
  assert_near(tan(0.5 * scene->camera.fov_rad), 2.0 * tan(0.3), 1e-6);
  neph_scene_destroy(scene);
}

static void compute_hash(test_fixture *f, char out[NEPH_HASH_SIZE]) {
  char text[512];
  neph_scene *scene;
  (void)snprintf(text, sizeof text, "{frame_rate: 2, camera: {resolution: [20, 10], motion: {file: \"%s\"}}}", f->path);
  assert_int_equal(neph_scene_load_text(f->context, text, "/scene.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_render_compute_hash(scene, NULL, out), NEPH_OK);
  neph_scene_destroy(scene);
}

/* Keys that stand in a file beside it, whose name is written as a URI. */
static void a_picture_follows_from_buffers_beside_it(void **state) {
  test_fixture *f = test_get_meshes(state);
  char first[NEPH_HASH_SIZE], second[NEPH_HASH_SIZE], again[NEPH_HASH_SIZE];
  static const char *const names[][2] = {{"shot.bin", "shot.bin"}, {"a%20shot.bin", "a shot.bin"}};
  for (int i = 0; i < 2; i++) {
    unsigned char buffer[300] = {0};
    char *path = test_path(f->folder, names[i][1]);
    const shot_keys keys = make_keys();
    size_t size = pack(keys.seconds, sizeof(float), false, buffer);
    size += pack(keys.position, sizeof *keys.position, false, buffer + size);
    size += pack(keys.rotation, sizeof *keys.rotation, false, buffer + size);
    write_shot(f->path, (file_kind){.interpolation = "LINEAR", .buffer = names[i][0]});
    char *plain = test_path(f->folder, names[i][0]); /* readers that do not decode */
    test_file_write(plain, buffer, size);
    test_file_write(path, buffer, size);
    compute_hash(f, first);
    compute_hash(f, again);
    assert_string_equal(first, again);
    buffer[size - 1] ^= 1;
    test_file_write(path, buffer, size);
    compute_hash(f, second);
    assert_string_not_equal(first, second);
    free(path);
    free(plain);
  }
}

#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down_meshes)

int main(void) {
  const struct CMUnitTest tests[] = {FILE_TEST(poses_are_those_of_whole_frames), FILE_TEST(one_of_several_has_a_name),
                                     FILE_TEST(what_is_no_gltf_is_refused), FILE_TEST(a_scene_looks_through_it),
                                     FILE_TEST(a_picture_follows_from_buffers_beside_it)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
