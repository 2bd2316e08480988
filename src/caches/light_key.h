/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of multiple scattering and of sun optical depth: all that they depend on. A solution is reused while clouds are
 * the same to the bit, and the light on them within a thousandth; depths while the sun's direction is the same to the
 * bit. Keys do not include the camera. */
#ifndef NP_CACHES_LIGHT_KEY_H
#define NP_CACHES_LIGHT_KEY_H

#include "caches/sun_optical_depth.h"
#include "transport/scattering_field.h"

enum { NP_LIGHT_KEY_PLACES = 64 };

/* Key of a solution. The light on the clouds represents sky, ground, air and terrain. */
typedef struct np_light_key {
  np_scattering_desc desc;
  char clouds[33]; /* hash of grids, places, optics and emission, and of the choice of cells */
  char matter[33]; /* hash of the same without the choice of cells */
  char around[33]; /* hash of all but the clouds that the light around them depends on; empty: it is unknown */
  char ground[33]; /* hash of the ground's heights; empty: they are unknown */
  bool has_depth;  /* sun optical depths came from their cache */
  np_vec3 to_sun;
  np_spectrum sun[NP_LIGHT_KEY_PLACES]; /* sun's irradiance at places spread over the clouds' box */
  np_boundary_radiance surroundings;
} np_light_key;

/* Key of optical depths: extinction alone, without albedo, phase and intensity of the light. */
typedef struct np_depth_key {
  char clouds[33]; /* hash of grids, places and extinction */
  np_vec3 to_sun;
  np_sun_optical_depth_desc desc;
} np_depth_key;

/* Fills a key whose description and other hashes are set. Light around the clouds is that of `earlier`, a key that may
 * be NULL, where all that it depends on is the same. */
neph_result np_light_key_fill(neph_context *context, const np_world *world, const np_sun_optical_depth_source *depths,
                              const np_light_key *earlier, np_light_key *key);
neph_result np_depth_key_make(neph_context *context, const np_world *world, const np_sun_optical_depth_desc *desc,
                              np_depth_key *out);

/* All light on the clouds in a band, sun and surroundings, as irradiance, averaged over their box. */
double np_light_key_sum(const np_light_key *key, unsigned band);

/* Share of the sun in np_light_key_sum, over all bands. */
double np_light_key_get_sun_share(const np_light_key *key);

/* Writes why a cached result is out of date; "" if it is valid. is_exact: results must agree to the bit. */
void np_light_key_compare(const np_light_key *cached, const np_light_key *wanted, bool is_exact, char *reason,
                          size_t size);
/* The same for a coarse picture: cells may be others, and light may differ by a tenth. */
void np_light_key_compare_coarse(const np_light_key *cached, const np_light_key *wanted, char *reason, size_t size);
void np_depth_key_compare(const np_depth_key *cached, const np_depth_key *wanted, char *reason, size_t size);

#endif
