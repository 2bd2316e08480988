/* SPDX-License-Identifier: Apache-2.0 */
/* Places of a cloud that stands in several. */
#ifndef NP_SCENE_CLOUD_PLACES_H
#define NP_SCENE_CLOUD_PLACES_H

#include "scene/scene_private.h"

/* Reads the places of a cloud from its file, if that is there; a cloud with places has its pivot at the origin, from
 * which they move it. NEPH_ERROR_BAD_FILE, with line and column, for a place that is none, and for a file without any.
 */
neph_result np_cloud_places_read(neph_context *context, np_scene_cloud *cloud);

/* Gives a baked cloud that repeats a place for each tile within its range, tangent to the planet's sphere.
 * NEPH_ERROR_BAD_SCENE where they are too many. */
neph_result np_cloud_places_repeat(neph_context *context, double planet_radius_m, np_scene_cloud *cloud);

/* Whether two states of a cloud, each on a planet's sphere, have the same tiles. */
bool np_cloud_places_repeat_alike(const np_scene_cloud *a, double a_radius_m, const np_scene_cloud *b,
                                  double b_radius_m);

/* Box of a baked cloud with places before it is moved to them. */
void np_cloud_places_get_box(const np_scene_cloud *cloud, const neph_cloud_desc *bake, double scale, np_dvec3 *out_low,
                             np_dvec3 *out_high);

/* Fails where some cloud's file of places is not there. */
neph_result np_cloud_places_check(const neph_scene *scene);

void np_cloud_places_clear(neph_context *context, np_scene_cloud *cloud);

/* The way from a cloud with its pivot at the origin to one of its places. */
np_affine np_cloud_place_get_affine(const np_cloud_place *place);

/* World box of a box that is moved so. */
void np_cloud_place_move_box(const np_cloud_place *place, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                             np_dvec3 *out_high);

/* World box of a cloud in all of its places, of its box before it is moved to them. */
void np_cloud_places_bound(const np_scene_cloud *cloud, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                           np_dvec3 *out_high);

/* Places of a cloud: one, its own, unless it has a file of them or repeats. */
static inline unsigned np_cloud_places_count(const np_scene_cloud *cloud) {
  return cloud->place_count > 0 ? cloud->place_count : 1;
}

#endif
