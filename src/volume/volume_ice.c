/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_ice.h"

#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "volume/volume_split.h"

enum { DROPLETS, CRYSTALS, PARTS };

float np_ice_compute_share(double altitude_m) {
  return np_clampf((float)((altitude_m - NP_ICE_FROM_M) / (NP_ICE_ALONE_M - NP_ICE_FROM_M)), 0.0f, 1.0f);
}

static void compute_shares(const void *user, size_t block, int n, float out[NP_TINT_PARTS_MAX]) {
  const np_split *split = user;
  const np_dvec3 at = np_affine_point(&split->density->index_to_world, np_split_get_index(split, block, n));
  memset(out, 0, NP_TINT_PARTS_MAX * sizeof *out);
  out[CRYSTALS] = np_ice_compute_share(at.z);
  out[DROPLETS] = 1.0f - out[CRYSTALS];
}

/* A cloud of crystals alone is its own single part. */
static neph_result build_parts(const np_split *split, np_tint *out) {
  neph_volume *volumes[PARTS] = {NULL, NULL};
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < PARTS && !result; k++) result = np_split_make_part(split, k, &volumes[k]);
  for (unsigned k = 0; k < PARTS; k++) {
    if (!volumes[k]) continue;
    const bool is_ice = k == CRYSTALS;
    out->parts[out->count++] = (np_tint_part){.volume = volumes[k], .color = {1.0, 1.0, 1.0}, .is_ice = is_ice};
  }
  return result;
}

/* False, with a warning, if a volume has too many blocks: its cloud keeps droplets alone. */
static bool can_split(const neph_volume *volume, const char *name) {
  const size_t blocks = np_bricks_list_cells(&volume->bricks, NULL);
  if (blocks <= NP_SPLIT_BLOCKS_MAX) return true;
  np_log(volume->context, NEPH_LOG_WARNING,
         "bake: %zu blocks of 8³ voxels of %s are not empty, must be at most %d for ice: all of it is of droplets; "
         "enlarge voxel, or set phase to {droplets: {}}",
         blocks, name, (int)NP_SPLIT_BLOCKS_MAX);
  return false;
}

neph_result np_tint_create_ice(neph_context *context, const neph_volume *density, neph_precision precision,
                               np_monitor *monitor, np_tint **out_tint) {
  np_split split = {.context = context,
                    .density = density,
                    .precision = precision,
                    .monitor = monitor,
                    .compute_shares = compute_shares,
                    .user = &split};
  *out_tint = NULL;
  if (!can_split(density, "the cloud")) return NEPH_OK;
  np_tint *tint = np_alloc(context, 1, sizeof *tint);
  if (!tint) return NEPH_ERROR_OUT_OF_MEMORY;
  tint->context = context;
  tint->kind = NP_PARTS_OF_SIZES;
  neph_result result = np_split_start(&split, "bake", "phase.droplets");
  if (!result) result = build_parts(&split, tint);
  np_split_clear(&split);
  if (!result && tint->count > 0 && tint->parts[tint->count - 1].is_ice)
    *out_tint = tint;
  else
    np_tint_destroy(tint);
  return result;
}

/* ---- Levels of detail ---- */

/* The level keeps its box, which encloses its parts. */
static void take_bricks(neph_volume *level, neph_volume *part) {
  const np_bricks whole = level->bricks;
  level->bricks = part->bricks;
  part->bricks = whole;
  neph_volume_release(part);
}

/* Splits a level; its crystals are appended if it has droplets too. */
static neph_result split_level(neph_volume *volume, unsigned k, neph_precision precision, np_monitor *monitor) {
  np_tint *tint = volume->tint;
  neph_volume *level = k > 0 ? tint->parts[k].volume : volume, *parts[PARTS] = {NULL, NULL};
  np_split split = {.context = volume->context,
                    .density = level,
                    .precision = precision,
                    .monitor = monitor,
                    .is_level = true,
                    .compute_shares = compute_shares,
                    .user = &split};
  neph_result result = np_split_start(&split, "bake", "phase.droplets");
  if (!result) result = np_split_make_part(&split, CRYSTALS, &parts[CRYSTALS]);
  if (!result && parts[CRYSTALS]) result = np_split_make_part(&split, DROPLETS, &parts[DROPLETS]);
  np_split_clear(&split);
  const bool is_mixed = parts[DROPLETS] && parts[CRYSTALS];
  if (!result && is_mixed) {
    take_bricks(level, parts[DROPLETS]);
    tint->parts[tint->count++] = (np_tint_part){.volume = parts[CRYSTALS], .color = {1.0, 1.0, 1.0}, .is_ice = true};
    return NEPH_OK;
  }
  if (!result && parts[CRYSTALS]) tint->parts[k].is_ice = true;
  for (int p = 0; p < PARTS; p++) neph_volume_release(parts[p]);
  return result;
}

static bool can_split_levels(const neph_volume *volume) {
  char name[32];
  for (unsigned k = 0; k < volume->tint->count; k++) {
    np_print(name, sizeof name, "level %u", k);
    if (!can_split(np_volume_get_part(volume, k), name)) return false;
  }
  return true;
}

neph_result np_volume_split_ice(neph_volume *volume, neph_precision precision, np_monitor *monitor) {
  const unsigned count = volume->tint->count;
  for (unsigned k = 0; k < count; k++)
    if (volume->tint->parts[k].is_ice) return NEPH_OK; /* a cache returned split levels */
  if (!can_split_levels(volume)) return NEPH_OK;
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < count && volume->tint->count < NP_TINT_PARTS_MAX && !result; k++)
    result = split_level(volume, k, precision, monitor);
  return result;
}
