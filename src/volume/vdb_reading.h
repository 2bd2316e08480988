/* SPDX-License-Identifier: Apache-2.0 */
/* Reads trees into leaves and tiles of a sparse grid. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_READING_H
#define NP_VOLUME_VDB_READING_H

#include <algorithm>
#include <cstring>
#include <numeric>
#include <type_traits>
#include <vector>

#include <openvdb/io/Compression.h>
#include <openvdb/tools/Composite.h>

#include "volume/vdb_archive.h"
#include "volume/vdb_failure.h"

namespace np_vdb {

/* ---- Trees ---- */

enum class Part { topology, tree };

/* Reads a grid with voxels of its own (not an instance) by OpenVDB alone. */
inline openvdb::GridBase::Ptr read_unchecked(np_vdb_file &file, const Entry &entry, Part part) {
  const np_vdb_grid_place &place = file.source.places[entry.index];
  file.stream.clear();
  const openvdb::GridBase::Ptr grid = own(openvdb::GridBase::createGrid(entry.descriptor.gridType()));
  file.buffer.wait_until(place.buffers);
  if (part == Part::tree) {
    file.stream.seekg(place.begin);
    Archive::readGrid(grid, entry.descriptor, file.stream);
  } else {
    read_header(file, place, *grid);
    grid->readTopology(file.stream);
  }
  return grid;
}

inline openvdb::GridBase::Ptr read_tree(np_vdb_file &file, const Entry &instance, Part part) {
  if (instance.owner == no_owner)
    throw Failure{NEPH_ERROR_BAD_FILE,
                  "grid '" + instance.name + "' shares the voxels of a grid that is missing or of another type"};
  const Entry &entry = file.entries[instance.owner];
  check_result(file.source.check_tree(file.source.user, entry.index, entry.header->saveFloatAsHalf()));
  return read_unchecked(file, entry, part);
}

template <typename Number> float get_component(const Number &value, int) { return static_cast<float>(value); }

template <typename Number> float get_component(const openvdb::math::Vec3<Number> &value, int component) {
  return static_cast<float>(value[component]);
}

/* Origin and active voxels of a leaf. */
template <typename LeafType> void fill_topology(const LeafType &leaf, np_leaf &out) {
  static_assert(LeafType::SIZE == NP_LEAF_SIZE, "leaves of 8³ voxels in the same order");
  std::memcpy(out.origin, leaf.origin().data(), sizeof out.origin);
  for (openvdb::Index word = 0; word < 8; word++)
    out.active[word] = leaf.getValueMask().template getWord<openvdb::Index64>(word);
}

template <typename LeafType> void copy_leaf(const LeafType &leaf, int component, const np_vdb_sink &sink) {
  const auto *values = leaf.buffer().data();
  np_leaf *const out = sink.add_leaf(sink.grid, leaf.origin().data());
  check_room(out);
  fill_topology(leaf, *out);
  for (int n = 0; n < NP_LEAF_SIZE; n++) out->values[n] = get_component(values[n], component);
}

inline bool is_same(float a, float b) { return a == b || (a != a && b != b); }

/* Copies the background, and the tiles that differ from it. */
template <typename TreeType>
inline void copy_tiles(const TreeType &tree, int component, const np_vdb_sink &sink, const Canceller &canceller) {
  sink.grid->background = get_component(tree.background(), component);
  auto value = tree.cbeginValueAll();
  value.setMaxDepth(TreeType::ValueAllCIter::LEAF_DEPTH - 1);
  for (; value; ++value) {
    const float number = get_component(*value, component);
    if (!value.isValueOn() && is_same(number, sink.grid->background)) continue;
    canceller.poll();
    const openvdb::CoordBBox box = value.getBoundingBox();
    check_room(sink.add_tile(sink.grid, box.min().data(), box.dim().x(), number, value.isValueOn()));
  }
}

inline void copy_tree(const openvdb::FloatTree &tree, const np_vdb_sink &sink, const Canceller &canceller) {
  check_result(sink.reserve(sink.grid, tree.leafCount(), 0));
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    canceller.poll();
    copy_leaf(*leaf, 0, sink);
  }
  copy_tiles(tree, 0, sink, canceller);
}

/* Values go straight from the file to the sparse grid: the leaves of the tree hold none. */
template <typename LeafType>
inline void read_leaf(std::istream &stream, const LeafType &leaf, bool is_half, int component, float *out) {
  using Number = typename LeafType::ValueType;
  leaf.getValueMask().seek(stream); /* the topology has set it already */
  if constexpr (std::is_same_v<Number, float>) {
    openvdb::io::readCompressedValues(stream, out, NP_LEAF_SIZE, leaf.getValueMask(), is_half);
  } else {
    Number values[NP_LEAF_SIZE];
    openvdb::io::readCompressedValues(stream, values, NP_LEAF_SIZE, leaf.getValueMask(), is_half);
    for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_component(values[n], component);
  }
}

/* Place of each leaf among all, sorted by origin as a sparse grid has them. */
template <typename LeafType> inline std::vector<std::size_t> sort_leaves(const std::vector<const LeafType *> &leaves) {
  std::vector<std::size_t> order(leaves.size()), places(leaves.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return leaves[a]->origin() < leaves[b]->origin(); });
  for (std::size_t n = 0; n < order.size(); n++) places[order[n]] = n;
  return places;
}

/* Reads the buffers of a tree on all threads, straight to their sorted places: each piece of leaves is a stretch of the
 * file, and a stream of its own. */
template <typename TreeType>
inline void read_buffers(np_vdb_file &file, const np_vdb_grid_place &place, const TreeType &tree, bool is_half,
                         int component, const np_vdb_sink &sink) {
  std::vector<const typename TreeType::LeafNodeType *> leaves;
  leaves.reserve(tree.leafCount());
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) leaves.push_back(leaf.getLeaf());
  if (leaves.size() != place.leaf_count)
    throw Failure{NEPH_ERROR_BAD_FILE, "the tree has another number of leaves than its topology: it is damaged"};
  const std::vector<std::size_t> places = sort_leaves(leaves);
  np_leaf *const out = leaves.empty() ? nullptr : sink.add_leaves(sink.grid, leaves.size());
  if (!leaves.empty()) check_room(out);
  run_pieces(leaves.size(), piece_leaves, [&](std::size_t begin, std::size_t end) {
    file.canceller.poll();
    std::vector<char> bytes(static_cast<std::size_t>(place.leaves[end] - place.leaves[begin]));
    check_result(file.source.read_apart(file.source.user, place.leaves[begin], bytes.data(), bytes.size()));
    MemoryBuffer buffer(bytes.data(), bytes.size());
    std::istream stream(&buffer);
    stream.copyfmt(file.stream); /* version, compression and exceptions */
    for (std::size_t n = begin; n < end; n++) {
      np_leaf &leaf = out[places[n]];
      fill_topology(*leaves[n], leaf);
      read_leaf(stream, *leaves[n], is_half, component, leaf.values);
    }
  });
}

template <typename GridType>
inline void read_if(np_vdb_file &file, const np_vdb_grid_place &place, const openvdb::GridBase::Ptr &grid,
                    int component, const np_vdb_sink &sink) {
  if (!is_grid<GridType>(*grid)) return;
  const auto &tree = openvdb::gridPtrCast<GridType>(grid)->tree();
  read_buffers(file, place, tree, grid->saveFloatAsHalf(), component, sink);
  copy_tiles(tree, component, sink, file.canceller);
}

inline void check_type(const Entry &entry) {
  if (!entry.is_scalar && !entry.is_count && !entry.is_vector)
    throw Failure{NEPH_ERROR_INVALID_ARGUMENT,
                  "grid '" + entry.name + "' is of type " + entry.value_type + ", neither a scalar nor a vector"};
}

/* ---- Densities ---- */

/* A grid that is a density, or a part of one. */
struct Addend {
  std::string name;
  bool is_affine, is_level_set; /* is_level_set: the class says so */
  openvdb::FloatGrid::Ptr grid;
};

/* Sums need one lattice: affine grids are resampled to the lattice of the first, frustums must share it. */
inline openvdb::FloatGrid::Ptr match_lattice(const Addend &addend, const Addend &first, double byte_max) {
  if (addend.grid->transform() == first.grid->transform()) return addend.grid;
  if (!addend.is_affine || !first.is_affine)
    throw Failure{NEPH_ERROR_UNSUPPORTED, "grids '" + first.name + "' and '" + addend.name +
                                              "' are not of one frustum, as grids of a sum must be: export both with " +
                                              "one transform, or make each a cloud of its own"};
  return resample(addend.grid, first.grid->transform().copy(), byte_max, addend.name);
}

/* A sum of densities, in the grid of the first. */
class Sum {
public:
  Sum(double level_set_voxels, np_sparse_grid &out)
      : level_set_voxels_(level_set_voxels), byte_max_(static_cast<double>(out.brick_bytes_max)), out_(out) {}

  void add(const Addend &addend) {
    convert(addend);
    if (first_.grid)
      openvdb::tools::compSum(*first_.grid, *match_lattice(addend, first_, byte_max_));
    else
      first_ = addend;
  }

  void copy_to(const np_vdb_sink &sink, const Canceller &canceller, uint64_t *out_tree_bytes) const {
    const openvdb::FloatGrid &grid = *first_.grid;
    if (grid.transform().isLinear()) get_affine(grid, sink.grid->index_to_world.m);
    copy_tree(grid.tree(), sink, canceller);
    *out_tree_bytes = grid.memUsage();
  }

private:
  /* Converts a level set, found by its class or by a background of the band's width, to a density, which is 0
   * outside. */
  void convert(const Addend &addend) {
    if (level_set_voxels_ > 0.0 && (addend.is_level_set || addend.grid->background() > 0.0f))
      out_.level_set_voxels = convert_distances(*addend.grid, level_set_voxels_);
  }

  const double level_set_voxels_, byte_max_;
  np_sparse_grid &out_;
  Addend first_{};
};

/* A grid of a file, with the transform of its own that an instance has. */
inline Addend read_addend(np_vdb_file &file, const Entry &entry) {
  const openvdb::FloatGrid::Ptr grid = convert_to_floats(read_tree(file, entry, Part::tree));
  grid->setTransform(entry.header->transform().copy());
  return {entry.name, entry.is_affine, entry.header->getGridClass() == openvdb::GRID_LEVEL_SET, grid};
}

/* Whether a grid is stored as a density, without any conversion. */
inline bool is_plain(const np_vdb_file &file, const np_vdb_request &request) {
  const Entry &first = file.entries[request.indices[0]];
  return request.count == 1 && first.is_scalar && !(request.level_set_voxels > 0.0) &&
         first.header->getGridClass() != openvdb::GRID_LEVEL_SET;
}

inline void read_converted(np_vdb_file &file, const np_vdb_request &request, const np_vdb_sink &sink,
                           uint64_t *out_tree_bytes) {
  Sum sum(request.level_set_voxels, *sink.grid);
  for (std::size_t i = 0; i < request.count; i++) sum.add(read_addend(file, file.entries[request.indices[i]]));
  sum.copy_to(sink, file.canceller, out_tree_bytes);
}

inline void read_plain(np_vdb_file &file, const np_vdb_request &request, const np_vdb_sink &sink,
                       uint64_t *out_tree_bytes) {
  const Entry &entry = file.entries[request.indices[0]];
  const openvdb::GridBase::Ptr grid = read_tree(file, entry, Part::topology);
  if (entry.is_affine) std::memcpy(sink.grid->index_to_world.m, entry.index_to_world, sizeof entry.index_to_world);
  const np_vdb_grid_place &place = file.source.places[entry.owner];
  read_if<openvdb::FloatGrid>(file, place, grid, request.component, sink);
  read_if<openvdb::DoubleGrid>(file, place, grid, request.component, sink);
  read_if<openvdb::Vec3SGrid>(file, place, grid, request.component, sink);
  read_if<openvdb::Vec3DGrid>(file, place, grid, request.component, sink);
  *out_tree_bytes = grid->memUsage();
}

} /* namespace np_vdb */

#endif
