/* SPDX-License-Identifier: Apache-2.0 */
/* Places of a cloud with several copies. */
#ifndef NP_SCENE_CLOUD_PLACES_H
#define NP_SCENE_CLOUD_PLACES_H

#include "scene/scene_private.h"

/* Reads the places of a cloud from its file, if it exists. The pivot of such a cloud is at the origin, and a place
 * moves it from there. NEPH_ERROR_BAD_FILE, with line and column, for an invalid place and for a file without places.
 */
neph_result np_cloud_places_read(neph_context *context, np_scene_cloud *cloud);

/* Creates a place for each tile of a repeating baked cloud within its range, tangent to the planet's sphere.
 * NEPH_ERROR_BAD_SCENE for too many. */
neph_result np_cloud_places_repeat(neph_context *context, double planet_radius_m, np_scene_cloud *cloud);

/* Whether two states of a cloud, each with its planet's radius, have equal tiles. */
bool np_cloud_places_repeat_alike(const np_scene_cloud *a, double a_radius_m, const np_scene_cloud *b,
                                  double b_radius_m);

/* Box of a baked cloud with its pivot at the origin. */
void np_cloud_places_get_box(const np_scene_cloud *cloud, const neph_cloud_desc *bake, double scale, np_dvec3 *out_low,
                             np_dvec3 *out_high);

/* Fails if a cloud's file of places is missing. */
neph_result np_cloud_places_check(const neph_scene *scene);

void np_cloud_places_clear(neph_context *context, np_scene_cloud *cloud);

/* Transform from a cloud with its pivot at the origin to one of its places. */
np_affine np_cloud_place_get_affine(const np_cloud_place *place);

/* World box of a box moved to a place. */
void np_cloud_place_move_box(const np_cloud_place *place, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                             np_dvec3 *out_high);

/* World box of all places of a cloud, from its box with the pivot at the origin. */
void np_cloud_places_bound(const np_scene_cloud *cloud, np_dvec3 low, np_dvec3 high, np_dvec3 *out_low,
                           np_dvec3 *out_high);

/* Number of places: one, unless the cloud has a file of places or repeats. */
static inline unsigned np_cloud_places_count(const np_scene_cloud *cloud) {
  return cloud->place_count > 0 ? cloud->place_count : 1;
}

#endif
