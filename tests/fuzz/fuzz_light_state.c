/* SPDX-License-Identifier: Apache-2.0 */
/* Light kept beside a checkpoint, on its way or found, with changed bytes and a checksum that is right: a frame resumes
 * with it. Whatever it holds, the frame gets its picture.
 *
 * The first byte of an input chooses between the two, the second cuts the end off; each six bytes that follow are two
 * of a place and four that are put there. The place counts words: of the first kilobyte where its highest bit is 0,
 * else of the whole. */
#include "fuzz_support.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <nephos/image.h>
#include <nephos/parts.h>
#include <nephos/scene.h>

#include "core/hash.h"

/* An entry's header: magic, format and size, checksum, key. */
enum { SIZE_AT = 24, SUM_AT = 32, HEADER = 112, HEAD = 2, PATCH = 6, PATCHES_MAX = 64 };

static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0, -2 km, 1200 m], look_at: [0, 0, 1600 m], fov: 50 deg, resolution: [2, 2]}\n"
    "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
    "atmosphere: none\n"
    "clouds:\n"
    "  - {name: one, bake: {preset: cumulus_humilis, seed: 7, base: 1500 m, voxel: 100 m, extent: 800 m}}\n"
    "render: {integrator: march, samples: 1, multiple_scattering: ordinates}\n";

typedef struct light {
  uint8_t *bytes;
  size_t size;
} light;

static char checkpoint[96], path[128], bad[144];
static light lights[2]; /* on its way; found */

/* ---- The picture ---- */

static bool is_light_missing(void *user, const neph_progress *progress) {
  (void)user, (void)progress;
  return access(path, F_OK) != 0;
}

static neph_result render(bool is_stopped, double interval_s) {
  neph_scene *scene;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  if (neph_scene_load_text(fuzz_get_context(), scene_text, "scene", &scene)) abort();
  if (neph_scene_get_render_desc(scene, &desc)) abort();
  desc.checkpoint_path = checkpoint;
  desc.checkpoint_interval_s = interval_s;
  desc.is_resumed = true;
  if (is_stopped) desc.progress = is_light_missing;
  const neph_result result = neph_render_image(scene, &desc, &image);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  unlink(checkpoint);
  return result;
}

static light read_light(void) {
  FILE *file = fopen(path, "rb");
  if (!file || fseek(file, 0, SEEK_END)) abort();
  light out = {.size = (size_t)ftell(file)};
  rewind(file);
  out.bytes = malloc(out.size);
  if (!out.bytes || fread(out.bytes, 1, out.size, file) != out.size || out.size <= HEADER) abort();
  fclose(file);
  return out;
}

/* A frame that is stopped early enough leaves light on its way, any other light that is found. */
static void make_first(void) {
  enum { ATTEMPTS = 20 };
  for (int i = 0; i < ATTEMPTS; i++) {
    unlink(path);
    const neph_result result = render(true, 1e-9);
    if (result == NEPH_ERROR_CANCELLED) break;
    if (result) abort();
  }
  lights[0] = read_light();
}

static void make_lights(void) {
  const char *first = fuzz_write_file("shot.npart", (const uint8_t *)"", 0);
  snprintf(checkpoint, sizeof checkpoint, "%s", first);
  snprintf(path, sizeof path, "%s.light0-0", checkpoint);
  snprintf(bad, sizeof bad, "%s.bad", path);
  unlink(checkpoint);
  make_first();
  if (render(false, 1e-9)) abort();
  lights[1] = read_light();
  unlink(path);
}

/* ---- Forging ---- */

static void patch(const light *l, uint8_t *bytes, const uint8_t *at) {
  const size_t words = (l->size - HEADER) / 4, place = (size_t)at[0] << 8 | at[1], near = words < 256 ? words : 256;
  const size_t word = place & 0x8000 ? (place & 0x7fff) * 7919 % words : place % near;
  memcpy(bytes + HEADER + 4 * word, at + 2, 4);
}

static void mend(uint8_t *bytes, size_t size) {
  const uint64_t payload = size - HEADER;
  np_hash *hash = np_hash_create(fuzz_get_context());
  memcpy(bytes + SIZE_AT, &payload, sizeof payload);
  np_hash_add(hash, bytes + HEADER, payload);
  if (np_hash_finish(hash, (char *)bytes + SUM_AT)) abort();
}

static void write_light(const uint8_t *bytes, size_t size) {
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (!lights[0].bytes) make_lights();
  if (size < HEAD) return 0;
  const light *l = &lights[data[0] & 1];
  const size_t kept = HEADER + (l->size - HEADER) * (256u - data[1]) / 256;
  uint8_t *bytes = malloc(l->size);
  if (!bytes) abort();
  memcpy(bytes, l->bytes, l->size);
  for (size_t i = 0; i < PATCHES_MAX && HEAD + (i + 1) * PATCH <= size; i++) patch(l, bytes, data + HEAD + i * PATCH);
  mend(bytes, kept);
  write_light(bytes, kept);
  free(bytes);
  const neph_result result = render(false, 1e9);
  fuzz_expect(result);
  if (result) abort();
  unlink(path);
  unlink(bad);
  return 0;
}
