/* SPDX-License-Identifier: Apache-2.0 */
/* Another cover for a terrain, whose heights and facets stay. */
#ifndef NP_TERRAIN_TERRAIN_COVER_H
#define NP_TERRAIN_TERRAIN_COVER_H

#include <nephos/terrain.h>

#include "core/parallel.h"

/* Replaces ground albedo and cover by those of a description, whose heights are the terrain's own, and names them. The
 * caller alone has the terrain. */
neph_result np_terrain_set_cover(neph_terrain *terrain, const neph_terrain_desc *desc, np_monitor *monitor,
                                 const char *name);

/* The name of the cover, for its comparison; "": it has none. */
void np_terrain_name_cover(neph_terrain *terrain, const char *name);
const char *np_terrain_get_cover_name(const neph_terrain *terrain);

#endif
