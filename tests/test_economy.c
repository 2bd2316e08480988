/* SPDX-License-Identifier: Apache-2.0 */
/* A scene only pays for its content: which stages are built for it, and which libraries are loaded.
 *
 * Each row is built in its own process, because a loaded library stays. OpenVDB counts if its library is mapped, Embree
 * if a device is created. */
#include <dlfcn.h>
#include <link.h>
#include <sys/wait.h>
#include <unistd.h>

#include "plan/plan.h"
#include "plan/plan_choices.h"
#include "plan/stage_rules.h"
#include "stages/assembly.h"
#include "test_scenes.h"

#define BIT(stage) (1u << NP_STAGE_##stage)

/* Stages by the feature that needs them. */
enum {
  ALWAYS = BIT(COLOR) | BIT(LIGHTS) | BIT(WORLD) | BIT(LIGHTING),
  AIR = BIT(ATMOSPHERE) | BIT(CAMERA_SKY),
  CLOUD = BIT(VOLUMES),
  LIGHT_IN_CLOUDS = BIT(ORDINATES) | BIT(VIEWER_LIGHT),
  CACHES_OF_MARCH = BIT(SUN_OPTICAL_DEPTH) | LIGHT_IN_CLOUDS | BIT(GROUND_CLOUDS) | BIT(AIR_SHADOWS),
  NIGHT = BIT(AIRGLOW) | BIT(STARS),
  LIGHT = AIR | BIT(COLOR_FIT) | BIT(EMISSION) | BIT(CLOUD_SKY) | BIT(WATER_SKY) | BIT(SKY_GUIDE) | BIT(APPROXIMATION) |
          CACHES_OF_MARCH | BIT(RELIEF_LIGHT) | NIGHT,
  ALL = LIGHT | ALWAYS | CLOUD | BIT(TERRAIN) | BIT(MOTION)
};

enum { NO_LIBRARY = 0, EMBREE = 1, OPENVDB = 2 };

typedef struct row {
  const char *name, *scene;
  uint32_t built, absent; /* no stage in both; what is in neither may be there or not */
  int libraries;          /* all that wake up */
} row;

#define SMALL "camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [16, 8]}\n"
#define DAY SMALL "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
#define HEAP "clouds: [{name: a, bake: {model: hero, seed: 3, extent: [600 m, 600 m], voxel: 60 m}}]\n"
#define FILED "clouds: [{name: a, vdb: cloud.vdb, extinction: 1 1/m}]\n"
#define HILLS "terrain: {ridges: {samples: 33, relief: 200 m}, width: 10 km}\n"
#define MOONLIT                                                                                                        \
  SMALL "place: {latitude: 45 deg, longitude: 0 deg}\nsun: {elevation: -30 deg, azimuth: 100 deg}\n"                   \
        "moon: {elevation: 40 deg, azimuth: 100 deg}\nstars: {sidereal_time: 30 deg}\nairglow: {}\n"
#define SPACE "environment: {planet: none, radiance: 1}\n"

static const row rows[] = {
    {"sky", DAY, ALWAYS | AIR | BIT(COLOR_FIT), ALL & ~(ALWAYS | AIR | BIT(COLOR_FIT)), NO_LIBRARY},
    {"sky by path", DAY "render: {integrator: path}", ALWAYS, CLOUD | CACHES_OF_MARCH | BIT(TERRAIN), NO_LIBRARY},
    {"sky in bands", DAY "output: {color_space: bands}", ALWAYS | AIR, BIT(COLOR_FIT) | CLOUD | BIT(TERRAIN),
     NO_LIBRARY},
    {"sky in many wavelengths", DAY "render: {wavelengths: 6}", ALWAYS | AIR, BIT(COLOR_FIT) | CLOUD, NO_LIBRARY},
    {"nothing", SMALL "atmosphere: none\nenvironment: {planet: none}\nsun: {irradiance: 0}", ALWAYS, LIGHT, NO_LIBRARY},
    {"sky by moonlight", MOONLIT, ALWAYS | AIR | NIGHT, CLOUD | BIT(TERRAIN) | CACHES_OF_MARCH, NO_LIBRARY},
    {"stars by day", DAY "place: {latitude: 45 deg, longitude: 0 deg}\nstars: {sidereal_time: 30 deg}\nairglow: {}",
     ALWAYS | AIR, NIGHT | CLOUD, NO_LIBRARY},
    {"hills", DAY HILLS, ALWAYS | AIR | BIT(TERRAIN) | BIT(RELIEF_LIGHT),
     CLOUD | LIGHT_IN_CLOUDS | BIT(CLOUD_SKY) | BIT(WATER_SKY), EMBREE},
    {"hills' distance", DAY HILLS "output: {beauty: false, aovs: [distance]}", ALWAYS | BIT(TERRAIN), LIGHT | CLOUD,
     EMBREE},
    {"sea", DAY "water: {}", ALWAYS | AIR | BIT(WATER_SKY), CLOUD | BIT(TERRAIN) | CACHES_OF_MARCH, NO_LIBRARY},
    {"cloud", DAY HEAP, ALWAYS | AIR | CLOUD | LIGHT_IN_CLOUDS | BIT(CLOUD_SKY),
     BIT(TERRAIN) | BIT(WATER_SKY) | BIT(SKY_GUIDE) | BIT(APPROXIMATION) | BIT(EMISSION) | NIGHT, NO_LIBRARY},
    {"cloud and its motion", DAY HEAP "output: {aovs: [motion]}", ALWAYS | AIR | CLOUD | BIT(MOTION),
     BIT(TERRAIN) | NIGHT, NO_LIBRARY},
    {"cloud of a file", DAY FILED, ALWAYS | AIR | CLOUD | LIGHT_IN_CLOUDS | BIT(CLOUD_SKY), BIT(TERRAIN) | NIGHT,
     OPENVDB},
    {"cloud and its shadows", DAY HEAP "render: {sun_optical_depth: volume, air_shadows: true}",
     ALWAYS | AIR | CLOUD | CACHES_OF_MARCH, BIT(TERRAIN) | NIGHT, NO_LIBRARY},
    {"cloud by path at dusk", SMALL HEAP "sun: {elevation: -4 deg, azimuth: 100 deg}\nrender: {integrator: path}",
     ALWAYS | CLOUD | BIT(ATMOSPHERE) | BIT(CLOUD_SKY) | BIT(SKY_GUIDE), CACHES_OF_MARCH | BIT(TERRAIN), NO_LIBRARY},
    {"cloud by path", DAY HEAP "render: {integrator: path}", ALWAYS | CLOUD | BIT(SUN_OPTICAL_DEPTH),
     LIGHT_IN_CLOUDS | BIT(GROUND_CLOUDS) | BIT(AIR_SHADOWS) | BIT(TERRAIN) | BIT(APPROXIMATION) | BIT(CAMERA_SKY) |
         BIT(CLOUD_SKY),
     NO_LIBRARY},
    {"cloud by guided path", DAY HEAP "render: {integrator: path, path_guiding: adjoint}",
     ALWAYS | CLOUD | BIT(SUN_OPTICAL_DEPTH) | BIT(ORDINATES),
     BIT(VIEWER_LIGHT) | BIT(GROUND_CLOUDS) | BIT(AIR_SHADOWS) | BIT(TERRAIN), NO_LIBRARY},
    {"cloud's depth", DAY HEAP "output: {beauty: false, aovs: [depth, transmittance]}", ALWAYS | CLOUD,
     LIGHT | BIT(TERRAIN), NO_LIBRARY},
    {"cloud scattering once", DAY HEAP "render: {max_scatterings: 1}", ALWAYS | AIR | CLOUD | BIT(CLOUD_SKY),
     LIGHT_IN_CLOUDS | BIT(GROUND_CLOUDS) | BIT(APPROXIMATION), NO_LIBRARY},
    {"cloud in octaves", DAY HEAP "render: {multiple_scattering: octaves}", ALWAYS | AIR | CLOUD | BIT(APPROXIMATION),
     LIGHT_IN_CLOUDS | BIT(GROUND_CLOUDS), NO_LIBRARY},
    {"cloud in space", DAY HEAP SPACE, ALWAYS | CLOUD | LIGHT_IN_CLOUDS,
     AIR | BIT(CLOUD_SKY) | BIT(GROUND_CLOUDS) | BIT(AIR_SHADOWS) | BIT(TERRAIN) | NIGHT, NO_LIBRARY},
    {"cloud 20 deg after sunset", SMALL HEAP "sun: {elevation: -20 deg, azimuth: 100 deg}", ALWAYS | CLOUD, LIGHT,
     NO_LIBRARY},
    {"cloud by moonlight", MOONLIT HEAP, ALWAYS | AIR | CLOUD | NIGHT | LIGHT_IN_CLOUDS, BIT(TERRAIN) | BIT(WATER_SKY),
     NO_LIBRARY},
    {"cloud without sun", SMALL HEAP "sun: {irradiance: 0}\nenvironment: {radiance: 1}",
     ALWAYS | CLOUD | LIGHT_IN_CLOUDS,
     BIT(SUN_OPTICAL_DEPTH) | BIT(CAMERA_SKY) | BIT(CLOUD_SKY) | BIT(AIR_SHADOWS) | NIGHT, NO_LIBRARY},
    {"cloud over hills", DAY HEAP HILLS, ALWAYS | AIR | CLOUD | BIT(TERRAIN) | LIGHT_IN_CLOUDS | BIT(GROUND_CLOUDS),
     NIGHT, EMBREE},
    {"file over hills", DAY FILED HILLS, ALWAYS | AIR | CLOUD | BIT(TERRAIN) | LIGHT_IN_CLOUDS, NIGHT,
     EMBREE | OPENVDB},
    {"fire",
     SMALL "clouds: [{name: a, vdb: cloud.vdb, extinction: 1 1/m, emission: {temperature: density}}]\n"
           "sun: {irradiance: 0}\natmosphere: none",
     ALWAYS | CLOUD | BIT(EMISSION) | LIGHT_IN_CLOUDS, AIR | BIT(CLOUD_SKY) | BIT(AIR_SHADOWS) | BIT(TERRAIN) | NIGHT,
     OPENVDB},
};

/* ---- Libraries ---- */

static unsigned embree_devices; /* devices of this process */

/* Stands before Embree's own, which it calls. */
void *rtcNewDevice(const char *config);
void *rtcNewDevice(const char *config) {
  void *(*create)(const char *) = NULL;
  void *symbol = dlsym(RTLD_NEXT, "rtcNewDevice");
  memcpy(&create, &symbol, sizeof create); /* ISO C has no cast from object to function pointers */
  embree_devices++;
  return create(config);
}

static int note_openvdb(struct dl_phdr_info *info, size_t size, void *is_mapped) {
  (void)size;
  *(bool *)is_mapped |= strstr(info->dlpi_name, "openvdb") != NULL;
  return 0;
}

static int get_libraries(void) {
  bool has_openvdb = false;
  dl_iterate_phdr(note_openvdb, &has_openvdb);
  return (embree_devices ? EMBREE : 0) | (has_openvdb ? OPENVDB : 0);
}

/* ---- Rows ---- */

static void print_stages(const char *name, const char *what, uint32_t stages) {
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (stages >> i & 1u) print_error("%s: %s %s\n", name, np_stage_get_rule((np_stage)i)->name, what);
}

/* Builds a row's scene in the child, as if read from the file `name`, and prints what is wrong. */
static bool is_built_as_told(neph_context *context, const row *r, const char *name) {
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  neph_scene *scene = NULL;
  np_plan plan;
  np_assembly a;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  neph_result result = neph_scene_load_text(context, r->scene, name, &scene);
  if (!result) result = np_plan_make(scene, NULL, &plan);
  if (!result) result = np_assembly_build(scene, &plan, &job, &monitor, &a);
  if (result) return false;
  const int libraries = get_libraries();
  print_stages(r->name, "was not built", r->built & ~a.built);
  print_stages(r->name, "was built for nothing", r->absent & a.built);
  if (libraries != r->libraries) print_error("%s: libraries %d, not %d\n", r->name, libraries, r->libraries);
  return !(r->built & ~a.built) && !(r->absent & a.built) && libraries == r->libraries;
}

/* All that the child allocates goes with it. */
static bool try_row(const row *r, const char *name) {
  const pid_t child = fork();
  if (child == 0) {
    test_log log;
    test_log_start(&log);
    const bool is_right = is_built_as_told(test_context_create(2, &log), r, name);
    if (!is_right) print_error("%s: %s\n", r->name, log.text);
    _exit(is_right ? 0 : 1);
  }
  int status;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/* Baked by a child as well, so that no row inherits OpenVDB. */
static bool bake_file(const char *path) {
  const pid_t child = fork();
  if (child == 0) {
    neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
    cloud.extent_m[0] = cloud.extent_m[1] = 600.0;
    cloud.voxel_m = 60.0;
    _exit((int)neph_cloud_bake_file(test_context_create(1, NULL), &cloud, NULL, "density", path));
  }
  int status;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static void scenes_build_what_they_show(void **state) {
  (void)state;
  char *folder = test_folder_create(), *vdb = test_path(folder, "cloud.vdb"), *name = test_path(folder, "scene.yaml");
  assert_true(bake_file(vdb));
  unsigned wrong = 0;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    assert_int_equal(rows[i].built & rows[i].absent, 0);
    wrong += try_row(&rows[i], name) ? 0 : 1;
  }
  free(vdb);
  free(name);
  test_folder_destroy(folder);
  assert_int_equal(wrong, 0);
}

/* Every stage is left out by some row and built by another, so that each decision is seen both ways. */
static void every_stage_is_seen_both_ways(void **state) {
  (void)state;
  const np_part_counts one = np_part_counts_make(1, 1, 1);
  uint32_t built = 0, absent = 0, all = 0;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    built |= rows[i].built;
    absent |= rows[i].absent;
  }
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (np_stage_count_parts(np_stage_get_rule((np_stage)i), &one)) all |= 1u << i;
  print_stages("table", "is built by no row", all & ~built);
  print_stages("table", "is absent from no row", all & ~absent & ~(uint32_t)ALWAYS);
  assert_int_equal(all & ~built, 0);
  assert_int_equal(all & ~absent & ~(uint32_t)ALWAYS, 0);
}

/* ---- Cells ---- */

static double count_cells(neph_context *context, const char *camera) {
  char text[500];
  neph_scene *scene;
  np_plan plan;
  np_cells_forecast forecast;
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0, %s, 1 km], look_at: [0, 0, 1 km], fov: 40 deg, resolution: [400, 200]}\n"
                 "clouds: [{bake: {extent: 2 km, base: 500 m, thickness: 1 km, voxel: 25 m, extinction: 0.05 1/m}}]\n",
                 camera);
  assert_int_equal(neph_scene_load_text(context, text, "scene.yaml", &scene), NEPH_OK);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(np_plan_forecast_cells(&plan, scene, &forecast), NEPH_OK);
  assert_true(forecast.is_known);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
  return forecast.cells.cell_count;
}

/* A cloud that fills the picture has cells of one voxel; one of 40 pixels, of two. */
static void a_small_cloud_has_no_fine_cells(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  const double near = count_cells(context, "-3 km"), far = count_cells(context, "-70 km");
  assert_true(near > 4.0 * far); /* eight times as many, but for the rim of empty ones */
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_small_cloud_has_no_fine_cells),
      cmocka_unit_test(every_stage_is_seen_both_ways),
      cmocka_unit_test(scenes_build_what_they_show),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
