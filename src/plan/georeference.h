/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds whose files are in the coordinate system of the terrain's raster, as eastings and northings of a zone of UTM:
 * they stand where the raster has these coordinates. */
#ifndef NP_PLAN_GEOREFERENCE_H
#define NP_PLAN_GEOREFERENCE_H

#include "scene/scene_private.h"
#include "volume/volume_private.h"

typedef struct np_georeference {
  bool is_applied;    /* the file is in that system */
  char crs[120];      /* its name */
  np_affine to_world; /* shift of its coordinates, exact at the middle of the cloud's box */
} np_georeference;

/* Decides by the box of a volume, placed by `file_to_world`: it lies far from the world's origin, and within the raster
 * or next to it by the coordinates of its system; clouds with a position depend on that. Where it does, `file_to_world`
 * leads to the world afterwards. */
neph_result np_georeference_apply(const neph_scene *scene, const np_scene_cloud *cloud, const neph_volume *volume,
                                  np_affine *file_to_world, np_georeference *out);

/* Message about an applied georeference, which the caller frees; NULL: no memory. */
char *np_georeference_describe(neph_context *context, const np_georeference *georeference);

#endif
