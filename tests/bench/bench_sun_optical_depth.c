/* SPDX-License-Identifier: Apache-2.0 */
/* Cost and gain of the sun optical-depth volume, and whether the plan picks the cheaper way of the two.
 *
 * Usage: bench_sun_optical_depth SCENE.yaml [FRAMES [KEY VALUE …]]. One thread; CPU seconds, the least of several.
 * Printed: what it takes to fill the volume; a frame's rays with the volume kept from the last frame, and with depths
 * marched for; both for all FRAMES; what the plan says. Then, from the scene's parts: a node filled, a depth looked up
 * and one walked for, at places in the cloud.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <nephos/nephos.h>

#include "caches/sun_optical_depth.h"
#include "core/random.h"
#include "stages/assembly.h"
#include "volume/tracking.h"

enum { REPEATS = 3, PLACES = 20000 };

static void fail(const char *what) {
  fprintf(stderr, "bench_sun_optical_depth: %s\n", what);
  exit(1);
}

static void check(neph_result result) {
  if (result) fail(neph_result_get_text(result));
}

static double read_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- Frames ---- */

static double render(neph_renderer *renderer, neph_scene *scene, const char *sun_optical_depth) {
  neph_image *image = NULL;
  check(neph_scene_set(scene, "render.sun_optical_depth", sun_optical_depth));
  const double begin = read_clock();
  check(neph_renderer_render(renderer, scene, NULL, &image));
  const double seconds = read_clock() - begin;
  neph_image_destroy(image);
  return seconds;
}

/* Turns the sun so little that only the volume is refilled. */
static void turn_sun(neph_scene *scene, double elevation_deg, int step) {
  char text[40];
  (void)snprintf(text, sizeof text, "%.6f deg", elevation_deg + 1e-4 * step);
  check(neph_scene_set(scene, "sun.elevation", text));
}

static void print_plan(neph_scene *scene) {
  char *text = NULL;
  check(neph_scene_set(scene, "render.sun_optical_depth", "auto"));
  check(neph_render_explain(scene, NULL, NEPH_TEXT_PLAIN, &text));
  const char *line = strstr(text, "sun optical depth");
  if (line) printf("plan    %.*s\n", (int)strcspn(line, "\n"), line);
  neph_text_destroy(scene->context, text);
}

static void time_frames(neph_scene *scene, double elevation_deg, int frames) {
  neph_renderer *renderer;
  check(neph_renderer_create(scene->context, &renderer));
  double filled = HUGE_VAL, kept = HUGE_VAL, marched = HUGE_VAL;
  (void)render(renderer, scene, "volume");
  for (int i = 0; i < REPEATS; i++) {
    turn_sun(scene, elevation_deg, i + 1);
    filled = fmin(filled, render(renderer, scene, "volume"));
    kept = fmin(kept, render(renderer, scene, "volume"));
    marched = fmin(marched, render(renderer, scene, "march"));
  }
  const double fill = filled - kept;
  printf("frames  fill %.3f s; a frame %.3f s with the volume, %.3f s marched; %d frames %.3f / %.3f s: %s\n", fill,
         kept, marched, frames, fill + frames * kept, frames * marched,
         fill < frames * (marched - kept) ? "volume" : "march");
  neph_renderer_destroy(renderer);
}

/* ---- Parts ---- */

typedef struct places {
  np_dvec3 at[PLACES];
} places;

/* True in cloud. */
static void draw_places(const np_assembly *a, places *out) {
  np_random random = np_random_start(1, 2, 3, 4, 5);
  const np_dvec3 low = a->clouds.low, size = np_dvec3_subtract(a->clouds.high, low);
  for (int n = 0; n < PLACES;) {
    const double x = np_random_double(&random), y = np_random_double(&random), z = np_random_double(&random);
    out->at[n] = np_dvec3_make(low.x + x * size.x, low.y + y * size.y, low.z + z * size.z);
    n += np_instance_extinction(&a->clouds.at[0].placed, out->at[n]) > 0.0f;
  }
}

static double time_filling(const np_world *world, neph_context *context, const np_sun_optical_depth_desc *desc) {
  double best = HUGE_VAL;
  for (int i = 0; i < REPEATS; i++) {
    np_sun_optical_depth cache;
    const double begin = read_clock();
    check(np_sun_optical_depth_build(context, world, desc, NULL, &cache));
    best = fmin(best, read_clock() - begin);
    np_sun_optical_depth_clear(&cache);
  }
  return best;
}

/* Walks for all depths, of the first cloud. Returns the seconds that one takes. */
static double time_walks(const np_world *world, const places *p, const np_depth_query *query, double *sum) {
  double best = HUGE_VAL;
  for (int i = 0; i < REPEATS; i++) {
    const double begin = read_clock();
    for (int n = 0; n < PLACES; n++)
      *sum += (double)np_track_volume_depth(world->clouds.at, p->at[n], world->to_sun, INFINITY, query, 0.0f);
    best = fmin(best, read_clock() - begin);
  }
  return best / PLACES;
}

static double time_look_ups(const np_sun_optical_depth *cache, np_vec3 to_sun, const places *p, double *sum,
                            int *unknown) {
  double best = HUGE_VAL;
  for (int i = 0; i < REPEATS; i++) {
    const double begin = read_clock();
    *unknown = 0;
    for (int n = 0; n < PLACES; n++) {
      const float depth = np_sun_lattice_get(cache->lattices, cache->depth_end, p->at[n], to_sun);
      *unknown += depth == NP_SUN_OPTICAL_DEPTH_UNKNOWN;
      *sum += (double)depth;
    }
    best = fmin(best, read_clock() - begin);
  }
  return best / PLACES;
}

static void time_parts(const np_plan *plan, const np_assembly *a) {
  const np_packet_light *light = &a->packets[0].lights[0];
  const np_world *world = &light->world;
  const np_sun_optical_depth *cache = light->lighting.sun_optical_depths.cache;
  static places p;
  draw_places(a, &p);
  /* Half of it is what the scaled medium fades by, and a tenth what most steps may be wrong by. */
  const np_depth_query query = {0.5f, 0.1f};
  np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  desc.rate = 16.0f / cache->depth_end;
  double sum = 0.0, voxels = 0.0;
  int unknown;
  for (unsigned v = 0; v < world->clouds.count; v++)
    voxels += (double)world->clouds.at[v].bricks->brick_count * NP_BRICK_EDGE * NP_BRICK_EDGE * NP_BRICK_EDGE;
  const double fill = time_filling(world, a->context, &desc), walk = time_walks(world, &p, &query, &sum),
               found = time_look_ups(cache, world->to_sun, &p, &sum, &unknown);
  printf("parts   %.3g voxels in bricks (the plan: %.3g), %.1f ns to fill each; a depth walked for %.0f ns, looked up "
         "%.0f ns, of which %.0f %% are walked for [%g]\n",
         voxels, np_plan_get_cloud_voxels(plan), 1e9 * fill / voxels, 1e9 * walk, 1e9 * found, 100.0 * unknown / PLACES,
         sum);
}

static double start_parts(neph_scene *scene) {
  np_plan plan;
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  np_assembly assembly;
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, NULL, NULL);
  check(neph_scene_set(scene, "render.sun_optical_depth", "volume"));
  check(np_plan_make(scene, NULL, &plan));
  check(np_assembly_build(scene, &plan, &job, &monitor, &assembly));
  time_parts(&plan, &assembly);
  np_assembly_clear(&assembly);
  np_stores_clear(scene->context, &stores);
  const double elevation = asin(plan.decisions.lights.to_sun.z) * 180.0 / NP_PI;
  np_plan_clear(&plan);
  return elevation;
}

int main(int argc, char **argv) {
  if (argc < 2) fail("SCENE.yaml [FRAMES [KEY VALUE ...]]");
  neph_context *context = NULL;
  neph_scene *scene = NULL;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = 1;
  check(neph_context_create(&desc, &context));
  check(neph_scene_load(context, argv[1], &scene));
  for (int i = 3; i + 1 < argc; i += 2) check(neph_scene_set(scene, argv[i], argv[i + 1]));
  print_plan(scene);
  const double elevation_deg = start_parts(scene);
  time_frames(scene, elevation_deg, argc > 2 ? atoi(argv[2]) : 1);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return 0;
}
