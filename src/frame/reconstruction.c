/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/reconstruction.h"

#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "frame/channel_table.h"
#include "image/image_private.h"
#include "scene/sequence.h"

/* ---- Which pixels ---- */

/* Position of the n-th pixel of a square of 1, 2 or 4 pixels a side, in the order of Bayer (1973): successive pixels
 * are far apart. */
static void get_place(unsigned edge, unsigned n, unsigned out[2]) {
  out[0] = out[1] = 0;
  for (unsigned half = edge / 2; half > 0; half /= 2, n /= 4) {
    static const unsigned across[] = {0, 1, 1, 0}, down[] = {0, 1, 0, 1};
    out[0] += half * across[n % 4];
    out[1] += half * down[n % 4];
  }
}

/* Chooses the lattices of a frame by its distance from the block's first frame. A picture without history renders the
 * middle of each square. */
static void choose_lattices(np_reconstruction *r, const np_scene_render *render, unsigned n) {
  const unsigned edge = render->history_update == 16 ? 4 : render->history_update == 4 ? 2 : 1;
  const unsigned size[2] = {r->width, r->height}, upsample = render->upsample;
  unsigned fine[2] = {upsample / 2, upsample / 2}, coarse[2] = {0, 0};
  if (r->has_history) {
    get_place(upsample, n / (edge * edge) % (upsample * upsample), fine);
    get_place(edge, n % (edge * edge), coarse);
  }
  r->resolution.edge = upsample;
  r->update.edge = r->has_history ? edge * upsample : upsample;
  for (int k = 0; k < 2; k++) {
    r->resolution.at[k] = fine[k] < size[k] ? fine[k] : size[k] - 1;
    r->update.at[k] = coarse[k] * upsample + r->resolution.at[k];
  }
}

static np_pixel_source choose_source(const np_reconstruction *r, unsigned x, unsigned y) {
  const bool is_seen = r->places && !r->is_cut && r->places[(size_t)y * r->width + x].is_seen;
  if (np_pixel_lattice_has(is_seen ? &r->update : &r->resolution, x, y)) return NP_PIXEL_RENDERED;
  if (is_seen) return NP_PIXEL_REPROJECTED;
  return np_reconstruction_has_alike(r, x, y) ? NP_PIXEL_INTERPOLATED : NP_PIXEL_RENDERED;
}

/* ---- Making one ---- */

static neph_result fill(const neph_scene *scene, const np_plan *plan, const np_frame *f, np_reconstruction *r) {
  const size_t pixels = (size_t)f->width * f->height;
  const int first = np_scene_get_history_first(scene, plan->request.desc.frame);
  r->context = plan->request.context;
  r->width = f->width;
  r->height = f->height;
  memcpy(r->min, f->min, sizeof r->min);
  r->has_history = np_plan_needs(plan, NP_STAGE_HISTORY);
  r->before = np_history_get(scene, plan, f->assembly->stores);
  r->has_still_light = np_scene_has_still_light(scene);
  r->has_beauty = plan->request.has_beauty;
  r->weight_min = scene->render.history_weight;
  choose_lattices(r, &scene->render, (unsigned)(plan->request.desc.frame - first));
  if (r->before) r->places = np_alloc(r->context, pixels, sizeof *r->places);
  if (r->before && !r->has_still_light)
    r->changes = np_alloc(r->context, pixels, f->channels.count * sizeof *r->changes);
  r->sources = np_alloc(r->context, pixels, sizeof *r->sources);
  if (!r->sources || (r->before && !r->places)) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_history_frame_create(r->context, pixels, f->channels.count, &r->next);
  r->next.camera = f->assembly->camera;
  r->next.frame = plan->request.desc.frame;
  return result;
}

neph_result np_reconstruction_create(const neph_scene *scene, const np_plan *plan, const np_frame *f,
                                     np_reconstruction **out) {
  *out = NULL;
  if (!np_plan_needs(plan, NP_STAGE_HISTORY) && scene->render.upsample == 1) return NEPH_OK;
  np_reconstruction *r = np_alloc(plan->request.context, 1, sizeof *r);
  if (!r) return NEPH_ERROR_OUT_OF_MEMORY;
  r->context = plan->request.context;
  const neph_result result = fill(scene, plan, f, r);
  if (result)
    np_reconstruction_destroy(r);
  else
    *out = r;
  return result;
}

void np_reconstruction_destroy(np_reconstruction *r) {
  if (!r) return;
  neph_context *context = r->context;
  np_history_frame_clear(context, &r->next);
  np_alloc_free(context, r->places);
  np_alloc_free(context, r->sources);
  np_alloc_free(context, r->changes);
  np_alloc_free(context, r);
}

neph_result np_reconstruction_store(np_reconstruction *r, const np_plan *plan, np_stores *stores) {
  if (!r->has_history) return NEPH_OK;
  memcpy(r->next.hash, plan->hash, sizeof r->next.hash);
  return np_history_put(plan, stores, &r->next);
}

/* ---- Passes over rows ---- */

typedef struct row_pass {
  np_frame *f;
  void (*run)(const np_frame *f, unsigned y);
} row_pass;

static neph_result run_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const row_pass *pass = user;
  for (size_t y = begin; y < end; y++) pass->run(pass->f, (unsigned)y);
  return NEPH_OK;
}

static neph_result pass_rows(np_frame *f, void (*run)(const np_frame *f, unsigned y)) {
  row_pass pass = {f, run};
  return np_parallel_for(f->assembly->context, f->monitor, f->height, 1, run_rows, &pass);
}

/* ---- Before pixels are rendered ---- */

static void guide_row(const np_frame *f, unsigned y) {
  np_reconstruction *r = f->reconstruction;
  for (unsigned x = 0; x < f->width; x++) {
    const int at[2] = {f->min[0] + (int)x, f->min[1] + (int)y};
    r->next.guides[(size_t)y * f->width + x] = np_frame_compute_guide(f, at);
  }
}

static void mark_row(const np_frame *f, unsigned y) {
  np_pixel_guide *guides = f->reconstruction->next.guides;
  for (unsigned x = 0; x < f->width; x++) np_pixel_guide_fill_around(guides, f->width, f->height, x, y);
}

static void choose_row(const np_frame *f, unsigned y) {
  np_reconstruction *r = f->reconstruction;
  for (unsigned x = 0; x < r->width; x++) r->sources[(size_t)y * r->width + x] = (uint8_t)choose_source(r, x, y);
}

static np_reprojection make_reprojection(const np_reconstruction *r) {
  return np_reprojection_make(r->before, &r->next.camera, r->next.guides, r->min, r->width, r->height);
}

static void project_row(const np_frame *f, unsigned y) {
  np_reconstruction *r = f->reconstruction;
  const np_reprojection reprojection = make_reprojection(r);
  for (unsigned x = 0; x < f->width; x++)
    r->places[(size_t)y * f->width + x] = np_reprojection_project(&reprojection, x, y);
}

/* A pixel that moves by more than jump_share of the width has jumped; if fewer than seen_share_min of the pixels have
 * not, there is a cut. */
static const double jump_share = 0.25, seen_share_min = 0.5;

static bool has_cut(const np_reconstruction *r) {
  uint64_t seen = 0;
  for (unsigned y = 0; y < r->height; y++)
    for (unsigned x = 0; x < r->width; x++) {
      const np_reprojected *place = &r->places[(size_t)y * r->width + x];
      const double moved = hypot((double)place->at[0] - x - 0.5, (double)place->at[1] - y - 0.5);
      seen += place->is_seen && moved <= jump_share * r->width;
    }
  return (double)seen < seen_share_min * r->width * r->height;
}

neph_result np_reconstruction_prepare(np_frame *f) {
  np_reconstruction *r = f->reconstruction;
  neph_result result = pass_rows(f, guide_row);
  if (!result) result = pass_rows(f, mark_row);
  if (!result && r->before) result = pass_rows(f, project_row);
  if (result) return result;
  r->is_cut = r->before && has_cut(r);
  result = pass_rows(f, choose_row);
  for (size_t i = 0; i < (size_t)r->width * r->height && !result; i++) r->source_counts[r->sources[i]]++;
  return result;
}

/* ---- After ---- */

/* Copies a row of resolved values into the frame's planes. Depths of pixels that were not rendered come from their
 * guides. */
static void copy_row(const np_frame *f, unsigned y) {
  const np_reconstruction *r = f->reconstruction;
  const size_t pixels = (size_t)r->width * r->height, row = (size_t)y * r->width;
  const np_channel_finish_fn depth = np_channel_finish_get("depth"), distance = np_channel_finish_get("distance");
  for (unsigned c = 0; c < f->channels.count; c++) {
    const np_channel_finish_fn finish = f->channels.channel[c].kind.finish;
    if (finish != depth && finish != distance)
      memcpy(f->planes[c] + row, r->next.values + c * pixels + row, r->width * sizeof *f->planes[c]);
    for (unsigned x = 0; x < r->width && (finish == depth || finish == distance); x++) {
      if (np_reconstruction_is_rendered(r, row + x)) continue;
      const int at[2] = {r->min[0] + (int)x, r->min[1] + (int)y};
      const double half_m = (double)r->next.guides[row + x].half_m;
      f->planes[c][row + x] = (float)(finish == depth ? np_frame_get_depth(f, at, half_m) : half_m);
    }
  }
}

neph_result np_reconstruction_resolve(np_frame *f) {
  neph_result result = f->reconstruction->changes ? pass_rows(f, np_reconstruction_compare_row) : NEPH_OK;
  if (!result) result = pass_rows(f, np_reconstruction_blend_row);
  if (!result) result = pass_rows(f, np_reconstruction_interpolate_row);
  return result ? result : pass_rows(f, copy_row);
}

/* ---- Header ---- */

static neph_result describe_mean(const np_frame *f, neph_image *image) {
  const size_t pixels = (size_t)f->width * f->height;
  double mean[NP_BAND_COUNT] = {0};
  char text[96];
  if (!f->reconstruction->has_beauty) return NEPH_OK;
  for (int b = 0; b < NP_BAND_COUNT; b++)
    for (size_t i = 0; i < pixels; i++) mean[b] += (double)f->planes[b][i] / (double)pixels;
  np_print(text, sizeof text, "%.6g %.6g %.6g", mean[0], mean[1], mean[2]);
  return neph_image_set_attribute(image, "nephos:mean", text);
}

neph_result np_reconstruction_describe(const np_frame *f, neph_image *image) {
  const np_reconstruction *r = f->reconstruction;
  const double percent = 100.0 / ((double)r->width * r->height), rendered = (double)r->source_counts[NP_PIXEL_RENDERED];
  char text[160];
  np_print(text, sizeof text, "%.3g %% rendered, %.3g %% reprojected, %.3g %% interpolated%s", percent * rendered,
           percent * (double)r->source_counts[NP_PIXEL_REPROJECTED],
           percent * (double)r->source_counts[NP_PIXEL_INTERPOLATED],
           r->is_cut ? "; a cut: nothing was taken from the frame before" : "");
  np_log(r->context, NEPH_LOG_INFO, "pixels: %s", text);
  neph_result result = neph_image_set_attribute(image, "nephos:pixels", text);
  if (!result) result = np_image_set_real(image, "nephos:samples", 0.01 * percent * rendered * f->desc->sample_count);
  return result ? result : describe_mean(f, image);
}
