/* SPDX-License-Identifier: Apache-2.0 */
/* The keys of multiple scattering and of sun optical depth: all that they depend on. They are the same while the clouds
 * are, to the bit, and what shines on them within a thousandth; for depths where it stands, to the bit. The camera does
 * not matter to them. */
#ifndef NP_CACHES_LIGHT_KEY_H
#define NP_CACHES_LIGHT_KEY_H

#include "caches/sun_optical_depth.h"
#include "transport/scattering_field.h"

enum { NP_LIGHT_KEY_PLACES = 64 };

/* Key of a solution. The light on the clouds stands for sky, ground, air, terrain and their own place. */
typedef struct np_light_key {
  np_scattering_desc desc;
  char clouds[33]; /* fingerprint of grids, places, optics, glows, and of how cells are chosen */
  np_vec3 to_sun;
  np_spectrum sun[NP_LIGHT_KEY_PLACES]; /* its irradiance at places spread over the clouds' box */
  np_boundary_radiance surroundings;
} np_light_key;

/* Key of optical depths: extinction alone, neither albedo nor phase nor the size of the light. */
typedef struct np_depth_key {
  char clouds[33]; /* fingerprint of grids, places and extinction */
  np_vec3 to_sun;
  np_sun_optical_depth_desc desc;
} np_depth_key;

/* Fills all but the description, by which the key is made. */
neph_result np_light_key_fill(neph_context *context, const np_world *world, const np_sun_optical_depth_source *depths,
                              np_light_key *key);
neph_result np_depth_key_make(neph_context *context, const np_world *world, const np_sun_optical_depth_desc *desc,
                              np_depth_key *out);

/* All that shines on the clouds in a band, the sun and what is around, as irradiances, in the mean over their box. */
double np_light_key_sum(const np_light_key *key, unsigned band);

/* The sun's share in that, of all bands. */
double np_light_key_get_sun_share(const np_light_key *key);

/* Write the reason why a cached result is out of date; nothing if it is not. is_exact: what shines must be the same to
 * the bit. */
void np_light_key_compare(const np_light_key *cached, const np_light_key *wanted, bool is_exact, char *reason,
                          size_t size);
void np_depth_key_compare(const np_depth_key *cached, const np_depth_key *wanted, char *reason, size_t size);

#endif
