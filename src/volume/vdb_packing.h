/* SPDX-License-Identifier: Apache-2.0 */
/* Compressed chunks of .nvdb files. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_PACKING_H
#define NP_VOLUME_VDB_PACKING_H

#include <blosc.h>
#include <zlib.h>

#include "volume/vdb_writing.h"

namespace np_vdb {

[[noreturn]] inline void fail_chunk(const char *codec) {
  throw Failure{NEPH_ERROR_BAD_FILE, std::string("a chunk cannot be decompressed by ") + codec};
}

/* Ends a stream of zlib. */
class Inflation {
public:
  Inflation() {
    if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  }
  ~Inflation() { inflateEnd(&stream); }
  Inflation(const Inflation &) = delete;

  z_stream stream{};
};

/* The most bytes that zlib takes or gives at once. */
constexpr std::size_t zip_piece_bytes = std::size_t(1) << 30;

inline void unpack_zip(const void *packed, std::size_t packed_bytes, void *out, std::size_t count) {
  Inflation inflation;
  z_stream &stream = inflation.stream;
  auto *in = static_cast<unsigned char *>(const_cast<void *>(packed));
  auto *to = static_cast<unsigned char *>(out);
  while (count > 0) {
    stream.next_in = in;
    stream.avail_in = static_cast<uInt>(std::min(packed_bytes, zip_piece_bytes));
    stream.next_out = to;
    stream.avail_out = static_cast<uInt>(std::min(count, zip_piece_bytes));
    const int state = inflate(&stream, Z_NO_FLUSH);
    const std::size_t taken = static_cast<std::size_t>(stream.next_in - in),
                      given = static_cast<std::size_t>(stream.next_out - to);
    in += taken, packed_bytes -= taken, to += given, count -= given;
    if (state == Z_MEM_ERROR) throw std::bad_alloc();
    if ((state != Z_OK && state != Z_STREAM_END) || (count > 0 && (state == Z_STREAM_END || given + taken == 0)))
      fail_chunk("zlib");
  }
}

/* Blosc checks the structure of a chunk itself, and its size beforehand. */
inline void unpack_blosc(const void *packed, std::size_t packed_bytes, void *out, std::size_t count) {
  std::size_t bytes = 0, type_bytes = 0;
  int flags = 0;
  if (packed_bytes < BLOSC_MIN_HEADER_LENGTH || blosc_cbuffer_validate(packed, packed_bytes, &bytes) < 0 ||
      bytes < count)
    fail_chunk("Blosc");
  check_compression_room();
  blosc_cbuffer_metainfo(packed, &type_bytes, &flags);
  if (bytes == count) {
    if (blosc_decompress_ctx(packed, out, count, 1) != static_cast<int>(count)) fail_chunk("Blosc");
    return;
  }
  if (type_bytes == 0 || count % type_bytes) fail_chunk("Blosc");
  if (blosc_getitem(packed, 0, static_cast<int>(count / type_bytes), out) != static_cast<int>(count))
    fail_chunk("Blosc");
}

} /* namespace np_vdb */

#endif
