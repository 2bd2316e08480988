/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/request.h"

#include <math.h>
#include <string.h>

#include "core/parallel.h"
#include "image/film.h"
#include "plan/part_check.h"
#include "plan/plan_history.h"
#include "scene/cloud_places.h"

enum { SIZE_LIMIT = 65536 };

/* ---- The description ---- */

#define NAME(id, name, needs) " " name
#define NAMES NP_MULTIPLE_SCATTERING_ROWS(NAME)

static neph_result check_eye(const neph_scene *scene, const neph_render_desc *desc) {
  if (desc->eye == NEPH_EYE_CENTRE || (scene->camera.is_stereo && (unsigned)desc->eye <= NEPH_EYE_RIGHT))
    return NEPH_OK;
  return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "eye is %d, must be centre (0), or, of a scene with camera.stereo, left (1) or right (2)",
                 (int)desc->eye);
}

static neph_result check_desc(neph_context *context, const neph_render_desc *desc) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (desc->width < 1 || desc->height < 1 || desc->width > SIZE_LIMIT || desc->height > SIZE_LIMIT)
    return np_fail(context, bad, "the picture is %u x %u pixels, must be 1 to %d each way", desc->width, desc->height,
                   (int)SIZE_LIMIT);
  if (desc->detail_height > SIZE_LIMIT)
    return np_fail(context, bad, "detail_height is %u pixels, must be at most %d", desc->detail_height,
                   (int)SIZE_LIMIT);
  const unsigned *min = desc->crop_min, *max = desc->crop_max;
  if (min[0] >= max[0] || min[1] >= max[1] || max[0] > desc->width || max[1] > desc->height)
    return np_fail(context, bad, "the crop is %u,%u to %u,%u, must not be empty and lie within %u x %u pixels", min[0],
                   min[1], max[0], max[1], desc->width, desc->height);
  if (desc->tile_index >= desc->tile_count || desc->tile_count > max[1] - min[1])
    return np_fail(context, bad, "tile %u of %u is asked for, must be one of 1 to %u, the rows of the crop",
                   desc->tile_index + 1, desc->tile_count, max[1] - min[1]);
  if (desc->sample_count < 1 || desc->sample_count > NP_FILM_SAMPLES_MAX)
    return np_fail(context, bad, "samples is %u, must be 1 to %d", desc->sample_count, (int)NP_FILM_SAMPLES_MAX);
  if (!(desc->target_error > 0.0))
    return np_fail(context, bad, "target_error is %g, must be above 0", desc->target_error);
  if (!(desc->time_limit_s >= 0.0))
    return np_fail(context, bad, "time_limit_s is %g, must be at least 0", desc->time_limit_s);
  if (desc->sample_count_max < 16 || desc->sample_count_max > NP_FILM_SAMPLES_MAX)
    return np_fail(context, bad, "sample_count_max is %u, must be 16 to %d", desc->sample_count_max,
                   (int)NP_FILM_SAMPLES_MAX);
  if (!np_multiple_scattering_get_row(desc->multiple_scattering))
    return np_fail(context, bad, "multiple_scattering is %d, must be a neph_multiple_scattering, of:" NAMES,
                   (int)desc->multiple_scattering);
  if ((unsigned)desc->atmosphere > NEPH_RENDER_ATMOSPHERE_TABLES)
    return np_fail(context, bad, "atmosphere is %d, must be traced (0) or tables (1)", (int)desc->atmosphere);
  if ((unsigned)desc->path_guiding > NEPH_PATH_GUIDING_ADJOINT)
    return np_fail(context, bad, "path_guiding is %d, must be none (0) or adjoint (1)", (int)desc->path_guiding);
  if (desc->integrator != NEPH_INTEGRATOR_MARCH && desc->integrator != NEPH_INTEGRATOR_PATH)
    return np_fail(context, bad, "integrator is %d, must be march (0) or path (1)", (int)desc->integrator);
  return NEPH_OK;
}

neph_result np_request_read_desc(const neph_scene *scene, const neph_render_desc *desc, neph_render_desc *out_desc) {
  neph_render_desc own = NEPH_RENDER_DESC_DEFAULT;
  neph_result result = neph_scene_get_render_desc(scene, &own);
  if (!result) result = np_desc_read(scene->context, "neph_render_desc", &own, sizeof own, desc, out_desc);
  if (!result) result = check_eye(scene, out_desc);
  if (out_desc->sample_end == NEPH_SAMPLES_ALL) out_desc->sample_end = out_desc->sample_count;
  return result ? result : check_desc(scene->context, out_desc);
}

/* ---- Windows, samples and channels ---- */

/* Sets the windows. Edges of crop and tiles that are edges of the picture are extended by the overscan. */
static void set_windows(np_request *r, const neph_scene *scene) {
  const neph_render_desc *desc = &r->desc;
  const uint64_t rows = desc->crop_max[1] - desc->crop_min[1];
  const unsigned size[2] = {desc->width, desc->height};
  const int overscan = (int)scene->camera.overscan;
  for (int k = 0; k < 2; k++) {
    r->view_min[k] = -overscan;
    r->view_max[k] = (int)size[k] + overscan;
    r->whole_min[k] = r->window_min[k] = desc->crop_min[k] == 0 ? r->view_min[k] : (int)desc->crop_min[k];
    r->whole_max[k] = r->window_max[k] = desc->crop_max[k] == size[k] ? r->view_max[k] : (int)desc->crop_max[k];
  }
  if (desc->tile_index > 0) r->window_min[1] = (int)(desc->crop_min[1] + rows * desc->tile_index / desc->tile_count);
  if (desc->tile_index + 1 < desc->tile_count)
    r->window_max[1] = (int)(desc->crop_min[1] + rows * (desc->tile_index + 1) / desc->tile_count);
}

/* A deep pixel has 16 samples, where all the picture is cloud. */
static const uint64_t deep_bytes = 16 * 24;

static void count_work(np_request *r, const neph_scene *scene) {
  const uint64_t pixels = np_request_count_pixels(r);
  r->ray_count = pixels * (r->desc.sample_end - r->desc.sample_begin);
  if (np_plan_is_reconstructed(scene))
    r->ray_count = (uint64_t)ceil(np_plan_get_rendered_share(scene) * (double)r->ray_count);
  const unsigned own = r->has_beauty ? 5 : 2;
  r->film_bytes = pixels * (own + np_aovs_count_channels(r->aovs, scene->cloud_count)) * sizeof(float);
  if (r->desc.part_path || r->desc.checkpoint_path) r->film_bytes += 3 * r->film_bytes;
  if (scene->output.deep) r->film_bytes += pixels * deep_bytes;
}

/* Sets the least number of samples. A single sample has no error estimate: with a target error pixels get more, else
 * too few are refused. */
static neph_result require_samples(np_request *r) {
  unsigned *samples = &r->desc.sample_count;
  for (const np_aov_row *aov; (aov = np_aovs_search_short(r->aovs, *samples)); *samples = aov->samples_min)
    if (!isfinite(r->desc.target_error))
      return np_fail(r->context, NEPH_ERROR_BAD_SCENE,
                     "render.samples is %u, must be at least %u for the %s of output.aovs", *samples, aov->samples_min,
                     aov->name);
  return NEPH_OK;
}

/* ---- The request ---- */

static neph_result begin(const neph_scene *scene, const neph_render_desc *desc, np_request *r) {
  *r = (np_request){.context = scene->context};
  neph_result result = np_scene_check(scene);
  if (!result) result = np_cloud_places_check(scene);
  if (!result) result = np_request_read_desc(scene, desc, &r->desc);
  if (result) return result;
  const bool has_fewer_samples = r->desc.detail_height && r->desc.sample_count < scene->render.sample_count;
  r->takes_near = has_fewer_samples || np_request_is_coarse(r);
  const double given = scene->render.light_memory_bytes;
  const neph_machine constants = NEPH_MACHINE_DEFAULT, *machine = r->desc.machine;
  memcpy(r->work_factor, (machine ? machine : &constants)->factor, sizeof r->work_factor);
  r->light_bytes = isfinite(given) ? given : 0.25 * (double)np_memory_size();
  set_windows(r, scene);
  return NEPH_OK;
}

neph_result np_request_make(const neph_scene *scene, const neph_render_desc *desc, np_request *out_request) {
  neph_result result = begin(scene, desc, out_request);
  out_request->has_beauty = scene->output.has_beauty;
  out_request->aovs = scene->output.aovs;
  out_request->has_light_groups = scene->output.aovs & NP_AOV_LIGHTS;
  if (!result) result = require_samples(out_request);
  if (!result) result = np_part_check(scene, out_request);
  if (!result) result = np_plan_check_history(scene, out_request);
  if (!result) count_work(out_request, scene);
  return result;
}

neph_result np_request_make_sky(const neph_scene *scene, const np_sky_request *sky, np_request *out_request) {
  const neph_result result = begin(scene, NULL, out_request);
  out_request->has_beauty = out_request->is_sky_alone = true;
  out_request->sky = *sky;
  out_request->desc.atmosphere = NEPH_RENDER_ATMOSPHERE_TABLES; /* whatever integrator the scene's pictures take */
  return result;
}

np_request np_request_get_detail(const np_request *request, const neph_scene *scene) {
  np_request detail = *request;
  const unsigned height = request->desc.detail_height;
  if (!height) return detail;
  const double width = (double)request->desc.width * height / request->desc.height;
  detail.desc.width = (unsigned)fmin(fmax(round(width), 1.0), SIZE_LIMIT);
  detail.desc.height = height;
  detail.desc.sample_count = scene->render.sample_count;
  return detail;
}
