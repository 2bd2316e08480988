/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/repeat.h"

#include "volume/sparse_grid.h"

static bool is_turned(const neph_cloud_desc *desc) {
  return desc->repeat_m > 0 && desc->wind_m_s[0] != 0 && desc->wind_m_s[1] != 0;
}

static double get_speed(const double wind_m_s[2]) {
  return sqrt(wind_m_s[0] * wind_m_s[0] + wind_m_s[1] * wind_m_s[1]);
}

/* Turns a vector into the frame of the tile; square roots alone give equal bits on every machine. */
static void turn(const double wind_m_s[2], double vector[2]) {
  const double speed_m_s = get_speed(wind_m_s), c = wind_m_s[0] / speed_m_s, s = wind_m_s[1] / speed_m_s;
  const double east = vector[0], north = vector[1];
  vector[0] = c * east + s * north;
  vector[1] = c * north - s * east;
}

neph_cloud_desc np_repeat_round(const neph_cloud_desc *desc) {
  neph_cloud_desc rounded = *desc;
  const double leaf_m = NP_LEAF_EDGE * desc->voxel_m;
  if (desc->repeat_m > 0)
    rounded.voxel_m = desc->extent_m[0] / (NP_LEAF_EDGE * np_repeat_count(desc->extent_m[0], leaf_m));
  if (!is_turned(desc)) return rounded;
  turn(desc->wind_m_s, rounded.skew_m);
  rounded.wind_m_s[0] = get_speed(desc->wind_m_s);
  rounded.wind_m_s[1] = 0;
  return rounded;
}

double np_repeat_get_turn(const neph_cloud_desc *desc) {
  return is_turned(desc) ? atan2(desc->wind_m_s[1], desc->wind_m_s[0]) : 0.0;
}
