/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB behind C functions. No exception leaves this file: every entry runs inside `guarded`.
 *
 * OpenVDB trusts the lengths in a file. So it reads through the caller's np_vdb_source, which has checked the
 * structure, and through a stream that throws at the first missing byte. The caller, not OpenVDB, reads the header of
 * the file: OpenVDB would log warnings about its version to standard output. */
#include "volume/vdb_table.h"

#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include <openvdb/io/Compression.h>
#include <openvdb/tools/Interpolation.h>

#include "volume/vdb_failure.h"
#include "volume/vdb_mending.h"
#include "volume/vdb_packing.h"
#include "volume/vdb_reading.h"
#include "volume/nvdb_writing.h"

using namespace np_vdb;

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
  if (!file.stream) throw std::bad_alloc(); /* the stream allocates slots for these */
  file.stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
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

/* Creator of a file: Houdini states it in the file's metadata, other programs in each grid's. */
std::string read_creator(np_vdb_file &file) {
  openvdb::MetaMap metadata;
  file.stream.seekg(file.source.metadata);
  metadata.readMeta(file.stream);
  const auto text = metadata.getMetadata<openvdb::StringMetadata>("creator");
  return text ? text->value() : std::string();
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
  entry.frustum = get_frustum(*entry.header);
  return entry;
}

/* Index of the grid whose voxels an instance shares by name; an instance has a transform of its own. */
std::size_t search_owner(const std::vector<Entry> &entries, const Entry &entry) {
  if (!entry.descriptor.isInstance()) return entry.index;
  for (const Entry &other : entries)
    if (!other.descriptor.isInstance() && other.descriptor.uniqueName() == entry.descriptor.instanceParentName() &&
        other.descriptor.gridType() == entry.descriptor.gridType())
      return other.index;
  return no_owner;
}

neph_result open_file(const np_vdb_source *source, unsigned thread_count, np_vdb_cancel_fn cancel, void *cancel_user,
                      np_vdb_file **out_file, np_vdb_error *error) noexcept {
  *out_file = nullptr;
  return guarded(error, Direction::reading, [&] {
    openvdb::initialize();
    auto file = std::make_unique<np_vdb_file>(*source, thread_count, Canceller{cancel, cancel_user});
    start_stream(*file);
    const std::string creator = read_creator(*file);
    for (std::size_t i = 0; i < source->grid_count; i++) {
      file->entries.push_back(read_entry(*file, i));
      if (file->entries[i].creator.empty()) file->entries[i].creator = creator;
    }
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
  out_info->frustum = entry.frustum;
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

neph_result read_grid(np_vdb_file *file, const np_vdb_request *request, const np_vdb_sink *sink,
                      uint64_t *out_tree_bytes, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, file->thread_count, [&] {
    for (std::size_t i = 0; i < request->count; i++) check_type(file->entries[request->indices[i]]);
    if (!request->is_density || is_plain(*file, *request))
      read_plain(*file, *request, *sink, out_tree_bytes);
    else
      read_converted(*file, *request, *sink, out_tree_bytes);
  });
}

neph_result combine_grids(const np_vdb_addend *addends, size_t count, double level_set_voxels, unsigned thread_count,
                          np_vdb_cancel_fn cancel, void *cancel_user, const np_vdb_sink *sink, uint64_t *out_tree_bytes,
                          np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, thread_count, [&] {
    openvdb::initialize();
    const Canceller canceller{cancel, cancel_user};
    Sum sum(level_set_voxels, *sink->grid);
    for (size_t i = 0; i < count; i++) {
      const np_sparse_grid &source = *addends[i].grid;
      const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(source.background);
      grid->setTransform(make_transform(source.index_to_world));
      fill_scalar(source, canceller, *grid);
      sum.add({source.name, addends[i].is_affine != 0, addends[i].is_level_set != 0, grid});
    }
    sum.copy_to(*sink, canceller, out_tree_bytes);
  });
}

neph_result unpack_chunk(int is_blosc, const void *packed, size_t packed_bytes, void *out, size_t count,
                         np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, [&] {
    if (is_blosc)
      unpack_blosc(packed, packed_bytes, out, count);
    else
      unpack_zip(packed, packed_bytes, out, count);
  });
}

/* Size of a leaf's values, for grids that store them outside of the leaf. */
template <typename... GridTypes> std::size_t get_leaf_value_bytes(const openvdb::GridBase &grid) {
  return ((is_grid<GridTypes>(grid) ? NP_LEAF_SIZE * sizeof(typename GridTypes::ValueType) : 0) + ...);
}

neph_result measure_grid(np_vdb_file *file, size_t index, np_vdb_grid_size *out_size, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, file->thread_count, [&] {
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

void write_nano_grids(const char *path, const np_vdb_write_grid *grids, size_t count, const Canceller &canceller) {
  std::vector<NanoHandle> outputs;
  for (size_t i = 0; i < count; i++) {
    const openvdb::GridBase::Ptr grid = make_output(grids[i]);
    fill_output(grids[i], canceller, *grid);
    outputs.push_back(convert_to_nano(*grid));
  }
  write_nano(path, outputs, canceller);
}

neph_result write_grids(const char *path, const np_vdb_write_grid *grids, size_t count, int is_nano,
                        unsigned thread_count, np_vdb_cancel_fn cancel, void *cancel_user,
                        np_vdb_error *error) noexcept {
  return guarded(error, Direction::writing, thread_count, [&] {
    openvdb::initialize();
    const Canceller canceller{cancel, cancel_user};
    if (is_nano) return write_nano_grids(path, grids, count, canceller);
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
  return guarded(error, Direction::reading, file->thread_count, [&] {
    const openvdb::GridBase::Ptr grid = read_tree(*file, file->entries[index], Part::tree);
    const auto tell = [&](const std::string &text) { visit(user, text.c_str()); };
    diagnose_if<openvdb::FloatGrid>(*grid, tell);
    diagnose_if<openvdb::DoubleGrid>(*grid, tell);
  });
}

/* Reads an instance: OpenVDB writes a tree that it has already written as one. */
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
      if (entry.owner == no_owner) read_tree(file, entry, Part::topology); /* throws the reason */
      grids[entry.index] = read_instance(entry, grids[entry.owner]);
    }
  return grids;
}

void mend_grid(openvdb::GridBase &grid, np_vdb_mending &mending) {
  mend_if<openvdb::FloatGrid>(grid, mending);
  mend_if<openvdb::DoubleGrid>(grid, mending);
  mend_if<openvdb::Int32Grid>(grid, mending);
  mend_if<openvdb::Int64Grid>(grid, mending);
  make_finite_if<openvdb::FloatGrid>(grid, mending);
  make_finite_if<openvdb::DoubleGrid>(grid, mending);
  make_finite_if<openvdb::Vec3SGrid>(grid, mending);
  make_finite_if<openvdb::Vec3DGrid>(grid, mending);
}

neph_result mend_file(np_vdb_file *file, np_vdb_mending *mendings, const char *path, np_vdb_error *error) noexcept {
  openvdb::GridPtrVec grids;
  openvdb::MetaMap metadata;
  const neph_result result = guarded(error, Direction::reading, [&] {
    file->stream.seekg(file->source.metadata);
    metadata.readMeta(file->stream);
    grids = read_all(*file);
    for (size_t i = 0; i < grids.size(); i++) mend_grid(*grids[i], mendings[i]);
  });
  if (result) return result;
  return guarded(error, Direction::writing, [&] {
    write_stream(path, openvdb::GridCPtrVec(grids.begin(), grids.end()), metadata, file->canceller);
  });
}

/* ---- Tests and benchmarks ---- */

neph_result read_alone(np_vdb_file *file, size_t index, np_vdb_error *error) noexcept {
  return guarded(error, Direction::reading, file->thread_count, [&] {
    const std::size_t owner = file->entries[index].owner;
    read_unchecked(*file, file->entries[owner == no_owner ? index : owner], Part::tree);
  });
}

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

const np_vdb_module module_table = {
    NP_VDB_MODULE_VERSION,
    try_chunk,
    open_file,
    close_file,
    count_grids,
    describe_grid,
    visit_metadata,
    read_grid,
    combine_grids,
    unpack_chunk,
    measure_grid,
    diagnose_grid,
    mend_file,
    write_grids,
    sample_grid,
    read_alone,
};

} /* namespace */

/* Initialises OpenVDB when it is loaded, while there is memory: its compressor does not check allocations. The first
 * call that needs OpenVDB reports a failure. */
const np_vdb_module *nephos_vdb_module(void) {
  try {
    openvdb::initialize();
  } catch (...) {}
  return &module_table;
}
