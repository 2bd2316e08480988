/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/deep_pixels.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

/* Segments that are compared pair by pair; more are first joined by their share of the opacity. */
enum { PAIRED_MAX = 128 };

/* ---- Adding ---- */

/* Light is spread where its place is not known. */
static np_spectrum compute_rest(const np_integrator_layers *layers, np_spectrum light, float *out_opacity) {
  *out_opacity = 0.0f;
  for (unsigned i = 0; i < layers->depth_count; i++) {
    light = np_spectrum_subtract(light, layers->depths[i].light);
    *out_opacity += layers->depths[i].opacity;
  }
  return light;
}

void np_deep_bins_add(np_deep_bins *bins, const np_integrator_layers *layers, np_spectrum light, float alpha) {
  float opacity;
  const np_spectrum rest = compute_rest(layers, light, &opacity);
  bins->alpha += alpha;
  if (bins->count + layers->depth_count > NP_DEEP_BINS_MAX) np_deep_bins_reduce(bins, PAIRED_MAX);
  for (unsigned i = 0; i < layers->depth_count && bins->count < NP_DEEP_BINS_MAX; i++) {
    np_depth_record *bin = &bins->at[bins->count++];
    *bin = layers->depths[i];
    if (opacity > 0.0f) bin->light = np_spectrum_add_scaled(bin->light, bin->opacity / opacity, rest);
  }
}

/* ---- Joining ---- */

static int compare(const void *a, const void *b) {
  const np_depth_record *p = a, *q = b;
  const float first = p->begin + p->end, second = q->begin + q->end;
  if (first != second) return first < second ? -1 : 1;
  return p->opacity < q->opacity ? -1 : p->opacity > q->opacity;
}

static void join(np_depth_record *to, const np_depth_record *from) {
  to->begin = fminf(to->begin, from->begin);
  to->end = fmaxf(to->end, from->end);
  to->opacity += from->opacity;
  to->light = np_spectrum_add(to->light, from->light);
}

/* Joins adjacent segments without a gap whose opacities sum to a small share. */
static void join_by_opacity(np_deep_bins *bins) {
  float all = 0.0f;
  for (unsigned i = 0; i < bins->count; i++) all += bins->at[i].opacity;
  const float most = 2.0f * all / PAIRED_MAX;
  const float gap = 2.0f * (bins->at[bins->count - 1].end - bins->at[0].begin) / PAIRED_MAX;
  unsigned joined = 0;
  for (unsigned i = 1; i < bins->count; i++) {
    np_depth_record *last = &bins->at[joined];
    const bool is_near = bins->at[i].begin - last->end <= gap;
    if (is_near && last->opacity + bins->at[i].opacity <= most)
      join(last, &bins->at[i]);
    else
      bins->at[++joined] = bins->at[i];
  }
  bins->count = joined + 1;
}

/* The error of a cut through a pair that is joined: its opacity, times how long it is. */
static float weigh_pair(const np_depth_record *a, const np_depth_record *b) {
  return (a->opacity + b->opacity + 1e-6f) * (fmaxf(a->end, b->end) - fminf(a->begin, b->begin));
}

static void join_least_pair(np_deep_bins *bins) {
  unsigned best = 0;
  float least = HUGE_VALF;
  for (unsigned i = 0; i + 1 < bins->count; i++) {
    const float weight = weigh_pair(&bins->at[i], &bins->at[i + 1]);
    if (weight < least) {
      least = weight;
      best = i;
    }
  }
  join(&bins->at[best], &bins->at[best + 1]);
  bins->count--;
  for (unsigned i = best + 1; i < bins->count; i++) bins->at[i] = bins->at[i + 1];
}

void np_deep_bins_reduce(np_deep_bins *bins, unsigned count_max) {
  qsort(bins->at, bins->count, sizeof *bins->at, compare);
  if (bins->count > count_max && bins->count > PAIRED_MAX) join_by_opacity(bins);
  while (bins->count > count_max) join_least_pair(bins);
}

/* ---- Storing ---- */

void np_deep_bins_load(const np_deep_stored *stored, np_deep_bins *out) {
  out->count = stored->count;
  out->alpha = stored->alpha;
  if (stored->count) memcpy(out->at, stored->at, stored->count * sizeof *stored->at);
}

neph_result np_deep_bins_store(neph_context *context, np_deep_bins *bins, np_deep_stored *stored) {
  np_deep_bins_reduce(bins, NP_DEEP_SAMPLES_MAX);
  np_alloc_free(context, stored->at);
  *stored = (np_deep_stored){.alpha = bins->alpha};
  if (bins->count == 0) return NEPH_OK;
  stored->at = np_alloc(context, bins->count, sizeof *stored->at);
  if (!stored->at) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(stored->at, bins->at, bins->count * sizeof *stored->at);
  stored->count = bins->count;
  return NEPH_OK;
}

/* ---- Finishing ---- */

/* Segments of several rays may overlap: each ends where the next begins, halfway. */
static void part(np_deep_bins *bins) {
  for (unsigned i = 0; i + 1 < bins->count; i++) {
    np_depth_record *a = &bins->at[i], *b = &bins->at[i + 1];
    if (a->end <= b->begin) continue;
    const float middle = fmaxf(0.5f * (a->end + b->begin), a->begin);
    a->end = middle;
    b->begin = middle;
    b->end = fmaxf(b->end, middle);
  }
}

/* Transmittance below which the following segments are merged: they are invisible, and survivors of Russian roulette
 * among them would be far too bright. */
static const float left_least = 2e-3f;

unsigned np_deep_bins_finish(np_deep_bins *bins, unsigned sample_count, float scale, double cosine,
                             np_deep_sample *out) {
  float all = 0.0f, left = 1.0f, before = 1.0f;
  unsigned count = 0;
  np_deep_bins_reduce(bins, NP_DEEP_SAMPLES_MAX);
  part(bins);
  for (unsigned i = 0; i < bins->count; i++) all += bins->at[i].opacity;
  const float opacity_scale = all > 0.0f ? bins->alpha / all / (float)sample_count : 0.0f,
              light_scale = scale / (float)sample_count;
  for (unsigned i = 0; i < bins->count; i++) {
    const np_depth_record *bin = &bins->at[i];
    const float opacity = bin->opacity * opacity_scale;
    if (count == 0 || left > left_least) {
      before = left;
      out[count++] = (np_deep_sample){.front = (float)((double)bin->begin * cosine)};
    }
    np_deep_sample *sample = &out[count - 1];
    sample->back = fmaxf((float)((double)bin->end * cosine), sample->front);
    sample->alpha = fminf(sample->alpha + opacity / before, 1.0f);
    for (int c = 0; c < 3; c++) sample->color[c] += bin->light.band[c] * light_scale / before;
    left -= opacity;
  }
  return count;
}
