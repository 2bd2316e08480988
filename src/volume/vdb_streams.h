/* SPDX-License-Identifier: Apache-2.0 */
/* C++ streams that the shim passes to OpenVDB, and their exceptions. */
#ifndef NP_VOLUME_VDB_STREAMS_H
#define NP_VOLUME_VDB_STREAMS_H

#include <algorithm>
#include <cstring>
#include <fstream>
#include <streambuf>
#include <string>

#include "volume/vdb_table.h"

namespace np_vdb {

/* ---- Failure ---- */

struct Failure {
  neph_result result;
  std::string message;
};

struct Cancelled {};

/* A callback has failed and has logged the reason. */
struct AlreadyReported {
  neph_result result;
};

inline void check_result(neph_result result) {
  if (result) throw AlreadyReported{result};
}

struct Canceller {
  np_vdb_cancel_fn ask;
  void *user;

  bool is_cancelled() const { return ask && ask(user); }
  void poll() const {
    if (is_cancelled()) throw Cancelled();
  }
};

/* ---- Reading ---- */

/* A buffer of positions alone: each read goes straight to its destination. */
class ReadBuffer : public std::streambuf {
protected:
  explicit ReadBuffer(std::streamoff size) : size_(size) {}

  virtual void read(std::streamoff position, char *bytes, std::size_t count) = 0;

  std::streamsize xsgetn(char *bytes, std::streamsize count) override {
    if (count > size_ - position_) return 0;
    read(position_, bytes, static_cast<std::size_t>(count));
    position_ += count;
    return count;
  }

  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const std::streamoff base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? position_ : size_;
    if (offset < -base || offset > size_ - base) return pos_type(off_type(-1));
    return position_ = base + offset;
  }

  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(position, std::ios_base::beg, mode);
  }

private:
  const std::streamoff size_;
  std::streamoff position_ = 0;
};

class SourceBuffer : public ReadBuffer {
public:
  SourceBuffer(const np_vdb_source &source, Canceller canceller)
      : ReadBuffer(source.size), source_(source), canceller_(canceller) {}

  /* OpenVDB leaks a half-built tree if reading its topology throws: cancellation waits up to this position. */
  void wait_until(std::streamoff position) { waits_until_ = position; }

protected:
  void read(std::streamoff position, char *bytes, std::size_t count) override {
    if (position >= waits_until_) canceller_.poll();
    check_result(source_.read(source_.user, position, bytes, count));
  }

private:
  const np_vdb_source &source_;
  const Canceller canceller_;
  std::streamoff waits_until_ = 0;
};

class MemoryBuffer : public ReadBuffer {
public:
  MemoryBuffer(const void *bytes, std::size_t count)
      : ReadBuffer(static_cast<std::streamoff>(count)), bytes_(static_cast<const char *>(bytes)) {}

protected:
  void read(std::streamoff position, char *bytes, std::size_t count) override {
    std::memcpy(bytes, bytes_ + position, count);
  }

private:
  const char *const bytes_;
};

/* ---- Writing ---- */

class PolledFile : public std::filebuf {
public:
  explicit PolledFile(Canceller canceller) : canceller_(canceller) {}

protected:
  std::streamsize xsputn(const char *bytes, std::streamsize count) override {
    std::streamsize done = 0;
    while (done < count) {
      canceller_.poll();
      const std::streamsize piece = std::min(count - done, piece_bytes);
      const std::streamsize moved = std::filebuf::xsputn(bytes + done, piece);
      done += moved;
      if (moved < piece) break;
    }
    return done;
  }

private:
  static constexpr std::streamsize piece_bytes = std::streamsize(1) << 20;

  const Canceller canceller_;
};

} /* namespace np_vdb */

#endif
