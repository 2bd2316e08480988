/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "field_statistics.h"

static const double pi = 3.14159265358979323846;

/* ---- Power laws ---- */

enum { BREAKS = 60, ASCENTS = 12, SECTIONS = 40, SIZES_MIN = 20 };

/* Sizes on both sides of a break, in it. */
typedef struct broken_sample {
  double below_count, above_count, below_logs, above_logs; /* sums of ln x */
  double least, break_log;
} broken_sample;

static double integrate_power(double from, double exponent) { /* integral of x^−exponent up to 1 */
  const double rest = 1 - exponent, log_from = log(from);
  return fabs(rest * log_from) < 1e-8 ? -log_from : -expm1(rest * log_from) / rest;
}

static double compute_likelihood(const broken_sample *s, double below, double above) {
  const double mass = integrate_power(s->least, below) + 1 / (above - 1);
  return -below * s->below_logs - above * s->above_logs -
         (s->below_count + s->above_count) * (log(mass) + s->break_log);
}

/* The exponent of one side of highest likelihood, by golden sections. */
static double search_exponent(const broken_sample *s, bool is_below, double other) {
  const double golden = 0.6180339887498949;
  double low = is_below ? -1 : 1.05, high = is_below ? 6 : 12;
  for (int n = 0; n < SECTIONS; n++) {
    const double p = high - golden * (high - low), q = low + golden * (high - low);
    const double at_p = is_below ? compute_likelihood(s, p, other) : compute_likelihood(s, other, p);
    const double at_q = is_below ? compute_likelihood(s, q, other) : compute_likelihood(s, other, q);
    *(at_p > at_q ? &high : &low) = at_p > at_q ? q : p;
  }
  return 0.5 * (low + high);
}

static double fit_break(const broken_sample *s, double *out_below, double *out_above) {
  double below = 2, above = 3;
  for (int n = 0; n < ASCENTS; n++) {
    below = search_exponent(s, true, above);
    above = search_exponent(s, false, below);
  }
  *out_below = below;
  *out_above = above;
  return compute_likelihood(s, below, above);
}

static broken_sample split_sample(const double *sizes, size_t count, double least, double break_size) {
  broken_sample s = {.least = least / break_size, .break_log = log(break_size)};
  for (size_t i = 0; i < count; i++) {
    const double x = log(sizes[i] / break_size);
    *(x < 0 ? &s.below_logs : &s.above_logs) += x;
    *(x < 0 ? &s.below_count : &s.above_count) += 1;
  }
  return s;
}

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Standard error of the exponent below the break, by the curvature of the likelihood. */
static double compute_error(const broken_sample *s, double below, double above) {
  const double step = 1e-3;
  const double bend = compute_likelihood(s, below - step, above) + compute_likelihood(s, below + step, above) -
                      2 * compute_likelihood(s, below, above);
  return bend < 0 ? step / sqrt(-bend) : HUGE_VAL;
}

/* Breaks stand from the tenth largest size down to the middle one. */
bool field_fit_power_law(double *sizes, size_t count, double least, field_power_law *out) {
  size_t first = 0;
  qsort(sizes, count, sizeof *sizes, compare_doubles);
  while (first < count && sizes[first] < least) first++;
  sizes += first;
  count -= first;
  if (count < SIZES_MIN) return false;
  double best = -INFINITY, logs = 0;
  const double low = log(sizes[count / 2]), high = log(sizes[count - 10]);
  for (int n = 0; n < BREAKS; n++) {
    const double break_size = exp(low + (high - low) * n / (BREAKS - 1));
    const broken_sample s = split_sample(sizes, count, least, break_size);
    double below, above;
    const double likelihood = fit_break(&s, &below, &above);
    if (!(likelihood > best)) continue;
    best = likelihood;
    *out = (field_power_law){count, below, compute_error(&s, below, above), above, break_size, 0};
  }
  for (size_t i = 0; i < count; i++) logs += log(sizes[i] / least);
  const double n = (double)count, single = 1 + n / logs;
  out->gain = best - (n * log((single - 1) / least) - single * logs);
  return true;
}

/* ---- Lines ---- */

static field_line fit_line(size_t count, const double *x, const double *y) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, rest = 0;
  for (size_t i = 0; i < count; i++) mean_x += x[i] / (double)count, mean_y += y[i] / (double)count;
  for (size_t i = 0; i < count; i++) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  field_line line = {.slope = xx > 0 ? xy / xx : nan(""), .decades = count ? (x[count - 1] - x[0]) / log(10) : 0};
  for (size_t i = 0; i < count; i++) {
    const double off = y[i] - mean_y - line.slope * (x[i] - mean_x);
    rest += off * off;
  }
  line.error = count > 2 ? sqrt(rest / ((double)(count - 2) * xx)) : HUGE_VAL;
  return line;
}

enum { DIMENSION_BINS = 64, BIN_REGIONS_MIN = 4 };

field_line field_fit_dimension(const field_region *regions, size_t count, double least_area) {
  double number[DIMENSION_BINS] = {0}, x[DIMENSION_BINS] = {0}, y[DIMENSION_BINS] = {0};
  size_t kept = 0;
  for (size_t i = 0; i < count; i++) {
    const double off = 5 * log10(regions[i].area / least_area);
    if (!(off >= 0 && off < DIMENSION_BINS)) continue;
    const int bin = (int)off;
    number[bin]++;
    x[bin] += log(regions[i].area);
    y[bin] += log(regions[i].perimeter);
  }
  for (int bin = 0; bin < DIMENSION_BINS; bin++) {
    if (number[bin] < BIN_REGIONS_MIN) continue;
    x[kept] = x[bin] / number[bin];
    y[kept++] = y[bin] / number[bin];
  }
  field_line line = fit_line(kept, x, y);
  line.slope *= 2;
  line.error *= 2;
  return line;
}

/* ---- Spectra ---- */

/* Adds the power of the harmonics of a line of values under Hann's window, the plain sum for each. */
static void add_power(int32_t count, const double *line, int32_t harmonics, double *power) {
  for (int32_t h = 1; h < harmonics; h++) {
    const double turn = 2 * pi * h / count, cosine = cos(turn), sine = sin(turn);
    double re = 0, im = 0, c = 1, s = 0;
    for (int32_t i = 0; i < count; i++) {
      const double next = c * cosine - s * sine;
      re += line[i] * c;
      im += line[i] * s;
      s = s * cosine + c * sine;
      c = next;
    }
    power[h] += re * re + im * im;
  }
}

/* Power over wavenumbers, of all rows (columns: stride and step exchanged). */
static void add_lines(int32_t count, int32_t harmonics, size_t stride, size_t step, const float *values, double mean,
                      double *line, double *power) {
  for (int32_t n = 0; n < count; n++) {
    for (int32_t i = 0; i < count; i++) {
      const double window = 0.5 - 0.5 * cos(2 * pi * (i + 0.5) / count);
      line[i] = window * ((double)values[(size_t)n * step + (size_t)i * stride] - mean);
    }
    add_power(count, line, harmonics, power);
  }
}

/* Means of bins of a tenth of a decade weigh the same. */
static field_line fit_power(int32_t count, int32_t harmonics, const double *power, double shortest, double longest) {
  enum { BINS = 64 };
  double number[BINS] = {0}, x[BINS] = {0}, y[BINS] = {0};
  size_t kept = 0;
  for (int32_t h = 1; h < harmonics; h++) {
    const double length = (double)count / h, off = 10 * log10(longest / length);
    if (length < shortest || !(off >= 0 && off < BINS)) continue;
    number[(int)off]++;
    x[(int)off] += (double)h;
    y[(int)off] += power[h];
  }
  for (int bin = 0; bin < BINS; bin++) {
    if (!(number[bin] > 0)) continue;
    x[kept] = log(x[bin] / number[bin]);
    y[kept++] = log(y[bin] / number[bin]);
  }
  return fit_line(kept, x, y);
}

bool field_fit_spectrum(int32_t width, int32_t height, const float *values, double shortest, double longest,
                        field_line *out) {
  const int32_t count = width < height ? width : height; /* edge of the square in the map's corner */
  const int32_t harmonics = (int32_t)((double)count / shortest) + 1;
  double mean = 0, *line = malloc((size_t)count * sizeof *line), *power = calloc((size_t)count, sizeof *power);
  const bool is_done = line && power;
  for (int32_t j = 0; j < count && is_done; j++)
    for (int32_t i = 0; i < count; i++)
      mean += (double)values[(size_t)j * (size_t)width + (size_t)i] / ((double)count * count);
  if (is_done) {
    add_lines(count, harmonics, 1, (size_t)width, values, mean, line, power);
    add_lines(count, harmonics, (size_t)width, 1, values, mean, line, power);
    *out = fit_power(count, harmonics, power, shortest, longest);
  }
  free(line);
  free(power);
  return is_done;
}
