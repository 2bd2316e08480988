/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_store.h"

#include <string.h>

#include "atmosphere/atmosphere_tables.h"
#include "core/alloc.h"

static const char *const role_names[NP_SKY_ROLES] = {[NP_SKY_OF_CAMERA] = "camera sky",
                                                     [NP_SKY_OF_CLOUDS] = "cloud sky",
                                                     [NP_SKY_OF_CAMERA_BY_MOON] = "camera sky by moonlight",
                                                     [NP_SKY_OF_CLOUDS_BY_MOON] = "cloud sky by moonlight"};

/* Of the tolerance: through the long paths of the horizon a coefficient counts ten times. */
static const double medium_share = 0.1;

static np_sky_store_entry *get_entry(const np_sky_store *store, unsigned index) {
  return index < store->count ? &store->entries[index] : NULL;
}

/* Of light in the air, the first order alone needs no table. */
static neph_result create_atmosphere(neph_context *context, const neph_atmosphere_desc *desc, bool has_light,
                                     np_monitor *monitor, neph_atmosphere **out_atmosphere) {
  return np_atmosphere_create_orders(context, desc, has_light ? NP_ORDERS_ALL : 1, false, monitor, out_atmosphere);
}

/* How far a cached atmosphere is from the one wanted; infinite where it will not do. `out_what` says why. */
static neph_result compare_cached(neph_context *context, const neph_atmosphere *cached,
                                  const neph_atmosphere_desc *desc, bool has_light, double *out_change,
                                  const char **out_what) {
  np_medium wanted;
  neph_result result = np_medium_init(context, desc, &wanted);
  if (result) return result;
  *out_change = np_medium_compare(&wanted, &cached->medium, out_what);
  np_medium_free(context, &wanted);
  if (cached->desc.tolerance != desc->tolerance) {
    *out_what = "its tolerance";
    *out_change = (double)INFINITY;
  } else if (has_light && cached->order_max != NP_ORDERS_ALL) {
    *out_what = "what is asked of it";
    *out_change = (double)INFINITY;
  }
  return NEPH_OK;
}

neph_result np_sky_store_take_atmosphere(neph_context *context, np_sky_store *store, unsigned index,
                                         const neph_atmosphere_desc *desc, bool has_light, np_monitor *monitor,
                                         neph_atmosphere **out_atmosphere) {
  *out_atmosphere = NULL;
  np_sky_store_entry *entry = get_entry(store, index);
  if (!entry || !entry->atmosphere) {
    np_log(context, NEPH_LOG_DEBUG, "atmosphere: built");
    return create_atmosphere(context, desc, has_light, monitor, out_atmosphere);
  }
  double change;
  const char *what;
  neph_result result = compare_cached(context, entry->atmosphere, desc, has_light, &change, &what);
  if (result) return result;
  if (change <= medium_share * desc->tolerance) {
    np_log(context, NEPH_LOG_DEBUG, "atmosphere: reused");
    *out_atmosphere = entry->atmosphere;
    entry->atmosphere = NULL;
    return NEPH_OK;
  }
  if (isfinite(change))
    np_log(context, NEPH_LOG_INFO, "atmosphere: rebuilt: %s changed by %.3g %%", what, 100.0 * change);
  else
    np_log(context, NEPH_LOG_INFO, "atmosphere: rebuilt: %s changed", what);
  neph_atmosphere_release(entry->atmosphere);
  entry->atmosphere = NULL;
  return create_atmosphere(context, desc, has_light, monitor, out_atmosphere);
}

neph_result np_sky_store_take_sky(np_sky_store *store, unsigned index, np_sky_role role, neph_atmosphere *atmosphere,
                                  const neph_sky_desc *desc, np_monitor *monitor, neph_sky **out_sky) {
  neph_context *context = atmosphere->context;
  np_sky_store_entry *entry = get_entry(store, index);
  neph_sky *cached = entry ? entry->skies[role] : NULL;
  *out_sky = NULL;
  if (!cached) {
    np_log(context, NEPH_LOG_DEBUG, "%s: built", role_names[role]);
    return np_sky_create_monitored(atmosphere, desc, monitor, out_sky);
  }
  char reason[128] = "the atmosphere was rebuilt";
  entry->skies[role] = NULL;
  if (cached->atmosphere == atmosphere && np_sky_move(cached, desc, reason, sizeof reason)) {
    np_log(context, NEPH_LOG_DEBUG, "%s: reused", role_names[role]);
    *out_sky = cached;
    return NEPH_OK;
  }
  np_log(context, NEPH_LOG_INFO, "%s: rebuilt: %s", role_names[role], reason);
  neph_sky_destroy(cached);
  return np_sky_create_monitored(atmosphere, desc, monitor, out_sky);
}

static bool grow(neph_context *context, np_sky_store *store, unsigned count) {
  if (count <= store->count) return true;
  np_sky_store_entry *entries = np_alloc_resize(context, store->entries, count, sizeof *entries);
  if (!entries) return false;
  store->entries = entries;
  store->count = count;
  return true;
}

void np_sky_store_give_atmosphere(neph_context *context, np_sky_store *store, unsigned index,
                                  neph_atmosphere *atmosphere) {
  if (!atmosphere) return;
  neph_atmosphere *released = atmosphere;
  if (grow(context, store, index + 1)) {
    released = store->entries[index].atmosphere;
    store->entries[index].atmosphere = atmosphere;
  }
  neph_atmosphere_release(released);
}

void np_sky_store_offer(neph_context *context, np_sky_store *store, unsigned index, neph_atmosphere *atmosphere) {
  const np_sky_store_entry *entry = get_entry(store, index);
  if (!entry || entry->atmosphere != atmosphere)
    np_sky_store_give_atmosphere(context, store, index, neph_atmosphere_retain(atmosphere));
}

void np_sky_store_give_sky(neph_context *context, np_sky_store *store, unsigned index, np_sky_role role,
                           neph_sky *sky) {
  if (!sky) return;
  neph_sky *released = sky;
  if (grow(context, store, index + 1)) {
    released = store->entries[index].skies[role];
    store->entries[index].skies[role] = sky;
  }
  neph_sky_destroy(released);
}

void np_sky_store_clear(neph_context *context, np_sky_store *store) {
  for (unsigned i = 0; i < store->count; i++) {
    for (int role = 0; role < NP_SKY_ROLES; role++) neph_sky_destroy(store->entries[i].skies[role]);
    neph_atmosphere_release(store->entries[i].atmosphere);
  }
  np_alloc_free(context, store->entries);
  *store = (np_sky_store){0};
}
