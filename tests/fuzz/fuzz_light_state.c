/* SPDX-License-Identifier: Apache-2.0 */
/* Light beside a checkpoint, still being solved for or solved, with changed bytes and a checksum that is right: a frame
 * resumes with it. Whatever the light holds, the frame gets its picture.
 *
 * The first byte of an input chooses the light, the second cuts its end off; each six bytes that follow are two of a
 * place and four that are put there. The place counts words: of the first kilobyte where its highest bit is 0, else of
 * the whole. */
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

enum { STATES_MAX = 256, CHOSEN = 8, LIGHTS = CHOSEN + 1 };

static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0, -2 km, 1200 m], look_at: [0, 0, 1600 m], fov: 50 deg, resolution: [2, 2]}\n"
    "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
    "atmosphere: none\n"
    "environment: {radiance: [0.01, 0.02, 0.03]}\n"
    "clouds:\n"
    "  - {name: one, bake: {preset: cumulus_humilis, seed: 7, base: 1500 m, voxel: 100 m, extent: 800 m}}\n"
    "render: {integrator: march, samples: 1, multiple_scattering: ordinates}\n";

typedef struct light {
  uint8_t *bytes;
  size_t size;
} light;

static char folder[] = "/tmp/nephos-fuzz-light-XXXXXX", checkpoint[64], path[80];
static neph_context *context;
static unsigned error_count, state_count;
static light states[STATES_MAX]; /* states of the solution, in the order of its steps */
static light lights[LIGHTS];     /* a few of them, and the solution last */

/* ---- Light that is kept ---- */

static light read_light(void) {
  FILE *file = fopen(path, "rb");
  if (!file || fseek(file, 0, SEEK_END)) abort();
  light out = {.size = (size_t)ftell(file)};
  rewind(file);
  out.bytes = malloc(out.size);
  if (!out.bytes || out.size <= HEADER || fread(out.bytes, 1, out.size, file) != out.size) abort();
  fclose(file);
  return out;
}

/* Each state is replaced by the next: a copy is taken once it is written. */
static void take_message(void *user, neph_log_level level, const char *message) {
  (void)user;
  if (strchr(message, '\n')) abort();
  error_count += level == NEPH_LOG_ERROR;
  if (!strstr(message, "checkpoint written, at step") || lights[0].bytes) return;
  if (state_count == STATES_MAX) abort();
  states[state_count++] = read_light();
}

static void end(void) {
  char command[64];
  for (unsigned i = 0; i < LIGHTS; i++) free(lights[i].bytes);
  neph_context_destroy(context);
  snprintf(command, sizeof command, "rm -rf %s", folder);
  if (system(command)) abort();
}

/* Messages on states are of the most verbose level, at which a render measures more as well. */
static void open_context(neph_log_level level) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = 1;
  desc.log = take_message;
  desc.log_level_max = level;
  neph_context_destroy(context);
  if (neph_context_create(&desc, &context)) abort();
}

static void start(void) {
  if (!mkdtemp(folder)) abort();
  atexit(end);
  snprintf(checkpoint, sizeof checkpoint, "%s/shot.npart", folder);
  snprintf(path, sizeof path, "%s.light0-0", checkpoint);
  open_context(NEPH_LOG_DEBUG);
}

/* ---- The picture ---- */

/* Renders with a checkpoint interval. A tiny one saves each step of the solution, and the solution; a large one saves
 * nothing. */
static void render(double interval_s) {
  neph_scene *scene;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  if (neph_scene_load_text(context, scene_text, "scene", &scene)) abort();
  if (neph_scene_get_render_desc(scene, &desc)) abort();
  desc.checkpoint_path = checkpoint;
  desc.checkpoint_interval_s = interval_s;
  desc.is_resumed = true;
  if (neph_render_image(scene, &desc, &image) || error_count > 0) abort();
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  unlink(checkpoint);
}

/* The states that are chosen are spread over the solution, from its first to its last. */
static void make_lights(void) {
  start();
  render(1e-9);
  if (state_count < CHOSEN) abort();
  for (unsigned i = 0; i < CHOSEN; i++) {
    light *chosen = &states[i * (state_count - 1) / (CHOSEN - 1)];
    lights[i] = *chosen;
    *chosen = (light){NULL, 0};
  }
  for (unsigned i = 0; i < state_count; i++) free(states[i].bytes);
  lights[CHOSEN] = read_light();
  open_context(NEPH_LOG_WARNING);
}

/* ---- Forging ---- */

static void patch(const light *l, uint8_t *bytes, const uint8_t *at) {
  const size_t words = (l->size - HEADER) / 4, place = (size_t)at[0] << 8 | at[1], near = words < 256 ? words : 256;
  const size_t word = place & 0x8000 ? (place & 0x7fff) * 7919 % words : place % near;
  memcpy(bytes + HEADER + 4 * word, at + 2, 4);
}

static void mend(uint8_t *bytes, size_t size) {
  const uint64_t payload = size - HEADER;
  np_hash *hash = np_hash_create(context);
  memcpy(bytes + SIZE_AT, &payload, sizeof payload);
  np_hash_add(hash, bytes + HEADER, payload);
  if (np_hash_finish(hash, (char *)bytes + SUM_AT)) abort();
}

static void write_light(const uint8_t *bytes, size_t size) {
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (!context) make_lights();
  if (size < HEAD) return 0;
  const light *l = &lights[data[0] % LIGHTS];
  const size_t kept = HEADER + (l->size - HEADER) * (256u - data[1]) / 256;
  uint8_t *bytes = malloc(l->size);
  if (!bytes) abort();
  memcpy(bytes, l->bytes, l->size);
  for (size_t i = 0; i < PATCHES_MAX && HEAD + (i + 1) * PATCH <= size; i++) patch(l, bytes, data + HEAD + i * PATCH);
  mend(bytes, kept);
  write_light(bytes, kept);
  free(bytes);
  render(1e9);
  return 0;
}
