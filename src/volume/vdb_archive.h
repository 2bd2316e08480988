/* SPDX-License-Identifier: Apache-2.0 */
/* An open file and its grids, read up to their transforms; destroying them allocates no memory. Part of vdb_shim.cpp.
 */
#ifndef NP_VOLUME_VDB_ARCHIVE_H
#define NP_VOLUME_VDB_ARCHIVE_H

#include <istream>
#include <memory>
#include <string>
#include <vector>

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include "volume/vdb_conversion.h"
#include "volume/vdb_streams.h"

namespace np_vdb {

/* ---- Grids ---- */

/* Node list for OpenVDB to fill; each node is deleted. */
template <typename NodeType> struct NodeDeleter {
  using value_type = NodeType *;
  void push_back(NodeType *node) { delete node; }
};

/* Deletes all voxels of a grid. OpenVDB's destructor first allocates a list of them, and ends the process if out of
 * memory. */
template <typename GridType> void delete_tree(GridType &grid) noexcept {
  NodeDeleter<typename GridType::TreeType::RootNodeType::ChildNodeType> deleter;
  grid.tree().stealNodes(deleter);
}

/* Wraps a grid so that its destruction allocates nothing. The type is compared here, because the comparison allocates.
 */
inline openvdb::GridBase::Ptr own(const openvdb::GridBase::Ptr &grid) {
  openvdb::GridBase::Ptr owned;
  grid->apply<openvdb::GridTypes>(
      [&](auto &typed) { owned.reset(&typed, [grid, &typed](openvdb::GridBase *) { delete_tree(typed); }); });
  return owned ? owned : grid;
}

/* ---- Files ---- */

/* Gives access to the protected parts of OpenVDB's archive, the base of its File and its Stream: neither can read a
 * single grid from a caller's buffer. */
class Archive : public openvdb::io::Archive {
public:
  using openvdb::io::Archive::readGrid;
  using openvdb::io::Archive::readGridCompression;
  using openvdb::io::Archive::write;
};

constexpr std::size_t no_owner = static_cast<std::size_t>(-1);

struct Entry {
  std::size_t index;
  openvdb::io::GridDescriptor descriptor;
  openvdb::GridBase::Ptr header; /* metadata and transform */
  std::string name, value_type, grid_class, creator;
  bool is_scalar, is_count, is_vector, is_affine;
  double index_to_world[3][4]; /* valid if it is affine */
  np_frustum frustum{};
  std::size_t owner; /* index of the grid that stores the voxels; for an instance another grid */
};

} /* namespace np_vdb */

struct np_vdb_file {
  np_vdb_file(const np_vdb_source &source_, unsigned thread_count_, np_vdb::Canceller canceller_)
      : source(source_), thread_count(thread_count_), canceller(canceller_), buffer(source_, canceller_),
        stream(&buffer) {}

  const np_vdb_source &source;
  const unsigned thread_count; /* threads that read trees */
  const np_vdb::Canceller canceller;
  np_vdb::SourceBuffer buffer;
  openvdb::io::StreamMetadata::Ptr metadata{
      new openvdb::io::StreamMetadata}; /* the stream keeps the address of this pointer */
  std::istream stream;
  std::vector<np_vdb::Entry> entries;
};

namespace np_vdb {

/* ---- Headers ---- */

/* Reads metadata and transform. They must end at the position that the source states: otherwise OpenVDB would read
 * unchecked bytes. */
inline void read_header(np_vdb_file &file, const np_vdb_grid_place &place, openvdb::GridBase &grid) {
  file.stream.seekg(place.begin);
  Archive::readGridCompression(file.stream);
  grid.readMeta(file.stream);
  grid.readTransform(file.stream);
  if (file.stream.tellg() != std::streampos(place.topology))
    throw Failure{NEPH_ERROR_BAD_FILE,
                  "grid '" + grid.getName() + "' has metadata that OpenVDB reads differently: it is damaged"};
}

/* Whether the transform is affine, and its matrix: OpenVDB multiplies row vectors from the left, ours is the transpose.
 */
inline bool get_affine(const openvdb::GridBase &grid, double out[3][4]) {
  if (!grid.transform().isLinear()) return false;
  try {
    const openvdb::Mat4R matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
    for (int row = 0; row < 3; row++)
      for (int column = 0; column < 4; column++) out[row][column] = matrix[column][row];
    return true;
  } catch (const openvdb::ArithmeticError &) { /* singular */
    return false;
  }
}

/* Map of a frustum; not enabled for other maps. */
inline np_frustum get_frustum(const openvdb::GridBase &grid) {
  np_frustum out{};
  const auto map = grid.transform().constMap<openvdb::math::NonlinearFrustumMap>();
  if (!map) return out;
  const openvdb::BBoxd &box = map->getBBox();
  const openvdb::Vec3d size = box.extents();
  const double middle[3] = {0.5 * size.x(), 0.5 * size.y(), 0.0};
  const openvdb::Mat4R matrix = map->secondMap().getMat4();
  for (int axis = 0; axis < 3; axis++) out.origin[axis] = box.min()[axis] + middle[axis];
  out.scale = 1.0 / size.x();
  out.growth = map->getGamma();
  out.step = map->getDepth() / size.z();
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) out.local_to_world.m[row][column] = matrix[column][row];
  out.is_enabled = true;
  return out;
}

} /* namespace np_vdb */

#endif
