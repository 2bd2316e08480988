/* SPDX-License-Identifier: Apache-2.0 */
/* Light in clouds, kept from one picture of a sequence to the next and used again while what it depends on is the same:
 * the clouds to the bit, what shines on them within a thousandth. What was solved anew, and why, is logged.
 *
 * A solution is lent: who takes it owns it, and gives it back for the next picture. Changes are counted from when it
 * was solved, so that small steps do not add up unseen.
 */
#ifndef NP_LIGHT_LIGHT_STORE_H
#define NP_LIGHT_LIGHT_STORE_H

#include "light/multi_scatter.h"

enum { NP_LIGHT_KEY_PLACES = 64 };

typedef enum np_light_role { NP_LIGHT_OF_SUN, NP_LIGHT_OF_MOON, NP_LIGHT_ROLES } np_light_role;

/* What a solution depends on. What shines on the clouds stands for sky, ground, air, terrain and their own place. */
typedef struct np_light_key {
  char clouds[33]; /* fingerprint of grids, places, optics, glows, and of how cells are chosen */
  np_vec3 to_sun;
  np_spectrum sun[NP_LIGHT_KEY_PLACES]; /* its irradiance at places spread over the clouds' box */
  np_inflow surroundings;
} np_light_key;

typedef struct np_light_store_entry {
  np_multi_scatter solution; /* empty: none */
  np_light_key *key;
} np_light_store_entry;

/* What belongs to one packet of bands, by role. */
typedef struct np_light_store {
  unsigned count;
  np_light_store_entry (*entries)[NP_LIGHT_ROLES];
} np_light_store;

/* The solution of the `index`-th packet for the view's light: kept, or solved. */
neph_result np_light_store_take(neph_context *context, np_light_store *store, unsigned index, np_light_role role,
                                const np_scene_view *view, const np_multi_scatter_desc *desc, np_monitor *monitor,
                                np_multi_scatter *out);

/* Takes back what was lent; an empty one changes nothing. */
void np_light_store_give(np_light_store *store, unsigned index, np_light_role role, np_multi_scatter *solution);

void np_light_store_clear(neph_context *context, np_light_store *store);

#endif
