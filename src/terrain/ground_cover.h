/* SPDX-License-Identifier: Apache-2.0 */
/* Albedo of a terrain from place to place: a picture over the field or land cover by climate, rock where it is steep,
 * snow where it is high.
 *
 * Values are those of a scene's lists of three, in its reference bands: R, G and B of a picture as well. Rock replaces
 * the picture (or the one albedo), snow both. Borders are soft, and broken by noise of some metres to some hundreds.
 */
#ifndef NP_TERRAIN_GROUND_COVER_H
#define NP_TERRAIN_GROUND_COVER_H

#include <nephos/terrain.h>

#include "core/math.h"
#include "core/parallel.h"
#include "noise/noise.h"
#include "terrain/cover_place.h"

typedef struct np_cover_layer {
  bool is_enabled;
  float albedo[3];
  float slope_rad; /* slope above which rock begins, or snow ends */
  float level_m;   /* elevation above which snow lies */
} np_cover_layer;

typedef struct np_ground_cover {
  neph_context *context; /* borrowed */
  const np_noise_table *noise;
  float albedo[3];        /* albedo without a picture */
  unsigned width, height; /* size of the picture */
  float (*texels)[3];     /* picture from the north-western corner, row by row; NULL: none */
  np_cover_layer rock, snow;
  neph_ground_cover climate; /* in place of picture and albedo (land_cover.h) */
} np_ground_cover;

/* Reads the picture, if there is one. On failure `*out` is empty. */
neph_result np_ground_cover_create(neph_context *context, const neph_terrain_desc *desc, np_monitor *monitor,
                                   np_ground_cover *out);
void np_ground_cover_destroy(np_ground_cover *cover);

/* Checks by name and header alone whether a file can be a picture of albedo. */
neph_result np_ground_cover_check_image(neph_context *context, const char *path);

/* Whether the albedo differs from place to place. */
static inline bool np_ground_cover_varies(const np_ground_cover *cover) {
  return cover->climate || cover->texels || cover->rock.is_enabled || cover->snow.is_enabled;
}

void np_ground_cover_eval(const np_ground_cover *cover, const np_cover_place *place, float out_albedo[3]);

#endif
