/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB behind C functions. Nothing throws out of here: every entry runs inside `guarded`.
 *
 * Files are read through a stream buffer that asks whether to go on before each piece, and on a stream that throws at
 * the first byte that is missing: OpenVDB itself checks neither.
 */
#include "volume/vdb_shim.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <istream>
#include <memory>
#include <new>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/global_control.h>

namespace {

/* ---- Failure ---- */

struct Cancelled {};

/* A callback has failed, and has said why. */
struct AlreadyTold {
  neph_result result;
};

struct Failure {
  neph_result result;
  std::string message;
};

struct Canceller {
  np_vdb_cancel_fn ask;
  void *user;

  bool is_cancelled() const { return ask && ask(user); }
  void poll() const {
    if (is_cancelled()) throw Cancelled();
  }
};

neph_result report(np_vdb_error *error, neph_result result, const char *format, const char *text) noexcept {
  error->result = result;
  std::snprintf(error->message, sizeof error->message, format, text);
  return result;
}

enum class Direction { reading, writing };

neph_result report_stream(np_vdb_error *error, Direction direction) noexcept {
  if (direction == Direction::writing)
    return report(error, NEPH_ERROR_IO, "cannot write: %s", errno ? std::strerror(errno) : "the stream failed");
  return report(error, NEPH_ERROR_BAD_FILE, "%s", "the file ends before its data does: it is truncated or damaged");
}

/* Runs `work` and turns whatever it throws into a result and a message. */
template <typename Work> neph_result guarded(np_vdb_error *error, Direction direction, const Work &work) noexcept {
  try {
    work();
    error->result = NEPH_OK;
    error->message[0] = 0;
    return NEPH_OK;
  } catch (const Cancelled &) {
    return report(error, NEPH_ERROR_CANCELLED, "%s", "cancelled");
  } catch (const AlreadyTold &told) {
    return report(error, told.result, "%s", "");
  } catch (const Failure &failure) {
    return report(error, failure.result, "%s", failure.message.c_str());
  } catch (const std::bad_alloc &) {
    return report(error, NEPH_ERROR_OUT_OF_MEMORY, "out of memory inside OpenVDB%s",
                  direction == Direction::reading ? ": the grid is too large, or the file damaged" : "");
  } catch (const std::ios_base::failure &) {
    return report_stream(error, direction);
  } catch (const openvdb::Exception &exception) {
    return report(error, direction == Direction::reading ? NEPH_ERROR_BAD_FILE : NEPH_ERROR_IO, "%s", exception.what());
  } catch (const std::length_error &) {
    return report(error, NEPH_ERROR_BAD_FILE, "%s", "the file names a length that cannot be: it is damaged");
  } catch (const std::exception &exception) {
    return report(error, NEPH_ERROR_INTERNAL, "OpenVDB failed: %s", exception.what());
  } catch (...) {
    return report(error, NEPH_ERROR_INTERNAL, "%s", "OpenVDB failed without saying why");
  }
}

/* ---- Streams ---- */

class PolledFile : public std::filebuf {
public:
  explicit PolledFile(Canceller canceller) : canceller_(canceller) {}

  /* OpenVDB loses a half-built tree when its topology throws: up to this position a cancel must wait. */
  void wait_until(std::streamoff position) { waits_until_ = position; }

  std::streamoff measure() {
    const std::streamoff here = seekoff(0, std::ios_base::cur, std::ios_base::in);
    const std::streamoff size = seekoff(0, std::ios_base::end, std::ios_base::in);
    seekoff(here, std::ios_base::beg, std::ios_base::in);
    return size;
  }

protected:
  std::streamsize xsgetn(char *bytes, std::streamsize count) override {
    return transfer(
        count, [&](std::streamsize done, std::streamsize piece) { return std::filebuf::xsgetn(bytes + done, piece); });
  }

  std::streamsize xsputn(const char *bytes, std::streamsize count) override {
    return transfer(
        count, [&](std::streamsize done, std::streamsize piece) { return std::filebuf::xsputn(bytes + done, piece); });
  }

private:
  static constexpr std::streamsize piece_bytes = std::streamsize(1) << 20;

  template <typename Move> std::streamsize transfer(std::streamsize count, const Move &move) {
    std::streamsize done = 0;
    while (done < count) {
      if (canceller_.is_cancelled() && get_position() >= waits_until_) throw Cancelled();
      const std::streamsize piece = std::min(count - done, piece_bytes), moved = move(done, piece);
      done += moved;
      if (moved < piece) break;
    }
    return done;
  }

  std::streamoff get_position() { return seekoff(0, std::ios_base::cur); }

  Canceller canceller_;
  std::streamoff waits_until_ = 0;
};

/* Opens the protected parts of OpenVDB's archive, which both its File and its Stream are made of: neither lets a caller
 * bring his own buffer and still read one grid alone. */
class Archive : public openvdb::io::Archive {
public:
  using openvdb::io::Archive::inputHasGridOffsets;
  using openvdb::io::Archive::readGrid;
  using openvdb::io::Archive::readGridCompression;
  using openvdb::io::Archive::readGridCount;
  using openvdb::io::Archive::readHeader;
  using openvdb::io::Archive::setDataCompression;
  using openvdb::io::Archive::setFormatVersion;
  using openvdb::io::Archive::setLibraryVersion;
  using openvdb::io::Archive::write;
};

struct Entry {
  openvdb::io::GridDescriptor descriptor;
  openvdb::GridBase::Ptr header; /* metadata and transform */
  openvdb::GridBase::Ptr whole;  /* read at once where a file has no offsets, else empty */
  std::string name, value_type, grid_class, creator;
};

} /* namespace */

struct np_vdb_file {
  explicit np_vdb_file(Canceller canceller_) : canceller(canceller_), buffer(canceller_), stream(&buffer) {}

  Canceller canceller;
  PolledFile buffer;
  openvdb::io::StreamMetadata::Ptr metadata{
      new openvdb::io::StreamMetadata}; /* the stream points at this very pointer */
  std::istream stream;
  std::streamoff size = 0;
  Archive archive;
  std::vector<Entry> entries;
};

namespace {

/* ---- Opening ---- */

void open_stream(np_vdb_file &file, const char *path) {
  if (!file.buffer.open(path, std::ios_base::in | std::ios_base::binary)) {
    const neph_result result = errno == ENOENT || errno == ENOTDIR ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO;
    throw Failure{result, std::string("cannot open: ") + std::strerror(errno)};
  }
  file.size = file.buffer.measure();
  file.stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
  file.archive.readHeader(file.stream);
  if (file.archive.fileVersion() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION)
    throw Failure{NEPH_ERROR_UNSUPPORTED,
                  "file format version " + std::to_string(file.archive.fileVersion()) +
                      " is too old: 222 and later are read; save it anew with OpenVDB 3 or later"};
  file.metadata->setSeekable(true);
  openvdb::io::setStreamMetadataPtr(file.stream, file.metadata, /*transfer=*/false);
  file.archive.setFormatVersion(file.stream);
  file.archive.setLibraryVersion(file.stream);
  file.archive.setDataCompression(file.stream);
  openvdb::MetaMap().readMeta(file.stream);
}

std::string describe_truncation(const np_vdb_file &file, const Entry &entry) {
  return "grid '" + entry.descriptor.gridName() + "' ends at byte " + std::to_string(entry.descriptor.getEndPos()) +
         ", the file at " + std::to_string(file.size) + ": it is truncated or damaged";
}

Entry read_entry(np_vdb_file &file) {
  Entry entry;
  entry.header = entry.descriptor.read(file.stream);
  if (file.archive.inputHasGridOffsets()) {
    if (entry.descriptor.getEndPos() > file.size) throw Failure{NEPH_ERROR_BAD_FILE, describe_truncation(file, entry)};
    entry.descriptor.seekToGrid(file.stream);
    Archive::readGridCompression(file.stream);
    entry.header->readMeta(file.stream);
    entry.header->readTransform(file.stream);
    entry.descriptor.seekToEnd(file.stream);
  } else {
    Archive::readGrid(entry.header, entry.descriptor, file.stream);
    entry.whole = entry.header;
  }
  entry.name = entry.descriptor.gridName();
  entry.value_type = entry.header->valueType();
  entry.grid_class = openvdb::GridBase::gridClassToString(entry.header->getGridClass());
  entry.creator = entry.header->getCreator();
  return entry;
}

neph_result open_file(const char *path, np_vdb_cancel_fn cancel, void *cancel_user, np_vdb_file **out_file,
                      np_vdb_error *error) noexcept {
  *out_file = nullptr;
  return guarded(error, Direction::reading, [&] {
    openvdb::initialize();
    auto file = std::make_unique<np_vdb_file>(Canceller{cancel, cancel_user});
    open_stream(*file, path);
    for (int32_t left = Archive::readGridCount(file->stream); left > 0; left--)
      file->entries.push_back(read_entry(*file));
    *out_file = file.release();
  });
}

void close_file(np_vdb_file *file) noexcept { delete file; }

size_t count_grids(const np_vdb_file *file) noexcept { return file->entries.size(); }

/* ---- Describing ---- */

template <typename GridType> bool is_grid(const openvdb::GridBase &grid) { return grid.isType<GridType>(); }

/* OpenVDB multiplies row vectors from the left: its matrix is the transpose of ours. */
void get_affine(const openvdb::GridBase &grid, double out[3][4]) {
  const openvdb::Mat4R matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) out[row][column] = matrix[column][row];
}

void describe_grid(const np_vdb_file *file, size_t index, np_vdb_grid_info *out_info) noexcept {
  const Entry &entry = file->entries[index];
  *out_info = np_vdb_grid_info{};
  out_info->name = entry.name.c_str();
  out_info->value_type = entry.value_type.c_str();
  out_info->grid_class = entry.grid_class.c_str();
  out_info->creator = entry.creator.c_str();
  out_info->is_half_on_disk = entry.descriptor.saveFloatAsHalf();
  out_info->is_scalar = is_grid<openvdb::FloatGrid>(*entry.header) || is_grid<openvdb::DoubleGrid>(*entry.header);
  out_info->is_vector = is_grid<openvdb::Vec3SGrid>(*entry.header) || is_grid<openvdb::Vec3DGrid>(*entry.header);
  np_vdb_error ignored;
  out_info->is_affine = entry.header->transform().isLinear() && !guarded(&ignored, Direction::reading, [&] {
                          get_affine(*entry.header, out_info->index_to_world);
                        });
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

openvdb::GridBase::Ptr read_stored(np_vdb_file &file, const Entry &entry) {
  if (entry.whole) return entry.whole;
  file.stream.clear();
  openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(entry.descriptor.gridType());
  grid->setSaveFloatAsHalf(entry.descriptor.saveFloatAsHalf());
  entry.descriptor.seekToGrid(file.stream);
  file.buffer.wait_until(entry.descriptor.getBlockPos());
  Archive::readGrid(grid, entry.descriptor, file.stream);
  return grid;
}

/* An instance stores a transform of its own, and the name of the grid whose tree it shares. */
openvdb::GridBase::Ptr read_whole(np_vdb_file &file, const Entry &entry) {
  openvdb::GridBase::Ptr grid = read_stored(file, entry);
  if (!entry.descriptor.isInstance()) return grid;
  for (const Entry &other : file.entries)
    if (&other != &entry && other.descriptor.uniqueName() == entry.descriptor.instanceParentName()) {
      grid->setTree(read_stored(file, other)->baseTreePtr());
      return grid;
    }
  throw Failure{NEPH_ERROR_BAD_FILE, "grid '" + entry.name + "' shares the voxels of a grid that is not in the file"};
}

void check_room(const void *block) {
  if (!block) throw AlreadyTold{NEPH_ERROR_OUT_OF_MEMORY};
}

void check_result(neph_result result) {
  if (result) throw AlreadyTold{result};
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
bool copy_if(const openvdb::GridBase::Ptr &grid, int component, const np_vdb_sink &sink, const Canceller &canceller) {
  if (!is_grid<GridType>(*grid)) return false;
  copy_tree(openvdb::gridPtrCast<GridType>(grid)->tree(), component, sink, canceller);
  return true;
}

neph_result read_grid(np_vdb_file *file, size_t index, int component, const np_vdb_sink *sink, uint64_t *out_tree_bytes,
                      np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    const Entry &entry = file->entries[index];
    const openvdb::GridBase::Ptr grid = read_whole(*file, entry);
    if (grid->transform().isLinear()) get_affine(*grid, sink->grid->index_to_world.m);
    if (!copy_if<openvdb::FloatGrid>(grid, component, *sink, file->canceller) &&
        !copy_if<openvdb::DoubleGrid>(grid, component, *sink, file->canceller) &&
        !copy_if<openvdb::Vec3SGrid>(grid, component, *sink, file->canceller) &&
        !copy_if<openvdb::Vec3DGrid>(grid, component, *sink, file->canceller))
      throw Failure{NEPH_ERROR_INVALID_ARGUMENT,
                    "grid '" + entry.name + "' is of type " + entry.value_type + ", neither a scalar nor a vector"};
    *out_tree_bytes = grid->memUsage();
  });
}

neph_result measure_grid(np_vdb_file *file, size_t index, np_vdb_grid_size *out_size, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    const openvdb::GridBase::Ptr grid = read_whole(*file, file->entries[index]);
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    for (int axis = 0; axis < 3; axis++) {
      out_size->active_min[axis] = box.min()[axis];
      out_size->active_max[axis] = box.max()[axis];
    }
    out_size->active_voxel_count = grid->activeVoxelCount();
    out_size->tree_bytes = grid->memUsage();
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
  auto grid = openvdb::Vec3SGrid::create(
      openvdb::Vec3s(output.grid->background, output.y->background, output.z->background));
  grid->setGridClass(openvdb::GRID_UNKNOWN); /* which also says: not staggered */
  grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
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
  const openvdb::GridBase::Ptr grid = output.y ? make_velocity(output) : make_fog(*output.grid);
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

/* Memory that OpenVDB needs to destroy a tree: it lists the leaves first, in a vector that doubles, and ends the
 * process where there is no room for that. */
std::vector<char> make_reserve(const np_vdb_write_grid *grids, size_t count) {
  size_t leaf_count = 0;
  for (size_t i = 0; i < count; i++) leaf_count = std::max(leaf_count, grids[i].grid->leaf_count);
  return std::vector<char>(3 * leaf_count * sizeof(void *) + (size_t(1) << 20));
}

void write_stream(const char *path, const openvdb::GridCPtrVec &outputs, const Canceller &canceller) {
  errno = 0;
  PolledFile buffer(canceller);
  std::ostream stream(&buffer);
  stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
  if (!buffer.open(path, std::ios_base::out | std::ios_base::binary | std::ios_base::trunc))
    throw Failure{NEPH_ERROR_IO, std::string("cannot write: ") + std::strerror(errno)};
  Archive().write(stream, outputs, /*seekable=*/true, openvdb::MetaMap());
  stream.flush();
  if (!buffer.close()) throw Failure{NEPH_ERROR_IO, std::string("cannot write: ") + std::strerror(errno)};
}

neph_result write_grids(const char *path, const np_vdb_write_grid *grids, size_t count, np_vdb_cancel_fn cancel,
                        void *cancel_user, np_vdb_error *error) noexcept {
  return guarded(error, Direction::writing, [&] {
    openvdb::initialize();
    const Canceller canceller{cancel, cancel_user};
    openvdb::GridPtrVec outputs;
    const std::vector<char> reserve = make_reserve(grids, count); /* given back first, should this fail */
    for (size_t i = 0; i < count; i++) {
      outputs.push_back(make_output(grids[i]));
      fill_output(grids[i], canceller, *outputs.back());
    }
    write_stream(path, openvdb::GridCPtrVec(outputs.begin(), outputs.end()), canceller);
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
    NP_VDB_MODULE_VERSION, open_file,   close_file,  count_grids,   describe_grid,   visit_metadata, read_grid,
    measure_grid,          write_grids, sample_grid, limit_threads, unlimit_threads,
};

} /* namespace */

const np_vdb_module *nephos_vdb_module(void) { return &module_table; }
