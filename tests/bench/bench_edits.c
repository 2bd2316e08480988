/* SPDX-License-Identifier: Apache-2.0 */
/* Seconds of a picture after an edit, with one renderer that keeps what the edit leaves valid: a draft of a cumulus
 * field of 160×90 pixels, after the same scene with the edit's other value. Medians of wall and CPU seconds of RUNS
 * pictures.
 *
 * usage: bench_edits [THREADS [EDIT [LOG]]]
 *
 * LOG receives the CPU time of each piece of each parallel loop, as neph_context_desc.loop_log has it.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <nephos/nephos.h>

enum { RUNS = 7 };

static const char field[] =
    "camera: {position: [-3 km, -12 km, 1600 m], look_at: [0 m, 0 m, 2700 m], focal_length: 35 mm,\n"
    "         resolution: [160, 90]}\n"
    "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
    "clouds: [{bake: {preset: cumulus_mediocris, seed: 12, extent: [12 km, 12 km], base: 2200 m, voxel: 25 m}}]\n"
    "terrain: {ridges: {seed: 3, relief: 1300 m}, width: 40 km, albedo: [0.08, 0.12, 0.05], rock: {slope: 33 deg}}\n"
    "render: {integrator: march, samples: 4, quality: draft}\n";

/* An edit of one key, there and back. */
typedef struct edit {
  const char *name, *key, *values[2];
  double goal_s; /* goal for the seconds of the wall */
} edit;

static const edit edits[] = {
    {"camera", "camera.position", {"[-3 km, -12 km, 1600 m]", "[-2.8 km, -12 km, 1620 m]"}, 0.08},
    {"sun", "sun.elevation", {"35 deg", "37 deg"}, 0.2},
    {"extinction", "clouds[0].extinction", {"0.05", "0.06"}, 0.15},
    {"coverage", "clouds[0].bake.coverage", {"0.4", "0.5"}, 0.5},
    {"wispiness", "clouds[0].bake.wispiness", {"0.3", "0.6"}, 0.5},
    {"ground albedo", "terrain.albedo", {"[0.08, 0.12, 0.05]", "[0.2, 0.2, 0.2]"}, 0.15},
    {"focal length", "camera.focal_length", {"35 mm", "40 mm"}, 0.08},
};

static void check(neph_result result) {
  if (!result) return;
  fprintf(stderr, "bench_edits: %s\n", neph_result_get_text(result));
  exit(1);
}

static double read_clock_s(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Wall and CPU seconds. */
typedef struct cost {
  double wall_s, cpu_s;
} cost;

static cost render(neph_renderer *renderer, const neph_scene *scene, unsigned detail_height) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  check(neph_scene_get_render_desc(scene, &desc));
  desc.detail_height = detail_height;
  const double wall_s = read_clock_s(CLOCK_MONOTONIC), cpu_s = read_clock_s(CLOCK_PROCESS_CPUTIME_ID);
  check(neph_renderer_render(renderer, scene, &desc, &image));
  const cost out = {read_clock_s(CLOCK_MONOTONIC) - wall_s, read_clock_s(CLOCK_PROCESS_CPUTIME_ID) - cpu_s};
  neph_image_destroy(image);
  return out;
}

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double get_median(double values[RUNS]) {
  qsort(values, RUNS, sizeof *values, compare);
  return values[RUNS / 2];
}

static cost measure(neph_renderer *renderer, neph_scene *scene, const edit *e, unsigned detail_height) {
  double wall_s[RUNS], cpu_s[RUNS];
  for (int i = -2; i < RUNS; i++) {
    check(neph_scene_set(scene, e->key, e->values[i & 1]));
    const cost own = render(renderer, scene, detail_height);
    if (i >= 0) wall_s[i] = own.wall_s, cpu_s[i] = own.cpu_s;
  }
  return (cost){get_median(wall_s), get_median(cpu_s)};
}

static void print_edit(neph_context *context, const edit *e) {
  cost costs[2];
  for (int i = 0; i < 2; i++) {
    neph_renderer *renderer;
    neph_scene *scene;
    check(neph_renderer_create(context, &renderer));
    check(neph_scene_load_text(context, field, "field", &scene));
    costs[i] = measure(renderer, scene, e, i ? 180 : 0);
    neph_scene_destroy(scene);
    neph_renderer_destroy(renderer);
  }
  printf("| %s | %s | %.3f | %.3f | %.3f | %.3f | %.2f |\n", e->name, e->key, costs[0].wall_s, costs[0].cpu_s,
         costs[1].wall_s, costs[1].cpu_s, e->goal_s);
  fflush(stdout);
}

/* Prints the row of a larger picture from nothing. */
static void print_first(neph_context *context) {
  neph_scene *scene;
  double wall_s[RUNS], cpu_s[RUNS];
  check(neph_scene_load_text(context, field, "field", &scene));
  check(neph_scene_set(scene, "camera.resolution", "[480, 270]"));
  for (int i = 0; i < RUNS; i++) {
    neph_renderer *renderer;
    check(neph_renderer_create(context, &renderer));
    const cost own = render(renderer, scene, 0);
    wall_s[i] = own.wall_s, cpu_s[i] = own.cpu_s;
    neph_renderer_destroy(renderer);
  }
  printf("| none: 480×270 from nothing | | %.3f | %.3f | | | 1.60 |\n", get_median(wall_s), get_median(cpu_s));
  neph_scene_destroy(scene);
}

int main(int argc, char **argv) {
  neph_context *context = NULL;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.loop_log = argc > 3 ? argv[3] : NULL;
  desc.thread_count = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 2;
  check(neph_context_create(&desc, &context));
  printf("| edit | key | draft: wall, s | CPU, s | first picture: wall, s | CPU, s | goal, wall s |\n"
         "| --- | --- | --- | --- | --- | --- | --- |\n");
  for (size_t i = 0; i < sizeof edits / sizeof *edits; i++)
    if (argc < 3 || !strcmp(argv[2], edits[i].name)) print_edit(context, &edits[i]);
  if (argc < 3) print_first(context);
  neph_context_destroy(context);
  return 0;
}
