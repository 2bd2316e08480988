/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_ice.h"

#include <string.h>

#include "core/alloc.h"
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

neph_result np_tint_create_ice(neph_context *context, const neph_volume *density, neph_precision precision,
                               np_monitor *monitor, np_tint **out_tint) {
  np_split split = {.context = context,
                    .density = density,
                    .precision = precision,
                    .monitor = monitor,
                    .compute_shares = compute_shares,
                    .user = &split};
  *out_tint = NULL;
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
