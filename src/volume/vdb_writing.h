/* SPDX-License-Identifier: Apache-2.0 */
/* Converts sparse grids to OpenVDB grids, and writes them to a file. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_WRITING_H
#define NP_VOLUME_VDB_WRITING_H

#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <ostream>
#include <string>

#include "volume/vdb_archive.h"

namespace np_vdb {

/* ---- Grids ---- */

inline openvdb::math::Transform::Ptr make_transform(const np_affine &affine) {
  openvdb::Mat4R matrix = openvdb::Mat4R::identity();
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) matrix[column][row] = affine.m[row][column];
  const openvdb::math::AffineMap::Ptr map(new openvdb::math::AffineMap(matrix));
  return openvdb::math::Transform::Ptr(new openvdb::math::Transform(openvdb::math::simplify(map)));
}

inline openvdb::Index get_tile_level(int32_t edge) { return edge == 8 ? 1u : edge == 128 ? 2u : 3u; }

/* Adds a leaf with the topology of `from`; `fill` sets its values. */
template <typename TreeType, typename Fill> void add_leaf(TreeType &tree, const np_leaf &from, const Fill &fill) {
  auto leaf = std::make_unique<typename TreeType::LeafNodeType>(openvdb::Coord(from.origin), tree.background(), false);
  fill(leaf->buffer().data());
  openvdb::util::NodeMask<3> mask;
  for (openvdb::Index word = 0; word < 8; word++) mask.getWord<openvdb::Index64>(word) = from.active[word];
  leaf->setValueMask(mask);
  tree.addLeaf(leaf.release());
}

/* Copies tiles and leaves to an empty grid. */
inline void fill_scalar(const np_sparse_grid &source, const Canceller &canceller, openvdb::FloatGrid &grid) {
  for (size_t i = 0; i < source.tile_count; i++) {
    const np_tile &tile = source.tiles[i];
    grid.tree().addTile(get_tile_level(tile.edge), openvdb::Coord(tile.origin), tile.value, tile.is_active);
  }
  for (size_t i = 0; i < source.leaf_count; i++) {
    canceller.poll();
    const np_leaf &from = source.leaves[i];
    add_leaf(grid.tree(), from, [&](float *to) { std::copy(from.values, from.values + NP_LEAF_SIZE, to); });
  }
}

inline void fill_velocity(const np_vdb_write_grid &output, const Canceller &canceller, openvdb::Vec3SGrid &grid) {
  const np_sparse_grid &x = *output.grid, &y = *output.y, &z = *output.z;
  for (size_t i = 0; i < x.tile_count; i++)
    grid.tree().addTile(get_tile_level(x.tiles[i].edge), openvdb::Coord(x.tiles[i].origin),
                        openvdb::Vec3s(x.tiles[i].value, y.tiles[i].value, z.tiles[i].value), x.tiles[i].is_active);
  for (size_t i = 0; i < x.leaf_count; i++) {
    canceller.poll();
    add_leaf(grid.tree(), x.leaves[i], [&](openvdb::Vec3s *to) {
      for (int n = 0; n < NP_LEAF_SIZE; n++)
        to[n] = openvdb::Vec3s(x.leaves[i].values[n], y.leaves[i].values[n], z.leaves[i].values[n]);
    });
  }
}

/* World-space velocity at the centres of voxels (covariant): it rotates with the grid. */
inline openvdb::GridBase::Ptr make_velocity(const np_vdb_write_grid &output) {
  auto grid =
      openvdb::Vec3SGrid::create(openvdb::Vec3s(output.grid->background, output.y->background, output.z->background));
  grid->setGridClass(openvdb::GRID_UNKNOWN); /* also means: not staggered */
  grid->setVectorType(output.is_invariant ? openvdb::VEC_INVARIANT : openvdb::VEC_CONTRAVARIANT_RELATIVE);
  grid->setIsInWorldSpace(true);
  return grid;
}

inline openvdb::GridBase::Ptr make_fog(const np_sparse_grid &source) {
  auto grid = openvdb::FloatGrid::create(source.background);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

/* A grid without its voxels. */
inline openvdb::GridBase::Ptr make_output(const np_vdb_write_grid &output) {
  const openvdb::GridBase::Ptr grid = own(output.y ? make_velocity(output) : make_fog(*output.grid));
  grid->setTransform(make_transform(output.grid->index_to_world));
  grid->setName(output.grid->name);
  grid->setSaveFloatAsHalf(output.is_half);
  if (output.grid_class) grid->setGridClass(openvdb::GridBase::stringToGridClass(output.grid_class));
  for (size_t i = 0; i < output.attribute_count; i++) {
    const np_vdb_attribute &attribute = output.attributes[i];
    if (attribute.text)
      grid->insertMeta(attribute.name, openvdb::StringMetadata(attribute.text));
    else
      grid->insertMeta(attribute.name, openvdb::DoubleMetadata(attribute.number));
  }
  return grid;
}

inline void fill_output(const np_vdb_write_grid &output, const Canceller &canceller, openvdb::GridBase &grid) {
  if (output.y)
    fill_velocity(output, canceller, static_cast<openvdb::Vec3SGrid &>(grid));
  else
    fill_scalar(*output.grid, canceller, static_cast<openvdb::FloatGrid &>(grid));
}

/* Blosc crashes on a failed allocation; it allocates about 100 kB. */
constexpr std::size_t compression_room_bytes = std::size_t(8) << 20;

/* Throws if that much memory is not available. */
inline void check_compression_room(void) { ::operator delete(::operator new(compression_room_bytes)); }

/* Writes a file by `put`, given its stream. */
template <typename Put> void write_file(const char *path, const Canceller &canceller, const Put &put) {
  errno = 0;
  PolledFile buffer(canceller);
  std::ostream stream(&buffer);
  stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
  if (!buffer.open(path, std::ios_base::out | std::ios_base::binary | std::ios_base::trunc))
    throw Failure{NEPH_ERROR_IO, std::string("cannot write: ") + std::strerror(errno)};
  put(stream);
  stream.flush();
  if (!buffer.close()) throw Failure{NEPH_ERROR_IO, std::string("cannot write: ") + std::strerror(errno)};
}

inline void write_stream(const char *path, const openvdb::GridCPtrVec &outputs, const openvdb::MetaMap &metadata,
                         const Canceller &canceller) {
  write_file(path, canceller, [&](std::ostream &stream) {
    check_compression_room();
    Archive().write(stream, outputs, /*seekable=*/true, metadata);
  });
}

} /* namespace np_vdb */

#endif
