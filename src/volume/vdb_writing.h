/* SPDX-License-Identifier: Apache-2.0 */
/* Converts sparse grids to OpenVDB grids, and writes them to a file. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_WRITING_H
#define NP_VOLUME_VDB_WRITING_H

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

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

/* Adds leaves with the topology of those of `source`; `fill` sets the values of one by its number. They are built on
 * all threads. */
template <typename TreeType, typename Fill>
void add_leaves(TreeType &tree, const np_sparse_grid &source, const Canceller &canceller, const Fill &fill) {
  using LeafType = typename TreeType::LeafNodeType;
  std::vector<std::unique_ptr<LeafType>> leaves(source.leaf_count);
  run_pieces(source.leaf_count, piece_leaves, [&](std::size_t begin, std::size_t end) {
    canceller.poll();
    for (std::size_t i = begin; i < end; i++) {
      const np_leaf &from = source.leaves[i];
      leaves[i] = std::make_unique<LeafType>(openvdb::Coord(from.origin), tree.background(), false);
      fill(i, leaves[i]->buffer().data());
      openvdb::util::NodeMask<3> mask;
      for (openvdb::Index word = 0; word < 8; word++) mask.getWord<openvdb::Index64>(word) = from.active[word];
      leaves[i]->setValueMask(mask);
    }
  });
  for (std::unique_ptr<LeafType> &leaf : leaves) tree.addLeaf(leaf.release());
}

/* Copies tiles and leaves to an empty grid. */
inline void fill_scalar(const np_sparse_grid &source, const Canceller &canceller, openvdb::FloatGrid &grid) {
  for (size_t i = 0; i < source.tile_count; i++) {
    const np_tile &tile = source.tiles[i];
    grid.tree().addTile(get_tile_level(tile.edge), openvdb::Coord(tile.origin), tile.value, tile.is_active);
  }
  add_leaves(grid.tree(), source, canceller, [&](std::size_t i, float *to) {
    std::copy(source.leaves[i].values, source.leaves[i].values + NP_LEAF_SIZE, to);
  });
}

inline void fill_velocity(const np_vdb_write_grid &output, const Canceller &canceller, openvdb::Vec3SGrid &grid) {
  const np_sparse_grid &x = *output.grid, &y = *output.y, &z = *output.z;
  for (size_t i = 0; i < x.tile_count; i++)
    grid.tree().addTile(get_tile_level(x.tiles[i].edge), openvdb::Coord(x.tiles[i].origin),
                        openvdb::Vec3s(x.tiles[i].value, y.tiles[i].value, z.tiles[i].value), x.tiles[i].is_active);
  add_leaves(grid.tree(), x, canceller, [&](std::size_t i, openvdb::Vec3s *to) {
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      to[n] = openvdb::Vec3s(x.leaves[i].values[n], y.leaves[i].values[n], z.leaves[i].values[n]);
  });
}

/* A grid whose leaves are compressed on all threads, to the bytes that OpenVDB writes on one. */
template <typename GridType> class WrittenGrid : public GridType {
public:
  using GridType::GridType;

  void writeBuffers(std::ostream &stream) const override {
    std::vector<const LeafType *> leaves;
    leaves.reserve(this->tree().leafCount());
    for (auto leaf = this->tree().cbeginLeaf(); leaf; ++leaf) leaves.push_back(leaf.getLeaf());
    for (std::size_t begin = 0; begin < leaves.size(); begin += batch_leaves)
      write_batch(stream, leaves, begin, std::min(begin + batch_leaves, leaves.size()));
  }

private:
  using LeafType = typename GridType::TreeType::LeafNodeType;

  static constexpr std::size_t batch_leaves = 128 * piece_leaves; /* 64 MB of floats */

  void write_batch(std::ostream &stream, const std::vector<const LeafType *> &leaves, std::size_t first,
                   std::size_t last) const {
    std::vector<std::string> texts((last - first + piece_leaves - 1) / piece_leaves);
    run_pieces(texts.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t piece = begin; piece < end; piece++) {
        std::ostringstream text;
        text.copyfmt(stream); /* version, compression and exceptions */
        const std::size_t from = first + piece * piece_leaves;
        for (std::size_t n = from; n < std::min(from + piece_leaves, last); n++)
          leaves[n]->writeBuffers(text, this->saveFloatAsHalf());
        texts[piece] = text.str();
      }
    });
    for (const std::string &text : texts) stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  }
};

/* World-space velocity at the centres of voxels (covariant): it rotates with the grid. */
inline openvdb::GridBase::Ptr make_velocity(const np_vdb_write_grid &output) {
  const openvdb::Vec3s background(output.grid->background, output.y->background, output.z->background);
  const auto grid = std::make_shared<WrittenGrid<openvdb::Vec3SGrid>>(background);
  grid->setGridClass(openvdb::GRID_UNKNOWN); /* also means: not staggered */
  grid->setVectorType(output.is_invariant ? openvdb::VEC_INVARIANT : openvdb::VEC_CONTRAVARIANT_RELATIVE);
  grid->setIsInWorldSpace(true);
  return grid;
}

inline openvdb::GridBase::Ptr make_fog(const np_sparse_grid &source) {
  const auto grid = std::make_shared<WrittenGrid<openvdb::FloatGrid>>(source.background);
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
