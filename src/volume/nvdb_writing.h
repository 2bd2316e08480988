/* SPDX-License-Identifier: Apache-2.0 */
/* Converts OpenVDB grids to NanoVDB, and writes them to a file without compression. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_NVDB_WRITING_H
#define NP_VOLUME_NVDB_WRITING_H

#include <cstring>
#include <memory>
#include <new>
#include <ostream>
#include <string>
#include <vector>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/io/Compression.h>

#include "volume/vdb_writing.h"

namespace np_vdb {

/* ---- Memory ---- */

/* The buffer of a NanoVDB grid. It is zero at first: the converter writes no padding. */
class ZeroedBuffer {
public:
  ZeroedBuffer() = default;
  explicit ZeroedBuffer(uint64_t size)
      : bytes(static_cast<uint8_t *>(::operator new(size, alignment))), byte_count(size) {
    std::memset(bytes.get(), 0, size);
  }
  static ZeroedBuffer create(uint64_t size, const ZeroedBuffer * = nullptr) { return ZeroedBuffer(size); }
  uint8_t *data() { return bytes.get(); }
  const uint8_t *data() const { return bytes.get(); }
  uint64_t size() const { return byte_count; }
  void clear() {
    bytes.reset();
    byte_count = 0;
  }

private:
  static constexpr std::align_val_t alignment{NANOVDB_DATA_ALIGNMENT};
  struct Free {
    void operator()(uint8_t *pointer) const { ::operator delete(pointer, alignment); }
  };
  std::unique_ptr<uint8_t, Free> bytes;
  uint64_t byte_count = 0;
};

using NanoHandle = nanovdb::GridHandle<ZeroedBuffer>;

/* ---- Metadata ---- */

/* Names and texts of a grid's metadata, each ended by a zero byte. */
inline std::string join_metadata(const openvdb::GridBase &grid) {
  std::string out;
  for (auto item = grid.beginMeta(); item != grid.endMeta(); ++item) {
    if (!item->second) continue;
    out.append(item->first).push_back('\0');
    out.append(item->second->str()).push_back('\0');
  }
  return out;
}

inline uint64_t align_up(uint64_t size) {
  return (size + NANOVDB_DATA_ALIGNMENT - 1) / NANOVDB_DATA_ALIGNMENT * NANOVDB_DATA_ALIGNMENT;
}

/* Adds the metadata as blind data behind the grid. The headers of its other blind data move to stand beside ours. */
inline NanoHandle add_metadata(const NanoHandle &grid, const std::string &metadata) {
  using Blind = nanovdb::GridBlindMetaData;
  const auto *old = reinterpret_cast<const nanovdb::GridData *>(grid.data());
  const uint64_t size = old->mGridSize, count = old->mBlindMetadataCount + 1;
  const uint64_t data_at = size + count * sizeof(Blind), whole = data_at + align_up(metadata.size());
  NanoHandle out(ZeroedBuffer::create(whole));
  std::memcpy(out.data(), grid.data(), size);
  auto *head = reinterpret_cast<nanovdb::GridData *>(out.data());
  auto *blind = reinterpret_cast<Blind *>(out.data() + size);
  for (uint64_t i = 0; i + 1 < count; i++) {
    const uint64_t from = uint64_t(old->mBlindMetadataOffset) + i * sizeof(Blind);
    std::memcpy(static_cast<void *>(&blind[i]), grid.data() + from, sizeof(Blind));
    blind[i].mByteOffset -= int64_t(size + i * sizeof(Blind) - from);
  }
  Blind &own = blind[count - 1];
  own.mByteOffset = int64_t(sizeof(Blind));
  own.mElementCount = metadata.size();
  own.mSemantic = nanovdb::GridBlindDataSemantic::Unknown;
  own.mDataClass = nanovdb::GridBlindDataClass::Unknown;
  own.mDataType = nanovdb::GridType::Unknown;
  std::strncpy(own.mName, NP_NVDB_ATTRIBUTES_NAME, Blind::MaxNameSize - 1);
  std::memcpy(out.data() + data_at, metadata.data(), metadata.size());
  head->mGridSize = whole;
  head->mBlindMetadataOffset = int64_t(size);
  head->mBlindMetadataCount = uint32_t(count);
  return out;
}

/* ---- Grids ---- */

/* NanoVDB has no half floats that keep their exponent: values are rounded to half and stored as floats. */
template <typename GridType> void round_to_half(GridType &grid) {
  openvdb::tools::foreach (grid.beginValueAll(), [](const typename GridType::ValueAllIter &value) {
    value.setValue(openvdb::io::truncateRealToHalf(*value));
  });
}

template <typename GridType, typename NanoType> NanoHandle convert_typed(GridType &grid) {
  if (grid.saveFloatAsHalf()) round_to_half(grid);
  NanoHandle out = add_metadata(nanovdb::openToNanoVDB<ZeroedBuffer>(grid), join_metadata(grid));
  nanovdb::updateChecksum(*out.grid<NanoType>());
  return out;
}

inline NanoHandle convert_to_nano(openvdb::GridBase &grid) {
  if (auto *scalar = dynamic_cast<openvdb::FloatGrid *>(&grid))
    return convert_typed<openvdb::FloatGrid, float>(*scalar);
  return convert_typed<openvdb::Vec3SGrid, nanovdb::Vec3f>(dynamic_cast<openvdb::Vec3SGrid &>(grid));
}

inline void write_nano(const char *path, const std::vector<NanoHandle> &grids, const Canceller &canceller) {
  write_file(path, canceller, [&](std::ostream &stream) { nanovdb::io::writeGrids(stream, grids); });
}

} /* namespace np_vdb */

#endif
