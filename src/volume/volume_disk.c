/* SPDX-License-Identifier: Apache-2.0 */
/* Cache entries of volumes: the bricks as they are in memory. */
#include "core/alloc.h"
#include "core/disk_cache.h"
#include "core/text.h"
#include "volume/bricks_check.h"
#include "volume/volume_private.h"
#include "volume/volume_tint.h"

/* Header of an entry: everything but the blocks of memory. */
typedef struct volume_header {
  np_affine index_to_world, world_to_index;
  int32_t active_min[3], active_max[3];
  int32_t origin[3], size[3], lead[3], table_size[3], period[2], reach_low[3], reach_high[3];
  float value_min, value_max, scale, background, bound;
  uint32_t is_half, is_periodic[2];
  uint64_t active_voxel_count, grid_bytes, brick_count, node_count;
  char name[64];
} volume_header;

static void save(const neph_volume *volume, np_cache_entry *entry) {
  const np_bricks *b = &volume->bricks;
  volume_header h;
  memset(&h, 0, sizeof h); /* zeroes the padding: equal volumes give equal files */
  h.index_to_world = volume->index_to_world, h.world_to_index = volume->world_to_index;
  memcpy(h.active_min, volume->active_min, sizeof h.active_min);
  memcpy(h.active_max, volume->active_max, sizeof h.active_max);
  memcpy(h.origin, b->origin, sizeof h.origin);
  memcpy(h.size, b->size, sizeof h.size);
  memcpy(h.lead, b->lead, sizeof h.lead);
  memcpy(h.table_size, b->table_size, sizeof h.table_size);
  memcpy(h.period, b->period, sizeof h.period);
  memcpy(h.reach_low, b->reach_low, sizeof h.reach_low);
  memcpy(h.reach_high, b->reach_high, sizeof h.reach_high);
  h.value_min = volume->value_min, h.value_max = volume->value_max;
  h.scale = b->scale, h.background = b->background, h.bound = b->value_max;
  h.is_half = b->halves != NULL;
  for (int a = 0; a < 2; a++) h.is_periodic[a] = b->is_periodic[a];
  h.active_voxel_count = volume->active_voxel_count, h.grid_bytes = volume->grid_bytes;
  h.brick_count = b->brick_count, h.node_count = b->node_count;
  np_print(h.name, sizeof h.name, "%s", volume->name);
  NP_CACHE_WRITE(entry, h);
  const size_t entries = np_bricks_count_table(b);
  np_cache_write(entry, b->table, entries * sizeof *b->table);
  np_cache_write(entry, b->table_ranges, entries * sizeof *b->table_ranges);
  np_cache_write(entry, b->nodes, b->node_count * sizeof *b->nodes);
  const size_t samples = b->brick_count * NP_BRICK_STRIDE;
  if (b->halves) np_cache_write(entry, b->halves, samples * sizeof *b->halves);
  if (b->floats) np_cache_write(entry, b->floats, samples * sizeof *b->floats);
}

/* Saves a volume, then its levels of detail. */
void np_volume_save_to_cache(const neph_volume *volume, np_cache_entry *entry) {
  const np_tint *levels = np_volume_has_shares(volume) ? NULL : volume->tint; /* shares are split again */
  const uint32_t level_count = levels ? levels->count : 1;
  const uint32_t kind = levels ? levels->kind : NP_PARTS_OF_CELLS;
  uint32_t ice = 0; /* one bit for each level of crystals */
  for (uint32_t k = 0; levels && k < level_count; k++) ice |= (uint32_t)levels->parts[k].is_ice << k;
  save(volume, entry);
  NP_CACHE_WRITE(entry, level_count);
  NP_CACHE_WRITE(entry, kind);
  NP_CACHE_WRITE(entry, ice);
  for (uint32_t k = 1; k < level_count; k++) save(levels->parts[k].volume, entry);
}

static void unpack_header(const volume_header *h, neph_volume *volume) {
  np_bricks *b = &volume->bricks;
  volume->index_to_world = h->index_to_world, volume->world_to_index = h->world_to_index;
  memcpy(volume->active_min, h->active_min, sizeof h->active_min);
  memcpy(volume->active_max, h->active_max, sizeof h->active_max);
  memcpy(b->origin, h->origin, sizeof h->origin);
  memcpy(b->size, h->size, sizeof h->size);
  memcpy(b->lead, h->lead, sizeof h->lead);
  memcpy(b->table_size, h->table_size, sizeof h->table_size);
  memcpy(b->period, h->period, sizeof h->period);
  memcpy(b->reach_low, h->reach_low, sizeof h->reach_low);
  memcpy(b->reach_high, h->reach_high, sizeof h->reach_high);
  volume->value_min = h->value_min, volume->value_max = h->value_max;
  b->scale = h->scale, b->background = h->background, b->value_max = h->bound;
  for (int a = 0; a < 2; a++) b->is_periodic[a] = h->is_periodic[a];
  volume->active_voxel_count = h->active_voxel_count, volume->grid_bytes = h->grid_bytes;
  b->brick_count = (size_t)h->brick_count, b->node_count = (size_t)h->node_count;
}

/* Whether a volume's voxels are within its bricks. The box of a volume with levels encloses them all. */
static bool is_box_inside(const neph_volume *volume) {
  const np_bricks *b = &volume->bricks;
  for (int a = 0; a < 3; a++) {
    const int64_t low = (int64_t)b->origin[a] * NP_BRICK_EDGE, high = low + (int64_t)b->size[a] * NP_BRICK_EDGE;
    const bool is_inside =
        volume->active_min[a] >= low && volume->active_min[a] <= volume->active_max[a] && volume->active_max[a] < high;
    if (!is_inside && volume->active_voxel_count > 0) return false;
  }
  return true;
}

/* Whether a loaded volume is consistent: both transforms agree. */
static bool is_sound(const neph_volume *volume) {
  np_affine inverse;
  if (!np_affine_invert(&volume->index_to_world, &inverse)) return false;
  if (memcmp(&inverse, &volume->world_to_index, sizeof inverse) != 0) return false;
  if (!np_bricks_check_shape(&volume->bricks)) return false;
  const float values[] = {volume->value_min, volume->value_max};
  return np_cache_are_finite(values, 2);
}

static bool load_blocks(const volume_header *h, np_cache_entry *entry, np_bricks *b) {
  const size_t entries = np_bricks_count_table(b);
  b->table = np_cache_read_block(entry, entries, sizeof *b->table);
  if (b->table) b->table_ranges = np_cache_read_block(entry, entries, sizeof *b->table_ranges);
  if (b->table_ranges) b->nodes = np_cache_read_block(entry, b->node_count, sizeof *b->nodes);
  if (!b->nodes) return false;
  const size_t samples = b->brick_count * NP_BRICK_STRIDE;
  if (h->is_half)
    b->halves = np_cache_read_halves(entry, samples);
  else
    b->floats = np_cache_read_floats(entry, samples);
  return (b->halves || b->floats) && np_cache_read_check(entry, np_bricks_check_content(b));
}

static neph_result load(neph_context *context, np_cache_entry *entry, neph_volume **out_volume) {
  volume_header h;
  *out_volume = NULL;
  if (!NP_CACHE_READ(entry, h)) return NEPH_OK;
  neph_volume *volume = np_alloc(context, 1, sizeof *volume);
  if (!volume) return NEPH_ERROR_OUT_OF_MEMORY;
  np_context_retain(context);
  atomic_init(&volume->references, 1);
  volume->context = volume->bricks.context = context;
  volume->name = np_alloc_printf(context, "%.64s", h.name);
  unpack_header(&h, volume);
  const bool has_all =
      volume->name && np_cache_read_check(entry, is_sound(volume)) && load_blocks(&h, entry, &volume->bricks);
  if (has_all)
    *out_volume = volume;
  else
    neph_volume_release(volume);
  return NEPH_OK;
}

static neph_result load_levels(np_cache_entry *entry, np_volume_parts kind, uint32_t count, uint32_t ice,
                               neph_volume *volume, bool *out_has_all) {
  neph_result result = np_tint_create_levels(volume->context, kind, &volume->tint);
  *out_has_all = true;
  for (uint32_t k = 1; k < count && !result && *out_has_all; k++) {
    neph_volume *level;
    result = load(volume->context, entry, &level);
    *out_has_all = level != NULL;
    if (level) np_tint_add_level(volume->tint, level);
  }
  for (uint32_t k = 0; k < count && !result; k++) volume->tint->parts[k].is_ice = ice >> k & 1;
  return result;
}

neph_result np_volume_load_from_cache(neph_context *context, np_cache_entry *entry, neph_volume **out_volume) {
  uint32_t level_count = 0, kind = 0, ice = 0;
  neph_result result = load(context, entry, out_volume);
  if (result || !*out_volume) return result;
  bool has_all = NP_CACHE_READ(entry, level_count) && NP_CACHE_READ(entry, kind) && NP_CACHE_READ(entry, ice) &&
                 np_cache_read_check(entry, level_count >= 1 && level_count <= NP_TINT_PARTS_MAX &&
                                                (kind == NP_PARTS_OF_CELLS || kind == NP_PARTS_OF_COPIES));
  has_all = has_all && np_cache_read_check(entry, level_count > 1 || is_box_inside(*out_volume));
  if (has_all && level_count > 1)
    result = load_levels(entry, (np_volume_parts)kind, level_count, ice, *out_volume, &has_all);
  if (!result && has_all) return NEPH_OK;
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return result;
}
