/* SPDX-License-Identifier: Apache-2.0 */
/* Light in clouds and optical depth to lights, reused from one picture of a sequence to the next while
 * what they depend on is the same: the clouds to the bit, what shines on them within a thousandth; for depths where it
 * stands, to the bit. The camera does not matter to them. What was built anew, and why, is logged.
 *
 * Cached light is lent: who takes it owns it, and gives it back for the next picture. Changes are counted from when it
 * was built, so that small steps do not add up unseen.
 */
#ifndef NP_CACHES_LIGHT_STORE_H
#define NP_CACHES_LIGHT_STORE_H

#include "caches/sun_optical_depth.h"
#include "transport/boundary_radiance.h"

enum { NP_LIGHT_KEY_PLACES = 64 };

typedef enum np_light_role { NP_LIGHT_OF_SUN, NP_LIGHT_OF_MOON, NP_LIGHT_ROLES } np_light_role;

/* What a solution depends on. What shines on the clouds stands for sky, ground, air, terrain and their own place. */
typedef struct np_light_key {
  char clouds[33]; /* fingerprint of grids, places, optics, emitters, and of how cells are chosen */
  np_vec3 to_sun;
  np_spectrum sun[NP_LIGHT_KEY_PLACES]; /* its irradiance at places spread over the clouds' box */
  np_boundary_radiance surroundings;
} np_light_key;

typedef struct np_light_store_entry {
  np_scattering_field *solution; /* NULL: none */
  np_light_key *key;
} np_light_store_entry;

/* What depths depend on: not on what else the clouds do to light, nor on the size of what shines. */
typedef struct np_depth_key {
  char clouds[33]; /* fingerprint of grids, places and extinction */
  np_vec3 to_sun;
  np_sun_optical_depth_desc desc;
} np_depth_key;

typedef struct np_light_store_depths {
  np_sun_optical_depth cache; /* empty: none */
  np_depth_key key;
} np_light_store_depths;

typedef struct np_light_store {
  unsigned count; /* of packets of bands, each with its entries by role */
  np_light_store_entry (*entries)[NP_LIGHT_ROLES];
  np_light_store_depths depths[NP_LIGHT_ROLES]; /* for all packets */
} np_light_store;

/* The solution of the `index`-th packet for the view's light: cached, or solved. */
neph_result np_light_store_take(neph_context *context, np_light_store *store, unsigned index, np_light_role role,
                                const np_world *world, const np_sun_optical_depth_source *depths,
                                const np_scattering_desc *desc, np_monitor *monitor,
                                np_scattering_field **out_solution);

/* Takes back a solution that was lent; NULL changes nothing. One that a time limit cut is destroyed. */
void np_light_store_give(np_light_store *store, unsigned index, np_light_role role, np_scattering_field *solution);

/* Optical depth to the view's light: cached, or computed. */
neph_result np_light_store_take_depths(neph_context *context, np_light_store *store, np_light_role role,
                                       const np_world *world, const np_sun_optical_depth_desc *desc,
                                       np_monitor *monitor, np_sun_optical_depth *out);

/* Takes back what was lent; an empty one changes nothing. */
void np_light_store_give_depths(np_light_store *store, np_light_role role, np_sun_optical_depth *cache);

void np_light_store_clear(neph_context *context, np_light_store *store);

#endif
