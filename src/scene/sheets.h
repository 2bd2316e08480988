/* SPDX-License-Identifier: Apache-2.0 */
/* Sheets of cloud that repeat to the horizon by default. */
#ifndef NP_SCENE_SHEETS_H
#define NP_SCENE_SHEETS_H

#include "scene/scene_private.h"

/* Sets the range of each baked cloud whose repetition is automatic: of a sheet the distance of its horizon, of others,
 * and of a sheet with an obstacle, 0. */
void np_sheets_derive(neph_scene *scene);

/* First reason for which the sheet of a cloud does not repeat by default, a noun phrase or a key with a verb; NULL:
 * none. Clouds that are no sheet, or whose range is given, have none. */
const char *np_sheet_search_obstacle(const neph_scene *scene, const np_scene_cloud *cloud);

/* Whether a cloud is a sheet whose repetition is automatic. */
bool np_sheet_is_automatic(const np_scene_cloud *cloud);

/* Turns the description of a cloud in a frame into that which files hold: a sheet that repeats by default ends at its
 * extent there. */
void np_sheet_set_alone(const np_scene_cloud *cloud, neph_cloud_desc *desc);

#endif
