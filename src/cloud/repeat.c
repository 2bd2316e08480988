/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/repeat.h"

#include "volume/sparse_grid.h"

neph_cloud_desc np_repeat_round(const neph_cloud_desc *desc) {
  neph_cloud_desc rounded = *desc;
  const double leaf_m = NP_LEAF_EDGE * desc->voxel_m;
  if (desc->repeat_m > 0)
    rounded.voxel_m = desc->extent_m[0] / (NP_LEAF_EDGE * np_repeat_count(desc->extent_m[0], leaf_m));
  return rounded;
}
