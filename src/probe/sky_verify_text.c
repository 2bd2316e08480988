/* SPDX-License-Identifier: Apache-2.0 */
/* The errors of a scene's sky, measured and written down. */
#include "atmosphere/sky_verify.h"
#include "core/given.h"
#include "probe/probe_run.h"
#include "stages/assembly.h"

typedef struct report {
  neph_text_format format;
  double tolerance;
  unsigned paths;
  np_sky_errors errors;
} report;

static void print_error(FILE *out, const char *name, const np_sky_error *e) {
  fprintf(out, "%-20s %6.3f %6.3f %6.3f %%  worst %.3g %.3g %.3g %%", name, 100.0 * e->rms[0], 100.0 * e->rms[1],
          100.0 * e->rms[2], 100.0 * e->worst[0], 100.0 * e->worst[1], 100.0 * e->worst[2]);
  if (e->noise[0] > 0.0)
    fprintf(out, "  (noise of the reference %.2g %.2g %.2g %%)", 100.0 * e->noise[0], 100.0 * e->noise[1],
            100.0 * e->noise[2]);
  fputc('\n', out);
}

static void print_json(FILE *out, const char *name, const np_sky_error *e) {
  fprintf(out, ", \"%s\": {\"rms\": [%.6g, %.6g, %.6g], \"worst\": [%.6g, %.6g, %.6g], \"noise\": [%.6g, %.6g, %.6g]}",
          name, e->rms[0], e->rms[1], e->rms[2], e->worst[0], e->worst[1], e->worst[2], e->noise[0], e->noise[1],
          e->noise[2]);
}

static void print_report(FILE *out, const void *user) {
  const report *r = user;
  const np_sky_errors *e = &r->errors;
  if (r->format == NEPH_TEXT_JSON) {
    fprintf(out, "{\"tolerance\": %g, \"paths\": %u", r->tolerance, r->paths);
    print_json(out, "optical_depth", &e->depths);
    print_json(out, "sky_view", &e->view);
    print_json(out, "aerial_perspective", &e->aerial);
    print_json(out, "sky", &e->all);
    fputs("}\n", out);
    return;
  }
  fprintf(out, "relative rms error of the tables in three bands, tolerance %g %%\n", 100.0 * r->tolerance);
  print_error(out, "optical depth", &e->depths);
  print_error(out, "sky view", &e->view);
  print_error(out, "aerial perspective", &e->aerial);
  print_error(out, "sky, traced", &e->all);
}

static neph_result verify(const neph_scene *scene, const neph_sky_verify_desc *desc, np_stores *stores, report *r,
                          char **out_text) {
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, desc->progress, desc->progress_user);
  np_plan plan;
  np_assembly assembly;
  const np_build_job job = np_build_job_make(stores);
  neph_result result = np_plan_make_sky(scene, &(np_sky_request){.is_of_bands = true}, &plan);
  if (!result) result = np_assembly_build(scene, &plan, &job, &monitor, &assembly);
  np_plan_clear(&plan);
  if (result) return result;
  neph_sky *sky = assembly.packets[0].lights[0].camera_sky;
  np_schedule_begin(&assembly.schedule, &monitor, NP_STAGE_INTEGRATOR, 0, 1);
  np_monitor_set_stage(&monitor, "verifying the sky");
  if (!sky)
    result = np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: the scene has no air, and so no tables");
  else
    result = np_sky_verify(sky, desc->path_count, desc->seed, &monitor, &r->errors);
  np_assembly_clear(&assembly);
  return result ? result : np_probe_write_text(scene->context, print_report, r, out_text);
}

neph_result neph_render_sky_verify(const neph_scene *scene, const neph_sky_verify_desc *desc, neph_text_format format,
                                   char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  const neph_sky_verify_desc defaults = NEPH_SKY_VERIFY_DESC_DEFAULT;
  neph_sky_verify_desc own;
  neph_result result = np_desc_read(scene->context, "neph_sky_verify_desc", &defaults, sizeof defaults, desc, &own);
  if (result) return result;
  if (own.path_count < 1)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "sky: path_count is 0, must be at least 1");
  report r = {.format = format, .tolerance = scene->atmosphere.tolerance, .paths = own.path_count};
  np_stores stores = {.results = NULL};
  const unsigned mode = np_float_mode_enter();
  result = verify(scene, &own, &stores, &r, out_text);
  np_float_mode_leave(mode);
  np_stores_clear(scene->context, &stores);
  return result;
}
