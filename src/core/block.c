/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of memory without a message, which the log needs as well. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "core/alloc.h"

enum { ALIGNMENT = 64, HUGE_BYTES_MIN = 8 << 20 };

/* Header in the 64 bytes before each block. */
typedef struct block_header {
  void *raw;          /* pointer from the allocator */
  size_t raw_bytes;   /* size requested from the allocator */
  size_t block_bytes; /* usable bytes of the block */
} block_header;

_Static_assert(sizeof(block_header) <= ALIGNMENT, "the header must fit before an aligned block");

static block_header *get_header(void *block) { return (block_header *)((char *)block - ALIGNMENT); }

static void *align_block(void *raw) {
  uintptr_t first = (uintptr_t)raw + ALIGNMENT;
  return (char *)raw + (((first + ALIGNMENT - 1) & ~(uintptr_t)(ALIGNMENT - 1)) - (uintptr_t)raw);
}

static void count_bytes(neph_context *context, size_t added, size_t removed) {
  size_t bytes = atomic_fetch_add(&context->allocated_bytes, added - removed) + (added - removed);
  size_t peak = atomic_load(&context->allocated_bytes_peak);
  while (bytes > peak && !atomic_compare_exchange_weak(&context->allocated_bytes_peak, &peak, bytes)) continue;
}

/* Bytes to request from the allocator, or 0 when no size_t holds them. */
static size_t compute_raw_bytes(size_t count, size_t size, size_t *out_block_bytes) {
  size_t raw_bytes;
  if (__builtin_mul_overflow(count, size, out_block_bytes)) return 0;
  if (__builtin_add_overflow(*out_block_bytes, (size_t)(2 * ALIGNMENT), &raw_bytes)) return 0;
  return raw_bytes <= PTRDIFF_MAX ? raw_bytes : 0;
}

/* Enables huge pages for a block that fills many: its first touch then costs a fault for 2 MiB instead of 4 KiB. */
static void advise_huge(void *raw, size_t bytes) {
#if defined(MADV_HUGEPAGE)
  const uintptr_t page = (uintptr_t)2 << 20, first = ((uintptr_t)raw + page - 1) & ~(page - 1);
  const uintptr_t end = ((uintptr_t)raw + bytes) & ~(page - 1);
  if (raw && bytes >= HUGE_BYTES_MIN) (void)madvise((char *)raw + (first - (uintptr_t)raw), end - first, MADV_HUGEPAGE);
#else
  (void)raw, (void)bytes;
#endif
}

/* Zeroed memory from the allocator. calloc takes large blocks from the kernel, which zeroes pages only at their first
 * touch. */
static void *allocate_raw(neph_context *context, size_t bytes) {
  if (!context->reallocate) {
    void *raw = calloc(1, bytes);
    advise_huge(raw, bytes);
    return raw;
  }
  void *raw = context->reallocate(context->reallocate_user, NULL, 0, bytes);
  if (raw) memset(raw, 0, bytes);
  return raw;
}

static void *reallocate_raw(neph_context *context, void *raw, size_t old_bytes, size_t new_bytes) {
  if (!context->reallocate) return realloc(raw, new_bytes);
  return context->reallocate(context->reallocate_user, raw, old_bytes, new_bytes);
}

void *np_alloc_quietly(neph_context *context, size_t count, size_t size) {
  size_t block_bytes, raw_bytes = compute_raw_bytes(count, size, &block_bytes);
  void *raw = raw_bytes ? allocate_raw(context, raw_bytes) : NULL;
  if (!raw) return NULL;
  void *block = align_block(raw);
  *get_header(block) = (block_header){raw, raw_bytes, block_bytes};
  count_bytes(context, raw_bytes, 0);
  return block;
}

void *np_alloc_resize_quietly(neph_context *context, void *block, size_t count, size_t size) {
  if (!block) return np_alloc_quietly(context, count, size);
  const block_header old = *get_header(block);
  const ptrdiff_t old_offset = (char *)block - (char *)old.raw;
  size_t block_bytes, raw_bytes = compute_raw_bytes(count, size, &block_bytes);
  void *raw = raw_bytes ? reallocate_raw(context, old.raw, old.raw_bytes, raw_bytes) : NULL;
  if (!raw) return NULL;
  char *moved = align_block(raw);
  const size_t kept = block_bytes < old.block_bytes ? block_bytes : old.block_bytes;
  /* The new address may have another offset from the alignment. */
  if (moved - (char *)raw != old_offset) memmove(moved, (char *)raw + old_offset, kept);
  memset(moved + kept, 0, block_bytes - kept);
  *get_header(moved) = (block_header){raw, raw_bytes, block_bytes};
  count_bytes(context, raw_bytes, old.raw_bytes);
  return moved;
}

void np_alloc_free(neph_context *context, void *block) {
  if (!block) return;
  const block_header header = *get_header(block);
  /* The count comes first, since the block may be the context itself. */
  count_bytes(context, 0, header.raw_bytes);
  if (!context->reallocate)
    free(header.raw);
  else
    context->reallocate(context->reallocate_user, header.raw, header.raw_bytes, 0);
}

void np_alloc_discard(neph_context *context, void *begin, size_t bytes) {
#if defined(MADV_DONTNEED)
  const size_t page = (size_t)sysconf(_SC_PAGESIZE), lead = (page - (uintptr_t)begin % page) % page;
  if (context->reallocate || bytes < lead + page) return;
  (void)madvise((char *)begin + lead, (bytes - lead) / page * page, MADV_DONTNEED);
#else
  (void)context, (void)begin, (void)bytes;
#endif
}
