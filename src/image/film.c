/* SPDX-License-Identifier: Apache-2.0 */
#include "image/film.h"

#include <assert.h>
#include <string.h>

static void copy_sums(unsigned channel_count, double *to, const double *from) {
  memcpy(to, from, channel_count * sizeof *to);
}

/* The left child is the first operand wherever two nodes meet, and this is the only place where they do. */
static void add_to_left(unsigned channel_count, const double *left, double *right) {
  for (unsigned c = 0; c < channel_count; c++) right[c] = left[c] + right[c];
}

static uint32_t get_ragged_count(const np_film_accumulator *accumulator) {
  return accumulator->sample_next % NP_FILM_LEAF_SAMPLES;
}

/* Stores a complete node, joined with the siblings that wait for it; destroys `sums`. */
static void store_node(np_film_accumulator *accumulator, unsigned level, uint32_t index, double *sums) {
  for (; index & accumulator->pending >> level & 1u; level++, index >>= 1) {
    add_to_left(accumulator->channel_count, accumulator->pending_node[level], sums);
    accumulator->pending &= ~(1u << level);
  }
  bool is_odd = index & 1u;
  *(is_odd ? &accumulator->edge : &accumulator->pending) |= 1u << level;
  copy_sums(accumulator->channel_count, (is_odd ? accumulator->edge_node : accumulator->pending_node)[level], sums);
}

void np_film_accumulator_begin(np_film_accumulator *accumulator, unsigned channel_count, uint32_t sample_begin) {
  assert(channel_count <= NP_FILM_CHANNELS_MAX && sample_begin % NP_FILM_LEAF_SAMPLES == 0);
  accumulator->channel_count = channel_count;
  accumulator->sample_begin = accumulator->sample_next = sample_begin;
  accumulator->pending = accumulator->edge = 0;
}

void np_film_accumulator_add(np_film_accumulator *accumulator, const float *values) {
  bool is_first = get_ragged_count(accumulator) == 0;
  for (unsigned c = 0; c < accumulator->channel_count; c++)
    accumulator->leaf[c] = is_first ? (double)values[c] : accumulator->leaf[c] + (double)values[c];
  accumulator->sample_next++;
  if (get_ragged_count(accumulator) == 0)
    store_node(accumulator, 0, accumulator->sample_next / NP_FILM_LEAF_SAMPLES - 1, accumulator->leaf);
}

bool np_film_accumulator_add_node(np_film_accumulator *accumulator, const np_film_node *node) {
  uint32_t count = node->sample_count;
  if (node->sample_begin != accumulator->sample_next || get_ragged_count(accumulator) != 0 || count == 0) return false;
  bool is_ragged = count < NP_FILM_LEAF_SAMPLES, is_power_of_two = (count & (count - 1)) == 0;
  if (!is_ragged && (!is_power_of_two || node->sample_begin % count != 0)) return false;

  copy_sums(accumulator->channel_count, accumulator->leaf, node->sums);
  accumulator->sample_next += count;
  if (is_ragged) return true;
  unsigned level = 0;
  while ((uint32_t)NP_FILM_LEAF_SAMPLES << level < count) level++;
  store_node(accumulator, level, node->sample_begin / count, accumulator->leaf);
  return true;
}

/* Going right, nodes grow while their siblings lie before the range, then shrink. */
unsigned np_film_accumulator_get_nodes(const np_film_accumulator *accumulator, np_film_node out[NP_FILM_NODES_MAX]) {
  unsigned count = 0;
  uint32_t begin = accumulator->sample_begin;
  for (unsigned level = 0; level < NP_FILM_LEVELS; level++) {
    if (!(accumulator->edge >> level & 1u)) continue;
    out[count++] = (np_film_node){begin, (uint32_t)NP_FILM_LEAF_SAMPLES << level, accumulator->edge_node[level]};
    begin += (uint32_t)NP_FILM_LEAF_SAMPLES << level;
  }
  for (unsigned level = NP_FILM_LEVELS; level-- > 0;) {
    if (!(accumulator->pending >> level & 1u)) continue;
    out[count++] = (np_film_node){begin, (uint32_t)NP_FILM_LEAF_SAMPLES << level, accumulator->pending_node[level]};
    begin += (uint32_t)NP_FILM_LEAF_SAMPLES << level;
  }
  uint32_t ragged_count = get_ragged_count(accumulator);
  if (ragged_count) out[count++] = (np_film_node){begin, ragged_count, accumulator->leaf};
  return count;
}

void np_film_accumulator_finish(const np_film_accumulator *accumulator, double *out_sums) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  unsigned count = np_film_accumulator_get_nodes(accumulator, nodes);
  if (count == 0) {
    for (unsigned c = 0; c < accumulator->channel_count; c++) out_sums[c] = 0;
    return;
  }
  copy_sums(accumulator->channel_count, out_sums, nodes[count - 1].sums);
  for (unsigned i = count - 1; i-- > 0;) add_to_left(accumulator->channel_count, nodes[i].sums, out_sums);
}
