/* SPDX-License-Identifier: Apache-2.0 */
/* Light of a landscape on itself, from rays that leave each point of a grid in all directions.
 *
 * Without hills the light on a slope is known: the sky's upper half, and level ground below. Rays correct it: one that
 * meets a hill takes away the sky behind it and adds what the hill reflects; one from the lower half adds what the
 * ground there reflects more than level ground does. So an even sky over white ground gives an even light on all slopes
 * exactly, whatever rays are drawn. The light of a place that a ray meets is its sunlight, its share of the light from
 * above, and for the rest of its half of the directions level ground of its own albedo: further reflections are summed
 * as if all the ground nearby were alike.
 */
#include "caches/relief_light.h"

#include "atmosphere/sky_along.h"
#include "core/alloc.h"
#include "core/units.h"

enum { AZIMUTHS = 8, UP = NP_RELIEF_RINGS, DOWN = 2, SKY_AZIMUTHS = NP_RELIEF_SKY_AZIMUTHS, SKY_SAMPLES = 3 };

enum { EMPTY, BUSY, DONE }; /* states of a point */

/* Sines of the elevations between rings of directions: the rings are narrow near the horizon, where hills are. */
static const float up_edges[UP + 1] = {0.0f, 0.1f, 0.2f, 0.35f, 0.55f, 1.0f}, down_edges[DOWN + 1] = {-1.0f, -0.5f, 0};

/* Distance beyond which air before the ground counts. */
static const double air_from_m = 1000.0;

/* Points over which the light turns into that without hills at the grid's rim. */
static const double rim_points = 2.0;

/* Factors of the cosine's convolution by degree, π, 2π/3 and π/4 (Ramamoorthi and Hanrahan 2001, eq. 8). */
static const float cosine_factor[NP_RELIEF_TERMS] = {
    NP_PI_F,         2.0f * NP_PI_F / 3.0f, 2.0f * NP_PI_F / 3.0f, 2.0f * NP_PI_F / 3.0f, 0.25f * NP_PI_F,
    0.25f * NP_PI_F, 0.25f * NP_PI_F,       0.25f * NP_PI_F,       0.25f * NP_PI_F};

/* Normalisation of the harmonics of degree 0 and 1. */
static const float harmonic_0 = 0.28209479f, harmonic_1 = 0.48860251f;

static void fill_harmonics(np_vec3 d, float out[NP_RELIEF_TERMS]) {
  out[0] = harmonic_0;
  out[1] = harmonic_1 * d.y;
  out[2] = harmonic_1 * d.z;
  out[3] = harmonic_1 * d.x;
  out[4] = 1.09254843f * d.x * d.y;
  out[5] = 1.09254843f * d.y * d.z;
  out[6] = 0.31539157f * (3.0f * d.z * d.z - 1.0f);
  out[7] = 1.09254843f * d.x * d.z;
  out[8] = 0.54627422f * (d.x * d.x - d.y * d.y);
}

/* Adds light of a direction, times its solid angle, to the irradiance of all slopes. */
static void add_light(np_vec3 towards, np_spectrum light, np_relief_irradiance *sum) {
  float harmonics[NP_RELIEF_TERMS];
  fill_harmonics(towards, harmonics);
  for (int k = 0; k < NP_RELIEF_TERMS; k++)
    sum->term[k] = np_spectrum_add_scaled(sum->term[k], cosine_factor[k] * harmonics[k], light);
}

static np_vec3 make_direction(float sine, float azimuth) {
  const float cosine = sqrtf(fmaxf(0.0f, 1.0f - sine * sine));
  return np_vec3_make(cosine * cosf(azimuth), cosine * sinf(azimuth), sine);
}

static np_spectrum reflect(np_spectrum irradiance, np_spectrum albedo) {
  return np_spectrum_scale(np_spectrum_multiply(irradiance, albedo), 1.0f / NP_PI_F);
}

/* ---- Light on a place without hills ---- */

/* Irradiance of the sky on level ground, as far as the clouds let it through, and light of the clouds. */
typedef struct level_light {
  np_spectrum clear;
  np_ground_light_value clouds;
} level_light;

static level_light get_level(const np_world *world, const np_ground_light *ground_light, const np_ground_hit *hit) {
  level_light out = {.clear = np_world_level_irradiance(world, hit)};
  if (!ground_light) return out;
  out.clouds = np_ground_light_get(ground_light, hit->position);
  out.clear = np_spectrum_multiply(out.clear, out.clouds.open);
  return out;
}

/* Irradiance on a slope from sky, clouds, and level ground below of the slope's albedo, which `below` illuminates. */
static np_spectrum share_light(const np_world *world, const np_ground_hit *hit, const level_light *level,
                               np_spectrum below) {
  const float share = np_world_get_sky_share(world, hit);
  const np_spectrum ground = np_spectrum_multiply(below, hit->albedo);
  const np_spectrum clouds = np_ground_light_add_slope(&level->clouds, hit->normal, share);
  return np_spectrum_add_scaled(np_spectrum_add_scaled(clouds, share, level->clear), 1.0f - share, ground);
}

np_spectrum np_relief_light_get_bare(const np_world *world, const np_ground_light *ground_light,
                                     const np_ground_hit *hit) {
  const level_light level = get_level(world, ground_light, hit);
  const bool has_ground = world->terrain != NULL;
  const np_spectrum all = np_spectrum_add(level.clear, level.clouds.added);
  return share_light(world, hit, &level, has_ground ? all : np_spectrum_grey(0.0f));
}

/* ---- Rays ---- */

/* Sunlight on a plane that faces the sun, through the clouds. */
static np_spectrum get_sunlight(const np_relief_light *c, np_dvec3 position) {
  const np_world *world = c->desc.world;
  const np_spectrum sun = np_world_sunlight(world, position, world->to_sun);
  if (np_spectrum_is_zero(sun) || world->clouds.count == 0) return sun;
  const np_ground_light *ground_light = c->desc.ground_light;
  const float depth = np_sun_optical_depths_get_scaled(&c->desc.depths, position, world->to_sun,
                                                       ground_light ? ground_light->fade : NULL, 16.0f);
  return np_spectrum_scale(sun, np_transmittance(depth));
}

/* Radiance of ground that a ray meets. */
static np_spectrum light_ground(const np_relief_light *c, const np_ground_hit *hit) {
  const np_world *world = c->desc.world;
  const level_light level = get_level(world, c->desc.ground_light, hit);
  const np_spectrum all = np_spectrum_add(level.clear, level.clouds.added);
  const float cosine = np_vec3_dot(hit->normal, world->to_sun),
              up = np_vec3_dot(np_zenith(hit->position, world->planet_radius_m), world->to_sun);
  const np_spectrum sun = cosine > 0.0f ? get_sunlight(c, hit->position) : np_spectrum_grey(0.0f);
  const np_spectrum below = np_spectrum_add_scaled(all, fmaxf(up, 0.0f), sun);
  return reflect(np_spectrum_add_scaled(share_light(world, hit, &level, below), fmaxf(cosine, 0.0f), sun), hit->albedo);
}

/* Radiance of the ground through the air before it. */
static np_spectrum compute_ground_radiance(const np_relief_light *c, np_dvec3 origin, np_vec3 direction,
                                           const np_ground_hit *hit) {
  const np_spectrum light = light_ground(c, hit);
  const neph_sky *sky = c->desc.world->cloud_sky ? c->desc.world->cloud_sky : c->desc.world->camera_sky;
  if (!sky || hit->distance_m < air_from_m) return light;
  const np_aerial_perspective air = np_sky_trace_air(sky, origin, direction, hit->distance_m);
  return np_spectrum_add(np_spectrum_multiply(light, air.transmittance), air.inscatter);
}

/* Light of the clear sky in a direction of a ring, over its irradiance on level ground. */
static np_spectrum get_sky(const np_relief_light *c, int ring, float azimuth) {
  const float turn = azimuth * (0.5f / NP_PI_F);
  const int k = (int)((turn - floorf(turn)) * SKY_AZIMUTHS);
  return c->sky[ring][k < SKY_AZIMUTHS ? k : SKY_AZIMUTHS - 1];
}

typedef struct relief_ray {
  int ring;
  float azimuth;
  float sine, solid_angle;
} relief_ray;

/* A ray within its part of a ring. */
static relief_ray draw_ray(const float *edges, int ring, int k, np_random *random) {
  const float height = edges[ring + 1] - edges[ring], width = 2.0f * NP_PI_F / AZIMUTHS;
  return (relief_ray){ring, ((float)k + np_random_float(random)) * width,
                      edges[ring] + height * np_random_float(random), height * width};
}

static void add_up(const np_relief_light *c, np_dvec3 origin, const relief_ray *ray, np_relief_point *out) {
  const np_vec3 towards = make_direction(ray->sine, ray->azimuth);
  np_ground_hit hit;
  if (!np_world_intersect_ground(c->desc.world, origin, towards, &hit)) return;
  const np_spectrum ground = compute_ground_radiance(c, origin, towards, &hit),
                    sky = get_sky(c, ray->ring, ray->azimuth);
  add_light(towards, np_spectrum_scale(ground, ray->solid_angle), &out->ground);
  add_light(towards, np_spectrum_scale(sky, ray->solid_angle), &out->hidden);
}

/* Adds the difference to level ground of radiance `level`. */
static void add_down(const np_relief_light *c, np_dvec3 origin, const relief_ray *ray, np_spectrum level,
                     np_relief_point *out) {
  const np_vec3 towards = make_direction(ray->sine, ray->azimuth);
  np_ground_hit hit;
  if (!np_world_intersect_ground(c->desc.world, origin, towards, &hit)) return;
  const np_spectrum more = np_spectrum_subtract(compute_ground_radiance(c, origin, towards, &hit), level);
  add_light(towards, np_spectrum_scale(more, ray->solid_angle), &out->ground);
}

/* Adds uniform light from the lower hemisphere: a slope at angle θ gets ½(1 − cos θ) of its irradiance. */
static void add_lower_half(np_spectrum irradiance, np_relief_irradiance *sum) {
  sum->term[0] = np_spectrum_add_scaled(sum->term[0], 0.5f / harmonic_0, irradiance);
  sum->term[2] = np_spectrum_add_scaled(sum->term[2], -0.5f / harmonic_1, irradiance);
}

/* Ground at a place seen from above; false: there is none. */
static bool get_ground(const np_world *world, double x, double y, np_ground_hit *out) {
  const np_dvec3 above = np_dvec3_make(x, y, world->terrain_max.z + 1.0);
  return np_world_intersect_ground(world, above, np_vec3_make(0, 0, -1), out);
}

/* Computes the point of a column i and a row j. */
static void fill_point(const np_relief_light *c, int32_t i, int32_t j, np_relief_point *out) {
  *out = (np_relief_point){0};
  np_ground_hit here;
  if (!get_ground(c->desc.world, c->origin_m[0] + i * c->spacing_m[0], c->origin_m[1] + j * c->spacing_m[1], &here))
    return;
  np_ground_hit flat = here;
  flat.normal = np_zenith(here.position, c->desc.world->planet_radius_m);
  const np_spectrum level = light_ground(c, &flat);
  add_lower_half(np_spectrum_scale(level, NP_PI_F), &out->ground);
  np_random random = np_random_start(0, 0, (uint32_t)i, (uint32_t)j, 0);
  for (int ring = 0; ring < UP; ring++)
    for (int k = 0; k < AZIMUTHS; k++) {
      const relief_ray ray = draw_ray(up_edges, ring, k, &random);
      add_up(c, here.position, &ray, out);
    }
  for (int ring = 0; ring < DOWN; ring++)
    for (int k = 0; k < AZIMUTHS; k++) {
      const relief_ray ray = draw_ray(down_edges, ring, k, &random);
      add_down(c, here.position, &ray, level, out);
    }
}

/* ---- The clear sky ---- */

static np_spectrum trace_sky(const np_world *world, np_dvec3 origin, np_vec3 towards) {
  const neph_sky *sky = world->cloud_sky ? world->cloud_sky : world->camera_sky;
  const np_spectrum air = sky ? np_sky_trace_air(sky, origin, towards, INFINITY).inscatter : np_spectrum_grey(0.0f);
  return np_world_add_beyond(world, origin, towards, air);
}

/* Mean radiance of a part of a ring; adds its light to slopes and to level ground. */
static np_spectrum sample_sky(np_relief_light *c, np_dvec3 origin, int ring, int k, np_spectrum *level) {
  const float height = up_edges[ring + 1] - up_edges[ring], width = 2.0f * NP_PI_F / SKY_AZIMUTHS;
  np_spectrum mean = np_spectrum_grey(0.0f);
  for (int s = 0; s < SKY_SAMPLES; s++) {
    const float sine = up_edges[ring] + height * ((float)s + 0.5f) / SKY_SAMPLES;
    const np_vec3 towards = make_direction(sine, ((float)k + 0.5f) * width);
    const np_spectrum light = np_spectrum_scale(trace_sky(c->desc.world, origin, towards), 1.0f / SKY_SAMPLES);
    mean = np_spectrum_add(mean, light);
    add_light(towards, np_spectrum_scale(light, height * width), &c->clear);
    *level = np_spectrum_add_scaled(*level, sine * height * width, light);
  }
  return mean;
}

/* Computes the clear sky over the terrain's centre, relative to its irradiance on level ground. */
static void fill_sky(np_relief_light *c) {
  np_ground_hit middle;
  const double x = c->origin_m[0] + 0.5 * (c->size[0] - 1) * c->spacing_m[0],
               y = c->origin_m[1] + 0.5 * (c->size[1] - 1) * c->spacing_m[1];
  if (!get_ground(c->desc.world, x, y, &middle)) middle.position = np_dvec3_make(x, y, 0.0);
  np_spectrum level = np_spectrum_grey(0.0f), per = level;
  for (int ring = 0; ring < UP; ring++)
    for (int k = 0; k < SKY_AZIMUTHS; k++) c->sky[ring][k] = sample_sky(c, middle.position, ring, k, &level);
  for (int b = 0; b < NP_BAND_COUNT; b++) per.band[b] = level.band[b] > 0.0f ? 1.0f / level.band[b] : 0.0f;
  for (int k = 0; k < NP_RELIEF_TERMS; k++) c->clear.term[k] = np_spectrum_multiply(c->clear.term[k], per);
  for (int ring = 0; ring < UP; ring++)
    for (int k = 0; k < SKY_AZIMUTHS; k++) c->sky[ring][k] = np_spectrum_multiply(c->sky[ring][k], per);
}

/* ---- The cache ---- */

static void place(np_relief_light *c) {
  double low[2], high[2];
  np_terrain_get_core(c->desc.world->terrain, low, high);
  for (int a = 0; a < 2; a++) {
    c->size[a] = NP_RELIEF_POINTS_MAX;
    c->origin_m[a] = low[a];
    c->spacing_m[a] = (high[a] - low[a]) / (NP_RELIEF_POINTS_MAX - 1);
  }
}

neph_result np_relief_light_build(neph_context *context, const np_relief_light_desc *desc, np_relief_light *out) {
  *out = (np_relief_light){.context = context, .desc = *desc};
  place(out);
  const size_t count = (size_t)out->size[0] * (size_t)out->size[1];
  out->points = np_alloc(context, count, sizeof *out->points);
  if (!out->points) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t n = 0; n < count; n++) atomic_init(&out->points[n].state, EMPTY);
  fill_sky(out);
  return NEPH_OK;
}

void np_relief_light_clear(np_relief_light *cache) {
  np_alloc_free(cache->context, cache->points);
  *cache = (np_relief_light){0};
}

/* A point, from the cache or computed. Threads that need one point at a time each compute it, and the first one stores
 * it. */
static const np_relief_point *get_point(const np_relief_light *c, int32_t i, int32_t j, np_relief_point *own) {
  np_relief_slot *slot = &c->points[(size_t)j * (size_t)c->size[0] + (size_t)i];
  unsigned char state = atomic_load_explicit(&slot->state, memory_order_acquire);
  if (state == DONE) return &slot->point;
  fill_point(c, i, j, own);
  if (state != EMPTY || !atomic_compare_exchange_strong(&slot->state, &state, BUSY)) return own;
  slot->point = *own;
  atomic_store_explicit(&slot->state, DONE, memory_order_release);
  return own;
}

/* ---- Look-up ---- */

/* The cell of four points about a place. */
typedef struct relief_cell {
  int32_t lower[2];
  float weight[2]; /* weight of the upper point along each axis */
  float share;     /* 1 well within the grid, 0 at its rim and beyond */
} relief_cell;

static relief_cell get_cell(const np_relief_light *c, np_dvec3 position) {
  const double p[2] = {position.x, position.y};
  relief_cell out = {.share = 1.0f};
  for (int a = 0; a < 2; a++) {
    const double last = c->size[a] - 1, u = (p[a] - c->origin_m[a]) / c->spacing_m[a], inside = np_clamp(u, 0.0, last);
    out.lower[a] = (int32_t)inside < c->size[a] - 2 ? (int32_t)inside : c->size[a] - 2;
    out.weight[a] = (float)(inside - out.lower[a]);
    out.share *= np_smoothstepf((float)(fmin(u, last - u) / rim_points));
  }
  return out;
}

typedef struct relief_slope {
  float harmonics[NP_RELIEF_TERMS]; /* harmonics of its normal */
  level_light level;
  np_spectrum clear;  /* light of the clear sky without hills, over that on level ground */
  np_spectrum clouds; /* light of the clouds, whose rays hills have ended */
} relief_slope;

static relief_slope make_slope(const np_relief_light *c, const np_ground_hit *hit) {
  relief_slope out = {.level = get_level(c->desc.world, c->desc.ground_light, hit)};
  out.clouds = np_ground_light_add_slope(&out.level.clouds, hit->normal, np_world_get_sky_share(c->desc.world, hit));
  fill_harmonics(hit->normal, out.harmonics);
  for (int k = 0; k < NP_RELIEF_TERMS; k++)
    out.clear = np_spectrum_add_scaled(out.clear, out.harmonics[k], c->clear.term[k]);
  return out;
}

/* Irradiance of a slope at a point. */
static np_spectrum eval_point(const np_relief_point *p, const relief_slope *s) {
  np_spectrum hidden = np_spectrum_grey(0.0f), out = hidden;
  for (int k = 0; k < NP_RELIEF_TERMS; k++) {
    hidden = np_spectrum_add_scaled(hidden, s->harmonics[k], p->hidden.term[k]);
    out = np_spectrum_add_scaled(out, s->harmonics[k], p->ground.term[k]);
  }
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out.band[b] = fmaxf(0.0f, out.band[b]) + s->level.clear.band[b] * fmaxf(0.0f, s->clear.band[b] - hidden.band[b]) +
                  s->clouds.band[b];
  return out;
}

np_spectrum np_relief_light_get(const np_relief_light *c, const np_ground_hit *hit) {
  const relief_cell cell = get_cell(c, hit->position);
  const np_spectrum bare =
      cell.share < 1.0f ? np_relief_light_get_bare(c->desc.world, c->desc.ground_light, hit) : np_spectrum_grey(0.0f);
  if (!(cell.share > 0.0f)) return bare;
  const relief_slope s = make_slope(c, hit);
  np_spectrum out = np_spectrum_grey(0.0f);
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    np_relief_point own;
    const np_relief_point *point = get_point(c, cell.lower[0] + i, cell.lower[1] + j, &own);
    const float weight = (i ? cell.weight[0] : 1.0f - cell.weight[0]) * (j ? cell.weight[1] : 1.0f - cell.weight[1]);
    out = np_spectrum_add_scaled(out, weight, eval_point(point, &s));
  }
  return np_spectrum_mix(bare, out, cell.share);
}
