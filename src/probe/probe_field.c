/* SPDX-License-Identifier: Apache-2.0 */
/* Light through level planes of a scene, and light that its clouds absorb between them, in the bands at 680, 550 and
 * 440 nm. The scene is assembled as for a picture; its skies are traced along each ray, as for a camera whose rays have
 * no common origin, and what caches hold for the camera alone is left out. */
#include <nephos/probe.h>

#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/units.h"
#include "plan/integrator_choice.h"
#include "probe/plane_light.h"
#include "probe/probe_run.h"
#include "scene/scene_eval.h"
#include "scene/scene_private.h"
#include "stages/assembly.h"
#include "stages/stores.h"
#include "volume/instance_period.h"

enum { HEIGHTS_MAX = 4096 };

/* One row of the output table. */
typedef struct field_row {
  const char *quantity;
  double height_m, low_m; /* the plane, or both ends of a layer that absorbs */
  np_plane_answer answer;
} field_row;

typedef struct field_probe {
  neph_context *context;
  neph_probe_field_desc desc;
  np_monitor monitor;
  const np_plan *plan;
  const np_assembly *assembly;
  np_world worlds[NP_LIGHTS_MAX];
  np_lighting lightings[NP_LIGHTS_MAX];
  np_plane_view views[NP_LIGHTS_MAX];
  np_plane_source source;
  double box_min_m[2], box_max_m[2];
  size_t row_count;
  field_row *rows;
} field_probe;

/* ---- The scene ---- */

static void set_views(field_probe *p) {
  const np_packet *packet = &p->assembly->packets[0];
  for (unsigned l = 0; l < packet->light_count; l++) {
    p->worlds[l] = packet->lights[l].world;
    p->worlds[l].has_no_disks = p->worlds[l].has_parallel_view = true;
    p->lightings[l] = packet->lights[l].lighting;
    p->lightings[l].viewer_light = NULL;
    p->lightings[l].air_shadow = NULL;
    p->lightings[l].sky_guide = NULL;
    p->views[l] = (np_plane_view){&p->worlds[l], &p->lightings[l]};
  }
}

static void set_source(field_probe *p, const neph_scene *scene) {
  const bool is_approximated = np_plan_needs(p->plan, NP_STAGE_APPROXIMATION);
  const np_integrator_kernels *kernels = np_integrator_get_kernels(neph_context_get_isa(p->context));
  p->source =
      (np_plane_source){.context = p->context,
                        .views = p->views,
                        .view_count = p->assembly->packets[0].light_count,
                        .integrate = p->desc.integrator == NEPH_INTEGRATOR_PATH ? kernels->path : kernels->march,
                        .seed = p->desc.seed};
  np_integrator_settings *settings = &p->source.settings;
  np_integrator_choice_make(
      &scene->render, is_approximated ? scene->render.multiple_scattering : NEPH_MULTIPLE_SCATTERING_NONE, settings);
  settings->is_air_traced = np_request_traces_air(&p->plan->request);
  settings->monitor = &p->monitor;
}

/* The rectangle of the description; else the box of the clouds, and along an axis on which they repeat, one period. */
static void set_box(field_probe *p) {
  const np_assembly *a = p->assembly;
  const double low[2] = {a->clouds.low.x, a->clouds.low.y}, high[2] = {a->clouds.high.x, a->clouds.high.y};
  for (int k = 0; k < 2; k++) {
    const double period_m = a->clouds.volume_count > 0 ? np_instances_compute_period(&p->worlds[0].clouds, k) : 0.0;
    const bool is_given = p->desc.box_min_m[k]<p->desc.box_max_m[k], has_clouds = a->clouds.volume_count> 0;
    p->box_min_m[k] = is_given ? p->desc.box_min_m[k] : has_clouds ? low[k] : -0.5;
    p->box_max_m[k] = is_given ? p->desc.box_max_m[k] : period_m > 0.0 ? low[k] + period_m : has_clouds ? high[k] : 0.5;
  }
}

/* ---- Measures ---- */

/* Light of sun, moon and an even environment on a level plane above the air. */
static np_plane_answer compute_incoming(const field_probe *p) {
  np_plane_answer out = {{0}, {0}};
  for (unsigned l = 0; l < p->source.view_count; l++)
    for (int b = 0; b < NP_BAND_COUNT; b++)
      out.value[b] += fmax((double)p->worlds[l].to_sun.z, 0.0) * (double)p->worlds[l].sun_irradiance.band[b] +
                      NP_PI * (double)p->worlds[l].environment_radiance.band[b];
  return out;
}

static field_row *add_row(field_probe *p, const char *quantity, double height_m, double low_m) {
  field_row *row = &p->rows[p->row_count++];
  *row = (field_row){.quantity = quantity, .height_m = height_m, .low_m = low_m};
  return row;
}

static neph_result measure_row(field_probe *p, np_plane_kind kind, bool is_up, field_row *row) {
  np_plane_query query = {.kind = kind,
                          .low_m = kind == NP_PLANE_ABSORBED ? row->low_m : row->height_m,
                          .high_m = row->height_m,
                          .is_up = is_up,
                          .columns = {1, 1}};
  unsigned ray_count;
  memcpy(query.box_min_m, p->box_min_m, sizeof query.box_min_m);
  memcpy(query.box_max_m, p->box_max_m, sizeof query.box_max_m);
  return np_plane_measure_to_target(&p->source, &query, p->desc.target_error, p->desc.path_count,
                                    (uint32_t)p->row_count, &p->monitor, &ray_count, &row->answer, NULL);
}

/* Measures the upward and downward flux of a plane, and the flux that clouds absorb between it and the next one. */
static neph_result measure_plane(field_probe *p, unsigned i) {
  const double height_m = p->desc.heights_m[i];
  neph_result result = measure_row(p, NP_PLANE_FLUX, true, add_row(p, "up", height_m, 0.0));
  if (!result) result = measure_row(p, NP_PLANE_FLUX, false, add_row(p, "down", height_m, 0.0));
  if (result || i + 1 == p->desc.height_count) return result;
  const double next_m = p->desc.heights_m[i + 1];
  field_row *row = add_row(p, "absorbed", fmax(height_m, next_m), fmin(height_m, next_m));
  return measure_row(p, NP_PLANE_ABSORBED, false, row);
}

static neph_result measure_all(field_probe *p) {
  np_monitor_set_stage(&p->monitor, "probing planes");
  p->rows = np_alloc(p->context, 3 * (size_t)p->desc.height_count, sizeof *p->rows);
  if (!p->rows) return NEPH_ERROR_OUT_OF_MEMORY;
  add_row(p, "incoming", NAN, NAN)->answer = compute_incoming(p);
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < p->desc.height_count && !result; i++) {
    np_monitor_set_range(&p->monitor, i / (double)p->desc.height_count, (i + 1.0) / p->desc.height_count);
    result = measure_plane(p, i);
  }
  return result;
}

/* ---- Output ---- */

static void print_height(FILE *out, bool has_height, double height_m) {
  if (has_height)
    fprintf(out, ",%.9g", height_m);
  else
    fputc(',', out);
}

static void print_rows(FILE *out, const void *user) {
  const field_probe *p = user;
  fputs("quantity,height_m,low_m,r,g,b,r_se,g_se,b_se\n", out);
  for (size_t i = 0; i < p->row_count; i++) {
    const field_row *row = &p->rows[i];
    fputs(row->quantity, out);
    print_height(out, !isnan(row->height_m), row->height_m);
    print_height(out, !strcmp(row->quantity, "absorbed"), row->low_m);
    for (int b = 0; b < NP_BAND_COUNT; b++) fprintf(out, ",%.6g", row->answer.value[b]);
    for (int b = 0; b < NP_BAND_COUNT; b++) fprintf(out, ",%.3g", row->answer.error[b]);
    fputc('\n', out);
  }
}

/* ---- The probe ---- */

static neph_result probe_assembly(field_probe *p, const neph_scene *scene, char **out_text) {
  set_views(p);
  set_source(p, scene);
  set_box(p);
  neph_result result = measure_all(p);
  if (!result) result = np_probe_write_text(p->context, print_rows, p, out_text);
  np_alloc_free(p->context, p->rows);
  return result;
}

/* The scene, evaluated in the frame, with pictures in bands. */
static neph_result probe_scene(field_probe *p, neph_scene *scene, char **out_text) {
  neph_render_desc render = NEPH_RENDER_DESC_DEFAULT;
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  np_assembly assembly;
  np_plan plan;
  scene->output.color_space = NP_COLOR_BANDS;
  neph_result result = neph_scene_get_render_desc(scene, &render);
  render.integrator = p->desc.integrator;
  render.frame = p->desc.frame;
  if (result) return result;
  result = np_plan_make(scene, &render, &plan);
  if (!result) result = np_assembly_build(scene, &plan, &job, &p->monitor, &assembly);
  if (!result) {
    p->plan = &plan;
    p->assembly = &assembly;
    result = probe_assembly(p, scene, out_text);
    np_assembly_clear(&assembly);
  }
  np_plan_clear(&plan);
  np_stores_clear(scene->context, &stores);
  return result;
}

static neph_result check_desc(neph_context *context, const neph_probe_field_desc *d) {
  if (!d->heights_m || d->height_count < 1 || d->height_count > HEIGHTS_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: the heights are %u, must be 1 to %d",
                   d->heights_m ? d->height_count : 0, HEIGHTS_MAX);
  for (unsigned i = 0; i < d->height_count; i++)
    if (!(fabs(d->heights_m[i]) <= 1e7))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: height %u is %g m, must be in [-1e7, 1e7]", i + 1,
                     d->heights_m[i]);
  for (int k = 0; k < 2; k++)
    if (!(d->box_min_m[k] <= d->box_max_m[k]) || !isfinite(d->box_max_m[k] - d->box_min_m[k]))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "probe: the box goes from %g m to %g m along %c, must have a positive width, or none for the box "
                     "of the clouds",
                     d->box_min_m[k], d->box_max_m[k], "xy"[k]);
  if (d->path_count < 1 || !(d->target_error > 0.0))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "probe: path_count is %u and target_error %g, must be at least 1 and above 0", d->path_count,
                   d->target_error);
  return NEPH_OK;
}

neph_result neph_probe_field(const neph_scene *scene, const neph_probe_field_desc *desc, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text, desc)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  neph_context *context = scene->context;
  const neph_probe_field_desc defaults = NEPH_PROBE_FIELD_DESC_DEFAULT;
  field_probe *p = np_alloc(context, 1, sizeof *p);
  neph_scene own = {.context = NULL};
  if (!p) return NEPH_ERROR_OUT_OF_MEMORY;
  p->context = context;
  neph_result result = np_desc_read(context, "neph_probe_field_desc", &defaults, sizeof defaults, desc, &p->desc);
  if (!result) result = check_desc(context, &p->desc);
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&p->monitor, context, p->desc.progress, p->desc.progress_user);
  if (!result) result = np_scene_eval(scene, p->desc.frame, &own);
  if (!result) result = probe_scene(p, &own, out_text);
  np_scene_eval_clear(&own);
  np_float_mode_leave(mode);
  np_alloc_free(context, p);
  return result;
}
