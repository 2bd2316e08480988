/* SPDX-License-Identifier: Apache-2.0 */
/* The file of a part with checksums that are right: merged alone, or, where the first byte is odd, the checkpoint that
 * a frame resumes from, whose hash it then has. No checkpoint keeps a frame from its picture. */
#include "fuzz_support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <nephos/parts.h>
#include <nephos/scene.h>

#include "../part_forge.h"

enum { FIELDS_HASH = 4 }; /* fields: header, version's length and text, hash's length; then its text */

static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0 m, 0 m, 500 m], look_at: [0 m, 1 km, 700 m], resolution: [4, 3]}\n"
    "sun: {irradiance: 0}\n"
    "atmosphere: none\n"
    "environment: {radiance: 0.5, planet: none}\n"
    "render: {samples: 2, integrator: march, multiple_scattering: octaves}\n"
    "output: {aovs: [position, variance, cryptomatte]}\n";

static neph_scene *get_scene(void) {
  static neph_scene *scene;
  if (!scene && neph_scene_load_text(fuzz_get_context(), scene_text, "fuzz.yaml", &scene)) abort();
  return scene;
}

static void merge(const char *path) {
  neph_image *image;
  fuzz_expect(neph_parts_merge(fuzz_get_context(), &path, 1, NULL, &image));
  neph_image_destroy(image);
}

/* Puts the hash of the scene in its place, where there is one. */
static void set_hash(uint8_t *bytes, size_t size) {
  static char hash[NEPH_HASH_SIZE];
  part_field fields[PART_FIELDS_MAX];
  if (!*hash && neph_render_compute_hash(get_scene(), NULL, hash)) abort();
  if (part_forge_list(bytes, size, fields) <= FIELDS_HASH || fields[FIELDS_HASH].size != NEPH_HASH_SIZE - 1) return;
  memcpy(bytes + fields[FIELDS_HASH].at, hash, NEPH_HASH_SIZE - 1);
}

static void resume(const char *path) {
  char bad[128];
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  if (neph_scene_get_render_desc(get_scene(), &desc)) abort();
  desc.checkpoint_path = path;
  desc.is_resumed = true;
  const neph_result result = neph_render_image(get_scene(), &desc, &image);
  fuzz_expect(result);
  if (result) abort();
  neph_image_destroy(image);
  snprintf(bad, sizeof bad, "%s.bad", path);
  unlink(bad);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 2) return 0;
  uint8_t *bytes = malloc(size);
  if (!bytes) return 0;
  memcpy(bytes, data + 1, size - 1);
  if (data[0] & 1) set_hash(bytes, size - 1);
  part_forge_mend(fuzz_get_context(), bytes, size - 1);
  const char *path = fuzz_write_file("shot.npart", bytes, size - 1);
  if (data[0] & 1)
    resume(path);
  else
    merge(path);
  free(bytes);
  return 0;
}
