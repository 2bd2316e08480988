/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB's own checks of fog volumes, and values made those of one. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_MENDING_H
#define NP_VOLUME_VDB_MENDING_H

#include <cstring>
#include <string>

#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Diagnostics.h>

#include "volume/vdb_conversion.h"

namespace np_vdb {

/* ---- Checks ---- */

/* All but the class, which stands in the grid's description. */
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

/* Positive doubles that floats cannot tell from 0, or hold, are none of a cloud's. */
inline bool is_good(double value) { return value == 0.0 || (value > 0.0 && is_good(static_cast<float>(value))); }

/* Makes what a cloud cannot hold 0. Returns whether a value is beyond halves. */
template <typename TreeType> bool mend_values(TreeType &tree) {
  bool is_beyond_half = false;
  for (auto value = tree.beginValueAll(); value; ++value) {
    if (!is_good(*value)) value.setValue(0);
    is_beyond_half = is_beyond_half || static_cast<double>(*value) > half_max;
  }
  return is_beyond_half;
}

/* NaN is not equal to itself, which changing the background would need. */
template <typename TreeType> void mend_background(TreeType &tree) {
  if (tree.background() == tree.background())
    openvdb::tools::changeBackground(tree, 0);
  else
    tree.root().setBackground(0, /*updateChildNodes=*/true);
}

template <typename GridType> void mend_if(openvdb::GridBase &grid, np_vdb_mark mark) {
  if (mark == NP_VDB_KEEP || !is_grid<GridType>(grid)) return;
  auto &tree = static_cast<GridType &>(grid).tree();
  if (mark == NP_VDB_MEND_DENSITY) mend_background(tree);
  if (mend_values(tree)) grid.setSaveFloatAsHalf(false);
  if (mark == NP_VDB_MEND_DENSITY) grid.setGridClass(openvdb::GRID_FOG_VOLUME);
}

} /* namespace np_vdb */

#endif
