/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/scattering_field.h"

#include <string.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/stable.h"
#include "core/units.h"

enum {
  SAMPLES_PER_ORDINATE = 48,
  OCTANT = NP_ORDINATE_BLOCKS_MAX * NP_ORDINATE_LANES, /* numbers of ordinates for each octant */
  ALL = NP_OCTANT_COUNT * OCTANT
};

/* Irradiance of the sun's dimmed beam on a plane that faces it. */
static np_spectrum compute_beam(const np_world *world, const np_sun_optical_depth_source *depths, const float *fade,
                                const np_ground_hit *hit) {
  if (!(np_vec3_dot(hit->normal, world->to_sun) > 0.0f)) return np_spectrum_grey(0.0f);
  const np_spectrum sun = np_world_sunlight(world, hit->position, world->to_sun);
  if (np_spectrum_is_zero(sun)) return sun;
  const float depth = depths->get(depths->user, hit->position, world->to_sun, fade, 16.0f);
  return np_spectrum_scale(sun, np_transmittance(depth));
}

/* Adds the light of the sky to that of the sun. */
static np_spectrum add_sky(const np_world *world, const np_ground_hit *hit, np_spectrum reflected, np_spectrum sun,
                           np_spectrum *out_gain) {
  *out_gain = np_spectrum_scale(reflected, np_world_get_sky_share(world, hit) / NP_PI_F);
  return np_spectrum_add(sun, np_spectrum_multiply(np_world_level_irradiance(world, hit), *out_gain));
}

np_spectrum np_boundary_radiance_light_ground(const np_world *world, const np_sun_optical_depth_source *depths,
                                              const float *fade, const np_ground_hit *hit, np_vec3 towards, float glint,
                                              np_spectrum *out_gain) {
  if (!hit->water) return np_boundary_radiance_light_column(world, depths, fade, hit, NULL, out_gain);
  const np_vec3 to_viewer = np_vec3_scale(towards, -1.0f);
  const np_water_value sun = np_water_eval(hit->water, hit->normal, to_viewer, world->to_sun);
  const np_spectrum share = np_spectrum_add(sun.scattered, np_spectrum_grey((glint - 1.0f) * sun.reflected));
  const np_spectrum sky = np_water_reflect_even(hit->water, np_vec3_dot(hit->normal, to_viewer));
  return add_sky(world, hit, sky, np_spectrum_multiply(compute_beam(world, depths, fade, hit), share), out_gain);
}

np_spectrum np_boundary_radiance_light_column(const np_world *world, const np_sun_optical_depth_source *depths,
                                              const float *fade, const np_ground_hit *hit, np_spectrum *out_glint,
                                              np_spectrum *out_gain) {
  const float cosine = np_maxf(0.0f, np_vec3_dot(hit->normal, world->to_sun));
  const np_spectrum beam = np_spectrum_scale(compute_beam(world, depths, fade, hit), cosine / NP_PI_F);
  if (out_glint) *out_glint = np_spectrum_grey(0.0f);
  if (!hit->water) return add_sky(world, hit, hit->albedo, np_spectrum_multiply(beam, hit->albedo), out_gain);
  const float reflected = np_water_reflectance(hit->water, cosine), entered = hit->water->mean_transmittance;
  *out_glint = np_spectrum_scale(beam, reflected);
  const np_spectrum sun = np_spectrum_multiply(np_spectrum_scale(beam, 1.0f - reflected), hit->water->albedo);
  const np_spectrum sky = np_spectrum_add_scaled(np_spectrum_grey(1.0f - entered), entered, hit->water->albedo);
  return add_sky(world, hit, sky, sun, out_gain);
}

np_spectrum np_boundary_radiance_compute(const np_world *world, const np_sun_optical_depth_source *depths,
                                         np_dvec3 position, np_vec3 towards) {
  np_ground_hit hit;
  if (!np_world_intersect_ground(world, position, towards, &hit))
    return np_world_sky_radiance(world, world->cloud_sky, position, towards);
  const np_aerial_perspective air = np_world_air(world, world->cloud_sky, position, towards, hit.distance_m);
  np_spectrum unused;
  const np_spectrum ground = np_boundary_radiance_light_ground(world, depths, NULL, &hit, towards, 1.0f, &unused);
  return np_spectrum_add(np_spectrum_multiply(ground, air.transmittance), air.inscatter);
}

/* A direction, the ordinate nearest to it, and its radiance. */
typedef struct boundary_sample {
  np_vec3 towards;
  unsigned ordinate;
  np_spectrum radiance;
} boundary_sample;

typedef struct boundary_samples {
  const np_world *world;
  const np_sun_optical_depth_source *depths;
  np_dvec3 low, size; /* box of the clouds */
  unsigned count;
  boundary_sample *at;
  unsigned counts[ALL]; /* sums by ordinate */
  double sums[NP_BAND_COUNT][ALL];
} boundary_samples;

static const double clearance_m = 1.0; /* above ground, of places that hills would bury */

/* Chooses among the places spread over the middle plane of the clouds' box, lifted out of hills: from within a hill,
 * all directions but the steepest would see its dark inside. */
static np_dvec3 choose_place(const boundary_samples *o, size_t sample) {
  const double u = fmod(0.7548776662466927 * (double)sample, 1.0), v = fmod(0.5698402909980532 * (double)sample, 1.0);
  np_dvec3 place = np_dvec3_make(o->low.x + u * o->size.x, o->low.y + v * o->size.y, o->low.z + 0.5 * o->size.z);
  const double top = fmax(o->world->terrain_max.z, place.z) + clearance_m;
  const np_dvec3 above = np_dvec3_make(place.x, place.y, top);
  np_dvec3 ground = place;
  if (o->world->terrain && isfinite(np_world_find_ground(o->world, above, np_vec3_make(0.0f, 0.0f, -1.0f), &ground)))
    place.z = fmax(place.z, ground.z + clearance_m);
  return place;
}

static void add_sample(boundary_samples *o, np_vec3 towards, unsigned ordinate) {
  o->at[o->count++] = (boundary_sample){.towards = towards, .ordinate = ordinate};
}

/* Adds directions that cover the sphere evenly, each for its nearest ordinate. */
static void add_sphere(boundary_samples *o, const np_ordinates *ordinates, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, azimuth = i * (NP_PI * (3.0 - sqrt(5.0)));
    const float r = (float)sqrt(1.0 - z * z);
    const np_vec3 towards = np_vec3_make(r * (float)cos(azimuth), r * (float)sin(azimuth), (float)z);
    add_sample(o, towards, np_ordinates_search_nearest(ordinates, np_vec3_scale(towards, -1.0f)));
  }
}

/* Adds the direction of each ordinate, so that each has a sample at least. */
static void add_ordinates(boundary_samples *o, const np_ordinates *ordinates) {
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
    for (unsigned n = 0; n < ordinates->count; n++) {
      const np_vec3 d = np_ordinates_direction(ordinates, octant, n / NP_ORDINATE_LANES, n % NP_ORDINATE_LANES);
      add_sample(o, np_vec3_scale(d, -1.0f), octant * OCTANT + n);
    }
}

static neph_result sample_radiances(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const boundary_samples *o = user;
  for (size_t i = begin; i < end; i++)
    o->at[i].radiance = np_boundary_radiance_compute(o->world, o->depths, choose_place(o, i), o->at[i].towards);
  return NEPH_OK;
}

static void sum_samples(boundary_samples *o) {
  for (unsigned i = 0; i < o->count; i++) {
    const unsigned ordinate = o->at[i].ordinate;
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) o->sums[b][ordinate] += (double)o->at[i].radiance.band[b];
    o->counts[ordinate]++;
  }
}

/* Averages the samples by ordinate. The Voronoi cells of the ordinates differ a little from their weights: means are
 * scaled to the octant's true irradiance. */
static void fill_octant(const boundary_samples *o, const np_ordinates *ordinates, unsigned octant, unsigned band,
                        float *out) {
  double sum = 0.0, found = 0.0, weight = 0.0;
  unsigned count = 0;
  for (unsigned n = 0; n < ordinates->count; n++) {
    const unsigned i = octant * OCTANT + n;
    const double own = (double)ordinates->weight[n / NP_ORDINATE_LANES][n % NP_ORDINATE_LANES];
    out[n] = (float)(o->sums[band][i] / o->counts[i]);
    sum += o->sums[band][i];
    count += o->counts[i];
    found += own * (double)out[n];
    weight += own;
  }
  for (unsigned n = 0; n < ordinates->count && found > 0.0; n++) out[n] *= (float)(sum / count * weight / found);
}

neph_result np_boundary_radiance_fill(neph_context *context, const np_world *world,
                                      const np_sun_optical_depth_source *depths, const np_transport_desc *cells,
                                      const np_ordinates *ordinates, np_boundary_radiance out) {
  const unsigned all = NP_OCTANT_COUNT * ordinates->count, on_sphere = SAMPLES_PER_ORDINATE * all;
  boundary_samples o = {.world = world,
                        .depths = depths,
                        .low = cells->bounds_min,
                        .size = np_dvec3_subtract(cells->bounds_max, cells->bounds_min),
                        .at = np_alloc(context, on_sphere + all, sizeof *o.at)};
  if (!o.at) return NEPH_ERROR_OUT_OF_MEMORY;
  memset(out, 0, sizeof(np_boundary_radiance));
  add_sphere(&o, ordinates, on_sphere);
  add_ordinates(&o, ordinates);
  const neph_result result = np_parallel_for(context, NULL, o.count, 64, sample_radiances, &o);
  sum_samples(&o);
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) fill_octant(&o, ordinates, octant, b, &out[b][octant][0][0]);
  np_alloc_free(context, o.at);
  return result;
}
