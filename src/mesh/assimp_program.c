/* SPDX-License-Identifier: Apache-2.0 */
/* The program nephos_assimp: reads one file by Assimp, and writes the records of assimp_stream.h to its output. It
 * limits its memory and time by the size of the files that it opens, and exits without freeing memory. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/mapped_bytes.h"
#include "mesh/assimp_reader.h"

/* ---- Limits ---- */

/* Inherited limits, which are never raised. */
typedef struct inherited_limit {
  bool is_known;
  struct rlimit limit;
} inherited_limit;

static void set_limit(int resource, inherited_limit *inherited, uint64_t wanted) {
  if (!inherited->is_known && getrlimit((__rlimit_resource_t)resource, &inherited->limit)) return;
  inherited->is_known = true;
  struct rlimit limit = inherited->limit;
  if (wanted < limit.rlim_cur) limit.rlim_cur = wanted; /* RLIM_INFINITY is the largest number */
  (void)setrlimit((__rlimit_resource_t)resource, &limit);
}

/* Adds a file's size to the limits. */
static void note_bytes(uint64_t bytes) {
  static uint64_t opened_bytes, mapped_bytes;
  static inherited_limit room, time;
  if (!mapped_bytes) mapped_bytes = np_mapped_bytes_get();
  opened_bytes += bytes;
  set_limit(RLIMIT_AS, &room, mapped_bytes + NP_ASSIMP_ROOM_BYTES + NP_ASSIMP_ROOM_FACTOR * opened_bytes);
  set_limit(RLIMIT_CPU, &time, NP_ASSIMP_TIME_S + opened_bytes / NP_ASSIMP_TIME_BYTES_PER_S);
}

/* ---- Answers ---- */

static void put(const void *bytes, size_t size, size_t count) { (void)fwrite(bytes, size, count, stdout); }

static void count_place(void *user, const np_assimp_place *place) {
  (void)place;
  ++*(uint64_t *)user;
}

static void put_place(void *user, const np_assimp_place *place) {
  (void)user;
  put(place, sizeof *place, 1);
}

static void put_triangles(void *user, const uint32_t *vertices, size_t count) {
  (void)user;
  put(vertices, sizeof *vertices, count);
}

static void put_mesh(const np_assimp_scene *scene, size_t index) {
  np_assimp_mesh mesh;
  np_assimp_describe_mesh(scene, index, &mesh);
  put(&mesh, sizeof mesh, 1);
  if (!mesh.triangle_count) return;
  put(np_assimp_get_positions(scene, index), 3 * sizeof(float), mesh.vertex_count);
  if (mesh.has_normals) put(np_assimp_get_normals(scene, index), 3 * sizeof(float), mesh.vertex_count);
  np_assimp_visit_faces(scene, index, put_triangles, NULL);
}

static void put_meshes(const np_assimp_scene *scene, char **words) {
  (void)words;
  np_assimp_counts counts = {np_assimp_count_meshes(scene), 0};
  np_assimp_visit_places(scene, count_place, &counts.place_count);
  put(&counts, sizeof counts, 1);
  for (size_t i = 0; i < counts.mesh_count; i++) put_mesh(scene, i);
  np_assimp_visit_places(scene, put_place, NULL);
}

static void put_cameras(const np_assimp_scene *scene, char **words) {
  (void)words;
  const uint64_t count = np_assimp_count_cameras(scene);
  put(&count, sizeof count, 1);
  for (size_t i = 0; i < count; i++) {
    np_assimp_camera camera;
    np_assimp_describe_camera(scene, i, &camera);
    put(&camera, sizeof camera, 1);
  }
}

static void put_poses(const np_assimp_scene *scene, char **words) {
  const size_t camera = strtoull(words[0], NULL, 10), count = strtoull(words[2], NULL, 10);
  const double first = strtod(words[1], NULL), rate = strtod(words[3], NULL);
  for (size_t i = 0; camera < np_assimp_count_cameras(scene) && i < count; i++) {
    np_assimp_pose pose;
    np_assimp_get_pose(scene, camera, (first + (double)i) / rate, &pose);
    put(&pose, sizeof pose, 1);
  }
}

/* ---- Program ---- */

static const struct {
  const char *word;
  int word_count; /* number of arguments after it */
  void (*put)(const np_assimp_scene *scene, char **words);
} requests[] = {{"meshes", 0, put_meshes}, {"cameras", 0, put_cameras}, {"poses", 4, put_poses}};

static void answer(const char *path, size_t request, char **words) {
  const char *message = "";
  note_bytes(0);
  const np_assimp_scene *scene = np_assimp_open(path, note_bytes, &message);
  np_assimp_start start = {.version = NP_ASSIMP_STREAM_VERSION};
  if (!scene) start.message_length = (uint32_t)strnlen(message, NP_ASSIMP_MESSAGE_BYTES - 1);
  put(&start, sizeof start, 1);
  if (scene)
    requests[request].put(scene, words);
  else
    put(message, 1, start.message_length);
}

int main(int count, char **words) {
  enum { PATH = 1, REQUEST, FIRST_BEHIND };
  inherited_limit core = {0};
  set_limit(RLIMIT_CORE, &core, 0);
  for (size_t i = 0; count > REQUEST && i < sizeof requests / sizeof *requests; i++)
    if (!strcmp(words[REQUEST], requests[i].word) && count == FIRST_BEHIND + requests[i].word_count) {
      answer(words[PATH], i, words + FIRST_BEHIND);
      _exit(fflush(stdout) ? EXIT_FAILURE : EXIT_SUCCESS);
    }
  (void)fprintf(stderr, "nephos_assimp: reads meshes and cameras for libnephos, and is not run by hand\n");
  return EXIT_FAILURE;
}
