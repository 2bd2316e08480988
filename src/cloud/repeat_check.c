/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/repeat_check.h"

#include "cloud/cloud_kinds.h"
#include "cloud/cloud_name.h"
#include "cloud/shape_desc.h"
#include "core/text.h"

const char *np_repeat_search_obstacle(const neph_cloud_desc *desc) {
  const double *wind = desc->wind_m_s;
  if (desc->extent_m[0] != desc->extent_m[1]) return "extent must be square";
  if (desc->center_m[0] != 0 || desc->center_m[1] != 0) return "center must be 0 m, 0 m";
  if (desc->map_file) return "map.image must not be given: a picture does not meet itself at the border";
  if (desc->measurement) return "map.file must not be given: a measured field does not meet itself at the border";
  if (np_cloud_desc_has_shape(desc)) return "shape must not be given: it stands once";
  if (desc->ground_lift > 0 || desc->ground_cover != 0)
    return "ground_lift and ground_cover must be 0: tiles are alike";
  if (desc->precipitation > 0) return "precipitation must be 0";
  if (desc->has_winds && wind[0] != 0 && wind[1] != 0)
    return "wind must blow along x or y beside wind_speed: turn the camera and the sun instead";
  return NULL;
}

static neph_result refuse_kind(neph_context *context, const neph_cloud_desc *desc, const np_cloud_kind *kind) {
  np_text list = {.context = context};
  const np_cloud_kind *other;
  int last = 0;
  for (int i = 0; (other = np_cloud_kind_get((neph_cloud_model)i)); i++) last = other->repeat_obstacle ? last : i;
  for (int i = 0, count = 0; i <= last; i++) {
    other = np_cloud_kind_get((neph_cloud_model)i);
    if (other->repeat_obstacle) continue;
    np_text_add(&list, "%s%s", !count ? "" : i < last ? ", " : " or ", other->name);
    count++;
  }
  if (list.has_failed) return np_text_end(&list, NEPH_OK);
  return np_text_end(&list, np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                                    "%s.repeat is %g m, but model is %s, %s, must be %s; or leave out repeat",
                                    np_cloud_desc_name(desc), desc->repeat_m, kind->name, kind->repeat_obstacle,
                                    np_text_get(&list)));
}

neph_result np_repeat_check(neph_context *context, const neph_cloud_desc *desc) {
  if (!(desc->repeat_m > 0)) return NEPH_OK;
  const char *name = np_cloud_desc_name(desc);
  const np_cloud_kind *kind = np_cloud_kind_get(desc->model);
  if (kind->repeat_obstacle) return refuse_kind(context, desc, kind);
  const char *obstacle = np_repeat_search_obstacle(desc);
  if (!obstacle) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s.repeat is %g m, so that %s; or leave out repeat", name,
                 desc->repeat_m, obstacle);
}
