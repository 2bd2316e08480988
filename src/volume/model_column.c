/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "volume/model.h"

static double get_middle(const double *faces_m, size_t level) { return 0.5 * (faces_m[level] + faces_m[level + 1]); }

/* Slope within a level: the central difference, limited so that the values at its faces stay between those of its
 * neighbours. 0 at the ends and at extremes. */
static double compute_slope(size_t count, const double *faces_m, const double *values, size_t level) {
  if (level == 0 || level + 1 == count) return 0.0;
  const double below = values[level] - values[level - 1], above = values[level + 1] - values[level];
  if (!(below * above > 0.0)) return 0.0;
  const double height_m = faces_m[level + 1] - faces_m[level];
  const double central = (below + above) / (get_middle(faces_m, level + 1) - get_middle(faces_m, level - 1));
  return copysign(fmin(fabs(central), 2.0 * fmin(fabs(below), fabs(above)) / height_m), central);
}

/* Adds the integral of a level over the part of each voxel within it. */
static void spread_level(const double faces_m[2], double value, double slope, double bottom_m, double step_m,
                         size_t voxel_count, double *out_values) {
  const double middle_m = 0.5 * (faces_m[0] + faces_m[1]), last = (double)(voxel_count - 1);
  const double begin = fmin(fmax(floor((faces_m[0] - bottom_m) / step_m), 0.0), last);
  const double end = fmin(fmax(floor((faces_m[1] - bottom_m) / step_m), 0.0), last);
  for (size_t k = (size_t)begin; k <= (size_t)end; k++) {
    const double low = fmax(faces_m[0], k == 0 ? faces_m[0] : bottom_m + (double)k * step_m);
    const double high = fmin(faces_m[1], k + 1 == voxel_count ? faces_m[1] : bottom_m + (double)(k + 1) * step_m);
    if (high > low) out_values[k] += (high - low) / step_m * (value + slope * (0.5 * (low + high) - middle_m));
  }
}

void np_model_resample_column(size_t level_count, const double *faces_m, const double *values, double bottom_m,
                              double step_m, size_t voxel_count, double *out_values) {
  for (size_t k = 0; k < voxel_count; k++) out_values[k] = 0.0;
  for (size_t j = 0; j < level_count; j++)
    if (values[j] > 0.0)
      spread_level(&faces_m[j], values[j], compute_slope(level_count, faces_m, values, j), bottom_m, step_m,
                   voxel_count, out_values);
}
