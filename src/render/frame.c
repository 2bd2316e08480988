/* SPDX-License-Identifier: Apache-2.0 */
#include "render/frame.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "image/film.h"
#include "image/image_private.h"
#include "integrate/integrator.h"

enum { TILE_EDGE = 8, CHANNELS_MAX = 48 };

/* What a channel holds: a sum over components, or one of the scalars. */
typedef enum source {
  SOURCE_COMPONENTS,
  SOURCE_ALPHA,
  SOURCE_TRANSMITTANCE,
  SOURCE_DEPTH,
  SOURCE_DISTANCE,
  SOURCE_STANDARD_ERROR
} channel_source;

typedef struct channel {
  const char *name;
  channel_source source;
  unsigned components; /* bit c: component c is part of it */
  unsigned band;
} channel;

/* The spread of a pixel's samples about their mean (Welford 1962), in R, G and B. */
typedef struct spread {
  unsigned count;
  double mean[NP_BAND_COUNT], squares[NP_BAND_COUNT]; /* Σ(x − mean)² */
} spread;

/* Over a tile's pixels: the sums of their means, and of the squares of the means' standard errors. */
typedef struct tile_total {
  double sum[NP_BAND_COUNT], variance[NP_BAND_COUNT];
} tile_total;

typedef struct frame {
  const np_assembly *assembly;
  const neph_render_desc *desc;
  np_monitor *monitor;
  np_integrator_settings settings;
  np_integrator_fn integrate;
  np_half_distance_fn half_distance;
  unsigned channel_count;
  channel channels[CHANNELS_MAX];
  float *planes[CHANNELS_MAX];
  unsigned beauty; /* components of the picture */
  tile_total *totals;
  float scale;
  unsigned width, height; /* of the crop */
  float blue_noise[NP_BLUE_NOISE_EDGE * NP_BLUE_NOISE_EDGE];
} frame;

/* --- channels ---------------------------------------------------------------------------------------------------- */

static void add_scalar(frame *f, const char *name, channel_source source) {
  f->channels[f->channel_count++] = (channel){.name = name, .source = source};
}

static void add_spectral(frame *f, const char *const names[NP_BAND_COUNT], unsigned components) {
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    f->channels[f->channel_count++] =
        (channel){.name = names[b], .source = SOURCE_COMPONENTS, .components = components, .band = b};
}

static void add_errors(frame *f) {
  static const char *const names[NP_BAND_COUNT] = {"standard_error.R", "standard_error.G", "standard_error.B"};
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    f->channels[f->channel_count++] = (channel){.name = names[b], .source = SOURCE_STANDARD_ERROR, .band = b};
}

static void choose_channels(frame *f, const np_plan *plan, bool has_background) {
  static const struct {
    np_aov aov;
    np_component component;
    const char *names[NP_BAND_COUNT];
  } layers[] = {
      {NP_AOV_BACKGROUND, NP_COMPONENT_BACKGROUND, {"background.R", "background.G", "background.B"}},
      {NP_AOV_TERRAIN, NP_COMPONENT_TERRAIN, {"terrain.R", "terrain.G", "terrain.B"}},
      {NP_AOV_AIR, NP_COMPONENT_AIR, {"air.R", "air.G", "air.B"}},
      {NP_AOV_SUN, NP_COMPONENT_SUN, {"sun.R", "sun.G", "sun.B"}},
      {NP_AOV_SKY, NP_COMPONENT_SKY, {"sky.R", "sky.G", "sky.B"}},
      {NP_AOV_GROUND, NP_COMPONENT_GROUND, {"ground.R", "ground.G", "ground.B"}},
      {NP_AOV_MULTIPLE, NP_COMPONENT_MULTIPLE, {"multiple.R", "multiple.G", "multiple.B"}},
  };
  static const char *const beauty[NP_BAND_COUNT] = {"R", "G", "B"};
  unsigned all = (1u << NP_COMPONENT_COUNT) - 1u;
  if (!has_background) all &= ~(1u << NP_COMPONENT_BACKGROUND);
  f->beauty = all;
  if (plan->has_beauty) add_spectral(f, beauty, all);
  add_scalar(f, "A", SOURCE_ALPHA);
  add_scalar(f, "Z", SOURCE_DEPTH);
  for (size_t i = 0; i < sizeof layers / sizeof *layers; i++)
    if (plan->aovs & layers[i].aov) add_spectral(f, layers[i].names, all & 1u << layers[i].component);
  if (plan->aovs & NP_AOV_TRANSMITTANCE) add_scalar(f, "transmittance", SOURCE_TRANSMITTANCE);
  if (plan->aovs & NP_AOV_STANDARD_ERROR) add_errors(f);
  if (plan->aovs & NP_AOV_DISTANCE) add_scalar(f, "distance", SOURCE_DISTANCE);
}

static float sum_components(const frame *f, unsigned components, unsigned band, const np_integrator_sample *sample) {
  float sum = 0.0f;
  for (unsigned i = 0; i < NP_COMPONENT_COUNT; i++)
    if (components & 1u << i) sum += sample->component[i].band[band];
  return sum * f->scale;
}

static float read_channel(const frame *f, const channel *c, const np_integrator_sample *sample) {
  if (c->source == SOURCE_ALPHA) return sample->is_ground_behind ? 1.0f : 1.0f - sample->transmittance;
  if (c->source == SOURCE_TRANSMITTANCE) return sample->transmittance;
  if (c->source != SOURCE_COMPONENTS) return 0.0f;
  return sum_components(f, c->components, c->band, sample);
}

/* --- errors ------------------------------------------------------------------------------------------------------ */

static void spread_add(const frame *f, const np_integrator_sample *sample, spread *s) {
  s->count++;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    const double x = (double)sum_components(f, f->beauty, b, sample), distance = x - s->mean[b];
    s->mean[b] += distance / s->count;
    s->squares[b] += distance * (x - s->mean[b]);
  }
}

/* Squared standard error of the mean as of independent samples: the spread of their points over the pixel makes it
 * less, never more. 0 where one sample tells nothing. */
static double spread_variance(const spread *s, unsigned band) {
  return s->count < 2 ? 0.0 : s->squares[band] / s->count / (s->count - 1);
}

/* --- pixels ------------------------------------------------------------------------------------------------------ */

/* Offset from a pixel's centre, distributed as a tent one pixel to each side: the reconstruction filter, by sampling.
 */
static float tent(float u) { return u < 0.5f ? sqrtf(2.0f * u) - 1.0f : 1.0f - sqrtf(2.0f - 2.0f * u); }

/* Low-discrepancy points of the plastic number (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
 * Sequences"), turned by a random offset per pixel; the golden ratio turns the blue noise from sample to sample. */
static float turn(float offset, double step, unsigned index) {
  const double x = (double)offset + step * (double)index;
  return (float)(x - floor(x));
}

static np_camera_ray make_ray(const frame *f, unsigned x, unsigned y, unsigned sample, const float offset[2]) {
  const float u = turn(offset[0], 0.7548776662466927, sample), v = turn(offset[1], 0.5698402909980532, sample);
  const float noise = f->blue_noise[y % NP_BLUE_NOISE_EDGE * NP_BLUE_NOISE_EDGE + x % NP_BLUE_NOISE_EDGE];
  const np_camera *camera = &f->assembly->camera;
  return (np_camera_ray){
      .origin = camera->origin,
      .direction = np_camera_direction(camera, (float)x + 0.5f + tent(u), (float)y + 0.5f + tent(v)),
      .jitter = turn(noise, 0.6180339887498949, sample),
  };
}

/* Distance along the ray of the pixel's centre to where cloud hides half, or to ground; infinite past both. */
static double find_distance(const frame *f, unsigned x, unsigned y, np_vec3 *out_direction) {
  const np_camera *camera = &f->assembly->camera;
  *out_direction = np_camera_direction(camera, (float)x + 0.5f, (float)y + 0.5f);
  const np_camera_ray ray = {.origin = camera->origin, .direction = *out_direction};
  np_ground_hit hit;
  const bool is_ground = np_ground_intersect(&f->assembly->packets[0].lights[0].view, ray.origin, ray.direction, &hit);
  const double ground = is_ground ? hit.distance_m : HUGE_VAL;
  return fmin(f->half_distance(&f->assembly->packets[0].lights[0].view, &ray, ground), ground);
}

static void write_pixel(const frame *f, unsigned x, unsigned y, const double *sums, const spread *errors) {
  np_vec3 direction;
  const double distance = find_distance(f, x, y, &direction);
  const double depth =
      isinf(distance) ? distance : -distance * (double)np_vec3_dot(direction, f->assembly->camera.back);
  const size_t pixel = (size_t)(y - f->desc->crop_min[1]) * f->width + (x - f->desc->crop_min[0]);
  for (unsigned c = 0; c < f->channel_count; c++) {
    double value = sums[c] / (double)f->desc->sample_count;
    if (f->channels[c].source == SOURCE_DEPTH) value = depth;
    if (f->channels[c].source == SOURCE_DISTANCE) value = distance;
    if (f->channels[c].source == SOURCE_STANDARD_ERROR) value = sqrt(spread_variance(errors, f->channels[c].band));
    f->planes[c][pixel] = (float)value;
  }
}

/* Light adds up: a scene under sun and moon is the scene under the one and under the other. Stars shine through what
 * the sample finds before them. */
static void integrate_packet(const frame *f, const np_packet *packet, const np_camera_ray *ray, const unsigned pixel[2],
                             np_random *random, np_integrator_sample *out) {
  f->integrate(&packet->lights[0].view, &f->settings, ray, random, out);
  for (unsigned l = 1; l < packet->light_count; l++) {
    np_integrator_sample more;
    f->integrate(&packet->lights[l].view, &f->settings, ray, random, &more);
    for (int c = 0; c < NP_COMPONENT_COUNT; c++)
      out->component[c] = np_spectrum_add(out->component[c], more.component[c]);
  }
  if (packet->stars.count && !out->is_ground_behind)
    out->component[NP_COMPONENT_BACKGROUND] =
        np_spectrum_add_scaled(out->component[NP_COMPONENT_BACKGROUND], out->transmittance,
                               np_star_field_get(&packet->stars, pixel[0], pixel[1]));
}

/* One sample of the picture: every packet along the same path, its bands added up to colours before anything is
 * squared. What does not depend on wavelength is the first packet's. */
static void integrate(const frame *f, const np_camera_ray *ray, const unsigned pixel[2], const np_random *random,
                      np_integrator_sample *out) {
  const np_assembly *a = f->assembly;
  np_random first_random = *random;
  integrate_packet(f, &a->packets[0], ray, pixel, &first_random, out);
  if (a->packet_count == 1) return;
  np_integrator_sample sample = *out;
  memset(out->component, 0, sizeof out->component);
  for (unsigned p = 0; p < a->packet_count; p++) {
    np_random same_random = *random;
    if (p > 0) integrate_packet(f, &a->packets[p], ray, pixel, &same_random, &sample);
    for (int c = 0; c < NP_COMPONENT_COUNT; c++)
      out->component[c] = np_packet_add_color(&a->packets[p], out->component[c], sample.component[c]);
  }
}

static neph_result render_pixel(const frame *f, unsigned x, unsigned y, tile_total *total) {
  np_film_accumulator accumulator;
  np_film_accumulator_begin(&accumulator, f->channel_count, 0);
  spread errors = {0};
  np_random shift = np_random_start(f->desc->seed, (uint32_t)f->desc->frame, x, y, UINT32_MAX);
  const float offset[2] = {np_random_float(&shift), np_random_float(&shift)};
  for (unsigned s = 0; s < f->desc->sample_count; s++) {
    if (np_monitor_is_cancelled(f->monitor)) return NEPH_ERROR_CANCELLED;
    const np_random random = np_random_start(f->desc->seed, (uint32_t)f->desc->frame, x, y, s);
    const np_camera_ray ray = make_ray(f, x, y, s, offset);
    np_integrator_sample sample;
    integrate(f, &ray, (unsigned[2]){x, y}, &random, &sample);
    float values[CHANNELS_MAX];
    for (unsigned c = 0; c < f->channel_count; c++) values[c] = read_channel(f, &f->channels[c], &sample);
    np_film_accumulator_add(&accumulator, values);
    spread_add(f, &sample, &errors);
  }
  double sums[CHANNELS_MAX];
  np_film_accumulator_finish(&accumulator, sums);
  write_pixel(f, x, y, sums, &errors);
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    total->sum[b] += errors.mean[b];
    total->variance[b] += spread_variance(&errors, b);
  }
  return NEPH_OK;
}

static neph_result render_tiles(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const frame *f = user;
  const size_t tiles_across = (f->width + TILE_EDGE - 1) / TILE_EDGE;
  for (size_t tile = begin; tile < end; tile++) {
    const unsigned x0 = (unsigned)(tile % tiles_across) * TILE_EDGE, y0 = (unsigned)(tile / tiles_across) * TILE_EDGE;
    for (unsigned y = y0; y < y0 + TILE_EDGE && y < f->height; y++)
      for (unsigned x = x0; x < x0 + TILE_EDGE && x < f->width; x++) {
        neph_result result = render_pixel(f, f->desc->crop_min[0] + x, f->desc->crop_min[1] + y, &f->totals[tile]);
        if (result) return result;
      }
  }
  return NEPH_OK;
}

/* --- a frame ----------------------------------------------------------------------------------------------------- */

static bool is_lit(const np_plan *plan) {
  return plan->stages[NP_STAGE_SUN_LIGHT].is_needed || plan->stages[NP_STAGE_SKY_LIGHT].is_needed ||
         plan->stages[NP_STAGE_MOON].is_needed;
}

static np_look choose_look(const np_scene_render *render, neph_multiple_scattering multiple) {
  static const np_look_kind kinds[] = {
      [NEPH_MULTIPLE_SCATTERING_NONE] = NP_LOOK_OCTAVES,
      [NEPH_MULTIPLE_SCATTERING_OCTAVES] = NP_LOOK_OCTAVES,
      [NEPH_MULTIPLE_SCATTERING_ORDINATES] = NP_LOOK_OCTAVES,
      [NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER] = NP_LOOK_SOFTENED_BEER,
      [NEPH_MULTIPLE_SCATTERING_POWDER] = NP_LOOK_POWDER,
      [NEPH_MULTIPLE_SCATTERING_DERIVATIVE] = NP_LOOK_DERIVATIVE,
  };
  const bool is_look = multiple != NEPH_MULTIPLE_SCATTERING_NONE && multiple != NEPH_MULTIPLE_SCATTERING_ORDINATES;
  return (np_look){
      .kind = kinds[multiple],
      .gain = is_look ? (float)render->look_gain : 1.0f,
      .octave_count = multiple == NEPH_MULTIPLE_SCATTERING_OCTAVES ? render->octave_count : 1,
      .octave_light = (float)render->octave_factors[0],
      .octave_depth = (float)render->octave_factors[1],
      .octave_asymmetry = (float)render->octave_factors[2],
      .softened_share = (float)render->softened_share,
      .softened_rate = (float)render->softened_rate,
      .powder_strength = (float)render->powder_strength,
      .derivative_distance_m = (float)render->derivative_distance_m,
  };
}

void np_frame_choose_settings(const np_scene_render *render, neph_multiple_scattering multiple,
                              np_integrator_settings *out_settings) {
  *out_settings = (np_integrator_settings){
      .scattering_max = render->scattering_max,
      .look = choose_look(render, multiple),
      .step_voxels = (float)render->step_voxels,
      .light_step_voxels = (float)render->step_voxels,
      .transmittance_end = (float)render->transmittance_end,
  };
}

static void choose_integrator(frame *f, const np_plan *plan, const np_scene_render *render) {
  const bool has_look = plan->stages[NP_STAGE_LOOK].is_needed;
  np_frame_choose_settings(render, has_look ? f->desc->multiple_scattering : NEPH_MULTIPLE_SCATTERING_NONE,
                           &f->settings);
  f->settings.scattering_max = is_lit(plan) ? f->desc->scattering_max : 0;
  const np_integrator_kernels *kernels = np_integrator_get_kernels(neph_context_get_isa(f->assembly->context));
  f->integrate = f->desc->integrator == NEPH_INTEGRATOR_PATH ? kernels->path : kernels->march;
  f->half_distance = kernels->half_distance;
}

static void fill_header(const frame *f, neph_image *image) {
  np_image_header *header = &image->header;
  header->has_camera = true;
  np_camera_get_matrices(&f->assembly->camera, header->world_to_camera, header->world_to_ndc);
  header->has_window = true;
  for (int a = 0; a < 2; a++) {
    header->data_min[a] = (int)f->desc->crop_min[a];
    header->data_max[a] = (int)f->desc->crop_max[a] - 1;
    header->display_max[a] = (int)(a == 0 ? f->desc->width : f->desc->height) - 1;
  }
}

static neph_result create_image(frame *f, neph_image **out_image) {
  const char *names[CHANNELS_MAX];
  for (unsigned c = 0; c < f->channel_count; c++) names[c] = f->channels[c].name;
  neph_result result = neph_image_create(f->assembly->context, f->width, f->height, f->channel_count, names, out_image);
  if (result) return result;
  for (unsigned c = 0; c < f->channel_count; c++) f->planes[c] = neph_image_get_channel(*out_image, names[c]);
  fill_header(f, *out_image);
  return NEPH_OK;
}

static size_t count_tiles(const frame *f) {
  return (size_t)((f->width + TILE_EDGE - 1) / TILE_EDGE) * ((f->height + TILE_EDGE - 1) / TILE_EDGE);
}

static neph_result set_triple(neph_image *image, const char *name, const double values[NP_BAND_COUNT]) {
  char text[96];
  (void)snprintf(text, sizeof text, "%.6g %.6g %.6g", values[0], values[1], values[2]);
  return neph_image_set_attribute(image, name, text);
}

/* The picture's mean and its standard error, into header and log. */
static neph_result describe_mean(const frame *f, neph_image *image) {
  const double pixels = (double)f->width * f->height;
  double mean[NP_BAND_COUNT] = {0}, error[NP_BAND_COUNT] = {0};
  for (size_t tile = 0; tile < count_tiles(f); tile++)
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      mean[b] += f->totals[tile].sum[b] / pixels;
      error[b] += f->totals[tile].variance[b];
    }
  for (int b = 0; b < NP_BAND_COUNT; b++) error[b] = sqrt(error[b]) / pixels;
  neph_result result = set_triple(image, "nephos:mean", mean);
  if (result || f->desc->sample_count < 2) return result;
  np_log(f->assembly->context, NEPH_LOG_DEBUG, "mean of R, G, B: %.6g +- %.2g, %.6g +- %.2g, %.6g +- %.2g", mean[0],
         error[0], mean[1], error[1], mean[2], error[2]);
  return set_triple(image, "nephos:meanStandardError", error);
}

static neph_result integrate_frame(frame *f, neph_image *image) {
  f->totals = np_alloc(f->assembly->context, count_tiles(f), sizeof *f->totals);
  if (!f->totals) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(f->monitor, "rendering");
  neph_result result = np_parallel_for(f->assembly->context, f->monitor, count_tiles(f), 1, render_tiles, f);
  return result ? result : describe_mean(f, image);
}

neph_result np_frame_render(const neph_scene *scene, const np_plan *plan, const np_assembly *assembly,
                            np_monitor *monitor, neph_image **out_image) {
  const neph_render_desc *desc = &plan->desc;
  neph_context *context = assembly->context;
  frame *f = np_alloc(context, 1, sizeof *f);
  if (!f) return NEPH_ERROR_OUT_OF_MEMORY;
  f->assembly = assembly;
  f->desc = desc;
  f->monitor = monitor;
  f->scale = (float)scene->output.scale;
  f->width = desc->crop_max[0] - desc->crop_min[0];
  f->height = desc->crop_max[1] - desc->crop_min[1];
  choose_channels(f, plan, scene->output.has_background);
  choose_integrator(f, plan, &scene->render);
  np_blue_noise_fill(f->blue_noise);
  neph_result result = create_image(f, out_image);
  if (!result) result = integrate_frame(f, *out_image);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  np_alloc_free(context, f->totals);
  np_alloc_free(context, f);
  return result;
}
