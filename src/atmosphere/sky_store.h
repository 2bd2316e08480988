/* SPDX-License-Identifier: Apache-2.0 */
/* Tables reused from one picture of a sequence to the next while what they depend on stays within the
 * tolerance that they were sized for. What was built anew, and why, is logged.
 *
 * An entry is lent: who takes its atmosphere and skies owns them, and gives them back for the next picture. Changes are
 * counted from when a table was built, so that small steps do not add up unseen.
 */
#ifndef NP_ATMOSPHERE_SKY_STORE_H
#define NP_ATMOSPHERE_SKY_STORE_H

#include "atmosphere/atmosphere_private.h"
#include "core/parallel.h"

typedef enum np_sky_role {
  NP_SKY_OF_CAMERA,
  NP_SKY_OF_CLOUDS,
  NP_SKY_OF_CAMERA_BY_MOON,
  NP_SKY_OF_CLOUDS_BY_MOON,
  NP_SKY_ROLES
} np_sky_role;

/* What belongs to one packet of bands. */
typedef struct np_sky_store_entry {
  neph_atmosphere *atmosphere;
  neph_sky *skies[NP_SKY_ROLES];
} np_sky_store_entry;

typedef struct np_sky_store {
  unsigned count;
  np_sky_store_entry *entries;
} np_sky_store;

/* One that fits `desc`: the `index`-th entry's, or a new one, for which the entry's skies no longer stand. Without
 * `has_light` it knows what the air is and lets through, not what light is scattered in it: that is for who traces it.
 */
neph_result np_sky_store_take_atmosphere(neph_context *context, np_sky_store *store, unsigned index,
                                         const neph_atmosphere_desc *desc, bool has_light, np_monitor *monitor,
                                         neph_atmosphere **out_atmosphere);

/* Puts an atmosphere that a caller has made in the place of an entry's own. Without memory that stays. */
void np_sky_store_offer(neph_context *context, np_sky_store *store, unsigned index, neph_atmosphere *atmosphere);

/* A sky of `atmosphere`, which was taken before, on the same terms. A cached one is moved to the light and the observer
 * wanted. */
neph_result np_sky_store_take_sky(np_sky_store *store, unsigned index, np_sky_role role, neph_atmosphere *atmosphere,
                                  const neph_sky_desc *desc, np_monitor *monitor, neph_sky **out_sky);

/* Take back what was lent, or new; NULL changes nothing. What there is no room for is released. */
void np_sky_store_give_atmosphere(neph_context *context, np_sky_store *store, unsigned index,
                                  neph_atmosphere *atmosphere);
void np_sky_store_give_sky(neph_context *context, np_sky_store *store, unsigned index, np_sky_role role, neph_sky *sky);

void np_sky_store_clear(neph_context *context, np_sky_store *store);

#endif
