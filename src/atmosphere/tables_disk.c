/* SPDX-License-Identifier: Apache-2.0 */
/* Disk cache of the tables of atmospheres and skies. Kernels and shells are rebuilt, which takes no time. */
#include "atmosphere/tables_disk.h"

#include <string.h>

#include "core/alloc.h"
#include "core/disk_cache.h"

static const char air_kind[] = "air", sky_kind[] = "sky";

/* ---- Keys ---- */

static void add_layer(np_hash *key, const neph_atmosphere_layer *layer) {
  NP_HASH_ADD(key, layer->profile);
  NP_HASH_ADD(key, layer->bottom_m);
  NP_HASH_ADD(key, layer->top_m);
  NP_HASH_ADD(key, layer->height_m);
  NP_HASH_ADD(key, layer->center_m);
  NP_HASH_ADD(key, layer->width_m);
  NP_HASH_ADD(key, layer->table_rows);
  if (layer->profile == NEPH_LAYER_TABLE) {
    np_hash_add(key, layer->table_altitude_m, layer->table_rows * sizeof *layer->table_altitude_m);
    np_hash_add(key, layer->table_density, layer->table_rows * sizeof *layer->table_density);
  }
  NP_HASH_ADD(key, layer->scattering_per_m);
  NP_HASH_ADD(key, layer->absorption_per_m);
  NP_HASH_ADD(key, layer->phase);
  NP_HASH_ADD(key, layer->asymmetry);
  NP_HASH_ADD(key, layer->second_asymmetry);
  NP_HASH_ADD(key, layer->second_weight);
  NP_HASH_ADD(key, layer->absorber);
}

static void add_air(np_hash *key, const neph_atmosphere *a) {
  NP_HASH_ADD(key, a->desc.planet_radius_m);
  NP_HASH_ADD(key, a->desc.top_altitude_m);
  NP_HASH_ADD(key, a->desc.layer_count);
  NP_HASH_ADD(key, a->desc.ground_albedo);
  NP_HASH_ADD(key, a->desc.tolerance);
  for (unsigned i = 0; i < a->desc.layer_count; i++) add_layer(key, &a->layers[i]);
  NP_HASH_ADD(key, a->sizes);
  NP_HASH_ADD(key, a->has_point_sun);
  NP_HASH_ADD(key, a->order_max);
}

/* False: there is no cache. */
static bool compute_key(const neph_atmosphere *a, const neph_sky *sky, char out_key[33]) {
  if (!np_disk_cache_is_wanted(a->context)) return false;
  np_hash *key = np_hash_create(a->context);
  if (key) {
    np_cache_key_begin(a->context, sky ? sky_kind : air_kind, true, key);
    add_air(key, a);
  }
  if (key && sky) {
    NP_HASH_ADD(key, sky->sun);
    NP_HASH_ADD(key, sky->sun_angular_radius);
    NP_HASH_ADD(key, sky->observer);
    NP_HASH_ADD(key, a->sea.share);
    NP_HASH_ADD(key, a->sea.glint);
    NP_HASH_ADD(key, a->sea.land_albedo);
    NP_HASH_ADD(key, a->sea.water.roughness);
    NP_HASH_ADD(key, a->sea.water.albedo);
    NP_HASH_ADD(key, sky->irradiance);
    NP_HASH_ADD(key, sky->frame.twilight);
  }
  return !np_hash_finish(key, out_key);
}

/* ---- Atmosphere ---- */

static void write_depths(np_cache_entry *entry, const np_depth_table *t) {
  const int32_t size[3] = {t->rows, t->columns, t->levels};
  NP_CACHE_WRITE(entry, size);
  np_cache_write(entry, t->texels, (size_t)t->rows * (size_t)t->columns * sizeof *t->texels);
  np_cache_write(entry, t->level, (size_t)t->levels * sizeof *t->level);
}

static bool read_depths(np_cache_entry *entry, const neph_atmosphere *a, np_depth_table *out) {
  const np_depth_sizes *wanted = &a->sizes.depth;
  int32_t size[3];
  const bool has_size =
      NP_CACHE_READ(entry, size) && size[0] == wanted->rows && size[1] == wanted->columns && size[2] == wanted->levels;
  if (!np_cache_read_check(entry, has_size)) return false;
  *out = (np_depth_table){.medium = &a->medium, .rows = size[0], .columns = size[1], .levels = size[2]};
  out->texels = np_cache_read_block(entry, (size_t)size[0] * (size_t)size[1], sizeof *out->texels);
  out->level = np_cache_read_block(entry, (size_t)size[2], sizeof *out->level);
  return out->texels && out->level;
}

static size_t count_texels(const np_moment_table *t) { return (size_t)t->rows * (size_t)t->sun.columns; }

static size_t count_moments(const np_moment_table *t) { return NP_MOMENT_COUNT * count_texels(t); }

/* An absent table has no rows. */
static void write_moments(np_cache_entry *entry, const np_moment_table *t) {
  const int32_t rows = t->moments ? t->rows : 0;
  NP_CACHE_WRITE(entry, rows);
  if (!rows) return;
  NP_CACHE_WRITE(entry, t->sun);
  np_cache_write(entry, t->moments, count_moments(t) * sizeof *t->moments);
  np_cache_write(entry, t->irradiance, count_texels(t) * sizeof *t->irradiance);
}

static bool read_moments(np_cache_entry *entry, const neph_atmosphere *a, bool is_wanted, np_moment_table *out) {
  const np_moment_sizes *wanted = &a->sizes.moments;
  const np_sun_scale sun = np_sun_scale_make(&a->medium, wanted->columns);
  int32_t rows;
  const bool has_rows = NP_CACHE_READ(entry, rows) && rows == (is_wanted ? wanted->rows : 0);
  if (!np_cache_read_check(entry, has_rows) || !is_wanted) return has_rows;
  *out = (np_moment_table){.medium = &a->medium, .rows = rows};
  const bool has_sun = NP_CACHE_READ(entry, out->sun) && !memcmp(&out->sun, &sun, sizeof sun);
  if (!np_cache_read_check(entry, has_sun)) return false;
  out->moments = np_cache_read_block(entry, count_moments(out), sizeof *out->moments);
  out->irradiance = np_cache_read_block(entry, count_texels(out), sizeof *out->irradiance);
  return out->moments && out->irradiance;
}

void np_atmosphere_save_tables(const neph_atmosphere *a) {
  char key[33];
  np_cache_entry entry;
  if (!compute_key(a, NULL, key)) return;
  np_cache_write_begin(a->context, air_kind, key, &entry);
  write_depths(&entry, &a->depths);
  write_moments(&entry, &a->moments);
  write_moments(&entry, &a->dome_moments);
  np_cache_write_commit(&entry);
}

bool np_atmosphere_load_tables(neph_atmosphere *a) {
  char key[33];
  np_cache_entry entry;
  if (!compute_key(a, NULL, key) || !np_cache_read_begin(a->context, air_kind, key, &entry)) return false;
  const bool has_dome = a->order_max != NP_ORDERS_ALL && a->order_max > 2;
  const bool has_all = read_depths(&entry, a, &a->depths) && read_moments(&entry, a, a->order_max > 1, &a->moments) &&
                       read_moments(&entry, a, has_dome, &a->dome_moments);
  if (np_cache_read_end(&entry) && has_all) return true;
  np_moment_table_free(a->context, &a->moments);
  np_moment_table_free(a->context, &a->dome_moments);
  np_depth_table_free(a->context, &a->depths);
  a->moments = a->dome_moments = (np_moment_table){0};
  a->depths = (np_depth_table){0};
  return false;
}

/* ---- Sky ---- */

/* Blocks of memory of a sky whose tables are allocated; a dark one has fewer. */
typedef struct sky_block {
  void *bytes;
  size_t size;
} sky_block;

static void list_blocks(neph_sky *sky, sky_block out[6]) {
  const np_view_sizes *view = &sky->atmosphere->sizes.view, *aerial = &sky->atmosphere->sizes.aerial;
  const size_t slices = (size_t)(aerial->up + aerial->down) * (size_t)aerial->points;
  const size_t cells = slices * (size_t)aerial->azimuths;
  const size_t rays = (size_t)(view->up + view->down) * (size_t)view->azimuths;
  out[0] = (sky_block){sky->depth, slices * sizeof *sky->depth};
  out[1] = (sky_block){sky->view, sky->view ? rays * sizeof *sky->view : 0};
  out[2] = (sky_block){sky->aerial, sky->aerial ? cells * sizeof *sky->aerial : 0};
  out[3] = (sky_block){sky->molecules, sky->molecules ? cells * sizeof *sky->molecules : 0};
  out[4] = (sky_block){sky->gather.sun_cosine, sizeof sky->gather.sun_cosine};
  out[5] = (sky_block){sky->gather.source, sky->gather.sun_count ? sizeof sky->gather.source : 0};
}

void np_sky_save_tables(neph_sky *sky) {
  char key[33];
  np_cache_entry entry;
  sky_block blocks[6];
  if (!compute_key(sky->atmosphere, sky, key)) return;
  np_cache_write_begin(sky->atmosphere->context, sky_kind, key, &entry);
  NP_CACHE_WRITE(&entry, sky->gather.sun_count);
  list_blocks(sky, blocks);
  for (int i = 0; i < 6; i++) np_cache_write(&entry, blocks[i].bytes, blocks[i].size);
  np_cache_write_commit(&entry);
}

/* Whether the number of suns of a gather, if there is one, is valid. */
static bool has_sun_count(const neph_sky *sky) {
  const int count = sky->gather.sun_count;
  if (!sky->view || !np_sky_has_gather(sky->atmosphere)) return count == 0;
  return count >= 2 && count <= NP_GATHER_SUNS_MAX;
}

bool np_sky_load_tables(neph_sky *sky) {
  char key[33];
  np_cache_entry entry;
  sky_block blocks[6];
  neph_context *context = sky->atmosphere->context;
  if (!compute_key(sky->atmosphere, sky, key) || !np_cache_read_begin(context, sky_kind, key, &entry)) return false;
  bool has_all = NP_CACHE_READ(&entry, sky->gather.sun_count);
  has_all = np_cache_read_check(&entry, has_all && has_sun_count(sky));
  list_blocks(sky, blocks);
  for (int i = 0; i < 6 && has_all; i++) has_all = np_cache_read(&entry, blocks[i].bytes, blocks[i].size);
  const bool is_loaded = np_cache_read_end(&entry) && has_all;
  if (!is_loaded) sky->gather.sun_count = 0;
  if (sky->gather.sun_count) sky->gather.kernel = &sky->atmosphere->kernel;
  return is_loaded;
}
