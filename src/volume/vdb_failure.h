/* SPDX-License-Identifier: Apache-2.0 */
/* Results and messages for exceptions from OpenVDB. Part of vdb_shim.cpp. */
#ifndef NP_VOLUME_VDB_FAILURE_H
#define NP_VOLUME_VDB_FAILURE_H

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>

#include <openvdb/Exceptions.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/text_copy.h"
#include "volume/vdb_streams.h"

namespace np_vdb {

inline void check_room(const void *block) {
  if (!block) throw AlreadyReported{NEPH_ERROR_OUT_OF_MEMORY};
}

inline neph_result report(np_vdb_error *error, neph_result result, const char *format, const char *text) noexcept {
  error->result = result;
  const int length = std::snprintf(error->message, sizeof error->message, format, text);
  if (length >= (int)sizeof error->message) np_text_end_short(error->message, sizeof error->message);
  return result;
}

enum class Direction { reading, writing };

inline neph_result report_stream(np_vdb_error *error, Direction direction) noexcept {
  if (direction == Direction::writing)
    return report(error, NEPH_ERROR_IO, "cannot write: %s", errno ? std::strerror(errno) : "the stream failed");
  return report(error, NEPH_ERROR_BAD_FILE, "%s", "the file ends before its data does: it is truncated or damaged");
}

/* Runs `work` on at most `thread_count` threads and turns exceptions into a result and a message. TBB starts threads at
 * any time and ends the process if it cannot; an arena of one thread starts none. TBB prints a warning if an arena is
 * wider than the number of processors. */
template <typename Work>
neph_result guarded(np_vdb_error *error, Direction direction, unsigned thread_count, const Work &work) noexcept {
  try {
    tbb::task_arena arena(std::min(static_cast<int>(thread_count), tbb::info::default_concurrency()));
    arena.execute(work);
    error->result = NEPH_OK;
    error->message[0] = 0;
    return NEPH_OK;
  } catch (const Cancelled &) {
    return report(error, NEPH_ERROR_CANCELLED, "%s", "cancelled");
  } catch (const AlreadyReported &told) {
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

/* Runs on the calling thread alone. */
template <typename Work> neph_result guarded(np_vdb_error *error, Direction direction, const Work &work) noexcept {
  return guarded(error, direction, 1, work);
}

/* Leaves of a piece, which one thread reads, builds or compresses: half a megabyte of floats. */
constexpr std::size_t piece_leaves = 256;

/* Calls `work` with [begin, end) for pieces of `grain` of `count` items, on the threads that `guarded` allows. The
 * count of pieces orders memory as TBB does, in sight of thread sanitizers, which do not see into TBB. */
template <typename Work> void run_pieces(std::size_t count, std::size_t grain, const Work &work) {
  std::atomic<std::size_t> done;
  done.store(0, std::memory_order_release);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, grain),
      [&](const tbb::blocked_range<std::size_t> &piece) {
        (void)done.load(std::memory_order_acquire);
        work(piece.begin(), piece.end());
        done.fetch_add(1, std::memory_order_release);
      },
      tbb::simple_partitioner());
  (void)done.load(std::memory_order_acquire);
}

} /* namespace np_vdb */

#endif
