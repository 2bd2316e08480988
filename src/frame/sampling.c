/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling of a frame: the number of samples of each pixel, and the passes in which they are taken. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "frame/kept_samples.h"
#include "frame/pilots.h"
#include "frame/reconstruction.h"
#include "image/film.h"
#include "image/image_private.h"

static bool has_limit(const np_frame *f) { return isfinite(f->desc->time_limit_s); }

/* ---- Tiles ---- */

typedef neph_result pixel_step_fn(const np_frame *f, const int at[2], size_t index, np_tile_total *total);

typedef struct tile_job {
  const np_frame *f;
  size_t begin; /* number of the first tile */
  pixel_step_fn *step;
  bool is_shown;                   /* its tiles are in the image */
  const struct placed_tile *order; /* NULL: in that of their numbers */
} tile_job;

/* A tile, by its distance from the focus. */
typedef struct placed_tile {
  double away;
  size_t tile;
} placed_tile;

static neph_result render_tiles(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const tile_job *job = user;
  const np_frame *f = job->f;
  const size_t tiles_across = (f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  for (size_t n = begin; n < end; n++) {
    const size_t tile = job->order ? job->order[n].tile : job->begin + n;
    const unsigned x0 = (unsigned)(tile % tiles_across) * NP_TILE_EDGE;
    const unsigned y0 = (unsigned)(tile / tiles_across) * NP_TILE_EDGE;
    for (unsigned y = y0; y < y0 + NP_TILE_EDGE && y < f->height; y++)
      for (unsigned x = x0; x < x0 + NP_TILE_EDGE && x < f->width; x++) {
        const int at[2] = {f->min[0] + (int)x, f->min[1] + (int)y};
        neph_result result = job->step(f, at, (size_t)y * f->width + x, &f->totals[tile]);
        if (result) return result;
      }
    if (job->is_shown && f->film) f->sink->mark(f->film, tile);
    if (job->is_shown) np_tile_feed_mark(f->feed, tile);
  }
  return NEPH_OK;
}

size_t np_frame_count_tiles(const np_frame *f) {
  return (size_t)((f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE) * ((f->height + NP_TILE_EDGE - 1) / NP_TILE_EDGE);
}

/* The tiles of rows from `begin`, a multiple of a tile's edge, up to `end`. */
static neph_result run_tiles(np_frame *f, unsigned begin, unsigned end, pixel_step_fn *step, bool is_shown) {
  assert(begin % NP_TILE_EDGE == 0 && begin <= end && end <= f->height);
  const size_t across = (f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  tile_job job = {f, across * (begin / NP_TILE_EDGE), step, is_shown, NULL};
  const size_t count = across * ((end - begin + NP_TILE_EDGE - 1) / NP_TILE_EDGE);
  return np_parallel_for(f->assembly->context, f->monitor, count, 1, render_tiles, &job);
}

static neph_result deliver_tiles(np_frame *f) {
  const bool is_wanted = np_tile_feed_deliver(f->feed, np_monitor_get_seconds(f->monitor));
  f->feed->pass_index++;
  return is_wanted ? NEPH_OK : NEPH_ERROR_CANCELLED;
}

static int compare_tiles(const void *a, const void *b) {
  const placed_tile *x = a, *y = b;
  return x->away != y->away ? (x->away > y->away) - (x->away < y->away) : (x->tile > y->tile) - (x->tile < y->tile);
}

/* Tiles from the focus outwards. NULL: there is no memory. */
static placed_tile *order_tiles(const np_frame *f) {
  const size_t count = np_frame_count_tiles(f), across = (f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  placed_tile *order = np_alloc(f->assembly->context, count, sizeof *order);
  for (size_t i = 0; order && i < count; i++) {
    const double x = (double)(i % across) + 0.5 - f->focus[0] * f->width / NP_TILE_EDGE;
    const double y = (double)(i / across) + 0.5 - f->focus[1] * f->height / NP_TILE_EDGE;
    order[i] = (placed_tile){x * x + y * y, i};
  }
  if (order) qsort(order, count, sizeof *order, compare_tiles);
  return order;
}

/* All tiles, from the focus outwards. */
static neph_result run_ordered(np_frame *f, pixel_step_fn *step) {
  placed_tile *order = order_tiles(f);
  if (!order) return NEPH_ERROR_OUT_OF_MEMORY;
  tile_job job = {f, 0, step, true, order};
  const neph_result result =
      np_parallel_for(f->assembly->context, f->monitor, np_frame_count_tiles(f), 1, render_tiles, &job);
  np_alloc_free(f->assembly->context, order);
  return result;
}

/* Fills the tiles of the image and passes them to the caller's callback. */
static neph_result show_tiles(np_frame *f, pixel_step_fn *step, bool is_final) {
  f->feed->is_final = is_final;
  const neph_result result = f->focus ? run_ordered(f, step) : run_tiles(f, 0, f->height, step, true);
  return result ? result : deliver_tiles(f);
}

/* ---- A number for all ---- */

/* Takes all samples of one pixel. */
static neph_result render_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  np_pixel_state p = {.begin = f->desc->sample_begin, .next = f->desc->sample_begin};
  double numbers[NP_PIXEL_NUMBERS_MAX];
  if (f->film && f->sink->develop(f->film, f, index, total)) return NEPH_OK;
  if (f->film) p.record = f->sink->get_record(f->film, index);
  p.kept = np_kept_samples_get(f->kept, index);
  neph_result result = np_frame_sample_pixel(f, at, f->desc->sample_end, &p, numbers);
  if (!result) result = np_frame_finish_pixel(f, at, &p, numbers, total);
  np_alloc_free(f->assembly->context, p.deep.at);
  return result;
}

/* ---- Pixels under way ---- */

static size_t count_slots(const np_frame *f) { return f->rows.stride * (f->rows.count + 2); }

static size_t get_slot(const np_frame *f, const int at[2]) {
  const size_t y = (size_t)(at[1] - f->min[1] + 1) - f->rows.begin;
  assert(y < f->rows.count + 2);
  return y * f->rows.stride + (size_t)(at[0] - f->min[0] + 1);
}

static double *get_numbers(const np_frame *f, size_t slot) {
  return f->rows.numbers + slot * np_channels_count_numbers(&f->channels);
}

static neph_result open_rows(np_frame *f, unsigned count) {
  neph_context *context = f->assembly->context;
  np_pixel_rows *rows = &f->rows;
  *rows = (np_pixel_rows){.count = count, .stride = f->width + 2};
  rows->states = np_alloc(context, count_slots(f), sizeof *rows->states);
  rows->pilots = np_alloc(context, count_slots(f), sizeof *rows->pilots);
  rows->numbers = np_alloc(context, count_slots(f), np_channels_count_numbers(&f->channels) * sizeof *rows->numbers);
  return rows->states && rows->pilots && rows->numbers ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void close_rows(np_frame *f) {
  neph_context *context = f->assembly->context;
  for (size_t i = 0; f->rows.states && i < count_slots(f); i++) np_alloc_free(context, f->rows.states[i].deep.at);
  np_alloc_free(context, f->rows.states);
  np_alloc_free(context, f->rows.pilots);
  np_alloc_free(context, f->rows.numbers);
  f->rows = (np_pixel_rows){.count = 0};
}

/* ---- A target error ---- */

/* Two stages, as of Stein (1945, "A Two-Sample Test for a Linear Hypothesis Whose Power is Independent of the
 * Variance"): a pilot of a few samples in each pixel, then the number that the pilots around it require. A pixel that
 * stopped when its own samples happened to agree would be too dark where bright ones are rare. */
static uint32_t choose_end(const np_frame *f, const int at[2]) {
  const np_pilot *pilot = &f->rows.pilots[get_slot(f, at)];
  const double spread = np_sample_rule_estimate_spread(&f->rule, pilot, f->rows.stride);
  return np_sample_rule_round(np_sample_rule_count(&f->rule, spread), np_frame_draw_rounding(f, at));
}

static bool is_in_window(const np_frame *f, const int at[2]) {
  return at[0] >= f->min[0] && at[0] < f->min[0] + (int)f->width && at[1] >= f->min[1] &&
         at[1] < f->min[1] + (int)f->height;
}

/* A pixel whose neighbours and itself are in a checkpoint needs no pilot. */
static bool needs_pilot(const np_frame *f, const int at[2]) {
  for (int k = 0; k < 9; k++) {
    const int near[2] = {at[0] + k % 3 - 1, at[1] + k / 3 - 1};
    const size_t index = (size_t)(near[1] - f->min[1]) * f->width + (size_t)(near[0] - f->min[0]);
    if (is_in_window(f, near) && !(f->film && f->sink->has(f->film, index))) return true;
  }
  return false;
}

static neph_result fly_pilot(const np_frame *f, const int at[2]) {
  const size_t slot = get_slot(f, at);
  np_pixel_state *p = &f->rows.states[slot];
  *p = (np_pixel_state){.next = 0};
  f->rows.pilots[slot] = (np_pilot){.count = 0.0f};
  if (!np_frame_is_in_view(f, at) || !needs_pilot(f, at)) return NEPH_OK;
  if (!is_in_window(f, at)) return np_frame_fly_pilot(f, at, f->rule.first, &f->rows.pilots[slot]);
  const neph_result result = np_frame_sample_pixel(f, at, f->rule.first, p, get_numbers(f, slot));
  if (!result) f->rows.pilots[slot] = np_frame_get_pilot(f, get_numbers(f, slot), p->next);
  return result;
}

typedef struct row_job {
  const np_frame *f;
  unsigned begin; /* first of the grid's rows */
} row_job;

static neph_result fly_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const row_job *job = user;
  const np_frame *f = job->f;
  neph_result result = NEPH_OK;
  for (size_t row = job->begin + begin; row < job->begin + end; row++)
    for (size_t column = 0; column < f->rows.stride && !result; column++) {
      const int y = f->min[1] + (int)f->rows.begin + (int)row - 1;
      result = fly_pilot(f, (const int[2]){f->min[0] + (int)column - 1, y});
    }
  return result;
}

/* The rest of a pixel that has its pilot. */
static neph_result render_rest(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  const size_t slot = get_slot(f, at);
  np_pixel_state *p = &f->rows.states[slot];
  if (f->film && f->sink->develop(f->film, f, index, total)) return NEPH_OK;
  if (f->film) p->record = f->sink->get_record(f->film, index);
  neph_result result = np_frame_sample_pixel(f, at, choose_end(f, at), p, get_numbers(f, slot));
  if (!result) result = np_frame_finish_pixel(f, at, p, get_numbers(f, slot), total);
  np_alloc_free(f->assembly->context, p->deep.at);
  p->deep = (np_deep_stored){.at = NULL};
  return result;
}

/* The last of a band's rows, and the one behind it, are the first of the next grid. */
static void advance_rows(np_frame *f) {
  np_pixel_rows *rows = &f->rows;
  const size_t moved = 2 * rows->stride, from = rows->count * rows->stride;
  const size_t numbers = np_channels_count_numbers(&f->channels);
  memmove(rows->states, rows->states + from, moved * sizeof *rows->states);
  memset(rows->states + from, 0, moved * sizeof *rows->states);
  memmove(rows->pilots, rows->pilots + from, moved * sizeof *rows->pilots);
  memmove(rows->numbers, rows->numbers + from * numbers, moved * numbers * sizeof *rows->numbers);
  rows->begin += rows->count;
}

/* Rows of a band, a multiple of a tile's edge. */
enum { BAND_ROWS = 64 };

static neph_result render_band(np_frame *f) {
  row_job job = {f, f->rows.begin > 0 ? 2 : 0};
  const unsigned begin = f->rows.begin, end = begin + f->rows.count < f->height ? begin + f->rows.count : f->height;
  const double share = 0.125, height = f->height;
  np_monitor_set_range(f->monitor, begin / height, (begin + share * (end - begin)) / height);
  neph_result result =
      np_parallel_for(f->assembly->context, f->monitor, end - begin + 2 - job.begin, 1, fly_rows, &job);
  np_monitor_set_range(f->monitor, (begin + share * (end - begin)) / height, end / height);
  return result ? result : run_tiles(f, begin, end, render_rest, true);
}

static neph_result render_bands(np_frame *f) {
  f->feed->is_final = true;
  neph_result result = open_rows(f, f->height < BAND_ROWS ? f->height : BAND_ROWS);
  while (!result && f->rows.begin < f->height) {
    result = render_band(f);
    advance_rows(f);
  }
  close_rows(f);
  return result ? result : deliver_tiles(f);
}

static void describe_pilots(const np_frame *f, const np_pilots *pilots) {
  np_log(f->assembly->context, NEPH_LOG_INFO,
         "%llu samples of %u pixels: the noise of one sample a pixel is %.3g %%, and falls as its %.2g-th power; for "
         "%.3g %% a pixel needs %.4g samples in the mean, from %u up",
         (unsigned long long)pilots->sample_count, pilots->point_count, 100.0 * pilots->noise_of_one,
         0.5 * pilots->exponent, 100.0 * f->noise_target, pilots->samples, f->rule.min);
}

/* Predicts the time of the remaining samples from the time of the pilots. */
static void predict_sampling(np_frame *f, const np_pilots *pilots, double pilots_s) {
  const double pixels = (double)f->width * f->height;
  f->prediction->has_pilots = pilots->sample_count > 0;
  f->prediction->sampling_s = pilots_s + pilots_s / (double)pilots->sample_count * pilots->samples * pixels;
  f->prediction->noise = pilots->noise;
}

static neph_result fly_lattice(np_frame *f) {
  np_pilots pilots;
  const double start_s = np_cpu_time_s();
  const neph_result result = np_pilots_fly(f, f->noise_target, &pilots);
  if (result) return result;
  f->rule = pilots.rule;
  predict_sampling(f, &pilots, np_cpu_time_s() - start_s);
  describe_pilots(f, &pilots);
  return np_image_set_real(f->image, "nephos:targetNoise", f->noise_target);
}

/* Runs `step` until the time `end_s`; skips it if that time has passed. */
static neph_result run_until(np_frame *f, double end_s, neph_result (*run)(np_frame *f), bool *out_is_cut) {
  np_monitor_begin_budget(f->monitor, end_s);
  const neph_result result = run(f);
  *out_is_cut = np_monitor_end_budget(f->monitor);
  return *out_is_cut && result == NEPH_ERROR_CANCELLED ? NEPH_OK : result;
}

/* Samples the pilots in at most a quarter of the remaining time. If time runs out, pixels get equal numbers of
 * samples. */
static neph_result sample_pilots(np_frame *f) {
  np_monitor_set_stage(f->monitor, "sampling the picture's noise");
  const double now_s = np_monitor_get_seconds(f->monitor), left_s = fmax(f->assembly->schedule.limit_s - now_s, 0.0);
  const uint32_t most = f->desc->sample_count_max;
  bool is_cut;
  f->rule = (np_sample_rule){.first = 1, .min = most, .max = most};
  return run_until(f, now_s + 0.25 * left_s, fly_lattice, &is_cut);
}

/* ---- A time limit ---- */

/* A sample of every pixel, then the rest of its first leaf, then leaf after leaf. */
static neph_result extend_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)index, (void)total;
  const size_t slot = get_slot(f, at);
  np_pixel_state *p = &f->rows.states[slot];
  if (f->is_first_pass) *p = (np_pixel_state){.end = np_frame_has_target(f) ? f->rule.first : f->desc->sample_end};
  if (p->next >= p->end) return NEPH_OK;
  const uint32_t leaf_end = (p->next / NP_FILM_LEAF_SAMPLES + 1) * NP_FILM_LEAF_SAMPLES;
  const uint32_t end = f->is_first_pass ? p->next + 1 : leaf_end;
  return np_frame_sample_pixel(f, at, end < p->end ? end : p->end, p, get_numbers(f, slot));
}

static neph_result close_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)index;
  const size_t slot = get_slot(f, at);
  return np_frame_finish_pixel(f, at, &f->rows.states[slot], get_numbers(f, slot), total);
}

static neph_result set_pilot(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)index, (void)total;
  const size_t slot = get_slot(f, at);
  f->rows.pilots[slot] = np_frame_get_pilot(f, get_numbers(f, slot), f->rows.states[slot].next);
  return NEPH_OK;
}

static neph_result set_end(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)index, (void)total;
  f->rows.states[get_slot(f, at)].end = choose_end(f, at);
  return NEPH_OK;
}

/* Leaves that a pixel is short of. */
static uint32_t count_leaves(const np_pixel_state *p) {
  return p->next < p->end ? (p->end - 1) / NP_FILM_LEAF_SAMPLES - p->next / NP_FILM_LEAF_SAMPLES + 1 : 0;
}

static uint32_t count_passes(const np_frame *f) {
  uint32_t passes = 0;
  for (size_t i = 0; i < count_slots(f); i++) {
    const uint32_t leaves = count_leaves(&f->rows.states[i]);
    if (leaves > passes) passes = leaves;
  }
  return passes;
}

static neph_result run_pass(np_frame *f) { return run_tiles(f, 0, f->height, extend_pixel, false); }

/* Value of a pixel from its samples so far, for a live view. */
static neph_result preview_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)total;
  np_tile_total unused = {.samples = 0};
  return close_pixel(f, at, index, &unused);
}

static neph_result preview_pass(np_frame *f) {
  return f->feed->fn && !f->is_cut ? show_tiles(f, preview_pixel, false) : NEPH_OK;
}

/* Sets the range of progress of a pass: by samples or by time, whichever ends first. */
static void set_pass_range(const np_frame *f, double begin_s, uint32_t pass, double passes) {
  const double by_time = (np_monitor_get_seconds(f->monitor) - begin_s) / (f->assembly->schedule.limit_s - begin_s);
  const double begin = fmax(pass / passes, by_time > 0.0 ? fmin(by_time, 1.0) : 0.0);
  np_monitor_set_range(f->monitor, begin, fmax((pass + 1) / passes, begin));
}

/* Passes from the `pass`-th on until each pixel has its samples, or time is up. The first leaf of samples may take some
 * of the grace. */
static neph_result extend_all(np_frame *f, double begin_s, uint32_t pass) {
  const np_schedule *schedule = &f->assembly->schedule;
  const uint32_t passes = pass + count_passes(f);
  neph_result result = NEPH_OK;
  for (; pass < passes && !f->is_cut && !result; pass++) {
    set_pass_range(f, begin_s, pass, passes);
    result = run_until(f, pass == 1 ? schedule->first_samples_s : schedule->limit_s, run_pass, &f->is_cut);
    if (!result && pass + 1 < passes) result = preview_pass(f);
  }
  return result;
}

/* Takes further samples until the target error is met. Pixels outside of the frame have no pilots. */
static neph_result extend_to_target(np_frame *f, double begin_s) {
  neph_result result = extend_all(f, begin_s, 1);
  if (result || f->is_cut) return result;
  result = run_tiles(f, 0, f->height, set_pilot, false);
  if (!result) result = run_tiles(f, 0, f->height, set_end, false);
  return result ? result : extend_all(f, begin_s, 2);
}

/* Runs the passes. The first pass, one sample for each pixel, ends at the call's deadline alone; later passes end at
 * the time limit. */
static neph_result run_passes(np_frame *f) {
  const double begin_s = np_monitor_get_seconds(f->monitor);
  f->is_first_pass = true;
  set_pass_range(f, begin_s, 0, 2.0 + f->desc->sample_count / NP_FILM_LEAF_SAMPLES);
  neph_result result = run_pass(f);
  if (!result) result = preview_pass(f);
  if (result) return result;
  f->is_first_pass = false;
  np_monitor_set_deadline(f->monitor, HUGE_VAL);
  return np_frame_has_target(f) ? extend_to_target(f, begin_s) : extend_all(f, begin_s, 1);
}

/* Whole passes, so that every pixel has its share when time is up. */
static neph_result render_passes(np_frame *f) {
  neph_result result = open_rows(f, f->height);
  if (!result) result = run_passes(f);
  np_monitor_set_range(f->monitor, 1.0, 1.0);
  if (!result) result = show_tiles(f, close_pixel, true);
  close_rows(f);
  return result;
}

/* ---- The frame ---- */

/* Mean radiance of emission over the clouds' box, whose mean projected area is a quarter of its surface. */
static np_spectrum compute_mean_emission(const np_assembly *a, const np_packet *packet) {
  const np_dvec3 size = np_dvec3_subtract(a->clouds.high, a->clouds.low);
  const double area = 0.5 * (size.x * size.y + size.y * size.z + size.z * size.x);
  const np_spectrum dark = np_spectrum_grey(0.0f);
  return packet->emission.all.emitter_count > 0 && area > 0.0
             ? np_spectrum_scale(packet->emission.all.power_w_sr_nm, (float)(1.0 / area))
             : dark;
}

/* Computes `dim`, a hundredth of the radiance of a white surface in full light and of the emission. Relative errors of
 * darker pixels are costly and barely visible. */
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

/* ---- Some of the pixels ---- */

static neph_result render_chosen(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  return np_reconstruction_is_rendered(f->reconstruction, index) ? render_pixel(f, at, index, total) : NEPH_OK;
}

static neph_result show_pixel(const np_frame *f, const int at[2], size_t index, np_tile_total *total) {
  (void)f, (void)at, (void)index, (void)total;
  return NEPH_OK;
}

/* Renders the pixels that are not interpolated or reprojected. */
static neph_result render_some(np_frame *f) {
  np_monitor_set_range(f->monitor, 0.0, 0.05);
  neph_result result = np_reconstruction_prepare(f);
  np_monitor_set_range(f->monitor, 0.05, 0.95);
  if (!result) result = run_tiles(f, 0, f->height, render_chosen, false);
  np_monitor_set_range(f->monitor, 0.95, 1.0);
  if (!result) result = np_reconstruction_resolve(f);
  return result ? result : show_tiles(f, show_pixel, true);
}

static neph_result sample_pixels(np_frame *f) {
  if (f->reconstruction) return render_some(f);
  if (has_limit(f)) return render_passes(f);
  return np_frame_has_target(f) ? render_bands(f) : show_tiles(f, render_pixel, true);
}

neph_result np_frame_sample(np_frame *f) {
  compute_dim(f);
  const np_monitor_part whole = np_monitor_get_part(f->monitor);
  const double pilots_end = np_frame_has_target(f) ? 0.05 : 0.0;
  np_monitor_set_part(f->monitor, whole, 0.0, pilots_end);
  neph_result result = np_frame_has_target(f) ? sample_pilots(f) : NEPH_OK;
  np_monitor_set_part(f->monitor, whole, pilots_end, 1.0);
  np_monitor_set_stage(f->monitor, "rendering");
  return result ? result : sample_pixels(f);
}
