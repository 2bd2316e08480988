/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "core/random.h"
#include "image/film.h"

enum { CHANNELS = 3, SAMPLES_MAX = 300 };

/* Values over 16 decades and of both signs: any other order of additions gives other bits. */
static void draw_sample(uint32_t sample, float out[CHANNELS]) {
  np_random random = np_random_start(11, 0, 0, 0, sample);
  for (int c = 0; c < CHANNELS; c++) {
    float mantissa = np_random_float(&random) - 0.25f;
    out[c] = mantissa * powf(10.0f, 16.0f * np_random_float(&random) - 8.0f);
  }
}

static void add_range(np_film_accumulator *film, uint32_t begin, uint32_t end) {
  np_film_accumulator_begin(film, CHANNELS, begin);
  for (uint32_t sample = begin; sample < end; sample++) {
    float values[CHANNELS];
    draw_sample(sample, values);
    np_film_accumulator_add(film, values);
  }
}

/* The tree by its definition: a node is the sum of its halves, a leaf of 16 samples is summed in order. */
static double sum_node(uint32_t begin, uint32_t count, int channel) {
  if (count > NP_FILM_LEAF_SAMPLES)
    return sum_node(begin, count / 2, channel) + sum_node(begin + count / 2, count / 2, channel);
  double sum = 0;
  for (uint32_t sample = begin; sample < begin + count; sample++) {
    float values[CHANNELS];
    draw_sample(sample, values);
    sum += (double)values[channel];
  }
  return sum;
}

/* Maximal nodes of [begin, end) from the left; what follows is added to each from the right. */
static double sum_tree(uint32_t begin, uint32_t end, int channel) {
  uint32_t count = NP_FILM_LEAF_SAMPLES;
  if (end - begin < count) count = end - begin;
  while (count >= NP_FILM_LEAF_SAMPLES && begin % (2 * count) == 0 && begin + 2 * count <= end) count *= 2;
  double first = sum_node(begin, count, channel);
  return begin + count == end ? first : first + sum_tree(begin + count, end, channel);
}

typedef struct fixture {
  np_film_accumulator whole, part, merged;
} fixture;

static int create_fixture(void **state) { return (*state = calloc(1, sizeof(fixture))) ? 0 : -1; }

static int destroy_fixture(void **state) {
  free(*state);
  return 0;
}

static void assert_same_sums(const np_film_accumulator *a, const np_film_accumulator *b) {
  double sums_a[CHANNELS], sums_b[CHANNELS];
  np_film_accumulator_finish(a, sums_a);
  np_film_accumulator_finish(b, sums_b);
  assert_memory_equal(sums_a, sums_b, sizeof sums_a);
}

static void sums_follow_the_tree(void **state) {
  fixture *f = *state;
  for (uint32_t count = 1; count <= SAMPLES_MAX; count++) {
    double sums[CHANNELS];
    add_range(&f->whole, 0, count);
    np_film_accumulator_finish(&f->whole, sums);
    for (int c = 0; c < CHANNELS; c++) assert_true(sums[c] == sum_tree(0, count, c));
  }
}

static void no_samples_sum_to_zero(void **state) {
  fixture *f = *state;
  double sums[CHANNELS] = {1, 1, 1};
  np_film_accumulator_begin(&f->whole, CHANNELS, 0);
  np_film_accumulator_finish(&f->whole, sums);
  for (int c = 0; c < CHANNELS; c++) assert_true(sums[c] == 0);
}

/* Renders [begin, end) alone and gives its nodes to the merged film. */
static void merge_part(fixture *f, uint32_t begin, uint32_t end) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  add_range(&f->part, begin, end);
  unsigned count = np_film_accumulator_get_nodes(&f->part, nodes);
  for (unsigned i = 0; i < count; i++) assert_true(np_film_accumulator_add_node(&f->merged, &nodes[i]));
}

static void every_pair_of_parts_merges_to_the_same_bits(void **state) {
  fixture *f = *state;
  for (uint32_t end = 1; end <= SAMPLES_MAX; end += 7) {
    add_range(&f->whole, 0, end);
    for (uint32_t cut = 0; cut <= end; cut += NP_FILM_LEAF_SAMPLES) {
      np_film_accumulator_begin(&f->merged, CHANNELS, 0);
      merge_part(f, 0, cut);
      merge_part(f, cut, end);
      assert_same_sums(&f->merged, &f->whole);
    }
  }
}

/* Every way to cut 12 leaves, and a ragged one, into parts. */
static void every_division_into_parts_merges_to_the_same_bits(void **state) {
  enum { LEAVES = 12, END = LEAVES * NP_FILM_LEAF_SAMPLES + 5 };
  fixture *f = *state;
  add_range(&f->whole, 0, END);
  for (uint32_t cuts = 0; cuts < 1u << LEAVES; cuts++) {
    uint32_t begin = 0;
    np_film_accumulator_begin(&f->merged, CHANNELS, 0);
    for (uint32_t leaf = 1; leaf <= LEAVES; leaf++) {
      if (!(cuts >> (leaf - 1) & 1u)) continue;
      merge_part(f, begin, leaf * NP_FILM_LEAF_SAMPLES);
      begin = leaf * NP_FILM_LEAF_SAMPLES;
    }
    merge_part(f, begin, END);
    assert_same_sums(&f->merged, &f->whole);
  }
}

/* Parts merge in two steps as well: the middle ones among themselves first. */
static void merged_parts_merge_again(void **state) {
  fixture *f = *state;
  np_film_node nodes[NP_FILM_NODES_MAX];
  add_range(&f->whole, 0, SAMPLES_MAX);
  np_film_accumulator_begin(&f->merged, CHANNELS, 48);
  merge_part(f, 48, 112);
  merge_part(f, 112, 240);
  np_film_accumulator middle = f->merged;
  np_film_accumulator_begin(&f->merged, CHANNELS, 0);
  merge_part(f, 0, 48);
  unsigned count = np_film_accumulator_get_nodes(&middle, nodes);
  for (unsigned i = 0; i < count; i++) assert_true(np_film_accumulator_add_node(&f->merged, &nodes[i]));
  merge_part(f, 240, SAMPLES_MAX);
  assert_same_sums(&f->merged, &f->whole);
}

/* [16, 176): one odd node a level while siblings lie outside, then even ones. */
static void nodes_of_a_range_are_maximal_and_in_order(void **state) {
  fixture *f = *state;
  np_film_node nodes[NP_FILM_NODES_MAX];
  const uint32_t begins[] = {16, 32, 64, 128, 160, 176}, counts[] = {16, 32, 64, 32, 16, 3};
  add_range(&f->part, 16, 179);
  assert_int_equal(np_film_accumulator_get_nodes(&f->part, nodes), 6);
  for (int i = 0; i < 6; i++) {
    assert_int_equal(nodes[i].sample_begin, begins[i]);
    assert_int_equal(nodes[i].sample_count, counts[i]);
    for (int c = 0; c < CHANNELS; c++) assert_true(nodes[i].sums[c] == sum_node(begins[i], counts[i], c));
  }
}

static void nodes_that_do_not_continue_are_refused(void **state) {
  fixture *f = *state;
  const double sums[CHANNELS] = {1, 2, 3};
  const np_film_node gap = {48, 16, sums}, overlap = {16, 16, sums}, crooked = {32, 48, sums},
                     unaligned = {32, 64, sums};
  const np_film_node nothing = {32, 0, sums}, ragged = {32, 5, sums}, behind_ragged = {37, 5, sums};
  add_range(&f->part, 0, 32);
  assert_false(np_film_accumulator_add_node(&f->part, &gap));
  assert_false(np_film_accumulator_add_node(&f->part, &overlap));
  assert_false(np_film_accumulator_add_node(&f->part, &crooked));
  assert_false(np_film_accumulator_add_node(&f->part, &unaligned));
  assert_false(np_film_accumulator_add_node(&f->part, &nothing));
  assert_true(np_film_accumulator_add_node(&f->part, &ragged));
  assert_false(np_film_accumulator_add_node(&f->part, &behind_ragged));
}

#define FILM_TEST(name) cmocka_unit_test_setup_teardown(name, create_fixture, destroy_fixture)

int main(void) {
  const struct CMUnitTest tests[] = {
      FILM_TEST(sums_follow_the_tree),
      FILM_TEST(no_samples_sum_to_zero),
      FILM_TEST(every_pair_of_parts_merges_to_the_same_bits),
      FILM_TEST(every_division_into_parts_merges_to_the_same_bits),
      FILM_TEST(merged_parts_merge_again),
      FILM_TEST(nodes_of_a_range_are_maximal_and_in_order),
      FILM_TEST(nodes_that_do_not_continue_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
