/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_film.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/set_aside.h"
#include "parts/part_file.h"
#include "plan/part_check.h"

struct np_kept_film {
  neph_context *context;
  const np_frame *frame;
  np_part_header header;
  np_part_grid grid;
  size_t reals; /* doubles of a record */
  double *records;
  atomic_bool *done; /* whether each tile is finished */
  const char *part_path, *checkpoint_path;
  double interval_s, last_s;
};

/* ---- Beginning ---- */

static void fill_header(const neph_scene *scene, const np_plan *plan, const np_frame *f, np_part_header *h) {
  const neph_render_desc *d = &plan->request.desc;
  *h = (np_part_header){.tile_index = d->tile_index,
                        .tile_count = d->tile_count,
                        .sample_begin = d->sample_begin,
                        .sample_end = d->sample_end,
                        .sample_count = d->sample_count,
                        .is_complete = !np_part_is_range(d),
                        .pixel_type = scene->output.pixel_type,
                        .scattering_max = d->scattering_max,
                        .target_error = d->target_error,
                        .lost_share = (double)f->settings.lost_share,
                        .channels = f->channels,
                        .image = f->image};
  memcpy(h->hash, plan->hash, sizeof h->hash);
  (void)strncpy(h->version, neph_version_get_text(), sizeof h->version - 1);
  memcpy(h->min, plan->request.window_min, sizeof h->min);
  memcpy(h->max, plan->request.window_max, sizeof h->max);
  memcpy(h->whole_min, plan->request.whole_min, sizeof h->whole_min);
  memcpy(h->whole_max, plan->request.whole_max, sizeof h->whole_max);
  np_part_header_set_display(h, &f->image->header);
}

static neph_result allocate(np_kept_film *film) {
  film->grid = np_part_grid_make(&film->header);
  film->reals = np_part_header_count_reals(&film->header);
  film->records =
      np_alloc(film->context, (size_t)film->grid.width * film->grid.height, film->reals * sizeof *film->records);
  film->done = np_alloc(film->context, np_part_grid_count(&film->grid), sizeof *film->done);
  return film->records && film->done ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Resuming ---- */

/* Name of the first field in which a header is not of this part; NULL: there is none. What is dim is found by the
 * samples that follow. */
static const char *compare_part(const np_part_header *own, const np_part_header *other) {
  np_part_header expected = *own;
  memcpy(expected.dim, other->dim, sizeof expected.dim);
  const char *field = np_part_header_compare(&expected, other);
  if (field) return field;
  if (own->sample_begin != other->sample_begin || own->sample_end != other->sample_end) return "samples";
  return own->tile_index != other->tile_index || own->tile_count != other->tile_count ? "tile" : NULL;
}

static bool check_same_part(const np_part_header *own, const np_part_header *other, np_part_fault *fault) {
  if (strcmp(own->hash, other->hash) != 0)
    return np_part_fault_set(
        fault,
        "it is of another scene, other settings or another version of nephos: its hash is %s, must "
        "be %s",
        other->hash, own->hash);
  const char *field = compare_part(own, other);
  return !field || np_part_fault_set(fault, "its field '%s' is not that of this picture", field);
}

static void mark(np_kept_film *film, size_t tile) {
  assert(tile < np_part_grid_count(&film->grid));
  atomic_store_explicit(&film->done[tile], true, memory_order_release);
}

static bool load_tiles(np_kept_film *film, np_part_file *file, np_part_fault *fault) {
  const size_t count = np_part_grid_count(&film->grid);
  for (size_t tile = 0; tile < count; tile++) {
    if (!np_part_file_has_tile(file, tile)) continue;
    size_t pixels;
    double *first = film->records + np_part_grid_get_first(&film->grid, tile, &pixels) * film->reals;
    if (!np_part_file_read_tile(file, tile, fault, first)) return false;
    mark(film, tile);
  }
  np_log(film->context, NEPH_LOG_INFO, "%s: resumed with %.3g %% of the picture's pixels rendered",
         np_part_file_get_path(file), 100.0 * (double)np_part_file_count_tiles(file) / (double)count);
  return true;
}

static void free_records(np_kept_film *film) {
  np_alloc_free(film->context, film->records);
  np_alloc_free(film->context, film->done);
}

/* Continues from a checkpoint. A checkpoint that cannot be used is ignored, and the frame starts anew. */
static neph_result resume(np_kept_film *film) {
  np_part_file *file = NULL;
  np_part_fault fault = {.context = film->context};
  if (!film->checkpoint_path || !np_file_exists(film->checkpoint_path)) return NEPH_OK;
  const bool is_loaded = np_part_file_open(film->context, film->checkpoint_path, &fault, &file) &&
                         check_same_part(&film->header, np_part_file_get_header(file), &fault) &&
                         load_tiles(film, file, &fault);
  np_part_file_close(file);
  if (is_loaded) return NEPH_OK;
  np_file_set_aside(film->context, film->checkpoint_path, np_part_fault_get_reason(&fault), "the frame begins anew");
  np_part_fault_clear(&fault);
  free_records(film);
  return allocate(film);
}

static void close_film(np_kept_film *film) {
  if (!film) return;
  free_records(film);
  np_alloc_free(film->context, film);
}

static neph_result open_film(const neph_scene *scene, const np_plan *plan, const np_frame *f, np_kept_film **out_film) {
  *out_film = NULL;
  const neph_render_desc *d = &plan->request.desc;
  if (!d->part_path && !d->checkpoint_path) return NEPH_OK;
  np_kept_film *film = np_alloc(scene->context, 1, sizeof *film);
  if (!film) return NEPH_ERROR_OUT_OF_MEMORY;
  film->context = scene->context;
  film->frame = f;
  film->part_path = d->part_path;
  film->checkpoint_path = d->checkpoint_path;
  film->interval_s = d->checkpoint_interval_s;
  film->last_s = np_monitor_get_seconds(f->monitor);
  fill_header(scene, plan, f, &film->header);
  neph_result result = allocate(film);
  if (!result && d->is_resumed) result = resume(film);
  if (result)
    close_film(film);
  else
    *out_film = film;
  return result;
}

/* ---- Records ---- */

static double *get_record(const np_kept_film *film, size_t index) {
  const unsigned width = film->grid.width;
  return film->records +
         np_part_grid_get_index(&film->grid, (unsigned)(index % width), (unsigned)(index / width)) * film->reals;
}

static bool has(const np_kept_film *film, size_t index) { return get_record(film, index)[NP_PART_RECORD_COUNT] > 0.0; }

static bool develop(const np_kept_film *film, const np_frame *f, size_t index, np_tile_total *total) {
  const double *record = get_record(film, index);
  const uint32_t count = (uint32_t)record[NP_PART_RECORD_COUNT];
  if (count == 0) return false;
  np_film_accumulator accumulator;
  double numbers[NP_PIXEL_NUMBERS_MAX];
  np_part_record_begin(&film->header, &accumulator);
  if (film->header.is_complete)
    memcpy(numbers, record + NP_PART_RECORD_NUMBERS, np_channels_count_numbers(&f->channels) * sizeof *numbers);
  else if (np_part_record_add(&film->header, record, &accumulator))
    np_film_accumulator_finish(&accumulator, numbers);
  const np_pixel_facts facts = {.spread = np_channels_get_spread(&f->channels, numbers, count),
                                .distance = record[NP_PART_RECORD_DISTANCE],
                                .depth = record[NP_PART_RECORD_DEPTH]};
  np_frame_develop_pixel(f, index, &facts, numbers, total);
  return true;
}

static void store_numbers(const np_kept_film *film, double *record, const np_film_accumulator *accumulator,
                          const double *numbers, uint32_t count) {
  const unsigned length = np_channels_count_numbers(&film->header.channels);
  record[NP_PART_RECORD_COUNT] = count;
  if (film->header.is_complete) {
    memcpy(record + NP_PART_RECORD_NUMBERS, numbers, length * sizeof *numbers);
    return;
  }
  np_film_node nodes[NP_FILM_NODES_MAX];
  const unsigned node_count = np_film_accumulator_get_nodes(accumulator, nodes);
  for (unsigned n = 0; n < node_count; n++)
    memcpy(record + NP_PART_RECORD_NUMBERS + n * length, nodes[n].sums, length * sizeof *numbers);
}

static void store_depths(double *record, double distance, double depth) {
  record[NP_PART_RECORD_DISTANCE] = distance;
  record[NP_PART_RECORD_DEPTH] = depth;
}

/* ---- Writing ---- */

static neph_result write_part(np_kept_film *film, const char *path) {
  memcpy(film->header.dim, film->frame->dim, sizeof film->header.dim);
  return np_part_file_write(film->context, path, &film->header, film->done, film->records);
}

/* A checkpoint that cannot be written does not end the render: its message says that there is none. */
static void write_when_due(np_kept_film *film, double seconds) {
  if (!film->checkpoint_path || !(seconds - film->last_s >= film->interval_s)) return;
  film->last_s = seconds;
  if (write_part(film, film->checkpoint_path)) return;
  np_log(film->context, NEPH_LOG_DEBUG, "%s: checkpoint written", film->checkpoint_path);
}

static neph_result finish(np_kept_film *film, neph_result result) {
  if (!film) return result;
  const bool is_stopped = result == NEPH_ERROR_CANCELLED && film->checkpoint_path;
  const char *path = is_stopped ? film->checkpoint_path : !result ? film->part_path : NULL;
  neph_result written = NEPH_OK;
  if (path) written = write_part(film, path);
  close_film(film);
  return written ? written : result;
}

const np_film_sink np_part_film_sink = {.open = open_film,
                                        .get_record = get_record,
                                        .has = has,
                                        .develop = develop,
                                        .keep_numbers = store_numbers,
                                        .keep_depths = store_depths,
                                        .mark = mark,
                                        .write_when_due = write_when_due,
                                        .finish = finish};
