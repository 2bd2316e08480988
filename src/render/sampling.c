/* SPDX-License-Identifier: Apache-2.0 */
/* The samples of a frame's pixels: which rays, how many, in what order. */
#include <string.h>

#include "core/alloc.h"
#include "image/film.h"
#include "integrate/blue_noise_table.h"
#include "render/frame_layers.h"
#include "render/part_film.h"
#include "render/part_header.h"
#include "volume/depth_cursor.h"

/* ---- One sample ---- */

/* Offset from a pixel's centre, distributed as a tent one pixel to each side: the reconstruction filter, by sampling.
 */
static float tent(float u) { return u < 0.5f ? sqrtf(2.0f * u) - 1.0f : 1.0f - sqrtf(2.0f - 2.0f * u); }

/* Low-discrepancy points of the plastic number (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
 * Sequences"), turned by a random offset per pixel; the golden ratio turns the blue noise from sample to sample. */
static float turn(float offset, double step, unsigned index) {
  const double x = (double)offset + step * (double)index;
  return (float)(x - floor(x));
}

/* Ray of the integrators from one of the lens; the clipping planes of the camera are its ends. */
static np_camera_ray clip_ray(const np_film_ray *ray, const float film[2]) {
  const bool is_near = ray->near_m > 0.0;
  return (np_camera_ray){.origin = is_near ? np_dvec3_along(ray->origin, ray->direction, ray->near_m) : ray->origin,
                         .direction = ray->direction,
                         .film = {film[0], film[1]},
                         .begin_m = ray->near_m,
                         .has_end = isfinite(ray->far_m),
                         .end_m = ray->far_m - ray->near_m};
}

/* Offsets of a pixel's sequences from sample to sample. */
enum { OFFSETS = 5 };

/* False: no light falls there. */
static bool make_ray(const np_frame *f, int x, int y, unsigned sample, const float offset[OFFSETS],
                     np_camera_ray *out) {
  const float u = turn(offset[0], 0.7548776662466927, sample), v = turn(offset[1], 0.5698402909980532, sample);
  const float film[2] = {(float)x + 0.5f + tent(u), (float)y + 0.5f + tent(v)};
  np_film_ray ray;
  if (!np_camera_start_ray(&f->assembly->camera, film[0], film[1], turn(offset[3], 0.8191725133961645, sample),
                           turn(offset[4], 0.6710436067037893, sample), &ray))
    return false;
  *out = clip_ray(&ray, film);
  out->jitter = turn(np_blue_noise_get(x, y), 0.6180339887498949, sample);
  out->choice = turn(offset[2], 0.6180339887498949, sample);
  return true;
}

/* Distance along the ray of the pixel's centre, through that of the lens, to where cloud hides half, or to ground;
 * infinite past both. */
static double compute_distance(const np_frame *f, int x, int y, np_vec3 *out_direction) {
  const np_camera *camera = &f->assembly->camera;
  const np_world *world = &f->assembly->packets[0].lights[0].world;
  const float film[2] = {(float)x + 0.5f, (float)y + 0.5f};
  np_film_ray middle;
  const bool has_ray = np_camera_start_ray(camera, film[0], film[1], 0.5f, 0.0f, &middle);
  *out_direction = middle.direction;
  if (!has_ray) return HUGE_VAL;
  const np_camera_ray ray = clip_ray(&middle, film);
  np_ground_hit hit;
  const bool is_ground = np_camera_ray_intersect_ground(world, &ray, &hit);
  const double end = is_ground ? hit.distance_m : np_camera_ray_get_end(&ray);
  const double cloud = f->half_distance(world, &ray, end);
  return ray.begin_m + fmin(cloud, is_ground ? end : HUGE_VAL);
}

/* Optical depth of all clouds up to the ground, whatever an integrator saw of them. */
static float compute_optical_depth(const np_frame *f, const np_camera_ray *ray) {
  const np_world *world = &f->assembly->packets[0].lights[0].world;
  np_ground_hit hit;
  const bool is_ground = np_camera_ray_intersect_ground(world, ray, &hit);
  const double end = is_ground ? hit.distance_m : np_camera_ray_get_end(ray);
  np_depth_cursors clouds;
  np_depth_cursors_start(&clouds, &world->clouds, ray->origin, ray->direction, end);
  np_depth_cursors_advance(&clouds, end);
  return (float)np_depth_cursors_sum(&clouds);
}

/* Light adds up: a scene under sun and moon is the scene under the one and under the other. Stars shine through what
 * the sample finds before them. */
static void integrate_packet(const np_frame *f, const np_packet *packet, const np_camera_ray *ray, const int pixel[2],
                             np_random *random, np_integrator_sample *out) {
  f->integrate(&packet->lights[0].world, &packet->lights[0].lighting, &f->settings, ray, random, out);
  if (f->has_light_groups) np_frame_add_group(f, ray, packet->lights[0].group, out);
  for (unsigned l = 1; l < packet->light_count; l++) {
    np_integrator_sample more;
    np_integrator_layers layers;
    np_camera_ray same = *ray;
    if (ray->layers) same.layers = np_frame_start_layers(f, &layers);
    f->integrate(&packet->lights[l].world, &packet->lights[l].lighting, &f->settings, &same, random, &more);
    if (ray->layers) np_integrator_append_light(ray->layers, &layers);
    if (f->has_light_groups) np_frame_add_group(f, ray, packet->lights[l].group, &more);
    for (int c = 0; c < NP_COMPONENT_ALL; c++)
      out->component[c] = np_spectrum_add(out->component[c], more.component[c]);
    out->lost = np_spectrum_add(out->lost, more.lost);
    out->cut_count += more.cut_count;
    out->followed_count += more.followed_count;
  }
  if ((!packet->stars.count && !packet->stars.blurred) || out->is_ground_behind) return;
  const np_spectrum stars =
      np_spectrum_scale(np_star_field_get(&packet->stars, pixel[0], pixel[1]), out->transmittance);
  out->component[NP_COMPONENT_BACKGROUND] = np_spectrum_add(out->component[NP_COMPONENT_BACKGROUND], stars);
  if (!f->has_light_groups || !(f->channels.beauty & 1u << NP_COMPONENT_BACKGROUND)) return;
  np_spectrum *sky = &ray->layers->group[NP_LIGHT_GROUP_SKY];
  *sky = np_spectrum_add(*sky, stars);
}

/* One sample of the picture: every packet along the same path, its bands added up to colours before anything is
 * squared. What does not depend on wavelength is the first packet's. */
static void integrate(const np_frame *f, const np_camera_ray *ray, const int pixel[2], const np_random *random,
                      np_integrator_sample *out) {
  const np_assembly *a = f->assembly;
  np_random first_random = *random;
  integrate_packet(f, &a->packets[0], ray, pixel, &first_random, out);
  if (a->is_of_bands) return;
  np_integrator_sample sample = *out;
  memset(out->component, 0, sizeof out->component);
  out->lost = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++) {
    np_random same_random = *random;
    np_integrator_layers layers;
    np_camera_ray same = *ray;
    if (ray->layers && p > 0) same.layers = np_frame_start_layers(f, &layers);
    if (p > 0) integrate_packet(f, &a->packets[p], &same, pixel, &same_random, &sample);
    if (ray->layers) np_frame_convert_layers(&a->packets[p], same.layers);
    if (ray->layers && p > 0) np_integrator_append_light(ray->layers, &layers);
    for (int c = 0; c < NP_COMPONENT_ALL; c++)
      out->component[c] = np_packet_add_color(&a->packets[p], out->component[c], sample.component[c]);
    out->lost = np_packet_add_color(&a->packets[p], out->lost, sample.lost);
  }
}

static np_random start_random(const np_frame *f, const int at[2], uint32_t sample) {
  return np_random_start(f->desc->seed, (uint32_t)f->desc->frame, (uint32_t)at[0], (uint32_t)at[1], sample);
}

neph_result np_frame_sample_pixel(const np_frame *f, const int at[2], uint32_t end, np_pixel_state *p,
                                  double *numbers) {
  np_film_accumulator accumulator;
  const uint32_t begun = p->next % NP_FILM_LEAF_SAMPLES, before = p->next - begun - p->begin;
  np_film_accumulator_begin_moments(&accumulator, f->channels.sum_count + NP_PIXEL_SUMS_OWN, NP_BAND_COUNT,
                                    p->next - begun);
  if (begun) (void)np_film_accumulator_add_node(&accumulator, &(np_film_node){p->next - begun, begun, numbers});
  np_random shift = start_random(f, at, UINT32_MAX);
  float offset[OFFSETS];
  for (int i = 0; i < OFFSETS; i++) offset[i] = np_random_float(&shift);
  np_deep_bins bins;
  if (f->depth_components) np_deep_bins_load(&p->deep, &bins);
  for (; p->next < end; p->next++) {
    const np_random random = start_random(f, at, p->next);
    np_integrator_layers layers;
    np_camera_ray ray = {.begin_m = 0.0};
    np_integrator_sample sample = {.transmittance = 1.0f};
    const bool has_ray = make_ray(f, at[0], at[1], p->next, offset, &ray);
    if (f->has_layers) ray.layers = np_frame_start_layers(f, &layers);
    if (has_ray) integrate(f, &ray, at, &random, &sample);
    if (has_ray && f->aovs & NP_AOV_OPTICAL_DEPTH) sample.optical_depth = compute_optical_depth(f, &ray);
    if (np_monitor_is_cancelled(f->monitor)) break;
    float values[NP_PIXEL_NUMBERS_MAX];
    np_channels_read_numbers(&f->channels, &ray, &sample, values);
    if (f->depth_components) np_frame_add_deep(f, &sample, &layers, &bins);
    np_film_accumulator_add(&accumulator, values);
  }
  if (f->depth_components && np_deep_bins_store(f->assembly->context, &bins, &p->deep)) return NEPH_ERROR_OUT_OF_MEMORY;
  double added[NP_PIXEL_NUMBERS_MAX];
  np_film_accumulator_finish(&accumulator, added);
  if (before) np_film_accumulator_join(&accumulator, numbers, before, added, p->next - p->begin - before);
  memcpy(numbers, added, np_channels_count_numbers(&f->channels) * sizeof *numbers);
  if (p->record && p->next == end) np_part_film_keep(f->part, p->record, &accumulator, added, end - p->begin);
  return p->next < end ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

/* ---- How many samples ---- */

static bool has_limit(const np_frame *f) { return isfinite(f->desc->time_limit_s); }

static uint32_t round_up_to_leaf(double count) {
  return (uint32_t)(ceil(count / NP_FILM_LEAF_SAMPLES) * NP_FILM_LEAF_SAMPLES);
}

uint32_t np_frame_get_first_sample(const np_frame *f) {
  return np_frame_has_target(f) ? round_up_to_leaf(f->desc->sample_count) : f->desc->sample_begin;
}

/* Two stages (Stein 1945, "A Two-Sample Test for a Linear Hypothesis Whose Power is Independent of the Variance"): the
 * spread of a first set of samples, the pilot, says how many the second needs, and only the second is kept. A pixel
 * that stopped when its own samples happened to agree would be too dark where bright ones are rare; this one knows
 * nothing of them. A pilot speaks for the pixels around it too, since a cloud's edge may hide from sixteen samples. */
static bool is_in_view(const np_frame *f, const int at[2]) {
  return at[0] >= f->view_min[0] && at[0] < f->view_max[0] && at[1] >= f->view_min[1] && at[1] < f->view_max[1];
}

static neph_result fly_pilots(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_frame *f = user;
  const neph_render_desc *d = f->desc;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < f->width + 2; column++) {
      const int at[2] = {f->min[0] + (int)column - 1, f->min[1] + (int)row - 1};
      if (!is_in_view(f, at)) continue;
      np_pixel_state p = {.next = 0};
      double numbers[NP_PIXEL_NUMBERS_MAX];
      neph_result result = np_frame_sample_pixel(f, at, d->sample_count, &p, numbers);
      np_alloc_free(f->assembly->context, p.deep.at);
      if (result) return result;
      f->pilots[row * (f->width + 2) + column] = np_channels_get_spread(&f->channels, numbers, p.next);
    }
  return NEPH_OK;
}

/* Samples that a pixel needs by the pilots of itself and its neighbours; 0 where there are none. */
static double count_needed(const np_frame *f, const int at[2]) {
  double mean[NP_BAND_COUNT] = {0}, variance[NP_BAND_COUNT] = {0}, worst = 0.0;
  const size_t x = (size_t)(at[0] - f->min[0]), y = (size_t)(at[1] - f->min[1]);
  unsigned count = 0;
  for (size_t n = 0; n < 9; n++) {
    const np_spread *pilot = &f->pilots[(y + n / 3) * (f->width + 2) + x + n % 3];
    count += pilot->count > 0;
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
      mean[b] += pilot->mean[b];
      variance[b] += np_spread_variance(pilot, b) * pilot->count;
    }
  }
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    if (variance[b] > 0.0) worst = fmax(worst, variance[b] / count / pow(fmax(fabs(mean[b]) / count, f->dim[b]), 2.0));
  return worst / (f->noise_target * f->noise_target);
}

static np_pixel_state start_pixel(const np_frame *f, const int at[2]) {
  const neph_render_desc *d = f->desc;
  const uint32_t begin = np_frame_get_first_sample(f);
  if (!np_frame_has_target(f)) return (np_pixel_state){.begin = begin, .next = begin, .end = d->sample_end};
  const double count = fmin(fmax(count_needed(f, at), d->sample_count), d->sample_count_max);
  return (np_pixel_state){.begin = begin, .next = begin, .end = begin + (uint32_t)ceil(count)};
}

static neph_result finish_pixel(const np_frame *f, const int at[2], const np_pixel_state *p, const double *numbers,
                                np_tile_total *total) {
  np_pixel_facts facts = {.spread = np_channels_get_spread(&f->channels, numbers, p->next - p->begin)};
  np_vec3 direction;
  facts.distance = compute_distance(f, at[0], at[1], &direction);
  facts.depth = np_camera_get_depth(&f->assembly->camera, direction, facts.distance);
  const size_t index = (size_t)(at[1] - f->min[1]) * f->width + (size_t)(at[0] - f->min[0]);
  if (p->record) {
    p->record[NP_PART_RECORD_DISTANCE] = facts.distance;
    p->record[NP_PART_RECORD_DEPTH] = facts.depth;
  }
  np_frame_develop_pixel(f, index, &facts, numbers, total);
  if (!f->depth_components) return NEPH_OK;
  return np_frame_set_deep(f, p, index, np_camera_get_depth(&f->assembly->camera, direction, 1.0));
}

/* Without a time limit: all of a pixel at once. */
static neph_result render_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  np_pixel_state p = start_pixel(f, at);
  double numbers[NP_PIXEL_NUMBERS_MAX];
  if (f->part && np_part_film_develop(f->part, f, index, total)) return NEPH_OK;
  if (f->part) p.record = np_part_film_get_record(f->part, index);
  neph_result result = np_frame_sample_pixel(f, at, p.end, &p, numbers);
  if (!result) result = finish_pixel(f, at, &p, numbers, total);
  np_alloc_free(f->assembly->context, p.deep.at);
  return result;
}

/* With one: a sample of every pixel, then the rest of its first leaf, then leaf after leaf. */
static neph_result extend_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)total;
  np_pixel_state *p = &f->pixels[index];
  if (f->is_first_pass) *p = start_pixel(f, at);
  if (p->next >= p->end) return NEPH_OK;
  const uint32_t leaf_end = (p->next / NP_FILM_LEAF_SAMPLES + 1) * NP_FILM_LEAF_SAMPLES;
  const uint32_t end = f->is_first_pass ? p->next + 1 : leaf_end;
  return np_frame_sample_pixel(f, at, end < p->end ? end : p->end, p,
                               f->numbers + index * np_channels_count_numbers(&f->channels));
}

static neph_result close_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  return finish_pixel(f, at, &f->pixels[index], f->numbers + index * np_channels_count_numbers(&f->channels), total);
}

/* ---- Tiles ---- */

typedef neph_result pixel_step_fn(const np_frame *f, const int at[2], size_t index, np_tile_total *total);

typedef struct tile_job {
  const np_frame *f;
  pixel_step_fn *step;
  bool is_shown; /* its tiles are in the image */
} tile_job;

static neph_result render_tiles(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const tile_job *job = user;
  const np_frame *f = job->f;
  const size_t tiles_across = (f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  for (size_t tile = begin; tile < end; tile++) {
    const unsigned x0 = (unsigned)(tile % tiles_across) * NP_TILE_EDGE;
    const unsigned y0 = (unsigned)(tile / tiles_across) * NP_TILE_EDGE;
    for (unsigned y = y0; y < y0 + NP_TILE_EDGE && y < f->height; y++)
      for (unsigned x = x0; x < x0 + NP_TILE_EDGE && x < f->width; x++) {
        const int at[2] = {f->min[0] + (int)x, f->min[1] + (int)y};
        neph_result result = job->step(f, at, (size_t)y * f->width + x, &f->totals[tile]);
        if (result) return result;
      }
    if (job->is_shown && f->part) np_part_film_mark(f->part, tile);
    if (job->is_shown) np_tile_feed_mark(f->feed, tile);
  }
  return NEPH_OK;
}

size_t np_frame_count_tiles(const np_frame *f) {
  return (size_t)((f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE) * ((f->height + NP_TILE_EDGE - 1) / NP_TILE_EDGE);
}

static neph_result run_tiles(np_frame *f, pixel_step_fn *step, bool is_shown) {
  tile_job job = {f, step, is_shown};
  return np_parallel_for(f->assembly->context, f->monitor, np_frame_count_tiles(f), 1, render_tiles, &job);
}

/* Tiles that go into the image, and on to who looks at it. */
static neph_result show_tiles(np_frame *f, pixel_step_fn *step, bool is_final) {
  f->feed->is_final = is_final;
  neph_result result = run_tiles(f, step, true);
  if (!result && !np_tile_feed_deliver(f->feed, np_monitor_get_seconds(f->monitor))) result = NEPH_ERROR_CANCELLED;
  f->feed->pass_index++;
  return result;
}

/* Passes that the pixel needs after the first one, and that one; or `passes` where those are more. */
static uint32_t max_passes(const np_pixel_state *p, uint32_t passes) {
  const uint32_t leaves = (p->end - 1) / NP_FILM_LEAF_SAMPLES - p->next / NP_FILM_LEAF_SAMPLES + 1;
  const uint32_t needed = p->next < p->end ? 1 + leaves : 1;
  return needed > passes ? needed : passes;
}

static uint32_t count_passes(const np_frame *f) {
  uint32_t passes = 1;
  for (size_t i = 0; i < (size_t)f->width * f->height; i++) passes = max_passes(&f->pixels[i], passes);
  return passes;
}

/* Runs what may be cut until a time, and not at all where that is past. */
static neph_result run_until(np_frame *f, double end_s, neph_result (*run)(np_frame *f), bool *out_is_cut) {
  np_monitor_begin_budget(f->monitor, end_s);
  const neph_result result = run(f);
  *out_is_cut = np_monitor_end_budget(f->monitor);
  return *out_is_cut && result == NEPH_ERROR_CANCELLED ? NEPH_OK : result;
}

static neph_result run_pass(np_frame *f) { return run_tiles(f, extend_pixel, false); }

/* Value of a pixel by the samples so far, for a live view. */
static neph_result preview_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)total;
  np_tile_total unused = {.samples = 0};
  return close_pixel(f, at, index, &unused);
}

static neph_result preview_pass(np_frame *f) {
  return f->feed->fn && !f->is_cut ? show_tiles(f, preview_pixel, false) : NEPH_OK;
}

/* Passes end when all are done, or at the limit: progress is that of which comes first. */
static void set_pass_range(const np_frame *f, double begin_s, uint32_t pass, double passes) {
  const double by_time = (np_monitor_get_seconds(f->monitor) - begin_s) / (f->assembly->schedule.limit_s - begin_s);
  const double begin = fmax(pass / passes, by_time > 0.0 ? fmin(by_time, 1.0) : 0.0);
  np_monitor_set_range(f->monitor, begin, fmax((pass + 1) / passes, begin));
}

/* The first pass gives every pixel its sample, without which there is no picture: the call's deadline ends it, and from
 * then on need end nothing. The first leaf of samples may take some of the grace. */
static neph_result run_passes(np_frame *f) {
  const np_schedule *schedule = &f->assembly->schedule;
  const double begin_s = np_monitor_get_seconds(f->monitor);
  f->is_first_pass = true;
  set_pass_range(f, begin_s, 0, 2.0 + f->desc->sample_count / NP_FILM_LEAF_SAMPLES);
  neph_result result = run_pass(f);
  if (!result) result = preview_pass(f);
  if (result) return result;
  f->is_first_pass = false;
  np_monitor_set_deadline(f->monitor, HUGE_VAL);
  const uint32_t passes = count_passes(f);
  for (uint32_t pass = 1; pass < passes && !f->is_cut && !result; pass++) {
    set_pass_range(f, begin_s, pass, passes);
    result = run_until(f, pass == 1 ? schedule->first_samples_s : schedule->limit_s, run_pass, &f->is_cut);
    if (!result && pass + 1 < passes) result = preview_pass(f);
  }
  return result;
}

/* Whole passes, so that every pixel has its share when time is up. */
static neph_result render_passes(np_frame *f) {
  neph_context *context = f->assembly->context;
  const size_t count = (size_t)f->width * f->height;
  f->pixels = np_alloc(context, count, sizeof *f->pixels);
  f->numbers = np_alloc(context, count, np_channels_count_numbers(&f->channels) * sizeof *f->numbers);
  neph_result result = f->pixels && f->numbers ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = run_passes(f);
  np_monitor_set_range(f->monitor, 1.0, 1.0);
  if (!result) result = show_tiles(f, close_pixel, true);
  for (size_t i = 0; f->pixels && i < count; i++) np_alloc_free(context, f->pixels[i].deep.at);
  np_alloc_free(context, f->pixels);
  np_alloc_free(context, f->numbers);
  return result;
}

static neph_result run_pilots(np_frame *f) {
  return np_parallel_for(f->assembly->context, f->monitor, f->height + 2, 1, fly_pilots, f);
}

/* A quarter of the rest of a time limit is for pilots. A pixel without any gets the least number of samples. */
static neph_result sample_pilots(np_frame *f) {
  neph_context *context = f->assembly->context;
  f->pilots = np_alloc(context, (size_t)(f->width + 2) * (f->height + 2), sizeof *f->pilots);
  if (!f->pilots) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(f->monitor, "sampling the picture's noise");
  const double now_s = np_monitor_get_seconds(f->monitor), left_s = fmax(f->assembly->schedule.limit_s - now_s, 0.0);
  bool is_cut;
  return run_until(f, now_s + 0.25 * left_s, run_pilots, &is_cut);
}

/* Mean radiance of emission, over the box of the clouds: seen from all sides its area is a quarter of its surface. */
static np_spectrum compute_mean_emission(const np_assembly *a, const np_packet *packet) {
  const np_dvec3 size = np_dvec3_subtract(a->clouds_max, a->clouds_min);
  const double area = 0.5 * (size.x * size.y + size.y * size.z + size.z * size.x);
  const np_spectrum dark = np_spectrum_grey(0.0f);
  return packet->emission.emitter_count > 0 && area > 0.0
             ? np_spectrum_scale(packet->emission.power_w_sr_nm, (float)(1.0 / area))
             : dark;
}

/* A hundredth of a white wall in full light, and of emission: in darker places an error relative to them would cost
 * much and show little. */
static void compute_dim(np_frame *f) {
  const np_assembly *a = f->assembly;
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++) {
    np_spectrum light = compute_mean_emission(a, &a->packets[p]);
    for (unsigned l = 0; l < a->packets[p].light_count; l++) {
      const np_world *world = &a->packets[p].lights[l].world;
      light = np_spectrum_add(light, np_spectrum_add_scaled(world->environment_radiance, 1.0f / NP_PI_F,
                                                            world->sun_scope == NP_SUN_SKY ? np_spectrum_grey(0.0f)
                                                                                           : world->sun_irradiance));
    }
    sum = a->is_of_bands ? light : np_packet_add_color(&a->packets[p], sum, light);
  }
  for (int b = 0; b < NP_BAND_COUNT; b++) f->dim[b] = 0.01 * (double)(sum.band[b] * f->channels.scale);
}

neph_result np_frame_sample(np_frame *f) {
  compute_dim(f);
  const np_monitor_part whole = np_monitor_get_part(f->monitor);
  const double pilots_end = np_frame_has_target(f) ? 0.2 : 0.0;
  np_monitor_set_part(f->monitor, whole, 0.0, pilots_end);
  neph_result result = np_frame_has_target(f) ? sample_pilots(f) : NEPH_OK;
  np_monitor_set_part(f->monitor, whole, pilots_end, 1.0);
  np_monitor_set_stage(f->monitor, "rendering");
  if (!result) result = has_limit(f) ? render_passes(f) : show_tiles(f, render_pixel, true);
  np_alloc_free(f->assembly->context, f->pilots);
  f->pilots = NULL;
  return result;
}
