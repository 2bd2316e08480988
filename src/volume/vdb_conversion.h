/* SPDX-License-Identifier: Apache-2.0 */
/* Conversion of other grid types and lattices to grids of floats. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_CONVERSION_H
#define NP_VOLUME_VDB_CONVERSION_H

#include <algorithm>
#include <string>

#include <openvdb/openvdb.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/LevelSetUtil.h>

#include "volume/vdb_streams.h"

namespace np_vdb {

template <typename GridType> bool is_grid(const openvdb::GridBase &grid) { return grid.isType<GridType>(); }

/* A copy of a grid with float values; null for a grid of another type. */
template <typename GridType> openvdb::FloatGrid::Ptr convert_if(const openvdb::GridBase &grid) {
  if (!is_grid<GridType>(grid)) return nullptr;
  return openvdb::FloatGrid::Ptr(new openvdb::FloatGrid(static_cast<const GridType &>(grid)));
}

/* A mask stores active states alone; they are its values. */
inline openvdb::FloatGrid::Ptr convert_mask(const openvdb::GridBase &grid) {
  if (!is_grid<openvdb::MaskGrid>(grid)) return nullptr;
  const auto &marks = static_cast<const openvdb::MaskGrid &>(grid).tree();
  openvdb::FloatTree::Ptr tree(new openvdb::FloatTree(marks, 0.0f, 1.0f, openvdb::TopologyCopy()));
  openvdb::FloatGrid::Ptr out = openvdb::FloatGrid::create(tree);
  out->setTransform(grid.transform().copy());
  return out;
}

inline openvdb::FloatGrid::Ptr convert_to_floats(const openvdb::GridBase::Ptr &grid) {
  if (is_grid<openvdb::FloatGrid>(*grid)) return openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
  openvdb::FloatGrid::Ptr out = convert_mask(*grid);
  if (!out) out = convert_if<openvdb::DoubleGrid>(*grid);
  if (!out) out = convert_if<openvdb::Int32Grid>(*grid);
  if (!out) out = convert_if<openvdb::Int64Grid>(*grid);
  if (!out) out = convert_if<openvdb::BoolGrid>(*grid);
  if (!out)
    throw Failure{NEPH_ERROR_INVALID_ARGUMENT, "a grid of type " + grid->valueType() + ", must hold numbers or marks"};
  return out;
}

/* Converts distances to a density that rises from 0 at the surface to 1 at a depth, at most the depth of the narrow
 * band. Returns the depth. OpenVDB's own conversion keeps rising below it if the band is wider. */
inline double convert_distances(openvdb::FloatGrid &grid, double depth_voxels) {
  const double voxel = grid.voxelSize()[0], band_voxels = static_cast<double>(grid.background()) / voxel;
  openvdb::tools::sdfToFogVolume(grid, static_cast<float>(depth_voxels * voxel));
  for (auto value = grid.beginValueOn(); value; ++value)
    if (*value > 1.0f) value.setValue(1.0f);
  return std::min(depth_voxels, band_voxels);
}

/* Limits the memory of resampling, which fills the space between active voxels. */
inline void check_room_for(const openvdb::FloatGrid &grid, const openvdb::math::Transform &lattice, double byte_max,
                           const std::string &name) {
  const openvdb::BBoxd box = lattice.worldToIndex(
      grid.transform().indexToWorld(grid.evalActiveVoxelBoundingBox())); /* box around the corners */
  const double bytes = (box.extents() + openvdb::Vec3d(1.0)).product() * sizeof(float);
  if (!(bytes <= byte_max))
    throw Failure{NEPH_ERROR_UNSUPPORTED, "grid '" + name + "' would have too many voxels in the lattice that it is " +
                                              "resampled to: resample it before"};
}

inline openvdb::FloatGrid::Ptr resample(const openvdb::FloatGrid::Ptr &grid,
                                        const openvdb::math::Transform::Ptr &lattice, double byte_max,
                                        const std::string &name) {
  if (grid->empty()) return grid;
  check_room_for(*grid, *lattice, byte_max, name);
  openvdb::FloatGrid::Ptr out = openvdb::FloatGrid::create(grid->background());
  out->setTransform(lattice);
  openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(*grid, *out);
  return out;
}

} /* namespace np_vdb */

#endif
