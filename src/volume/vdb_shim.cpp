/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB behind C functions. Nothing throws out of here: every entry runs inside `guarded`.
 *
 * OpenVDB takes lengths from a file as they stand. So it reads through the caller's np_vdb_source, which has checked
 * the structure of what is about to be read, and on a stream that throws at the first byte that is missing. The caller,
 * not OpenVDB, reads the header of the file: OpenVDB would log to standard output what it thinks of its version.
 */
#include "volume/vdb_table.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <istream>
#include <memory>
#include <new>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/global_control.h>

#include "volume/vdb_conversion.h"
#include "volume/vdb_failure.h"
#include "volume/vdb_mending.h"
#include "volume/vdb_streams.h"

using namespace np_vdb;

namespace {

/* ---- Grids ---- */

/* A list of nodes for OpenVDB to fill, which deletes each. */
template <typename NodeType> struct NodeDeleter {
  using value_type = NodeType *;
  void push_back(NodeType *node) { delete node; }
};

/* Deletes all voxels of a grid. OpenVDB's own destructor allocates a list of them first, and ends the process where
 * there is no memory for it. */
template <typename GridType> void delete_tree(GridType &grid) noexcept {
  NodeDeleter<typename GridType::TreeType::RootNodeType::ChildNodeType> deleter;
  grid.tree().stealNodes(deleter);
}

/* A grid that can end without memory. Its type is compared here, because that allocates. */
openvdb::GridBase::Ptr own(const openvdb::GridBase::Ptr &grid) {
  openvdb::GridBase::Ptr owned;
  grid->apply<openvdb::GridTypes>(
      [&](auto &typed) { owned.reset(&typed, [grid, &typed](openvdb::GridBase *) { delete_tree(typed); }); });
  return owned ? owned : grid;
}

/* ---- Files ---- */

/* Opens the protected parts of OpenVDB's archive, which both its File and its Stream are made of: neither lets a caller
 * bring his own buffer and still read one grid alone. */
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
  double index_to_world[3][4]; /* where it is affine */
  std::size_t owner;           /* index of the grid that stores its voxels; itself, but for an instance */
};

} /* namespace */

struct np_vdb_file {
  np_vdb_file(const np_vdb_source &source_, Canceller canceller_)
      : source(source_), canceller(canceller_), buffer(source_, canceller_), stream(&buffer) {}

  const np_vdb_source &source;
  const Canceller canceller;
  SourceBuffer buffer;
  openvdb::io::StreamMetadata::Ptr metadata{
      new openvdb::io::StreamMetadata}; /* the stream points at this very pointer */
  std::istream stream;
  std::vector<Entry> entries;
};

namespace {

/* ---- Opening ---- */

neph_result try_chunk(uint32_t compression, const void *chunk, size_t chunk_bytes, size_t count) noexcept {
  np_vdb_error ignored;
  return guarded(&ignored, Direction::reading, [&] {
    MemoryBuffer buffer(chunk, chunk_bytes);
    std::istream stream(&buffer);
    stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
    std::vector<char> values(count);
    if (compression & openvdb::io::COMPRESS_BLOSC)
      openvdb::io::bloscFromStream(stream, values.data(), count);
    else
      openvdb::io::unzipFromStream(stream, values.data(), count);
  });
}

void start_stream(np_vdb_file &file) {
  const np_vdb_source &source = file.source;
  file.metadata->setSeekable(true);
  openvdb::io::setStreamMetadataPtr(file.stream, file.metadata, /*transfer=*/false);
  openvdb::io::setVersion(file.stream, {source.library_version[0], source.library_version[1]}, source.format_version);
  if (!file.stream) throw std::bad_alloc(); /* for the places of these in the stream */
  file.stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
}

/* Reads metadata and transform, which must end where the source says: else OpenVDB reads what was not checked. */
void read_header(np_vdb_file &file, const np_vdb_grid_place &place, openvdb::GridBase &grid) {
  file.stream.seekg(place.begin);
  Archive::readGridCompression(file.stream);
  grid.readMeta(file.stream);
  grid.readTransform(file.stream);
  if (file.stream.tellg() != std::streampos(place.topology))
    throw Failure{NEPH_ERROR_BAD_FILE,
                  "grid '" + grid.getName() + "' has metadata that OpenVDB reads differently: it is damaged"};
}

bool is_scalar(const openvdb::GridBase &grid) {
  return is_grid<openvdb::FloatGrid>(grid) || is_grid<openvdb::DoubleGrid>(grid);
}

bool is_count(const openvdb::GridBase &grid) {
  return is_grid<openvdb::Int32Grid>(grid) || is_grid<openvdb::Int64Grid>(grid) || is_grid<openvdb::BoolGrid>(grid) ||
         is_grid<openvdb::MaskGrid>(grid);
}

bool is_vector(const openvdb::GridBase &grid) {
  return is_grid<openvdb::Vec3SGrid>(grid) || is_grid<openvdb::Vec3DGrid>(grid);
}

/* Whether the transform is affine, and its matrix: OpenVDB multiplies row vectors from the left, ours is the transpose.
 */
bool get_affine(const openvdb::GridBase &grid, double out[3][4]) {
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

Entry read_entry(np_vdb_file &file, std::size_t index) {
  Entry entry;
  entry.index = index;
  file.stream.seekg(file.source.places[index].descriptor);
  entry.header = entry.descriptor.read(file.stream);
  read_header(file, file.source.places[index], *entry.header);
  entry.name = entry.descriptor.gridName();
  entry.value_type = entry.header->valueType();
  entry.grid_class = openvdb::GridBase::gridClassToString(entry.header->getGridClass());
  entry.creator = entry.header->getCreator();
  entry.is_scalar = is_scalar(*entry.header);
  entry.is_count = is_count(*entry.header);
  entry.is_vector = is_vector(*entry.header);
  entry.is_affine = get_affine(*entry.header, entry.index_to_world);
  return entry;
}

/* An instance stores a transform of its own, and the name of the grid whose voxels it shares. */
std::size_t search_owner(const std::vector<Entry> &entries, const Entry &entry) {
  if (!entry.descriptor.isInstance()) return entry.index;
  for (const Entry &other : entries)
    if (!other.descriptor.isInstance() && other.descriptor.uniqueName() == entry.descriptor.instanceParentName() &&
        other.descriptor.gridType() == entry.descriptor.gridType())
      return other.index;
  return no_owner;
}

neph_result open_file(const np_vdb_source *source, np_vdb_cancel_fn cancel, void *cancel_user, np_vdb_file **out_file,
                      np_vdb_error *error) noexcept {
  *out_file = nullptr;
  return guarded(error, Direction::reading, [&] {
    openvdb::initialize();
    auto file = std::make_unique<np_vdb_file>(*source, Canceller{cancel, cancel_user});
    start_stream(*file);
    for (std::size_t i = 0; i < source->grid_count; i++) file->entries.push_back(read_entry(*file, i));
    for (Entry &entry : file->entries) entry.owner = search_owner(file->entries, entry);
    *out_file = file.release();
  });
}

void close_file(np_vdb_file *file) noexcept { delete file; }

size_t count_grids(const np_vdb_file *file) noexcept { return file->entries.size(); }

/* ---- Describing ---- */

void describe_grid(const np_vdb_file *file, size_t index, np_vdb_grid_info *out_info) noexcept {
  const Entry &entry = file->entries[index];
  *out_info = np_vdb_grid_info{};
  out_info->name = entry.name.c_str();
  out_info->value_type = entry.value_type.c_str();
  out_info->grid_class = entry.grid_class.c_str();
  out_info->creator = entry.creator.c_str();
  out_info->owner = entry.owner == no_owner ? index : entry.owner;
  out_info->is_half_on_disk = entry.descriptor.saveFloatAsHalf();
  out_info->is_scalar = entry.is_scalar;
  out_info->is_count = entry.is_count;
  out_info->is_vector = entry.is_vector;
  out_info->is_level_set = entry.header->getGridClass() == openvdb::GRID_LEVEL_SET;
  out_info->is_affine = entry.is_affine;
  if (entry.is_affine) std::memcpy(out_info->index_to_world, entry.index_to_world, sizeof entry.index_to_world);
}

neph_result visit_metadata(const np_vdb_file *file, size_t index, void (*visit)(void *, const char *, const char *),
                           void *user, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    const openvdb::GridBase &grid = *file->entries[index].header;
    for (auto item = grid.beginMeta(); item != grid.endMeta(); ++item)
      if (item->second && item->first != openvdb::GridBase::META_FILE_DELAYED_LOAD)
        visit(user, item->first.c_str(), item->second->str().c_str());
  });
}

/* ---- Reading ---- */

enum class Part { topology, tree };

openvdb::GridBase::Ptr read_tree(np_vdb_file &file, const Entry &instance, Part part) {
  if (instance.owner == no_owner)
    throw Failure{NEPH_ERROR_BAD_FILE,
                  "grid '" + instance.name + "' shares the voxels of a grid that is missing or of another type"};
  const Entry &entry = file.entries[instance.owner];
  const np_vdb_grid_place &place = file.source.places[entry.index];
  check_result(file.source.check_tree(file.source.user, entry.index, entry.header->saveFloatAsHalf()));
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

template <typename Number> float get_component(const Number &value, int) { return static_cast<float>(value); }

template <typename Number> float get_component(const openvdb::math::Vec3<Number> &value, int component) {
  return static_cast<float>(value[component]);
}

template <typename LeafType> void copy_leaf(const LeafType &leaf, int component, const np_vdb_sink &sink) {
  static_assert(LeafType::SIZE == NP_LEAF_SIZE, "leaves of 8³ voxels in the same order");
  const openvdb::Coord origin = leaf.origin();
  np_leaf *out = sink.add_leaf(sink.grid, origin.data());
  check_room(out);
  const auto *values = leaf.buffer().data();
  for (int n = 0; n < NP_LEAF_SIZE; n++) out->values[n] = get_component(values[n], component);
  for (openvdb::Index word = 0; word < 8; word++)
    out->active[word] = leaf.getValueMask().template getWord<openvdb::Index64>(word);
}

bool is_same(float a, float b) { return a == b || (a != a && b != b); }

template <typename TreeType>
void copy_tree(const TreeType &tree, int component, const np_vdb_sink &sink, const Canceller &canceller) {
  sink.grid->background = get_component(tree.background(), component);
  check_result(sink.reserve(sink.grid, tree.leafCount(), 0));
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    canceller.poll();
    copy_leaf(*leaf, component, sink);
  }
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

template <typename GridType>
void copy_if(const openvdb::GridBase::Ptr &grid, int component, const np_vdb_sink &sink, const Canceller &canceller) {
  if (is_grid<GridType>(*grid)) copy_tree(openvdb::gridPtrCast<GridType>(grid)->tree(), component, sink, canceller);
}

void check_type(const Entry &entry) {
  if (!entry.is_scalar && !entry.is_count && !entry.is_vector)
    throw Failure{NEPH_ERROR_INVALID_ARGUMENT,
                  "grid '" + entry.name + "' is of type " + entry.value_type + ", neither a scalar nor a vector"};
}

/* ---- Densities ---- */

/* A grid as a density. */
openvdb::FloatGrid::Ptr read_density(np_vdb_file &file, const Entry &entry, double level_set_voxels, double byte_max) {
  openvdb::FloatGrid::Ptr grid = convert_to_floats(read_tree(file, entry, Part::tree));
  grid->setTransform(entry.header->transform().copy()); /* an instance has its own */
  if (level_set_voxels > 0.0 && entry.header->getGridClass() == openvdb::GRID_LEVEL_SET) {
    convert_distances(*grid, level_set_voxels);
  }
  return entry.is_affine ? grid : resample(grid, make_lattice(*grid), byte_max, entry.name);
}

openvdb::FloatGrid::Ptr read_sum(np_vdb_file &file, const np_vdb_request &request, double byte_max) {
  openvdb::FloatGrid::Ptr sum;
  for (std::size_t i = 0; i < request.count; i++) {
    const Entry &entry = file.entries[request.indices[i]];
    openvdb::FloatGrid::Ptr grid = read_density(file, entry, request.level_set_voxels, byte_max);
    if (sum && grid->transform() != sum->transform()) grid = resample(grid, sum->transformPtr(), byte_max, entry.name);
    if (sum)
      openvdb::tools::compSum(*sum, *grid);
    else
      sum = grid;
  }
  return sum;
}

/* A grid that stands in the file as a density would. */
bool is_plain(const np_vdb_file &file, const np_vdb_request &request) {
  const Entry &first = file.entries[request.indices[0]];
  return request.count == 1 && first.is_scalar && first.is_affine &&
         first.header->getGridClass() != openvdb::GRID_LEVEL_SET;
}

void read_converted(np_vdb_file &file, const np_vdb_request &request, const np_vdb_sink &sink,
                    uint64_t *out_tree_bytes) {
  const openvdb::FloatGrid::Ptr grid = read_sum(file, request, static_cast<double>(sink.grid->brick_bytes_max));
  get_affine(*grid, sink.grid->index_to_world.m);
  copy_tree(grid->tree(), 0, sink, file.canceller);
  *out_tree_bytes = grid->memUsage();
}

void read_plain(np_vdb_file &file, const np_vdb_request &request, const np_vdb_sink &sink, uint64_t *out_tree_bytes) {
  const Entry &entry = file.entries[request.indices[0]];
  const openvdb::GridBase::Ptr grid = read_tree(file, entry, Part::tree);
  if (entry.is_affine) std::memcpy(sink.grid->index_to_world.m, entry.index_to_world, sizeof entry.index_to_world);
  copy_if<openvdb::FloatGrid>(grid, request.component, sink, file.canceller);
  copy_if<openvdb::DoubleGrid>(grid, request.component, sink, file.canceller);
  copy_if<openvdb::Vec3SGrid>(grid, request.component, sink, file.canceller);
  copy_if<openvdb::Vec3DGrid>(grid, request.component, sink, file.canceller);
  *out_tree_bytes = grid->memUsage();
}

neph_result read_grid(np_vdb_file *file, const np_vdb_request *request, const np_vdb_sink *sink,
                      uint64_t *out_tree_bytes, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    for (std::size_t i = 0; i < request->count; i++) check_type(file->entries[request->indices[i]]);
    if (!request->is_density || is_plain(*file, *request))
      read_plain(*file, *request, *sink, out_tree_bytes);
    else
      read_converted(*file, *request, *sink, out_tree_bytes);
  });
}

/* Bytes of a leaf's values, in grids that keep them outside the leaf. */
template <typename... GridTypes> std::size_t get_leaf_value_bytes(const openvdb::GridBase &grid) {
  return ((is_grid<GridTypes>(grid) ? NP_LEAF_SIZE * sizeof(typename GridTypes::ValueType) : 0) + ...);
}

neph_result measure_grid(np_vdb_file *file, size_t index, np_vdb_grid_size *out_size, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    const openvdb::GridBase::Ptr grid = read_tree(*file, file->entries[index], Part::topology);
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    for (int axis = 0; axis < 3; axis++) {
      out_size->active_min[axis] = box.min()[axis];
      out_size->active_max[axis] = box.max()[axis];
    }
    out_size->active_voxel_count = grid->activeVoxelCount();
    out_size->tree_bytes =
        grid->memUsage() +
        grid->constBaseTree().leafCount() *
            get_leaf_value_bytes<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid, openvdb::Int32Grid,
                                 openvdb::Int64Grid, openvdb::points::PointDataGrid, openvdb::tools::PointIndexGrid>(
                *grid);
  });
}

/* ---- Writing ---- */

openvdb::math::Transform::Ptr make_transform(const np_affine &affine) {
  openvdb::Mat4R matrix = openvdb::Mat4R::identity();
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) matrix[column][row] = affine.m[row][column];
  const openvdb::math::AffineMap::Ptr map(new openvdb::math::AffineMap(matrix));
  return openvdb::math::Transform::Ptr(new openvdb::math::Transform(openvdb::math::simplify(map)));
}

openvdb::Index get_tile_level(int32_t edge) { return edge == 8 ? 1u : edge == 128 ? 2u : 3u; }

/* Adds a leaf of the topology of `from`, whose values `fill` sets. */
template <typename TreeType, typename Fill> void add_leaf(TreeType &tree, const np_leaf &from, const Fill &fill) {
  auto leaf = std::make_unique<typename TreeType::LeafNodeType>(openvdb::Coord(from.origin), tree.background(), false);
  fill(leaf->buffer().data());
  openvdb::util::NodeMask<3> mask;
  for (openvdb::Index word = 0; word < 8; word++) mask.getWord<openvdb::Index64>(word) = from.active[word];
  leaf->setValueMask(mask);
  tree.addLeaf(leaf.release());
}

/* Copies tiles and leaves to a grid that has none. */
void fill_scalar(const np_sparse_grid &source, const Canceller &canceller, openvdb::FloatGrid &grid) {
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

void fill_velocity(const np_vdb_write_grid &output, const Canceller &canceller, openvdb::Vec3SGrid &grid) {
  const np_sparse_grid &x = *output.grid, &y = *output.y, &z = *output.z;
  for (size_t i = 0; i < x.leaf_count; i++) {
    canceller.poll();
    add_leaf(grid.tree(), x.leaves[i], [&](openvdb::Vec3s *to) {
      for (int n = 0; n < NP_LEAF_SIZE; n++)
        to[n] = openvdb::Vec3s(x.leaves[i].values[n], y.leaves[i].values[n], z.leaves[i].values[n]);
    });
  }
}

/* A velocity in world space at the voxels' centres, which turns with the grid when that is moved. */
openvdb::GridBase::Ptr make_velocity(const np_vdb_write_grid &output) {
  auto grid =
      openvdb::Vec3SGrid::create(openvdb::Vec3s(output.grid->background, output.y->background, output.z->background));
  grid->setGridClass(openvdb::GRID_UNKNOWN); /* which also says: not staggered */
  grid->setVectorType(output.is_invariant ? openvdb::VEC_INVARIANT : openvdb::VEC_CONTRAVARIANT_RELATIVE);
  grid->setIsInWorldSpace(true);
  return grid;
}

openvdb::GridBase::Ptr make_fog(const np_sparse_grid &source) {
  auto grid = openvdb::FloatGrid::create(source.background);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

/* All of a grid but its voxels. */
openvdb::GridBase::Ptr make_output(const np_vdb_write_grid &output) {
  const openvdb::GridBase::Ptr grid = own(output.y ? make_velocity(output) : make_fog(*output.grid));
  grid->setTransform(make_transform(output.grid->index_to_world));
  grid->setName(output.grid->name);
  grid->setSaveFloatAsHalf(output.is_half);
  for (size_t i = 0; i < output.attribute_count; i++) {
    const np_vdb_attribute &attribute = output.attributes[i];
    if (attribute.text)
      grid->insertMeta(attribute.name, openvdb::StringMetadata(attribute.text));
    else
      grid->insertMeta(attribute.name, openvdb::DoubleMetadata(attribute.number));
  }
  return grid;
}

void fill_output(const np_vdb_write_grid &output, const Canceller &canceller, openvdb::GridBase &grid) {
  if (output.y)
    fill_velocity(output, canceller, static_cast<openvdb::Vec3SGrid &>(grid));
  else
    fill_scalar(*output.grid, canceller, static_cast<openvdb::FloatGrid &>(grid));
}

/* Blosc does not survive a failed allocation, of which it makes some 100 kB on each of TBB's threads. */
constexpr std::size_t compression_room_bytes = std::size_t(8) << 20;

/* Throws where there is no such room. */
void check_compression_room() { ::operator delete(::operator new(compression_room_bytes)); }

void write_stream(const char *path, const openvdb::GridCPtrVec &outputs, const openvdb::MetaMap &metadata,
                  const Canceller &canceller) {
  errno = 0;
  PolledFile buffer(canceller);
  std::ostream stream(&buffer);
  stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
  if (!buffer.open(path, std::ios_base::out | std::ios_base::binary | std::ios_base::trunc))
    throw Failure{NEPH_ERROR_IO, std::string("cannot write: ") + std::strerror(errno)};
  check_compression_room();
  Archive().write(stream, outputs, /*seekable=*/true, metadata);
  stream.flush();
  if (!buffer.close()) throw Failure{NEPH_ERROR_IO, std::string("cannot write: ") + std::strerror(errno)};
}

neph_result write_grids(const char *path, const np_vdb_write_grid *grids, size_t count, np_vdb_cancel_fn cancel,
                        void *cancel_user, np_vdb_error *error) noexcept {
  return guarded(error, Direction::writing, [&] {
    openvdb::initialize();
    const Canceller canceller{cancel, cancel_user};
    openvdb::GridPtrVec outputs;
    for (size_t i = 0; i < count; i++) {
      outputs.push_back(make_output(grids[i]));
      fill_output(grids[i], canceller, *outputs.back());
    }
    write_stream(path, openvdb::GridCPtrVec(outputs.begin(), outputs.end()), openvdb::MetaMap(), canceller);
  });
}

/* ---- Checking and mending ---- */

neph_result diagnose_grid(np_vdb_file *file, size_t index, void (*visit)(void *, const char *), void *user,
                          np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    const openvdb::GridBase::Ptr grid = read_tree(*file, file->entries[index], Part::tree);
    const auto tell = [&](const std::string &text) { visit(user, text.c_str()); };
    diagnose_if<openvdb::FloatGrid>(*grid, tell);
    diagnose_if<openvdb::DoubleGrid>(*grid, tell);
  });
}

/* OpenVDB writes a tree that it has met before as an instance. */
openvdb::GridBase::Ptr read_instance(const Entry &entry, const openvdb::GridBase::Ptr &owner) {
  const openvdb::GridBase::Ptr grid = entry.header->copyGrid();
  grid->setTree(owner->baseTreePtr());
  return grid;
}

openvdb::GridPtrVec read_all(np_vdb_file &file) {
  openvdb::GridPtrVec grids(file.entries.size());
  for (const Entry &entry : file.entries) {
    if (entry.header->isType<openvdb::points::PointDataGrid>())
      throw Failure{NEPH_ERROR_UNSUPPORTED, "grid '" + entry.name + "' holds points, which cannot be copied"};
    if (entry.owner == entry.index) grids[entry.index] = read_tree(file, entry, Part::tree);
  }
  for (const Entry &entry : file.entries)
    if (entry.owner != entry.index) {
      if (entry.owner == no_owner) read_tree(file, entry, Part::topology); /* says what is wrong */
      grids[entry.index] = read_instance(entry, grids[entry.owner]);
    }
  return grids;
}

neph_result mend_file(np_vdb_file *file, const np_vdb_mark *marks, const char *path, np_vdb_error *error) noexcept {
  openvdb::GridPtrVec grids;
  openvdb::MetaMap metadata;
  const neph_result result = guarded(error, Direction::reading, [&] {
    file->stream.seekg(file->source.metadata);
    metadata.readMeta(file->stream);
    grids = read_all(*file);
    for (size_t i = 0; i < grids.size(); i++) {
      mend_if<openvdb::FloatGrid>(*grids[i], marks[i]);
      mend_if<openvdb::DoubleGrid>(*grids[i], marks[i]);
    }
  });
  if (result) return result;
  return guarded(error, Direction::writing, [&] {
    write_stream(path, openvdb::GridCPtrVec(grids.begin(), grids.end()), metadata, file->canceller);
  });
}

/* ---- For tests ---- */

neph_result sample_grid(const np_sparse_grid *source, size_t count, const double *positions, float *out_values,
                        np_vdb_error *error) noexcept {
  return guarded(error, Direction::writing, [&] {
    openvdb::initialize();
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(source->background);
    grid->setTransform(make_transform(source->index_to_world));
    fill_scalar(*source, Canceller{nullptr, nullptr}, *grid);
    const openvdb::FloatGrid::ConstAccessor accessor = grid->getConstAccessor();
    for (size_t i = 0; i < count; i++) {
      const openvdb::Vec3R position(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
      out_values[i] = openvdb::tools::BoxSampler::sample(accessor, position);
    }
  });
}

/* ---- Threads ---- */

void *limit_threads(unsigned thread_count) noexcept {
  try {
    return new tbb::global_control(tbb::global_control::max_allowed_parallelism, thread_count);
  } catch (...) {
    return nullptr;
  }
}

void unlimit_threads(void *handle) noexcept { delete static_cast<tbb::global_control *>(handle); }

const np_vdb_module module_table = {
    NP_VDB_MODULE_VERSION, try_chunk,      open_file,       close_file,   count_grids,
    describe_grid,         visit_metadata, read_grid,       measure_grid, diagnose_grid,
    mend_file,             write_grids,    sample_grid,     limit_threads, unlimit_threads,
};

} /* namespace */

const np_vdb_module *nephos_vdb_module(void) { return &module_table; }
