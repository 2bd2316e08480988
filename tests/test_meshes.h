/* SPDX-License-Identifier: Apache-2.0 */
/* Files of meshes and cameras, written by the test itself, and fixtures for them: a build without Assimp skips. */
#ifndef NP_TEST_MESHES_H
#define NP_TEST_MESHES_H

#include "test_support.h"

#include <stdlib.h>

#include "mesh/assimp_process.h"

/* ---- Fixtures ---- */

/* Like test_set_up; *state is NULL without Assimp. */
static inline int test_set_up_meshes(void **state, unsigned thread_count, const char *name) {
  const int failed = test_set_up(state, thread_count, name);
  if (failed) return failed;
  test_fixture *f = *state;
  if (np_assimp_is_present(f->context)) return 0;
  test_tear_down(state);
  *state = NULL;
  return 0;
}

static inline int test_tear_down_meshes(void **state) { return *state ? test_tear_down(state) : 0; }

static inline test_fixture *test_get_meshes(void **state) {
  if (!*state) skip();
  return *state;
}

/* ---- glTF ---- */

/* RFC 4648, of a multiple of three bytes. */
static inline void test_encode_base64(const unsigned char *bytes, size_t count, char *out) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < count; i += 3) {
    const unsigned group = (unsigned)(bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2]);
    for (int k = 0; k < 4; k++) *out++ = digits[group >> (18 - 6 * k) & 63u];
  }
  *out = '\0';
}

typedef struct test_gltf {
  const float (*positions)[3];
  const uint16_t *corners; /* three a triangle */
  int position_count, corner_count;
  const char *buffer; /* file for them beside the glTF; NULL: in it */
  int node_count;     /* each of them in the scene */
  void (*write_node)(FILE *file, int node);
} test_gltf;

static inline void test_write_gltf_nodes(FILE *file, const test_gltf *g) {
  (void)fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"nodes\":[");
  for (int i = 0; i < g->node_count; i++) {
    if (i) (void)fputc(',', file);
    g->write_node(file, i);
  }
  (void)fprintf(file, "],\"scenes\":[{\"nodes\":[0");
  for (int i = 1; i < g->node_count; i++) (void)fprintf(file, ",%d", i);
  (void)fprintf(file, "]}],");
}

static inline void test_write_gltf_buffer(FILE *file, const char *path, const test_gltf *g, size_t positions,
                                          size_t corners) {
  unsigned char bytes[300] = {0};
  char text[404];
  assert_in_range(positions + corners, 1, sizeof bytes);
  memcpy(bytes, g->positions, positions);
  memcpy(bytes + positions, g->corners, corners);
  const size_t whole = (positions + corners + 2) / 3 * 3;
  test_encode_base64(bytes, whole, text);
  if (!g->buffer) {
    (void)fprintf(file, "\"buffers\":[{\"uri\":\"data:application/octet-stream;base64,%s\",\"byteLength\":%zu}]}", text,
                  whole);
    return;
  }
  char beside[512];
  (void)snprintf(beside, sizeof beside, "%.*s/%s", (int)(strrchr(path, '/') - path), path, g->buffer);
  test_file_write(beside, bytes, positions + corners);
  (void)fprintf(file, "\"buffers\":[{\"uri\":\"%s\",\"byteLength\":%zu}]}", g->buffer, positions + corners);
}

/* One mesh of triangles, which the nodes place. */
static inline void test_write_gltf(const char *path, const test_gltf *g) {
  const size_t positions = sizeof *g->positions * (size_t)g->position_count,
               corners = sizeof *g->corners * (size_t)g->corner_count;
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  test_write_gltf_nodes(file, g);
  (void)fprintf(file,
                "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"accessors\":["
                "{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},"
                "{\"bufferView\":1,\"componentType\":5123,\"count\":%d,\"type\":\"SCALAR\"}],\"bufferViews\":["
                "{\"buffer\":0,\"byteLength\":%zu},{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}],",
                g->position_count, g->corner_count, positions, positions, corners);
  test_write_gltf_buffer(file, path, g, positions, corners);
  assert_int_equal(fclose(file), 0);
}

#endif
