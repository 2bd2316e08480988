/* SPDX-License-Identifier: Apache-2.0 */
/* Lattices of the sun optical depth that clouds in many places share.
 *
 * Depth inside a cloud depends on the direction towards the sun in the cloud's own space, and grows with its size; not
 * on where it stands. Places of one cloud with the sun on the same side, to a tolerance, share a lattice;
 * the tolerance begins at nothing and is doubled until there are few enough of them. */
#include "core/alloc.h"
#include "caches/sun_optical_depth.h"
#include "core/units.h"

/* Largest ratio of the scales of two places that share a lattice, since its nodes are chosen for the optical depths of
 * one. */
static const double ratio_max = 1.5;

/* Angles: rounding alone; the first tolerance of rotated places; the largest angle. */
static const double least_rad = 1e-6, first_rad = 1.25 * NP_DEGREE, most_rad = 4.0;

/* A place in terms of its lattice. */
typedef struct side {
  np_dvec3 to_sun; /* unit direction to the sun in the cloud's index space */
  double per_m;    /* voxels along the sun's ray in a metre */
  const np_instance *volume;
} side;

static side make_side(const np_instance *volume, np_vec3 to_sun) {
  const np_dvec3 along = np_affine_vector(&volume->world_to_index, np_vec3_to_double(to_sun));
  const double length = fmax(np_dvec3_length(along), 1e-30);
  return (side){np_dvec3_scale(along, 1.0 / length), length, volume};
}

/* Angle between two directions of the sun, infinite where the places cannot share a lattice: other clouds, or other
 * sizes. */
static double compute_angle(const side *a, const side *b) {
  const double ratio = a->per_m / b->per_m;
  if (a->volume->index != b->volume->index || ratio > ratio_max || ratio * ratio_max < 1.0) return INFINITY;
  return np_dvec3_length(np_dvec3_subtract(a->to_sun, b->to_sun));
}

/* The nearest chosen place; `count` where none is within the tolerance. */
static unsigned search_nearest(const side *sides, const uint32_t *chosen, unsigned count, const side *of,
                               double tolerance, double *out_angle) {
  unsigned nearest = count;
  *out_angle = tolerance;
  for (unsigned i = 0; i < count; i++) {
    const double angle = compute_angle(&sides[chosen[i]], of);
    if (angle > *out_angle) continue;
    *out_angle = angle;
    nearest = i;
  }
  return nearest;
}

/* Chooses places, from the middle of the list on, which is the middle of a field of tiles, until each is near one of
 * them; false where more than `limit` would be needed. */
static bool choose_within(const side *sides, uint32_t place_count, double tolerance, unsigned limit, uint32_t *chosen,
                          unsigned *out_count) {
  double angle;
  *out_count = 0;
  for (uint32_t n = 0; n < place_count; n++) {
    const uint32_t i = (n + place_count / 2) % place_count;
    if (search_nearest(sides, chosen, *out_count, &sides[i], tolerance, &angle) < *out_count) continue;
    if (*out_count == limit) return false;
    chosen[(*out_count)++] = i;
  }
  return true;
}

/* Map between the world positions of equal points of a cloud in two of its places. */
static np_affine make_way(const np_instance *from, const np_instance *to) {
  np_affine index_to_world;
  if (!np_affine_invert(&to->world_to_index, &index_to_world)) index_to_world = np_affine_identity();
  return np_affine_compose(&index_to_world, &from->world_to_index);
}

static void set_place(const side *sides, const np_sun_optical_depth *cache, unsigned count, double tolerance,
                      uint32_t place, double *side_rad) {
  double angle;
  const side *own = &sides[place];
  const unsigned lattice = search_nearest(sides, cache->stands, count, own, tolerance, &angle);
  const side *shared = &sides[cache->stands[lattice]];
  cache->places[place] = (np_sun_place){.lattice = lattice,
                                        .scale = (float)(shared->per_m / own->per_m),
                                        .to_lattice = make_way(own->volume, shared->volume)};
  *side_rad = fmax(*side_rad, angle);
}

static neph_result choose(const np_world *world, const side *sides, np_sun_optical_depth *out, unsigned *out_count) {
  const uint32_t count = world->clouds.places->count;
  const unsigned few = NP_SUN_SIDES_MAX > world->clouds.count ? NP_SUN_SIDES_MAX : world->clouds.count;
  double tolerance = least_rad;
  unsigned limit = few;
  while (!choose_within(sides, count, tolerance, limit, out->stands, out_count)) {
    if (tolerance > most_rad) limit = count;
    tolerance = tolerance < first_rad ? first_rad : 1.5 * tolerance;
  }
  for (uint32_t i = 0; i < count; i++) set_place(sides, out, *out_count, tolerance, i, &out->side_rad);
  np_log(out->context, NEPH_LOG_DEBUG,
         "sun optical depth: %u lattices for %u places, whose sun is up to %.2g degrees off", *out_count, count,
         out->side_rad / NP_DEGREE);
  return NEPH_OK;
}

neph_result np_sun_places_choose(const np_world *world, np_sun_optical_depth *out, unsigned *out_count) {
  const np_places *places = world->clouds.places;
  side *sides = np_alloc(out->context, places->count, sizeof *sides);
  out->places = np_alloc(out->context, places->count, sizeof *out->places);
  out->stands = np_alloc(out->context, places->count, sizeof *out->stands);
  neph_result result = sides && out->places && out->stands ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; !result && i < places->count; i++) sides[i] = make_side(&places->at[i], world->to_sun);
  if (!result) result = choose(world, sides, out, out_count);
  np_alloc_free(out->context, sides);
  return result;
}
