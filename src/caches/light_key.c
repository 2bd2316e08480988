/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/light_key.h"

#include <string.h>

#include "core/alloc.h"
#include "core/hash.h"
#include "core/text.h"
#include "core/units.h"
#include "world/emission.h"

/* Tolerance as a share of all light on the clouds, and in radians for the sun, whose disk is five times as wide. */
static const double tolerance = 1e-3;

/* Tolerance of a coarse picture: draft states an error of about that, and all pixels follow in a second. */
static const double coarse_tolerance = 0.1;

static const char clouds_changed[] = "the clouds changed";

static void describe_turn(np_vec3 cached, np_vec3 wanted, char *out, size_t size) {
  const double turned = (double)np_vec3_length(np_vec3_subtract(cached, wanted));
  np_print(out, size, "the light turned by %.3g degrees", turned / NP_DEGREE);
}

static void add_bricks(np_hash *hash, const np_bricks *b) {
  const size_t entries = np_bricks_count_table(b), samples = b->brick_count * NP_BRICK_STRIDE;
  NP_HASH_ADD(hash, b->origin);
  NP_HASH_ADD(hash, b->size);
  np_hash_add(hash, b->table, entries * sizeof *b->table);
  np_hash_add(hash, b->table_ranges, entries * sizeof *b->table_ranges);
  np_hash_add(hash, b->nodes, b->node_count * sizeof *b->nodes);
  if (b->halves) np_hash_add(hash, b->halves, samples * sizeof *b->halves);
  if (b->floats) np_hash_add(hash, b->floats, samples * sizeof *b->floats);
  NP_HASH_ADD(hash, b->scale);
  NP_HASH_ADD(hash, b->is_nearest);
  NP_HASH_ADD(hash, b->is_periodic);
  NP_HASH_ADD(hash, b->period);
  NP_HASH_ADD(hash, b->field_period);
  NP_HASH_ADD(hash, b->background);
}

/* Extinction of the clouds, and its place. */
static void add_extinction(np_hash *hash, const np_instance *v) {
  add_bricks(hash, v->bricks);
  NP_HASH_ADD(hash, v->world_to_index);
  NP_HASH_ADD(hash, v->extinction_per_value);
}

/* Adds the places of clouds that have several. */
static void add_places(np_hash *hash, const np_instances *clouds) {
  for (unsigned i = 0; clouds->places && i < clouds->places->count; i++) {
    NP_HASH_ADD(hash, clouds->places->at[i].index);
    NP_HASH_ADD(hash, clouds->places->at[i].world_to_index);
  }
}

/* Adds a cloud to a hash. Moments identify its phase function, because tables are loaded anew for every picture. */
static void add_cloud(np_hash *hash, const np_instance *v) {
  double moments[64];
  np_phase_get_moments(&v->phase, sizeof moments / sizeof *moments, moments);
  add_extinction(hash, v);
  NP_HASH_ADD(hash, v->albedo);
  NP_HASH_ADD(hash, moments);
}

static void add_emitter(np_hash *hash, const np_emitter *g) {
  add_bricks(hash, g->bricks);
  NP_HASH_ADD(hash, g->world_to_index);
  NP_HASH_ADD(hash, g->absorption_per_value);
  NP_HASH_ADD(hash, g->has_no_body);
  NP_HASH_ADD(hash, g->kelvin_per_value);
  NP_HASH_ADD(hash, g->offset_k);
  if (!g->temperature) return;
  add_bricks(hash, g->temperature);
  NP_HASH_ADD(hash, g->world_to_temperature);
}

static neph_result hash_matter(neph_context *context, const np_world *world, char out[33]) {
  np_hash *hash = np_hash_create(context);
  for (unsigned v = 0; v < world->clouds.count; v++) add_cloud(hash, &world->clouds.at[v]);
  add_places(hash, &world->clouds);
  if (world->emission) {
    NP_HASH_ADD(hash, world->emission->black_body);
    for (unsigned i = 0; i < world->emission->emitter_count; i++) add_emitter(hash, &world->emission->emitters[i]);
  }
  return np_hash_finish(hash, out);
}

static neph_result compute_fingerprint(neph_context *context, const np_world *world, np_light_key *key) {
  neph_result result = hash_matter(context, world, key->matter);
  np_hash *hash = np_hash_create(context);
  if (!result) result = np_scattering_desc_add_to_hash(context, world, &key->desc, hash);
  np_hash_add_text(hash, key->matter);
  const neph_result finished = np_hash_finish(hash, key->clouds);
  return result ? result : finished;
}

/* Samples the surroundings with the least number of ordinates, which suffices to distinguish skies. */
static neph_result compute_surroundings(neph_context *context, const np_world *world,
                                        const np_sun_optical_depth_source *depths, const np_transport_desc *cells,
                                        np_boundary_radiance out) {
  np_ordinates *ordinates = np_alloc(context, 1, sizeof *ordinates);
  if (!ordinates) return NEPH_ERROR_OUT_OF_MEMORY;
  np_ordinates_init(NP_DEGREE_MIN, false, ordinates);
  const neph_result result = np_boundary_radiance_fill(context, world, depths, cells, ordinates, out);
  np_alloc_free(context, ordinates);
  return result;
}

static void compute_sunlight(const np_world *world, const np_transport_desc *cells, np_light_key *key) {
  const np_dvec3 low = cells->bounds_min, size = np_dvec3_subtract(cells->bounds_max, low);
  for (unsigned i = 0; i < NP_LIGHT_KEY_PLACES; i++) {
    /* Steps of the three-dimensional low-discrepancy sequence of the root of x⁴ = x + 1. */
    const double u = fmod(0.8191725133961645 * i, 1.0), v = fmod(0.6710436067037893 * i, 1.0),
                 w = fmod(0.5497004779019703 * i, 1.0);
    const np_dvec3 place = np_dvec3_make(low.x + u * size.x, low.y + v * size.y, low.z + w * size.z);
    key->sun[i] = np_world_sunlight(world, place, world->to_sun);
  }
}

/* Sunlight is compared because files of the air have no name in the hash. */
static bool has_equal_surroundings(const np_light_key *a, const np_light_key *b) {
  return *a->around && !strcmp(a->around, b->around) && !strcmp(a->clouds, b->clouds) &&
         !memcmp(a->sun, b->sun, sizeof a->sun);
}

neph_result np_light_key_fill(neph_context *context, const np_world *world, const np_sun_optical_depth_source *depths,
                              const np_light_key *earlier, np_light_key *key) {
  key->to_sun = world->to_sun;
  compute_sunlight(world, &key->desc.cells, key);
  neph_result result = compute_fingerprint(context, world, key);
  if (!result && earlier && has_equal_surroundings(earlier, key))
    memcpy(key->surroundings, earlier->surroundings, sizeof key->surroundings);
  else if (!result)
    result = compute_surroundings(context, world, depths, &key->desc.cells, key->surroundings);
  return result;
}

static double sum_sun(const np_light_key *key, unsigned band) {
  double sum = 0.0;
  for (unsigned i = 0; i < NP_LIGHT_KEY_PLACES; i++) sum += (double)key->sun[i].band[band];
  return sum / NP_LIGHT_KEY_PLACES;
}

double np_light_key_sum(const np_light_key *key, unsigned band) {
  double around = 0.0;
  const float *ordinate = &key->surroundings[band][0][0][0];
  for (size_t i = 0; i < sizeof key->surroundings[band] / sizeof *ordinate; i++) around += (double)ordinate[i];
  return sum_sun(key, band) + 4.0 * NP_PI / np_ordinates_count(NP_DEGREE_MIN, false) * around;
}

double np_light_key_get_sun_share(const np_light_key *key) {
  double sun = 0.0, all = 0.0;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    sun += sum_sun(key, b);
    all += np_light_key_sum(key, b);
  }
  return all > 0.0 ? sun / all : 0.0;
}

/* Sums the difference and the values. */
static void compare(const float *a, const float *b, size_t count, double *difference, double *sum) {
  *difference = *sum = 0.0;
  for (size_t i = 0; i < count; i++) {
    *difference += fabs((double)a[i] - (double)b[i]);
    *sum += fabs((double)a[i]);
  }
}

/* Compares sun and surroundings, each with all the light; the sun counts as a sky of its irradiance. */
static void compare_light(const np_light_key *cached, const np_light_key *wanted, double limit, char *reason,
                          size_t size) {
  double sun, sun_sum, around, around_sum;
  compare(cached->sun[0].band, wanted->sun[0].band, (size_t)NP_LIGHT_KEY_PLACES * NP_BAND_COUNT, &sun, &sun_sum);
  compare(&cached->surroundings[0][0][0][0], &wanted->surroundings[0][0][0][0],
          sizeof(np_boundary_radiance) / sizeof(float), &around, &around_sum);
  sun /= NP_LIGHT_KEY_PLACES, sun_sum /= NP_LIGHT_KEY_PLACES;
  const double solid_angle = 4.0 * NP_PI / np_ordinates_count(NP_DEGREE_MIN, false),
               all = sun_sum + solid_angle * around_sum;
  if (sun > limit * all)
    np_print(reason, size, "sunlight on the clouds changed by %.3g %%", 100.0 * sun / all);
  else if (solid_angle * around > limit * all)
    np_print(reason, size, "sky and ground around the clouds changed by %.3g %%", 100.0 * solid_angle * around / all);
}

static void compare_lights(const np_light_key *cached, const np_light_key *wanted, double limit, char *reason,
                           size_t size) {
  if ((double)np_vec3_length(np_vec3_subtract(cached->to_sun, wanted->to_sun)) > limit)
    describe_turn(cached->to_sun, wanted->to_sun, reason, size);
  else
    compare_light(cached, wanted, limit, reason, size);
}

void np_light_key_compare(const np_light_key *cached, const np_light_key *wanted, bool is_exact, char *reason,
                          size_t size) {
  if (strcmp(cached->clouds, wanted->clouds) != 0)
    np_print(reason, size, "%s", clouds_changed);
  else if (is_exact && cached->has_depth != wanted->has_depth)
    np_print(reason, size, "sun optical depths are %s", wanted->has_depth ? "cached" : "not cached");
  else
    compare_lights(cached, wanted, is_exact ? 0.0 : tolerance, reason, size);
}

void np_light_key_compare_coarse(const np_light_key *cached, const np_light_key *wanted, char *reason, size_t size) {
  const np_scattering_desc *a = &cached->desc, *b = &wanted->desc;
  if (strcmp(cached->matter, wanted->matter) != 0 || a->left_out != b->left_out ||
      a->has_importance != b->has_importance)
    np_print(reason, size, "%s", clouds_changed);
  else
    compare_lights(cached, wanted, coarse_tolerance, reason, size);
}

neph_result np_depth_key_make(neph_context *context, const np_world *world, const np_sun_optical_depth_desc *desc,
                              np_depth_key *out) {
  *out = (np_depth_key){.to_sun = world->to_sun, .desc = *desc};
  np_hash *hash = np_hash_create(context);
  for (unsigned v = 0; v < world->clouds.count; v++) add_extinction(hash, &world->clouds.at[v]);
  add_places(hash, &world->clouds);
  return np_hash_finish(hash, out->clouds);
}

/* Compares exact bits, so that a picture does not depend on earlier ones. */
void np_depth_key_compare(const np_depth_key *cached, const np_depth_key *wanted, char *reason, size_t size) {
  const np_sun_optical_depth_desc *a = &cached->desc, *b = &wanted->desc;
  if (strcmp(cached->clouds, wanted->clouds) != 0)
    np_print(reason, size, "%s", clouds_changed);
  else if (!np_vec3_is_equal(cached->to_sun, wanted->to_sun))
    describe_turn(cached->to_sun, wanted->to_sun, reason, size);
  else if (a->tolerance != b->tolerance || a->rate != b->rate || a->bytes_max != b->bytes_max)
    np_print(reason, size, "what they may err by changed");
}
