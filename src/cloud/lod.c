/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/lod.h"

#include <assert.h>
#include <math.h>

unsigned np_lod_choose(const np_lod_viewers *viewers, unsigned count, double voxel_m, const double low_m[3],
                       const double high_m[3]) {
  assert(count >= 1 && voxel_m > 0.0 && viewers->angle_rad >= 0.0);
  double squared = 0;
  for (int a = 0; a < 3; a++) {
    const double beside_m = fmax(fmax(low_m[a] - viewers->max_m[a], viewers->min_m[a] - high_m[a]), 0.0);
    squared += beside_m * beside_m;
  }
  const double voxel_max_m = sqrt(squared) * viewers->angle_rad;
  unsigned level = 0;
  for (double m = 2 * voxel_m; level + 1 < count && m <= voxel_max_m; m *= 2) level++;
  return level;
}
