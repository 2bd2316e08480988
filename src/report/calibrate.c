/* SPDX-License-Identifier: Apache-2.0 */
/* Speed of this machine: CPU time of the stages of fixed small scenes, over the time that they took where the constants
 * of the cost model (plan/cost_table.h) are from. */
#include <math.h>
#include <stdio.h>

#include <nephos/machine.h>

#include "core/given.h"
#include "core/parallel.h"
#include "frame/frame.h"
#include "plan/stage_rules.h"

/* Number of runs of each scene; the shortest time counts, as other programs may disturb a run. */
enum { RUNS = 3, SCENES = 4 };

#define VIEW                                                                                                           \
  "camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [160, 90]}\n"                \
  "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
#define HEAP "clouds: [{bake: {model: hero, seed: 3, extent: [600 m, 600 m], voxel: 5 m}, extinction: 0.05 1/m}]\n"

static const char *const scenes[SCENES] = {
    VIEW HEAP "render: {samples: 16, sun_optical_depth: volume}\n",
    VIEW "terrain: {ridges: {samples: 513, relief: 200 m}, width: 10 km}\natmosphere: {tolerance: 0.003}\n"
         "render: {samples: 1}\n",
    VIEW HEAP "render: {integrator: path, samples: 4}\n",
    VIEW "clouds: [{bake: {preset: cumulus_mediocris, seed: 3, extent: [5 km, 5 km], voxel: 40 m}}]\n"
         "render: {samples: 1}\n",
};

/* Measured stages and their predicted seconds of one core. Other stages are too short, or mix several kinds of work. */
static const struct {
  unsigned scene;
  np_stage stage;
  neph_work work;
  double constant_s;
} rows[] = {
#define ROW(scene, stage, work, seconds) {scene, NP_STAGE_##stage, NEPH_WORK_##work, seconds},
    NP_CALIBRATION_ROWS(ROW)
#undef ROW
};

/* ---- One scene ---- */

typedef struct calibration {
  neph_context *context;
  np_monitor monitor;
  double least_s[SCENES][NP_STAGE_COUNT];
} calibration;

static neph_result render_once(calibration *c, unsigned scene, const neph_scene *loaded) {
  np_plan plan;
  np_stage_times times = {.error_s = 0.0};
  neph_image *image = NULL;
  neph_result result = np_plan_make(loaded, NULL, &plan);
  np_stores stores = {.results = NULL};
  np_render_job job = {.build = np_build_job_make(&stores)};
  job.build.times = &times;
  if (!result) result = np_render_image(loaded, &plan, &job, &c->monitor, &image);
  np_stores_clear(c->context, &stores);
  np_plan_clear(&plan);
  neph_image_destroy(image);
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) c->least_s[scene][i] = fmin(c->least_s[scene][i], times.cpu_s[i]);
  return result;
}

/* Measures a scene, each run with empty stores. */
static neph_result measure_scene(calibration *c, unsigned scene) {
  const np_monitor_part whole = np_monitor_get_part(&c->monitor);
  neph_result result = NEPH_OK;
  for (int i = 0; i < NP_STAGE_COUNT; i++) c->least_s[scene][i] = HUGE_VAL;
  for (unsigned run = 0; run < RUNS && !result; run++) {
    neph_scene *loaded;
    const double done = RUNS * scene + run;
    np_monitor_set_part(&c->monitor, whole, done / (RUNS * SCENES), (done + 1.0) / (RUNS * SCENES));
    result = neph_scene_load_text(c->context, scenes[scene], "calibration", &loaded);
    if (!result) result = render_once(c, scene, loaded);
    neph_scene_destroy(loaded);
  }
  np_monitor_set_part(&c->monitor, whole, 0.0, 1.0);
  return result;
}

static void compute_factors(const calibration *c, neph_machine *out) {
  double measured[NEPH_WORK_COUNT] = {0}, constant[NEPH_WORK_COUNT] = {0};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const double seconds = c->least_s[rows[i].scene][rows[i].stage];
    measured[rows[i].work] += seconds;
    constant[rows[i].work] += rows[i].constant_s;
    np_log(c->context, NEPH_LOG_DEBUG, "calibration: %s of scene %u takes %.4g s of one core, by the constants %.4g s",
           np_stage_get_rule(rows[i].stage)->name, rows[i].scene, seconds, rows[i].constant_s);
  }
  for (int k = 0; k < NEPH_WORK_COUNT; k++) out->factor[k] = measured[k] / constant[k];
}

neph_result neph_machine_calibrate(neph_context *context, neph_progress_fn progress, void *user,
                                   neph_machine *out_machine) {
  if (NP_LACKS(context, out_machine)) return NEPH_ERROR_INVALID_ARGUMENT;
  calibration c = {.context = context};
  neph_machine machine = NEPH_MACHINE_DEFAULT;
  neph_result result = np_desc_check_size(context, "neph_machine", out_machine, sizeof machine);
  if (result) return result;
  np_monitor_start(&c.monitor, context, progress, user);
  for (unsigned i = 0; i < SCENES && !result; i++) result = measure_scene(&c, i);
  if (result) return result;
  np_cpu_name(machine.cpu, sizeof machine.cpu);
  compute_factors(&c, &machine);
  return np_desc_write(context, "neph_machine", &machine, sizeof machine, out_machine);
}
