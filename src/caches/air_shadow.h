/* SPDX-License-Identifier: Apache-2.0 */
/* Shadows of clouds and hills in the air before the camera.
 *
 * Sky and aerial perspective come from tables of a clear sky. What clouds and hills take from them is the sunlight that
 * the air would have scattered once: with I(t) the table's in-scatter of that order up to a distance t and V the
 * visibility of the sun,
 *
 *     lost(t) = ∫ (1 − V) dI
 *
 * V is a matter of places alone (air_visibility.h). From it each packet of wavelengths makes the share lost(t)/I(t),
 * which is smooth even where I is not, as at the horizon, and is what is read in between rays. A ray that ends at a
 * hill counts little for what lies behind that hill.
 *
 * The disk is half a degree wide, so that edges of shadows which are seen along their sides are as wide: rays a quarter
 * of a degree apart show them all.
 *
 * Light that the air scatters more often is that without clouds, changed by what clouds scatter into the air, hide of
 * sky and ground and keep from the ground, where that is known (caches/lit_air.h). That can be more than they take.
 * What haze scatters nearly straight on counts as not scattered: it lacks what the first order lacks behind it and on
 * its way from the sun, and the light behind whatever ends the ray.
 *
 * It depends on what the visibility depends on and on the camera's sky.
 */
#ifndef NP_CACHES_AIR_SHADOW_H
#define NP_CACHES_AIR_SHADOW_H

#include "caches/air_visibility.h"
#include "caches/lit_air.h"

/* Unit of stored shares: shadowed light in three bands over the light of the first order. The value represents a share
 * of 1. */
#define NP_AIR_SHADOW_UNIT 65535.0f

/* Change of the air's light by clouds and hills up to a place, beside that of the first order. Shares are of the clear
 * air's light of the higher orders up to there, in NP_AIR_SHADOW_UNITs. */
typedef struct np_air_part {
  np_spectrum other;                /* light of clouds, hills and ground */
  uint16_t lost[NP_BAND_COUNT];     /* share that is lost */
  uint16_t ahead[NP_BAND_COUNT];    /* share that haze has scattered straight on from behind the place */
  uint16_t straight[NP_BAND_COUNT]; /* optical depth of what haze scatters straight on, of NP_STRAIGHT_DEPTH_MAX */
  uint16_t covered; /* share of that in the shade, in the directions around without ground before the place */
} np_air_part;

typedef struct np_air_shadow {
  neph_context *context;                       /* borrowed */
  const np_air_visibility *visibility;         /* borrowed */
  uint16_t (*visible_fraction)[NP_BAND_COUNT]; /* nodes × NP_AIR_SHADOW_PLANES, in NP_AIR_SHADOW_UNITs */
  np_air_part *parts;                          /* one for each of these; NULL: the change is unknown */
  float *ground_share; /* share of the directions around each node's ray that meet the ground, beside `parts` */
} np_air_shadow;

/* Computes lost light for the world's camera sky; with the change of the air's light by clouds, `lit_air`, and by
 * hills, `among_hills`, of which either may be NULL. */
neph_result np_air_shadow_build(const np_air_visibility *visibility, const np_world *world, const np_lit_air *lit_air,
                                const np_lit_air *among_hills, np_monitor *monitor, np_air_shadow *out);
void np_air_shadow_clear(np_air_shadow *shadow);

/* Mean share of the first order that is lost along the nodes' rays. */
double np_air_shadow_measure(const np_air_shadow *shadow);

/* Whatever ends a ray at a place hides the light behind it from the haze before it, which scatters that light straight
 * on: over the share of the directions around in which the ground is met, or, for clouds, over that of the haze that
 * they shade. Water is as the sky's tables have it. */
typedef enum np_ray_end { NP_RAY_END_NONE, NP_RAY_END_CLOUD, NP_RAY_END_GROUND } np_ray_end;

/* Change of the air's light up to a distance. */
typedef struct np_air_change {
  np_spectrum lost_share;   /* share of the first order's in-scatter that is lost */
  np_spectrum higher_share; /* share of the light of the higher orders that is lost; it may exceed 1 */
  np_spectrum other;        /* light of clouds, hills and ground */
  np_spectrum passed;       /* light of the end that haze scatters straight on, over what it does not scatter */
} np_air_change;

/* Infinity is allowed. */
np_air_change np_air_shadow_get(const np_air_shadow *shadow, const np_view_ray *view, double distance_m,
                                np_ray_end end);

#endif
