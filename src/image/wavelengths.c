/* SPDX-License-Identifier: Apache-2.0 */
#include "image/wavelengths.h"

#include <assert.h>
#include <math.h>

#include "image/matching.h"

static const double first_nm = 400.0, last_nm = 700.0;

/* Adds f over one cell by the midpoints of whole nanometres, clipped to the cell. */
typedef void (*add_fn)(void *sums, double nm, double width_nm);

static void sum_cell(const np_wavelengths *w, unsigned index, add_fn add, void *sums) {
  const double low = w->bound_nm[index], high = w->bound_nm[index + 1];
  for (double begin = floor(low); begin < high; begin += 1.0) {
    const double from = fmax(begin, low), to = fmin(begin + 1.0, high);
    add(sums, 0.5 * (from + to), to - from);
  }
}

/* Integrals of x, y, z over a cell, without and with the factor of the wavelength. */
typedef struct cell_moments {
  double mass[3], moment[3];
} cell_moments;

static void add_moments(void *sums, double nm, double width_nm) {
  cell_moments *m = sums;
  double xyz[3];
  np_matching_eval(nm, xyz);
  for (int c = 0; c < 3; c++) {
    m->mass[c] += width_nm * xyz[c];
    m->moment[c] += width_nm * xyz[c] * nm;
  }
}

static void choose_cell(np_wavelengths *w, unsigned index, cell_moments *out) {
  *out = (cell_moments){{0}, {0}};
  sum_cell(w, index, add_moments, out);
  w->nm[index] = (out->moment[0] + out->moment[1] + out->moment[2]) / (out->mass[0] + out->mass[1] + out->mass[2]);
}

void np_wavelengths_choose(unsigned count, np_wavelengths *out) {
  assert(count >= 1 && count <= NP_WAVELENGTHS_MAX);
  cell_moments cells[NP_WAVELENGTHS_MAX];
  *out = (np_wavelengths){.count = count};
  for (unsigned i = 0; i <= count; i++) out->bound_nm[i] = first_nm + (last_nm - first_nm) * i / count;
  out->bound_nm[0] = NP_MATCHING_FIRST_NM;
  out->bound_nm[count] = NP_MATCHING_LAST_NM;
  for (unsigned i = 0; i < count; i++) choose_cell(out, i, &cells[i]);
  for (unsigned i = 0; i < count; i++) {
    const unsigned below = i > 0 ? i - 1 : i, above = i + 1 < count ? i + 1 : i;
    assert(count == 1 || out->nm[below] < out->nm[above]);
    for (int c = 0; c < 3; c++) {
      const double beside = cells[i].moment[c] - cells[i].mass[c] * out->nm[i];
      const double shift = beside / (out->nm[above] - out->nm[below]);
      out->xyz_nm[i][c] += cells[i].mass[c];
      out->xyz_nm[above][c] += shift;
      out->xyz_nm[below][c] -= shift;
    }
  }
}

typedef struct mean_sums {
  double (*spectrum)(double nm);
  double sum, weight;
} mean_sums;

static void add_mean(void *sums, double nm, double width_nm) {
  mean_sums *m = sums;
  const double weight = width_nm * np_matching_sum(nm);
  m->sum += weight * m->spectrum(nm);
  m->weight += weight;
}

double np_wavelengths_mean(const np_wavelengths *wavelengths, unsigned index, double (*spectrum)(double nm)) {
  mean_sums sums = {.spectrum = spectrum};
  sum_cell(wavelengths, index, add_mean, &sums);
  return sums.sum / sums.weight;
}
