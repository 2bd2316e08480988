/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "core/random.h"
#include "image/image_private.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

static const char *const rgbz[] = {"R", "G", "B", "Z"};

/* R, G, B filled with one value, Z with 0. */
static neph_image *create_flat(test_fixture *f, unsigned width, unsigned height, float value) {
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, width, height, 4, rgbz, &image), NEPH_OK);
  for (unsigned c = 0; c < 3; c++)
    for (unsigned i = 0; i < width * height; i++) image->channels[c].values[i] = value;
  return image;
}

static neph_image_difference compare(test_fixture *f, const neph_image *image, const neph_image *reference) {
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare(f->context, image, reference, &difference), NEPH_OK);
  return difference;
}

static void a_picture_does_not_differ_from_itself(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 20, 20, 0.7f);
  for (int i = 0; i < 400; i++) image->channels[3].values[i] = INFINITY;
  neph_image_difference d = compare(f, image, image);
  assert_true(d.relative_mse == 0 && d.rmse == 0 && d.bias == 0 && d.bias_interval == 0 && d.block_rms == 0);
  assert_true(d.p999_relative == 0 && d.max_absolute == 0);
  assert_int_equal(d.value_count, 1200);
  assert_int_equal(d.differing_count, 0);
  neph_image_destroy(image);
}

/* Twice as bright: with L = 1 and ε = 0.01 every measure is known by hand. All are sums of equal terms, exact to
 * rounding; the percentile is kept in float. */
static void uniform_error_has_the_known_measures(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 24, 16, 2.0f), *reference = create_flat(f, 24, 16, 1.0f);
  neph_image_difference d = compare(f, image, reference);
  assert_near(d.relative_mse, 1.0 / 1.0001, 1e-12);
  assert_near(d.rmse, 1.0, 1e-12);
  assert_near(d.bias, 1.0, 1e-12);
  assert_near(d.bias_interval, 0.0, 1e-12); /* every block agrees */
  assert_near(d.block_rms, 1.0, 1e-12);
  assert_near(d.p999_relative, 1.0 / 1.01, 1e-7);
  assert_true(d.max_absolute == 1.0);
  assert_int_equal(d.differing_count, 24 * 16 * 3);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* Two values: reference (1, 3), picture (2, 3); mean 2, ε = 0.02. */
static void single_error_has_the_measures_computed_by_hand(void **state) {
  test_fixture *f = *state;
  static const char *const grey[] = {"Y"};
  neph_image *image, *reference;
  assert_int_equal(neph_image_create(f->context, 2, 1, 1, grey, &image), NEPH_OK);
  assert_int_equal(neph_image_create(f->context, 2, 1, 1, grey, &reference), NEPH_OK);
  image->channels[0].values[0] = 2, image->channels[0].values[1] = 3;
  reference->channels[0].values[0] = 1, reference->channels[0].values[1] = 3;
  neph_image_difference d = compare(f, image, reference);
  assert_near(d.relative_mse, 0.5 / (1.0 + 0.0004), 1e-12);
  assert_near(d.rmse, sqrt(0.5), 1e-12);
  assert_near(d.bias, 0.25, 1e-12);
  assert_true(isnan(d.bias_interval)); /* one block has no spread */
  assert_near(d.block_rms, 0.25, 1e-12);
  assert_near(d.p999_relative, 1.0 / 1.02, 1e-7);
  assert_int_equal(d.value_count, 2);
  assert_int_equal(d.differing_count, 1);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* One percent of error in each channel's own share: the brightest tenth of a percent is what p99.9 shows. */
static void percentile_is_that_of_the_sorted_values(void **state) {
  test_fixture *f = *state;
  static const char *const grey[] = {"Y"};
  enum { COUNT = 10000 };
  neph_image *image, *reference;
  assert_int_equal(neph_image_create(f->context, COUNT, 1, 1, grey, &image), NEPH_OK);
  assert_int_equal(neph_image_create(f->context, COUNT, 1, 1, grey, &reference), NEPH_OK);
  for (int i = 0; i < COUNT; i++) {
    reference->channels[0].values[i] = 1.0f;
    image->channels[0].values[i] = 1.0f + (float)((i * 7919) % COUNT) / COUNT; /* 7919 is prime: each rank once */
  }
  neph_image_difference d = compare(f, image, reference);
  assert_near(d.p999_relative, 0.9989 / 1.01, 1e-6); /* rank 9990 of 10000; the picture's values are floats near 2 */
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

static double draw_normal(np_random *random) {
  double u = 1.0 - np_random_double(random), v = np_random_double(random);
  return sqrt(-2.0 * log(u)) * cos(2.0 * 3.14159265358979323846 * v);
}

/* Noise of 10 % and a bias of 1 % on 400 pictures: the interval must hold the reference in 95 % of them. The count has
 * a standard deviation of √(400·0.95·0.05) = 4.4; five of them. */
static void confidence_interval_holds_the_bias_as_often_as_it_says(void **state) {
  test_fixture *f = *state;
  enum { PICTURES = 400, SIDE = 64 };
  neph_image *image = create_flat(f, SIDE, SIDE, 0), *reference = create_flat(f, SIDE, SIDE, 0);
  for (int i = 0; i < 3 * SIDE * SIDE; i++)
    reference->channels[i % 3].values[i / 3] = 1.0f + 0.5f * sinf(0.05f * (float)(i / 3 % SIDE));
  int held = 0;
  for (uint32_t k = 0; k < PICTURES; k++) {
    np_random random = np_random_start(5, k, 0, 0, 0);
    for (int i = 0; i < 3 * SIDE * SIDE; i++) {
      double noise = 1.01 + 0.1 * draw_normal(&random);
      image->channels[i % 3].values[i / 3] = (float)noise * reference->channels[i % 3].values[i / 3];
    }
    neph_image_difference d = compare(f, image, reference);
    held += fabs(d.bias - 0.01) <= d.bias_interval;
  }
  assert_near(held, 0.95 * PICTURES, 5 * 4.4);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* Noise that 8×8 means average away: block_rms is 1/8 of the pixels' 10 %, within 4 % for 192 blocks (5 σ of a variance
 * from 192 values are 36 %, of its root 18 %). */
static void block_rms_looks_past_the_noise_of_pixels(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 64, 64, 0), *reference = create_flat(f, 64, 64, 1.0f);
  np_random random = np_random_start(6, 0, 0, 0, 0);
  for (int i = 0; i < 3 * 64 * 64; i++)
    image->channels[i % 3].values[i / 3] = (float)(1.0 + 0.1 * draw_normal(&random));
  assert_near_relative(compare(f, image, reference).block_rms, 0.1 / 8, 0.18);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* A standard error of ½ in every pixel, R, G and B of the same samples: an eighth of it in means of 64 pixels, and in
 * the mean of all 256 a sixteenth. One channel without it, and nothing is known. */
static void noise_of_the_reference_is_stated(void **state) {
  test_fixture *f = *state;
  static const char *const names[] = {"R", "G", "B", "standard_error.R", "standard_error.G", "standard_error.B"};
  neph_image *image = create_flat(f, 16, 16, 2.0f), *reference = create_flat(f, 16, 16, 2.0f);
  neph_image_difference d = compare(f, image, reference);
  assert_true(isnan(d.noise_rmse) && isnan(d.noise_block_rms) && isnan(d.noise_bias));
  neph_image_destroy(reference);
  for (unsigned count = 5; count <= 6; count++) {
    assert_int_equal(neph_image_create(f->context, 16, 16, count, names, &reference), NEPH_OK);
    for (unsigned c = 0; c < count; c++)
      for (int i = 0; i < 256; i++) reference->channels[c].values[i] = c < 3 ? 2.0f : 0.5f;
    d = compare(f, image, reference);
    if (count == 5) assert_true(isnan(d.noise_rmse) && isnan(d.noise_block_rms) && isnan(d.noise_bias));
    neph_image_destroy(reference);
  }
  assert_near(d.noise_rmse, 0.5, 1e-12);
  assert_near(d.noise_block_rms, 0.5 / 8 / 2, 1e-12);
  assert_near(d.noise_bias, 0.5 / 16 / 2, 1e-12);
  neph_image_destroy(image);
}

/* Pictures of a bias of ± `bias` by columns of eight pixels and of noise, relative to a reference that spans a factor
 * of nine. R, G and B are of one sample: their noise is the same. */
typedef struct made_picture {
  unsigned side;
  double bias, noise;
} made_picture;

static double get_made_reference(const made_picture *m, unsigned i) {
  return 1.0 + 0.8 * sin(0.11 * (double)(i % m->side) + 0.07 * (double)(i / m->side));
}

static void fill_made(const made_picture *m, uint32_t seed, double bias, double noise, neph_image *out) {
  np_random random = np_random_start(9, seed, 0, 0, 0);
  for (unsigned i = 0; i < m->side * m->side; i++) {
    const double sign = i % m->side / 8 % 2 ? 1.0 : -1.0;
    const double value = get_made_reference(m, i), factor = 1.0 + sign * bias + noise * draw_normal(&random);
    for (int c = 0; c < 3; c++) out->channels[c].values[i] = (float)(value * factor);
    for (unsigned c = 3; c < out->channel_count; c++) out->channels[c].values[i] = (float)(value * noise);
  }
}

static bool holds(neph_bounded figure, double value) { return figure.min <= value && value <= figure.max; }

static const char *const rgb_with_errors[] = {
    "R", "G", "B", "standard_error.R", "standard_error.G", "standard_error.B"};

static const made_picture made = {64, 0.02, 0.03};

/* A noisy reference, whose own noise is taken off; noise of the picture by its channels, and by a second seed. */
static void made_errors_come_back_within_their_bounds(void **state) {
  test_fixture *f = *state;
  enum { PICTURES = 100 };
  neph_image *image[2], *reference;
  for (int k = 0; k < 2; k++)
    assert_int_equal(neph_image_create(f->context, made.side, made.side, 6, rgb_with_errors, &image[k]), NEPH_OK);
  assert_int_equal(neph_image_create(f->context, made.side, made.side, 6, rgb_with_errors, &reference), NEPH_OK);
  int held[6] = {0};
  for (uint32_t k = 0; k < PICTURES; k++) {
    fill_made(&made, 3 * k, made.bias, made.noise, image[0]);
    fill_made(&made, 3 * k + 1, made.bias, made.noise, image[1]);
    fill_made(&made, 3 * k + 2, 0.0, 0.02, reference);
    neph_image_difference by_pair = NEPH_IMAGE_DIFFERENCE_DEFAULT, d = compare(f, image[0], reference);
    assert_int_equal(neph_image_compare_seeds(f->context, image[0], image[1], reference, &by_pair), NEPH_OK);
    held[0] += holds(d.pixel_error, hypot(made.bias, made.noise));
    held[1] +=
        fabs(d.pixel_noise.value / made.noise - 1.0) < 0.01; /* stated by channels: known to the reference's 2 % */
    held[2] += holds(d.pixel_bias, made.bias);
    held[3] += holds(by_pair.pixel_error, hypot(made.bias, made.noise));
    held[4] += holds(by_pair.pixel_noise, made.noise);
    held[5] += holds(by_pair.pixel_bias, made.bias);
  }
  /* 95 of 100 have a standard deviation of 2.2; four of them, as six counts are looked at and squares are skewed. */
  for (int i = 0; i < 6; i++) assert_in_range(held[i], 86, 100);
  for (int k = 0; k < 2; k++) neph_image_destroy(image[k]);
  neph_image_destroy(reference);
}

/* A reference of 35 % of noise, by channels or by its header, and a picture of 3 % of bias; over the noisy pixel itself
 * the bias would read as 50 % and more. 196,608 pixels leave 4e-4 of the squares' noise, which bounds a bias of 3 % by
 * 0 and some 5 %. */
static void noise_of_the_reference_is_no_bias(void **state) {
  test_fixture *f = *state;
  enum { SEEDS = 5 };
  const made_picture large = {443, 0.03, 0.35};
  neph_image *image, *by_pixel, *by_header;
  assert_int_equal(neph_image_create(f->context, large.side, large.side, 3, rgb_with_errors, &image), NEPH_OK);
  assert_int_equal(neph_image_create(f->context, large.side, large.side, 6, rgb_with_errors, &by_pixel), NEPH_OK);
  assert_int_equal(neph_image_create(f->context, large.side, large.side, 3, rgb_with_errors, &by_header), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(by_header, "nephos:noise", "0.35"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(by_header, "nephos:noiseMin", "0.345"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(by_header, "nephos:noiseMax", "0.355"), NEPH_OK);
  fill_made(&large, 0, large.bias, 0.0, image);
  for (uint32_t seed = 1; seed <= SEEDS; seed++) {
    fill_made(&large, seed, 0.0, large.noise, by_pixel);
    for (int c = 0; c < 3; c++)
      memcpy(by_header->channels[c].values, by_pixel->channels[c].values,
             (size_t)large.side * large.side * sizeof(float));
    const neph_image_difference d = compare(f, image, by_pixel), stated = compare(f, image, by_header);
    assert_int_equal(d.reference_noise_source, NEPH_NOISE_BY_PIXEL);
    assert_near_relative(d.reference_noise.value, large.noise, 0.1);
    assert_true(holds(d.pixel_error, large.bias) && d.pixel_error.max < 0.06);
    assert_int_equal(stated.reference_noise_source, NEPH_NOISE_BY_HEADER);
    assert_near(stated.reference_noise.value, large.noise, 1e-12);
    assert_true(holds(stated.pixel_error, large.bias)); /* ± 1.5 % of the stated noise are 8 % of its square's root */
    assert_true(stated.pixel_error.max < 0.1);
    assert_near_relative(stated.noise_rmse, d.noise_rmse, 0.02);
  }
  neph_image_destroy(image);
  neph_image_destroy(by_pixel);
  neph_image_destroy(by_header);
}

/* The stated noise of 5 % is more than all that differs, 2 %, and no other seed could reach it: nothing is known. */
static void overstated_noise_leaves_nothing_known(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 64, 64, 1.02f), *reference = create_flat(f, 64, 64, 1.0f);
  assert_int_equal(neph_image_set_attribute(reference, "nephos:noise", "0.05"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(reference, "nephos:noiseMin", "0.049"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(reference, "nephos:noiseMax", "0.051"), NEPH_OK);
  const neph_image_difference d = compare(f, image, reference);
  assert_true(isnan(d.pixel_error.value) && isnan(d.pixel_error.min) && isnan(d.pixel_error.max));
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* Channels of standard errors that are twice too large, as those of spread samples are, and a header that is right: the
 * header's size is taken, of the reference and of the picture. An error is no less than its noise. */
static void channels_take_the_size_that_the_header_states(void **state) {
  test_fixture *f = *state;
  static const double overstatement = 2.0;
  const made_picture own = {128, 0.03, 0.04};
  neph_image *image, *reference;
  assert_int_equal(neph_image_create(f->context, own.side, own.side, 6, rgb_with_errors, &image), NEPH_OK);
  assert_int_equal(neph_image_create(f->context, own.side, own.side, 6, rgb_with_errors, &reference), NEPH_OK);
  fill_made(&own, 1, own.bias, own.noise, image);
  fill_made(&own, 2, 0.0, own.noise, reference);
  for (int k = 0; k < 2; k++) {
    neph_image *each = k ? image : reference;
    for (unsigned c = 3; c < 6; c++)
      for (unsigned i = 0; i < own.side * own.side; i++) each->channels[c].values[i] *= (float)overstatement;
  }
  const neph_image_difference overstated = compare(f, image, reference);
  assert_true(isnan(overstated.pixel_error.value) && isnan(overstated.pixel_bias.value));
  for (int k = 0; k < 2; k++) {
    neph_image *each = k ? image : reference;
    assert_int_equal(neph_image_set_attribute(each, "nephos:noise", "0.04"), NEPH_OK);
    assert_int_equal(neph_image_set_attribute(each, "nephos:noiseMin", "0.039"), NEPH_OK);
    assert_int_equal(neph_image_set_attribute(each, "nephos:noiseMax", "0.041"), NEPH_OK);
  }
  const neph_image_difference d = compare(f, image, reference);
  assert_int_equal(d.reference_noise_source, NEPH_NOISE_BY_PIXEL);
  assert_near_relative(d.reference_noise.value, own.noise, 0.02); /* the scale is that of a noisy picture */
  assert_near_relative(d.pixel_noise.value, own.noise, 0.02);
  assert_true(holds(d.pixel_bias, own.bias) && holds(d.pixel_error, hypot(own.bias, own.noise)));
  assert_near_relative(d.noise_rmse, overstated.noise_rmse / overstatement, 0.02);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* Noise stated by the header, else nothing is known of it; pixels below a hundredth of the mean are left out. */
static void noise_is_unknown_where_nothing_states_it(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 16, 16, 1.05f), *reference = create_flat(f, 16, 16, 1.0f);
  for (int c = 0; c < 3; c++) reference->channels[c].values[0] = 0.001f;
  neph_image_difference d = compare(f, image, reference);
  assert_int_equal(d.pixel_count, 255);
  assert_near(d.pixel_error.value, 0.05, 1e-6); /* floats near 1 */
  assert_true(isnan(d.pixel_noise.value) && isnan(d.pixel_bias.value) && isnan(d.pixel_bias.max));
  assert_int_equal(neph_image_set_attribute(image, "nephos:noise", "0.03"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, "nephos:noiseMax", "0.031"), NEPH_OK);
  d = compare(f, image, reference);
  assert_near(d.pixel_noise.value, 0.03, 1e-12);
  assert_near(d.pixel_bias.value, 0.04, 2e-6);
  assert_true(holds(d.pixel_bias, 0.04) && d.pixel_bias.min < d.pixel_bias.value);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* A green of +10 % alone: 7.15 % of Rec.709's luminance, a third in bands. */
static void error_is_that_of_luminance(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 16, 16, 1.0f), *reference = create_flat(f, 16, 16, 1.0f);
  for (int i = 0; i < 256; i++) image->channels[1].values[i] = 1.1f;
  assert_near(compare(f, image, reference).pixel_error.value, 0.0715, 1e-4); /* 0.7152 by the primaries' digits */
  assert_int_equal(neph_image_set_attribute(reference, "nephos:colorSpace", "nephos-bands"), NEPH_OK);
  assert_near(compare(f, image, reference).pixel_error.value, 0.1 / 3.0, 1e-6);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

static void black_references_give_no_nan(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 16, 16, 0), *reference = create_flat(f, 16, 16, 0);
  neph_image_difference d = compare(f, image, reference);
  assert_true(d.relative_mse == 0 && d.bias == 0 && d.bias_interval == 0 && d.p999_relative == 0);
  image->channels[0].values[0] = 1;
  d = compare(f, image, reference);
  assert_true(isinf(d.relative_mse) && isinf(d.bias));
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

static void values_without_a_finite_reference_are_left_out(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 16, 16, 1.0f), *reference = create_flat(f, 16, 16, 1.0f);
  reference->channels[0].values[3] = NAN;
  reference->channels[1].values[4] = INFINITY;
  image->channels[1].values[4] = INFINITY;
  neph_image_difference d = compare(f, image, reference);
  assert_int_equal(d.value_count, 3 * 256 - 2);
  assert_int_equal(d.differing_count, 1);
  assert_true(d.rmse == 0);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

static void unmeasurable_pictures_are_refused(void **state) {
  test_fixture *f = *state;
  neph_image_difference d = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_image *image = create_flat(f, 16, 16, 1.0f), *reference = create_flat(f, 16, 16, 1.0f), *out;
  image->channels[1].values[16 * 2 + 5] = NAN;
  assert_int_equal(neph_image_compare(f->context, image, reference, &d), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "pixel (5, 2)", "channel G", "nan");
  assert_int_equal(neph_image_create_difference(f->context, image, reference, &out), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "pixel (5, 2)");
  assert_null(out);
  neph_image_destroy(image);
  image = create_flat(f, 16, 15, 1.0f);
  assert_int_equal(neph_image_compare(f->context, image, reference, &d), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "16 × 15", "16 × 16");
  neph_image_destroy(image);
  assert_int_equal(neph_image_create(f->context, 16, 16, 2, rgbz, &image), NEPH_OK);
  assert_int_equal(neph_image_compare(f->context, image, reference, &d), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "no channel B");
  neph_image_destroy(image);
  image = create_flat(f, 16, 16, 1.0f);
  assert_int_equal(neph_image_set_attribute(image, "nephos:colorSpace", "rec709"), NEPH_OK);
  (void)compare(f, image, reference); /* which does not say */
  assert_int_equal(neph_image_set_attribute(reference, "nephos:colorSpace", "nephos-bands"), NEPH_OK);
  assert_int_equal(neph_image_compare(f->context, image, reference, &d), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "rec709", "nephos-bands");
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

/* 0 and −0 differ, a NaN does not from its copy, and a channel that one picture lacks differs everywhere. */
static void bits_are_compared_in_every_channel(void **state) {
  test_fixture *f = *state;
  static const char *const more[] = {"R", "G", "B", "Z", "sun.R"};
  neph_image *reference = create_flat(f, 4, 4, 0.0f), *image;
  assert_int_equal(neph_image_create(f->context, 4, 4, 5, more, &image), NEPH_OK);
  image->channels[0].values[0] = -0.0f;
  image->channels[3].values[1] = reference->channels[3].values[1] = NAN;
  image->channels[3].values[2] = NAN;
  assert_int_equal(compare(f, image, reference).differing_count, 1 + 1 + 16);
  neph_image_destroy(image);
  neph_image_destroy(reference);
}

/* ε = 0.01·mean 1 = 0.01; the pixels are brighter by half, and black. */
static void difference_picture_is_signed_and_coloured(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_flat(f, 3, 1, 1.0f), *reference = create_flat(f, 3, 1, 1.0f), *out;
  for (int c = 0; c < 3; c++) {
    image->channels[c].values[1] = 1.5f;
    image->channels[c].values[2] = 0.0f;
  }
  assert_int_equal(neph_image_create_difference(f->context, image, reference, &out), NEPH_OK);
  assert_int_equal(neph_image_get_channel_count(out), 6);
  const double signed_values[3] = {0, 0.5 / 1.01, -1 / 1.01};
  for (int i = 0; i < 3; i++) {
    assert_near(neph_image_get_channel(out, "difference.G")[i], signed_values[i], 1e-7); /* stored in float */
    assert_near(neph_image_get_channel(out, "R")[i], fmax(signed_values[i], 0), 1e-7);
    assert_near(neph_image_get_channel(out, "B")[i], fmax(-signed_values[i], 0), 1e-7);
    assert_true(neph_image_get_channel(out, "G")[i] == 0);
  }
  neph_image_destroy(out);
  neph_image_destroy(reference);
  neph_image_destroy(image);
}

static neph_result compare_two(neph_context *context, void *user) {
  (void)user;
  neph_image *image = NULL, *reference = NULL, *out = NULL;
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_result result = neph_image_create(context, 9, 9, 4, rgbz, &image);
  if (!result) result = neph_image_create(context, 9, 9, 4, rgbz, &reference);
  if (!result) result = neph_image_compare_seeds(context, image, image, reference, &difference);
  if (!result) result = neph_image_create_difference(context, image, reference, &out);
  neph_image_destroy(out);
  neph_image_destroy(reference);
  neph_image_destroy(image);
  return result;
}

static void failed_allocations_are_survived(void **state) {
  (void)state;
  assert_survives_failed_allocations(compare_two, NULL);
}

#define COMPARE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      COMPARE_TEST(a_picture_does_not_differ_from_itself),
      COMPARE_TEST(uniform_error_has_the_known_measures),
      COMPARE_TEST(single_error_has_the_measures_computed_by_hand),
      COMPARE_TEST(percentile_is_that_of_the_sorted_values),
      COMPARE_TEST(confidence_interval_holds_the_bias_as_often_as_it_says),
      COMPARE_TEST(block_rms_looks_past_the_noise_of_pixels),
      COMPARE_TEST(noise_of_the_reference_is_stated),
      COMPARE_TEST(made_errors_come_back_within_their_bounds),
      COMPARE_TEST(noise_of_the_reference_is_no_bias),
      COMPARE_TEST(overstated_noise_leaves_nothing_known),
      COMPARE_TEST(channels_take_the_size_that_the_header_states),
      COMPARE_TEST(noise_is_unknown_where_nothing_states_it),
      COMPARE_TEST(error_is_that_of_luminance),
      COMPARE_TEST(black_references_give_no_nan),
      COMPARE_TEST(values_without_a_finite_reference_are_left_out),
      COMPARE_TEST(unmeasurable_pictures_are_refused),
      COMPARE_TEST(bits_are_compared_in_every_channel),
      COMPARE_TEST(difference_picture_is_signed_and_coloured),
      COMPARE_TEST(failed_allocations_are_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
