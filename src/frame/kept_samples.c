/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/kept_samples.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "frame/frame_state.h"
#include "plan/scene_hash.h"

void np_kept_samples_clear(np_kept_samples *kept) {
  np_alloc_free(kept->context, kept->records);
  *kept = (np_kept_samples){.context = kept->context};
}

/* ---- The picture ---- */

/* Whether all pixels have the same number of samples, which are all taken here. */
static bool is_even(const np_frame *f) {
  const neph_render_desc *desc = f->desc;
  return !f->film && !f->reconstruction && !f->depth_components && !np_frame_has_target(f) &&
         !isfinite(desc->time_limit_s) && desc->sample_begin == 0 && desc->sample_end == desc->sample_count;
}

/* Hashes the picture but for its number of samples. Decisions that follow from that number count: other caches are
 * other bits. */
static neph_result hash_picture(const neph_scene *scene, const np_plan *plan, const np_frame *f, char out[33]) {
  neph_render_desc desc = plan->request.desc;
  char scene_hash[33];
  desc.sample_count = 0;
  out[0] = '\0';
  neph_result result = np_scene_hash_compute(scene, &desc, plan->savings.text, scene_hash);
  if (result || !*scene_hash) return result;
  uint64_t needs = 0;
  for (int stage = 0; stage < NP_STAGE_COUNT; stage++) needs |= (uint64_t)np_plan_needs(plan, (np_stage)stage) << stage;
  np_hash *hash = np_hash_create(scene->context);
  np_hash_add_text(hash, scene_hash);
  NP_HASH_ADD(hash, needs);
  NP_HASH_ADD(hash, plan->decisions.air_ray_spacing);
  NP_HASH_ADD(hash, f->min);
  NP_HASH_ADD(hash, f->width);
  NP_HASH_ADD(hash, f->height);
  NP_HASH_ADD(hash, f->aovs);
  return np_hash_finish(hash, out);
}

static unsigned count_nodes(uint32_t samples) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  return np_film_list_nodes(0, samples, nodes);
}

static size_t count_reals(unsigned node_max, unsigned numbers) { return 1 + (size_t)node_max * numbers; }

/* Records with room for `node_max` nodes, with the samples of those before. */
static neph_result resize(np_kept_samples *kept, unsigned node_max) {
  const size_t before = count_reals(kept->node_max, kept->numbers), after = count_reals(node_max, kept->numbers);
  double *records = np_alloc(kept->context, kept->pixel_count, after * sizeof *records);
  if (!records) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; kept->records && i < kept->pixel_count; i++)
    memcpy(records + i * after, kept->records + i * before, before * sizeof *records);
  np_alloc_free(kept->context, kept->records);
  kept->records = records;
  kept->node_max = node_max;
  return NEPH_OK;
}

/* Whether a pixel has more samples than are wanted. */
static bool has_more(const np_kept_samples *kept, uint32_t samples) {
  const size_t reals = count_reals(kept->node_max, kept->numbers);
  for (size_t i = 0; i < kept->pixel_count; i++)
    if (kept->records[i * reals] > samples) return true;
  return false;
}

neph_result np_kept_samples_begin(np_kept_samples *kept, const neph_scene *scene, const np_plan *plan,
                                  const np_frame *f) {
  char picture[33] = "";
  const uint32_t samples = f->desc->sample_count;
  neph_result result = is_even(f) ? hash_picture(scene, plan, f, picture) : NEPH_OK;
  const uint64_t results = f->assembly->stores->added;
  const bool is_same =
      *picture && !strcmp(picture, kept->picture) && results == kept->results && !has_more(kept, samples);
  if (!is_same) np_kept_samples_clear(kept);
  if (result || !*picture) return result;
  memcpy(kept->picture, picture, sizeof kept->picture);
  kept->results = results;
  kept->numbers = np_channels_count_numbers(&f->channels);
  kept->pixel_count = (size_t)f->width * f->height;
  const unsigned node_max = count_nodes(samples);
  if (!kept->records || node_max > kept->node_max) result = resize(kept, node_max);
  if (result) np_kept_samples_clear(kept);
  return result;
}

/* ---- Records ---- */

double *np_kept_samples_get(const np_kept_samples *kept, size_t index) {
  return kept && kept->records ? kept->records + index * count_reals(kept->node_max, kept->numbers) : NULL;
}

uint32_t np_kept_samples_load(const np_kept_samples *kept, const double *record, np_film_accumulator *accumulator) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  const uint32_t count = (uint32_t)record[0];
  const unsigned node_count = count ? np_film_list_nodes(0, count, nodes) : 0;
  for (unsigned n = 0; n < node_count; n++) {
    nodes[n].sums = record + 1 + n * kept->numbers;
    (void)np_film_accumulator_add_node(accumulator, &nodes[n]);
  }
  return count;
}

void np_kept_samples_store(const np_kept_samples *kept, double *record, const np_film_accumulator *accumulator,
                           uint32_t count) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  const unsigned node_count = np_film_accumulator_get_nodes(accumulator, nodes);
  record[0] = count;
  for (unsigned n = 0; n < node_count; n++)
    memcpy(record + 1 + n * kept->numbers, nodes[n].sums, kept->numbers * sizeof *record);
}
