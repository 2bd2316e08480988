/* SPDX-License-Identifier: Apache-2.0 */
/* Sun optical depths on disk: cells and their nodes, column by column. */
#include "caches/sun_optical_depth.h"
#include "core/alloc.h"

/* All members but the lattices. */
typedef struct depths_header {
  uint64_t bytes, level_cells[NP_SUN_CELL_LEVELS], steep_cells, dark_cells;
  uint32_t volume_count;
  float depth_end;
} depths_header;

/* A lattice without its cells and nodes. */
typedef struct lattice_header {
  np_affine world_to_lattice, lattice_to_world;
  double spacing_m;
  int32_t size[3], padding;
} lattice_header;

/* Whether maps are finite, and a lattice has no more cells than an entry can hold. */
static bool is_sound(const lattice_header *h) {
  return np_cache_are_doubles_finite(&h->world_to_lattice.m[0][0], 12) &&
         np_cache_are_doubles_finite(&h->lattice_to_world.m[0][0], 12) && isfinite(h->spacing_m) &&
         h->spacing_m > 0.0 && np_cache_count_cells(h->size) > 0;
}

static size_t count_columns(const np_sun_lattice *l) { return (size_t)l->size[0] * (size_t)l->size[1]; }

/* Number of nodes in a column, up to the last node of its cells. */
static size_t count_column_nodes(const np_sun_lattice *l, size_t column) {
  const uint32_t *cells = l->cells + column * (size_t)l->size[2];
  size_t count = 0;
  for (int32_t k = 0; k < l->size[2]; k++) {
    if (!np_sun_cell_keeps(cells[k])) continue;
    const uint32_t level = np_sun_cell_get_level(cells[k]);
    const size_t end = (cells[k] >> NP_SUN_CELL_LEVEL_BITS) + np_sun_level_count_nodes(level);
    if (level < NP_SUN_CELL_LEVELS && end > count) count = end;
  }
  return count;
}

static void save_lattice(const np_sun_lattice *l, np_cache_entry *entry) {
  lattice_header h = {
      .world_to_lattice = l->world_to_lattice, .lattice_to_world = l->lattice_to_world, .spacing_m = l->spacing_m};
  for (int a = 0; a < 3; a++) h.size[a] = l->size[a];
  NP_CACHE_WRITE(entry, h);
  if (!l->nodes) return;
  np_cache_write(entry, l->cells, count_columns(l) * (size_t)l->size[2] * sizeof *l->cells);
  for (size_t n = 0; n < count_columns(l); n++)
    if (l->nodes[n]) np_cache_write(entry, l->nodes[n], count_column_nodes(l, n) * sizeof **l->nodes);
}

void np_sun_optical_depth_save(const np_sun_optical_depth *cache, np_cache_entry *entry) {
  depths_header h = {.bytes = cache->bytes,
                     .steep_cells = cache->steep_cells,
                     .dark_cells = cache->dark_cells,
                     .volume_count = cache->volume_count,
                     .depth_end = cache->depth_end};
  for (unsigned level = 0; level < NP_SUN_CELL_LEVELS; level++) h.level_cells[level] = cache->level_cells[level];
  NP_CACHE_WRITE(entry, h);
  for (unsigned v = 0; v < cache->volume_count; v++) save_lattice(&cache->lattices[v], entry);
}

/* Whether all cells with nodes have a valid level. */
static bool are_levels_known(const uint32_t *cells, size_t count) {
  uint32_t highest = 0;
  for (size_t i = 0; i < count; i++) {
    const uint32_t level = np_sun_cell_keeps(cells[i]) ? np_sun_cell_get_level(cells[i]) : 0;
    highest = level > highest ? level : highest;
  }
  return highest < NP_SUN_CELL_LEVELS;
}

static bool load_columns(neph_context *context, np_cache_entry *entry, np_sun_lattice *l) {
  const size_t columns = count_columns(l), cells = columns * (size_t)l->size[2];
  l->cells = np_cache_read_block(entry, cells, sizeof *l->cells);
  if (!l->cells || !np_cache_read_check(entry, are_levels_known(l->cells, cells))) return false;
  l->nodes = np_alloc(context, columns, sizeof *l->nodes);
  if (!l->nodes) return false;
  size_t all = 0;
  for (size_t n = 0; n < columns; n++) all += count_column_nodes(l, n);
  uint16_t *next = l->all_nodes = np_cache_read_halves(entry, all);
  for (size_t n = 0; n < columns && next; n++) {
    const size_t count = count_column_nodes(l, n);
    l->nodes[n] = count > 0 ? next : NULL;
    next += count;
  }
  return next;
}

static bool load_lattice(neph_context *context, np_cache_entry *entry, np_sun_lattice *l) {
  lattice_header h;
  if (!NP_CACHE_READ(entry, h)) return false;
  l->world_to_lattice = h.world_to_lattice, l->lattice_to_world = h.lattice_to_world;
  l->spacing_m = h.spacing_m;
  for (int a = 0; a < 3; a++) l->size[a] = h.size[a];
  if (h.size[0] == 0) return true;
  return np_cache_read_check(entry, is_sound(&h)) && load_columns(context, entry, l);
}

static bool load_lattices(np_cache_entry *entry, np_sun_optical_depth *out) {
  for (unsigned v = 0; v < out->volume_count; v++)
    if (!load_lattice(out->context, entry, &out->lattices[v])) return false;
  return true;
}

bool np_sun_optical_depth_load(neph_context *context, const np_world *world, np_cache_entry *entry,
                               np_sun_optical_depth *out) {
  depths_header h;
  unsigned count = world->clouds.count;
  *out = (np_sun_optical_depth){.context = context};
  const bool is_known = !world->clouds.places || !np_sun_places_choose(world, out, &count);
  const bool is_read = is_known && NP_CACHE_READ(entry, h);
  if (!is_read || !np_cache_read_check(entry, h.volume_count == count && h.depth_end > 0.0f && isfinite(h.depth_end))) {
    np_sun_optical_depth_clear(out);
    return false;
  }
  out->depth_end = h.depth_end;
  out->bytes = (size_t)h.bytes, out->steep_cells = h.steep_cells, out->dark_cells = h.dark_cells;
  for (unsigned level = 0; level < NP_SUN_CELL_LEVELS; level++) out->level_cells[level] = h.level_cells[level];
  out->lattices = np_alloc(context, h.volume_count, sizeof *out->lattices);
  out->volume_count = out->lattices ? h.volume_count : 0;
  if (out->lattices && load_lattices(entry, out)) return true;
  np_sun_optical_depth_clear(out);
  return false;
}
