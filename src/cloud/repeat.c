/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/repeat.h"

#include "cloud/shape.h"
#include "volume/sparse_grid.h"

/* Why a model cannot repeat; NULL: it can. */
static const char *const refusals[] = {
    [NEPH_CLOUD_MODEL_HERO] = "hero, one cloud in the middle",
    [NEPH_CLOUD_MODEL_FOG] = "fog, which follows the ground",
    [NEPH_CLOUD_MODEL_LENSES] = "lenses, which follow mountains",
    [NEPH_CLOUD_MODEL_TRAILS] = "trails, lines across the whole field",
    [NEPH_CLOUD_MODEL_STREAKS] = NULL /* and after it */
};

/* The first thing beside the model that keeps a field from repeating; NULL: none. */
static const char *search_obstacle(const neph_cloud_desc *desc) {
  const double *wind = desc->wind_m_s;
  if (desc->extent_m[0] != desc->extent_m[1]) return "extent must be square";
  if (desc->center_m[0] != 0 || desc->center_m[1] != 0) return "center must be 0 m, 0 m";
  if (desc->map_file) return "map.image must not be given: a picture does not meet itself at the border";
  if (np_cloud_desc_has_shape(desc)) return "shape must not be given: it stands once";
  if (desc->ground_lift > 0 || desc->ground_cover != 0)
    return "ground_lift and ground_cover must be 0: tiles are alike";
  if (desc->precipitation > 0) return "precipitation must be 0";
  if (wind[0] != 0 && wind[1] != 0) return "wind must blow along x or y: turn the camera and the sun instead";
  return NULL;
}

neph_result np_repeat_check(neph_context *context, const neph_cloud_desc *desc) {
  if (!(desc->repeat_m > 0)) return NEPH_OK;
  const char *name = np_cloud_desc_name(desc), *refusal = refusals[desc->model];
  if (refusal)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s.repeat is %g m, but model is %s, must be cells, slab, thermals, deck or streaks; or leave out "
                   "repeat",
                   name, desc->repeat_m, refusal);
  const char *obstacle = search_obstacle(desc);
  if (!obstacle) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.repeat is %g m, so that %s; or leave out repeat", name,
                 desc->repeat_m, obstacle);
}

neph_cloud_desc np_repeat_round(const neph_cloud_desc *desc) {
  neph_cloud_desc rounded = *desc;
  const double leaf_m = NP_LEAF_EDGE * desc->voxel_m;
  if (desc->repeat_m > 0)
    rounded.voxel_m = desc->extent_m[0] / (NP_LEAF_EDGE * np_repeat_count(desc->extent_m[0], leaf_m));
  return rounded;
}
