/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/cloud_kinds.h"

static const np_cloud_kind *const kinds[] = {
    [NEPH_CLOUD_MODEL_CELLS] = &np_cells_kind,    [NEPH_CLOUD_MODEL_SLAB] = &np_slab_kind,
    [NEPH_CLOUD_MODEL_HERO] = &np_hero_kind,      [NEPH_CLOUD_MODEL_THERMALS] = &np_thermals_kind,
    [NEPH_CLOUD_MODEL_FOG] = &np_fog_kind,        [NEPH_CLOUD_MODEL_LENSES] = &np_lenses_kind,
    [NEPH_CLOUD_MODEL_TRAILS] = &np_trails_kind,  [NEPH_CLOUD_MODEL_DECK] = &np_deck_kind,
    [NEPH_CLOUD_MODEL_STREAKS] = &np_streaks_kind};

const np_cloud_kind *np_cloud_kind_get(neph_cloud_model model) {
  return (unsigned)model < sizeof kinds / sizeof *kinds ? kinds[model] : NULL;
}
