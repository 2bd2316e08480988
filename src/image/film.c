/* SPDX-License-Identifier: Apache-2.0 */
#include "image/film.h"

#include <assert.h>
#include <string.h>

static void copy_sums(unsigned channel_count, double *to, const double *from) {
  memcpy(to, from, channel_count * sizeof *to);
}

static unsigned get_sum_count(const np_film_accumulator *accumulator) {
  return accumulator->channel_count - 2 * accumulator->moment_count;
}

static void join_moments(unsigned count, const double *left, double left_count, double *right, double right_count) {
  const double all = left_count + right_count;
  for (unsigned m = 0; m < count; m++) {
    const double distance = right[m] - left[m];
    right[count + m] = left[count + m] + right[count + m] + distance * distance * (left_count * right_count / all);
    right[m] = left[m] + distance * (right_count / all);
  }
}

/* Joins two nodes. This is the only sum of nodes, and the left child is always the first operand. */
void np_film_accumulator_join(const np_film_accumulator *accumulator, const double *left, uint32_t left_count,
                              double *right, uint32_t right_count) {
  const unsigned sums = get_sum_count(accumulator);
  for (unsigned c = 0; c < sums; c++) right[c] = left[c] + right[c];
  join_moments(accumulator->moment_count, left + sums, left_count, right + sums, right_count);
}

static uint32_t get_ragged_count(const np_film_accumulator *accumulator) {
  return accumulator->sample_next % NP_FILM_LEAF_SAMPLES;
}

/* Stores a complete node, joined with its waiting siblings; destroys `sums`. */
static void store_node(np_film_accumulator *accumulator, unsigned level, uint32_t index, double *sums) {
  assert(level < NP_FILM_LEVELS);
  for (; index & accumulator->pending >> level & 1u; level++, index >>= 1) {
    const uint32_t count = (uint32_t)NP_FILM_LEAF_SAMPLES << level;
    np_film_accumulator_join(accumulator, accumulator->pending_node[level], count, sums, count);
    accumulator->pending &= ~(1u << level);
  }
  bool is_odd = index & 1u;
  *(is_odd ? &accumulator->edge : &accumulator->pending) |= 1u << level;
  copy_sums(accumulator->channel_count, (is_odd ? accumulator->edge_node : accumulator->pending_node)[level], sums);
}

void np_film_accumulator_begin(np_film_accumulator *accumulator, unsigned channel_count, uint32_t sample_begin) {
  assert(channel_count <= NP_FILM_CHANNELS_MAX && sample_begin % NP_FILM_LEAF_SAMPLES == 0);
  accumulator->channel_count = channel_count;
  accumulator->moment_count = 0;
  accumulator->sample_begin = accumulator->sample_next = sample_begin;
  accumulator->pending = accumulator->edge = 0;
}

void np_film_accumulator_begin_moments(np_film_accumulator *accumulator, unsigned sum_count, unsigned moment_count,
                                       uint32_t sample_begin) {
  np_film_accumulator_begin(accumulator, sum_count + 2 * moment_count, sample_begin);
  accumulator->moment_count = moment_count;
}

/* Adds the `count`-th sample of a leaf to its means and sums of squares. */
static void add_moments(np_film_accumulator *accumulator, const float *values, uint32_t count) {
  const unsigned moments = accumulator->moment_count;
  double *mean = accumulator->leaf + get_sum_count(accumulator), *squares = mean + moments;
  for (unsigned m = 0; m < moments; m++) {
    const double x = (double)values[m], before = count == 1 ? 0.0 : mean[m], distance = x - before;
    mean[m] = before + distance / count;
    squares[m] = (count == 1 ? 0.0 : squares[m]) + distance * (x - mean[m]);
  }
}

void np_film_accumulator_add(np_film_accumulator *accumulator, const float *values) {
  bool is_first = get_ragged_count(accumulator) == 0;
  const unsigned sums = get_sum_count(accumulator);
  for (unsigned c = 0; c < sums; c++)
    accumulator->leaf[c] = is_first ? (double)values[c] : accumulator->leaf[c] + (double)values[c];
  add_moments(accumulator, values + sums, get_ragged_count(accumulator) + 1);
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

static const uint32_t node_max = (uint32_t)NP_FILM_LEAF_SAMPLES << (NP_FILM_LEVELS - 1);

unsigned np_film_list_nodes(uint32_t begin, uint32_t end, np_film_node out[NP_FILM_NODES_MAX]) {
  unsigned count = 0;
  while (begin < end) {
    uint32_t samples = NP_FILM_LEAF_SAMPLES, left = end - begin;
    while (samples < node_max && begin % (2 * samples) == 0 && left / 2 >= samples) samples *= 2;
    if (samples > left) samples = left;
    out[count++] = (np_film_node){begin, samples, NULL};
    assert(count <= NP_FILM_NODES_MAX);
    begin += samples;
  }
  return count;
}

/* Nodes from left to right grow while their siblings lie before the range, then shrink. */
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
  uint32_t right_count = nodes[count - 1].sample_count;
  for (unsigned i = count - 1; i-- > 0; right_count += nodes[i].sample_count)
    np_film_accumulator_join(accumulator, nodes[i].sums, nodes[i].sample_count, out_sums, right_count);
}
