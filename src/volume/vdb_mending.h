/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB's own checks of fog volumes, and repair of invalid values. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_MENDING_H
#define NP_VOLUME_VDB_MENDING_H

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Diagnostics.h>

#include "volume/vdb_conversion.h"

namespace np_vdb {

/* ---- Checks ---- */

/* Runs all checks but the class check: the description of the grid states its class. */
template <typename GridType, typename Visit> void diagnose_if(openvdb::GridBase &grid, const Visit &visit) {
  if (!is_grid<GridType>(grid)) return;
  openvdb::tools::CheckFogVolume<GridType> check(static_cast<GridType &>(grid));
  for (const std::string &text :
       {check.checkBackground(), check.checkFinite(), check.checkInactiveValues(), check.checkRange()})
    if (!text.empty()) visit(text);
}

/* ---- Mending ---- */

constexpr double half_max = 65504.0;

inline bool is_good(float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits == 0 || (bits >= 0x00800000u && bits < 0x7f800000u);
}

/* Whether a value is valid in a cloud. Positive doubles that underflow or overflow in float are not. */
inline bool is_good(double value) { return value == 0.0 || (value > 0.0 && is_good(static_cast<float>(value))); }

inline bool is_good(int32_t value) { return value >= 0; }

inline bool is_good(int64_t value) { return value >= 0; }

/* Largest valid value; 0 if there is none. */
template <typename TreeType> typename TreeType::ValueType get_good_max(const TreeType &tree) {
  typename TreeType::ValueType largest = 0;
  for (auto value = tree.cbeginValueAll(); value; ++value)
    if (is_good(*value)) largest = std::max(largest, *value);
  return largest;
}

/* Whether a value overflows: infinity, or a double above the range of float. */
template <typename Number> bool is_above_all(Number value) {
  return static_cast<double>(value) > static_cast<double>(std::numeric_limits<float>::max());
}

/* Replaces active values that overflow by the largest valid value, other invalid values by 0, and returns the number of
 * replaced values. */
template <typename TreeType> uint64_t mend_values(TreeType &tree, bool &is_beyond_half) {
  const typename TreeType::ValueType largest = get_good_max(tree);
  uint64_t count = 0;
  for (auto value = tree.beginValueAll(); value; ++value) {
    if (is_good(*value)) continue;
    value.setValue(is_above_all(*value) && value.isValueOn() ? largest : 0);
    count++;
  }
  is_beyond_half = static_cast<double>(largest) > half_max;
  return count;
}

/* NaN is not equal to itself, and changeBackground compares values. */
template <typename TreeType> bool mend_background(TreeType &tree) {
  if (tree.background() == 0) return false;
  if (tree.background() == tree.background())
    openvdb::tools::changeBackground(tree, 0);
  else
    tree.root().setBackground(0, /*updateChildNodes=*/true);
  return true;
}

template <typename GridType> void mend_if(openvdb::GridBase &grid, np_vdb_mending &mending) {
  const bool is_density = mending.mark == NP_VDB_MEND_DENSITY;
  bool is_beyond_half = false;
  if ((!is_density && mending.mark != NP_VDB_MEND_VALUES) || !is_grid<GridType>(grid)) return;
  auto &tree = static_cast<GridType &>(grid).tree();
  if (is_density) mending.has_new_background = mend_background(tree);
  mending.value_count = mend_values(tree, is_beyond_half);
  if (is_beyond_half) grid.setSaveFloatAsHalf(false);
  if (!is_density) return;
  mending.has_new_class = grid.getGridClass() != openvdb::GRID_FOG_VOLUME;
  grid.setGridClass(openvdb::GRID_FOG_VOLUME);
}

template <typename Number> bool make_finite(Number &value) {
  if (std::isfinite(value)) return false;
  value = 0;
  return true;
}

template <typename Number> bool make_finite(openvdb::math::Vec3<Number> &value) {
  const bool are_mended[3] = {make_finite(value[0]), make_finite(value[1]), make_finite(value[2])};
  return are_mended[0] || are_mended[1] || are_mended[2];
}

/* Sets NaN and infinity of a vector, or of a component, to 0. */
template <typename GridType> void make_finite_if(openvdb::GridBase &grid, np_vdb_mending &mending) {
  if (mending.mark != NP_VDB_MAKE_FINITE || !is_grid<GridType>(grid)) return;
  auto &tree = static_cast<GridType &>(grid).tree();
  for (auto value = tree.beginValueAll(); value; ++value) {
    typename GridType::ValueType number = *value;
    if (!make_finite(number)) continue;
    value.setValue(number);
    mending.value_count++;
  }
}

} /* namespace np_vdb */

#endif
