/* SPDX-License-Identifier: Apache-2.0 */
/* Measured maps of baked clouds: their files, and the conversion of their values. */
#ifndef NP_SCENE_CLOUD_MAP_H
#define NP_SCENE_CLOUD_MAP_H

#include "scene/scene_private.h"
#include "terrain/map_raster.h"

/* Makes the source of a cloud's measured field, for the scene's frame; NULL without a file. */
neph_result np_cloud_map_source_make(const neph_scene *scene, np_scene_cloud *cloud);
void np_cloud_map_source_clear(neph_context *context, np_scene_cloud *cloud);

/* Opens the files of that source, and reads their headers alone. */
neph_result np_cloud_map_check(neph_context *context, const np_scene_cloud *cloud);

/* All that a conversion of values needs. */
typedef struct np_map_conversion {
  neph_context *context;
  const np_scene_map *map;
  const char *path, *key; /* file, and the map's key in messages: "clouds[0].bake.map" */
  np_phase_source phase_source;
  const char *phase_table; /* NULL: none */
  double albedo, ground_albedo;
} np_map_conversion;

/* Converts values of a raster in place: to optical depth, and to the height of tops in metres. Values that cannot be
 * those of the quantity are errors; saturation is reported. */
neph_result np_map_convert_depths(const np_map_conversion *conversion, np_map_raster *raster);
/* Largest displacement of a picture, in thicknesses of the field. */
#define NP_MAP_DISPLACEMENT_MAX 2.0

/* Whether a picture has parallax against its clouds: it shows a reflectance, and a key states the sun's azimuth. */
static inline bool np_map_is_displaced(const np_scene_map *map) {
  return map->quantity != NP_MAP_OPTICAL_DEPTH && map->has_azimuth;
}

/* Parallax of a picture of clouds: the displacement from the clouds to their picture, towards the sun, in metres along
 * x and y; 0 where the picture is not displaced. `raster` holds optical depths. */
void np_map_compute_displacement(const np_map_conversion *conversion, const np_map_raster *raster, double thickness_m,
                                 double out_m[2]);
neph_result np_map_convert_tops(const np_map_conversion *conversion, np_map_raster *raster);

#endif
