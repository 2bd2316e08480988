/* SPDX-License-Identifier: Apache-2.0 */
/* Statistics of cloud fields from above: regions of a map, their sizes and outlines, and spectra. */
#ifndef NP_FIELD_STATISTICS_H
#define NP_FIELD_STATISTICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* 4-connected cells; lengths in cells. */
typedef struct field_region {
  double area, perimeter; /* edges to cells outside, holes' included */
} field_region;

/* Regions in the order of their first cells; labels, or NULL, count from 1, 0 outside. NULL: out of memory. */
field_region *field_label_regions(int32_t width, int32_t height, const uint8_t *is_inside, int32_t *labels,
                                  size_t *out_count);

/* n(L) ∝ L^−below up to the break, then L^−above, continuous; by maximum likelihood. Errors are standard ones, at the
 * break that was chosen. */
typedef struct field_power_law {
  size_t count;
  double below, below_error, above, break_size;
  double gain; /* in log likelihood, over the best single power law */
} field_power_law;

/* Fit to the sizes from the least on, which are sorted. False: fewer than 20 of them are left. */
bool field_fit_power_law(double *sizes, size_t count, double least, field_power_law *out);

/* A straight line. */
typedef struct field_line {
  double slope, error; /* one standard error, by the residuals */
  double decades;      /* range of the abscissa */
} field_line;

/* Slope of log perimeter over log area, twice: the dimension D of perimeter ∝ area^(D/2). Means of bins of a fifth of a
 * decade weigh the same, from the least area on. */
field_line field_fit_dimension(const field_region *regions, size_t count, double least_area);

/* Slope of the spectrum of rows and columns of a map about the map's mean, each under Hann's window, for wavelengths
 * between two lengths in cells. False: out of memory. */
bool field_fit_spectrum(int32_t width, int32_t height, const float *values, double shortest, double longest,
                        field_line *out);

/* Components of a volume, 26-connected as what is interpolated between its cells is; z fastest: cells and lowest height
 * of each. NULL: out of memory. */
typedef struct field_component {
  double volume;
  int32_t lowest;
} field_component;
field_component *field_label_components(const int32_t size[3], const uint8_t *is_inside, size_t *out_count);

#endif
