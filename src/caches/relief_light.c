/* SPDX-License-Identifier: Apache-2.0 */
/* Light of a landscape on itself, from rays that leave each point of a grid in all directions.
 *
 * Without hills the light on a slope is known: the sky's upper half, and level ground below. Rays correct it: one that
 * meets a hill takes away the sky behind it and adds what the hill reflects; one from the lower half adds what the
 * ground there reflects more than level ground does. So an even sky over white ground gives an even light on all slopes
 * exactly, whatever rays are drawn. The light of a place that a ray meets is its sunlight, the sky that the hills about
 * the nearest point leave it, and for the rest of its directions level ground of its own albedo: further reflections
 * are summed as if all the ground nearby were alike.
 */
#include "caches/relief_light.h"

#include "core/alloc.h"
#include "core/units.h"

enum { AZIMUTHS = 8, NEAR_AZIMUTHS = 16, UP = NP_RELIEF_RINGS, DOWN = 2 };

enum { EMPTY, BUSY, DONE }; /* states of a point */

/* Sines of the elevations between rings of directions that go down. */
static const float down_edges[DOWN + 1] = {-1.0f, -0.5f, 0.0f};

/* Distance beyond which air before the ground counts. */
static const double air_from_m = 1000.0;

/* Points over which the light turns into that without hills at the grid's rim. */
static const double rim_points = 2.0;

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

typedef struct relief_ray {
  int ring;
  float azimuth;
  float sine, solid_angle;
} relief_ray;

/* Ground at a place seen from above; false: there is none. */
static bool get_ground(const np_world *world, double x, double y, np_ground_hit *out) {
  const np_dvec3 above = np_dvec3_make(x, y, world->terrain_max.z + 1.0);
  return np_world_intersect_ground(world, above, np_vec3_make(0, 0, -1), out);
}

/* A point of a grid. */
typedef struct relief_point {
  const np_relief_grid *grid;
  int32_t i, j;
} relief_point;

static np_dvec3 get_place(const relief_point *p) {
  const np_relief_grid *g = p->grid;
  return np_dvec3_make(g->origin_m[0] + p->i * g->spacing_m[0], g->origin_m[1] + p->j * g->spacing_m[1], 0.0);
}

/* Uses of random numbers at a point. */
enum { OF_RAYS, OF_HIDDEN_SHADE, OF_GROUND_SHADE, RANDOM_USES };

static np_random start_random(const relief_point *p, unsigned use) {
  const np_relief_grid *g = p->grid;
  return np_random_start(0, use + g->number * RANDOM_USES, (uint32_t)(g->first[0] + p->i),
                         (uint32_t)(g->first[1] + p->j), 0);
}

static int count_azimuths(const relief_point *p) { return p->grid->number > 0 ? NEAR_AZIMUTHS : AZIMUTHS; }

/* A ray within its part of a ring. Those of the terrain's grid are drawn; all near points have the same ones, in the
 * middle of their parts: a few points light all that is near, and their noise would be seen. */
static relief_ray choose_ray(const relief_point *p, const float *edges, int ring, int k, np_random *random) {
  static const float golden = 0.618034f;
  const float height = edges[ring + 1] - edges[ring], width = 2.0f * NP_PI_F / (float)count_azimuths(p);
  const bool is_near = p->grid->number > 0;
  const float turn = is_near ? golden * (float)ring - floorf(golden * (float)ring) : np_random_float(random);
  const float rise = is_near ? 0.5f : np_random_float(random);
  return (relief_ray){ring, ((float)k + turn) * width, edges[ring] + height * rise, height * width};
}

/* ---- What hills hide ---- */

/* Adds a ray of the upper half: a hill hides the sky behind it, and shade takes a part of the light before that. */
static void hide_ray(const np_relief_light *c, np_dvec3 origin, const relief_ray *ray, np_random *random,
                     np_relief_hidden *out) {
  const np_vec3 towards = np_relief_make_direction(ray->sine, ray->azimuth);
  const np_relief_patch *patch = np_relief_sky_get(&c->sky, ray->ring, ray->azimuth);
  np_spectrum lost = np_spectrum_grey(1.0f);
  if (isinf(np_world_find_ground(c->desc.world, origin, towards, NULL)))
    lost = np_relief_air_shade(&patch->air, c->desc.world, origin, towards, 1, random);
  else
    np_relief_add_share(towards, ray->solid_angle / NP_PI_F, out->blocked);
  np_relief_add_light(towards, np_spectrum_scale(np_spectrum_multiply(lost, patch->radiance), ray->solid_angle),
                      &out->sky);
}

/* Places along each direction of the glow. */
enum { GLOW_PLACES = 2 };

/* A point from which nothing is hidden. */
static np_relief_hidden make_open(void) {
  np_relief_hidden out = {0};
  for (int n = 0; n < NP_RELIEF_GLOW; n++) out.glow_left[n] = np_spectrum_grey(1.0f);
  return out;
}

static void fill_hidden(const np_relief_light *c, const relief_point *p, np_relief_hidden *out) {
  *out = make_open();
  const np_dvec3 place = get_place(p);
  np_ground_hit here;
  if (!get_ground(c->desc.world, place.x, place.y, &here)) return;
  np_random random = start_random(p, OF_RAYS), of_shade = start_random(p, OF_HIDDEN_SHADE);
  for (int ring = 0; ring < UP; ring++)
    for (int k = 0; k < count_azimuths(p); k++) {
      const relief_ray ray = choose_ray(p, np_relief_ring_edges, ring, k, &random);
      hide_ray(c, here.position, &ray, &of_shade, out);
    }
  if (np_spectrum_is_zero(c->sky.glow_share)) return;
  for (int n = 0; n < NP_RELIEF_GLOW; n++) {
    const np_glow_direction *ray = &c->sky.glow[n];
    np_spectrum lost = np_spectrum_grey(1.0f);
    if (isinf(np_world_find_ground(c->desc.world, here.position, ray->towards, NULL)))
      lost = np_relief_air_shade(&ray->air, c->desc.world, here.position, ray->towards, GLOW_PLACES, &of_shade);
    out->glow_left[n] = np_spectrum_subtract(np_spectrum_grey(1.0f), lost);
  }
}

/* Whether a slot's part is to be stored by this thread. Threads that need one point at a time each compute it, and the
 * first one stores it. */
static bool claim(atomic_uchar *state) {
  unsigned char expected = EMPTY;
  return atomic_compare_exchange_strong(state, &expected, BUSY);
}

static np_relief_slot *get_slot(const relief_point *p) {
  return &p->grid->points[(size_t)p->j * NP_RELIEF_POINTS_MAX + (size_t)p->i];
}

/* Light hidden from a point, from the cache or computed. */
static const np_relief_hidden *get_hidden(const np_relief_light *c, const relief_point *p, np_relief_hidden *own) {
  np_relief_slot *slot = get_slot(p);
  if (atomic_load_explicit(&slot->hidden_state, memory_order_acquire) == DONE) return &slot->hidden;
  fill_hidden(c, p, own);
  if (!claim(&slot->hidden_state)) return own;
  slot->hidden = *own;
  atomic_store_explicit(&slot->hidden_state, DONE, memory_order_release);
  return own;
}

/* The same of the nearest point in the finest grid, up to a number, that holds a place; beyond all grids nothing is
 * hidden. */
static const np_relief_hidden *get_nearest_hidden(const np_relief_light *c, unsigned finest, np_dvec3 place,
                                                  np_relief_hidden *own) {
  const double last = NP_RELIEF_POINTS_MAX - 1;
  for (unsigned n = finest + 1; n-- > 0;) {
    const np_relief_grid *g = &c->grids[n];
    const double u = (place.x - g->origin_m[0]) / g->spacing_m[0], v = (place.y - g->origin_m[1]) / g->spacing_m[1];
    if (u >= 0.0 && v >= 0.0 && u <= last && v <= last)
      return get_hidden(c, &(relief_point){g, (int32_t)lround(u), (int32_t)lround(v)}, own);
  }
  *own = make_open();
  return own;
}

/* ---- Light from the ground ---- */

/* Light that hills about a place leave it: shares of the clear sky's irradiance on level ground that arrive on a slope,
 * and of the irradiance of an even sky that hills take. */
typedef struct open_sky {
  np_spectrum open;
  float blocked;
} open_sky;

/* `share` is the slope's of an even sky. */
static open_sky open_slope(const np_relief_light *c, const np_relief_hidden *hidden, np_vec3 normal, float share) {
  float harmonics[NP_RELIEF_TERMS];
  np_relief_fill_harmonics(normal, harmonics);
  const np_spectrum clear = np_relief_sum_terms(&c->sky.clear, harmonics),
                    behind = np_relief_sum_terms(&hidden->sky, harmonics);
  const float even = np_relief_sum_shares(c->sky.even, harmonics);
  open_sky out = {.blocked = np_clampf(np_relief_sum_shares(hidden->blocked, harmonics), 0.0f, share)};
  const np_glow_cosines cosines = np_relief_sky_aim(&c->sky, normal);
  const np_spectrum glow = np_relief_sky_compute_glow(&c->sky, &cosines, hidden->glow_left);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out.open.band[b] = fmaxf(0.0f, share + clear.band[b] - even - behind.band[b]) + glow.band[b];
  return out;
}

/* Radiance of ground that a ray meets, with what hills hide from the nearest point. Ground about it has the light of a
 * level place there, and reflects it to and fro. */
static np_spectrum light_ground(const np_relief_light *c, const np_relief_hidden *hidden, const np_ground_hit *hit) {
  const np_world *world = c->desc.world;
  const level_light level = get_level(world, c->desc.ground_light, hit);
  const np_vec3 zenith = np_zenith(hit->position, world->planet_radius_m);
  const float cosine = np_vec3_dot(hit->normal, world->to_sun), up = np_vec3_dot(zenith, world->to_sun),
              share = np_world_get_sky_share(world, hit);
  const np_spectrum sun = cosine > 0.0f ? get_sunlight(c, hit->position) : np_spectrum_grey(0.0f);
  const open_sky flat = open_slope(c, hidden, zenith, 1.0f), slope = open_slope(c, hidden, hit->normal, share);
  np_spectrum out = np_ground_light_add_slope(&level.clouds, hit->normal, share);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float albedo = hit->albedo.band[b], clear = level.clear.band[b];
    const float around = clear * flat.open.band[b] / (1.0f - fminf(flat.blocked * albedo, 0.9f)) +
                         level.clouds.added.band[b] + fmaxf(up, 0.0f) * sun.band[b];
    out.band[b] += clear * slope.open.band[b] + (1.0f - share + slope.blocked) * albedo * around +
                   fmaxf(cosine, 0.0f) * sun.band[b];
  }
  return reflect(out, hit->albedo);
}

/* Radiance of the ground through the air before it. */
static np_spectrum compute_ground_radiance(const np_relief_light *c, unsigned finest, np_dvec3 origin,
                                           np_vec3 direction, const np_ground_hit *hit, np_random *random) {
  np_relief_hidden own;
  const np_spectrum light = light_ground(c, get_nearest_hidden(c, finest, hit->position, &own), hit);
  np_air_parts air;
  if (hit->distance_m < air_from_m) return light;
  if (!np_relief_trace_air(c->desc.world, origin, direction, hit->distance_m, random, &air)) return light;
  return np_spectrum_add(np_spectrum_multiply(light, air.transmittance), air.all);
}

static void add_up(const np_relief_light *c, unsigned finest, np_dvec3 origin, const relief_ray *ray, np_random *random,
                   np_relief_irradiance *out) {
  const np_vec3 towards = np_relief_make_direction(ray->sine, ray->azimuth);
  np_ground_hit hit;
  if (!np_world_intersect_ground(c->desc.world, origin, towards, &hit)) return;
  np_relief_add_light(
      towards, np_spectrum_scale(compute_ground_radiance(c, finest, origin, towards, &hit, random), ray->solid_angle),
      out);
}

/* Adds the difference to level ground of radiance `level`. */
static void add_down(const np_relief_light *c, unsigned finest, np_dvec3 origin, const relief_ray *ray,
                     np_spectrum level, np_random *random, np_relief_irradiance *out) {
  const np_vec3 towards = np_relief_make_direction(ray->sine, ray->azimuth);
  np_ground_hit hit;
  if (!np_world_intersect_ground(c->desc.world, origin, towards, &hit)) return;
  const np_spectrum more =
      np_spectrum_subtract(compute_ground_radiance(c, finest, origin, towards, &hit, random), level);
  np_relief_add_light(towards, np_spectrum_scale(more, ray->solid_angle), out);
}

/* Adds uniform light from the lower hemisphere: a slope at angle θ gets ½(1 − cos θ) of its irradiance. */
static void add_lower_half(np_spectrum irradiance, np_relief_irradiance *sum) {
  sum->term[0] = np_spectrum_add_scaled(sum->term[0], 0.5f / np_relief_harmonic_0, irradiance);
  sum->term[2] = np_spectrum_add_scaled(sum->term[2], -0.5f / np_relief_harmonic_1, irradiance);
}

/* Computes the light from the ground at a point. */
static void fill_ground(const np_relief_light *c, const relief_point *p, np_relief_irradiance *out) {
  *out = (np_relief_irradiance){0};
  const unsigned finest = p->grid->number;
  const np_dvec3 place = get_place(p);
  np_ground_hit here;
  if (!get_ground(c->desc.world, place.x, place.y, &here)) return;
  np_ground_hit flat = here;
  np_relief_hidden own;
  flat.normal = np_zenith(here.position, c->desc.world->planet_radius_m);
  const np_spectrum level = light_ground(c, get_hidden(c, p, &own), &flat);
  add_lower_half(np_spectrum_scale(level, NP_PI_F), out);
  np_random random = start_random(p, OF_RAYS), of_shade = start_random(p, OF_GROUND_SHADE);
  for (int ring = 0; ring < UP; ring++)
    for (int k = 0; k < count_azimuths(p); k++) {
      const relief_ray ray = choose_ray(p, np_relief_ring_edges, ring, k, &random);
      add_up(c, finest, here.position, &ray, &of_shade, out);
    }
  for (int ring = 0; ring < DOWN; ring++)
    for (int k = 0; k < count_azimuths(p); k++) {
      const relief_ray ray = choose_ray(p, down_edges, ring, k, &random);
      add_down(c, finest, here.position, &ray, level, &of_shade, out);
    }
}

static const np_relief_irradiance *get_from_ground(const np_relief_light *c, const relief_point *p,
                                                   np_relief_irradiance *own) {
  np_relief_slot *slot = get_slot(p);
  if (atomic_load_explicit(&slot->ground_state, memory_order_acquire) == DONE) return &slot->ground;
  fill_ground(c, p, own);
  if (!claim(&slot->ground_state)) return own;
  slot->ground = *own;
  atomic_store_explicit(&slot->ground_state, DONE, memory_order_release);
  return own;
}

/* ---- The cache ---- */

enum { FINER = 2 }; /* ratio of the spacings of two grids */

/* Steps by which finer grids follow the eye, in their points, and the distance from it, in points, that they always
 * cover. */
enum { FOLLOW = 8, COVERED = (NP_RELIEF_POINTS_MAX - FOLLOW) / 2 - 1 };

static void clear_points(np_relief_grid *g) {
  for (size_t n = 0; n < NP_RELIEF_POINTS_MAX * NP_RELIEF_POINTS_MAX; n++) {
    atomic_init(&g->points[n].hidden_state, EMPTY);
    atomic_init(&g->points[n].ground_state, EMPTY);
  }
}

static neph_result allocate_points(neph_context *context, np_relief_grid *g) {
  g->points = np_alloc(context, NP_RELIEF_POINTS_MAX * NP_RELIEF_POINTS_MAX, sizeof *g->points);
  if (!g->points) return NEPH_ERROR_OUT_OF_MEMORY;
  clear_points(g);
  return NEPH_OK;
}

static np_relief_grid place_over_terrain(const np_world *world) {
  np_relief_grid out = {.number = 0, .weight = 1.0f};
  double low[2], high[2];
  np_terrain_get_core(world->terrain, low, high);
  for (int a = 0; a < 2; a++) {
    out.origin_m[a] = low[a];
    out.spacing_m[a] = (high[a] - low[a]) / (NP_RELIEF_POINTS_MAX - 1);
  }
  return out;
}

/* A finer grid about the eye, of which every FINER-th point would be one of the next coarser. */
static np_relief_grid place_about(const np_relief_grid *terrain, unsigned number, np_dvec3 eye) {
  const double at[2] = {eye.x, eye.y};
  np_relief_grid out = {.number = number};
  for (int a = 0; a < 2; a++) {
    out.spacing_m[a] = terrain->spacing_m[a] * pow(FINER, -(double)number);
    const double first = (at[a] - terrain->origin_m[a]) / out.spacing_m[a] - 0.5 * NP_RELIEF_POINTS_MAX;
    out.first[a] = FOLLOW * (int32_t)np_clamp(round(first / FOLLOW), -1e6, 1e6);
    out.eye_m[a] = at[a];
    out.origin_m[a] = terrain->origin_m[a] + out.first[a] * out.spacing_m[a];
  }
  return out;
}

/* Least spacing of points, in the ground's own. */
static const double cells_least = 0.75;

/* Weight of a grid by what it shows beside the next coarser one: none where it is finer than the ground, and less the
 * higher the eye is above that. */
static float weigh(const np_world *world, const np_relief_grid *g, np_dvec3 eye) {
  const double spacing_m = fmax(g->spacing_m[0], g->spacing_m[1]);
  const double above_m = eye.z - neph_terrain_get_elevation_m(world->terrain, eye.x, eye.y);
  if (spacing_m < cells_least * np_terrain_get_cell_m(world->terrain)) return 0.0f;
  return np_smoothstepf((float)(4.0 - 4.0 * above_m / (COVERED * spacing_m)));
}

/* Ground in the middle of the terrain. */
static np_dvec3 get_middle(const np_relief_light *c) {
  const np_relief_grid *g = &c->grids[0];
  np_ground_hit middle;
  const double x = g->origin_m[0] + 0.5 * (NP_RELIEF_POINTS_MAX - 1) * g->spacing_m[0],
               y = g->origin_m[1] + 0.5 * (NP_RELIEF_POINTS_MAX - 1) * g->spacing_m[1];
  return get_ground(c->desc.world, x, y, &middle) ? middle.position : np_dvec3_make(x, y, 0.0);
}

/* A grid keeps its points where it and all coarser ones stay where they were: these light what its rays meet. */
static neph_result move_grid(neph_context *context, np_relief_grid *wanted, bool *are_moved, np_relief_grid *grid) {
  *are_moved = *are_moved || !grid->points || grid->first[0] != wanted->first[0] || grid->first[1] != wanted->first[1];
  wanted->points = grid->points;
  *grid = *wanted;
  if (!grid->points) return allocate_points(context, grid);
  if (*are_moved) clear_points(grid);
  return NEPH_OK;
}

/* Frees grids from a number on. */
static void drop_grids(np_relief_light *cache, unsigned first) {
  for (unsigned n = first; n < NP_RELIEF_GRIDS_MAX; n++) {
    np_alloc_free(cache->context, cache->grids[n].points);
    cache->grids[n].points = NULL;
  }
}

neph_result np_relief_light_set(np_relief_light *cache, const np_relief_light_desc *desc) {
  neph_result result = NEPH_OK;
  bool are_moved = false;
  cache->desc = *desc;
  cache->grid_count = 1;
  for (unsigned n = 1; n < NP_RELIEF_GRIDS_MAX && desc->eye && !result; n++) {
    np_relief_grid wanted = place_about(&cache->grids[0], n, *desc->eye);
    wanted.weight = weigh(desc->world, &wanted, *desc->eye);
    if (!(wanted.weight > 0.0f)) break;
    result = move_grid(cache->context, &wanted, &are_moved, &cache->grids[n]);
    if (!result) cache->grid_count++;
  }
  drop_grids(cache, cache->grid_count);
  cache->desc.eye = NULL;
  return result;
}

neph_result np_relief_light_build(neph_context *context, const np_relief_light_desc *desc, np_relief_light *out) {
  *out = (np_relief_light){.context = context, .desc = *desc, .grids = {place_over_terrain(desc->world)}};
  neph_result result = allocate_points(context, &out->grids[0]);
  if (!result) result = np_relief_light_set(out, desc);
  if (result) return np_relief_light_clear(out), result;
  np_relief_sky_build(desc->world, get_middle(out), &out->sky);
  return NEPH_OK;
}

void np_relief_light_clear(np_relief_light *cache) {
  drop_grids(cache, 0);
  *cache = (np_relief_light){0};
}

/* ---- Look-up ---- */

/* The cell of four points about a place. */
typedef struct relief_cell {
  int32_t lower[2];
  float weight[2]; /* weight of the upper point along each axis */
  float share;     /* 1 well within the grid, 0 at its rim and beyond */
} relief_cell;

static relief_cell get_cell(const np_relief_grid *g, np_dvec3 position) {
  const double p[2] = {position.x, position.y};
  relief_cell out = {.share = 1.0f};
  for (int a = 0; a < 2; a++) {
    const double last = NP_RELIEF_POINTS_MAX - 1, u = (p[a] - g->origin_m[a]) / g->spacing_m[a];
    const double inside = np_clamp(u, 0.0, last);
    out.lower[a] = (int32_t)inside < NP_RELIEF_POINTS_MAX - 2 ? (int32_t)inside : NP_RELIEF_POINTS_MAX - 2;
    out.weight[a] = (float)(inside - out.lower[a]);
    out.share *= np_smoothstepf((float)(fmin(u, last - u) / rim_points));
  }
  return out;
}

/* Weight of a grid at a place: finer ones fade away from the eye, so that nothing jumps where they follow it. */
static float weigh_place(const np_relief_grid *g, np_dvec3 position) {
  if (g->number == 0) return 1.0f;
  const double away = hypot((position.x - g->eye_m[0]) / g->spacing_m[0], (position.y - g->eye_m[1]) / g->spacing_m[1]);
  return g->weight * np_smoothstepf((float)(4.0 - 4.0 * away / COVERED));
}

typedef struct relief_slope {
  float harmonics[NP_RELIEF_TERMS]; /* harmonics of its normal */
  level_light level;
  np_spectrum clear; /* light of the clear sky but for its glow without hills, over that on level ground */
  np_glow_cosines glow;
  np_spectrum clouds; /* light of the clouds, whose rays hills have ended */
} relief_slope;

static relief_slope make_slope(const np_relief_light *c, const np_ground_hit *hit) {
  relief_slope out = {.level = get_level(c->desc.world, c->desc.ground_light, hit)};
  out.clouds = np_ground_light_add_slope(&out.level.clouds, hit->normal, np_world_get_sky_share(c->desc.world, hit));
  np_relief_fill_harmonics(hit->normal, out.harmonics);
  out.clear = np_relief_sum_terms(&c->sky.clear, out.harmonics);
  out.glow = np_relief_sky_aim(&c->sky, hit->normal);
  return out;
}

/* Irradiance of a slope at a point. */
static np_spectrum eval_point(const np_relief_light *c, const relief_point *p, const relief_slope *s) {
  np_relief_hidden own_hidden;
  np_relief_irradiance own_ground;
  const np_relief_hidden *point = get_hidden(c, p, &own_hidden);
  const np_spectrum hidden = np_relief_sum_terms(&point->sky, s->harmonics),
                    glow = np_relief_sky_compute_glow(&c->sky, &s->glow, point->glow_left);
  np_spectrum out = np_relief_sum_terms(get_from_ground(c, p, &own_ground), s->harmonics);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float open = fmaxf(0.0f, s->clear.band[b] - hidden.band[b]) + glow.band[b];
    out.band[b] = fmaxf(0.0f, out.band[b]) + s->level.clear.band[b] * open + s->clouds.band[b];
  }
  return out;
}

static np_spectrum eval_cell(const np_relief_light *c, const np_relief_grid *g, const relief_cell *cell,
                             const relief_slope *s) {
  np_spectrum out = np_spectrum_grey(0.0f);
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const float weight =
        (i ? cell->weight[0] : 1.0f - cell->weight[0]) * (j ? cell->weight[1] : 1.0f - cell->weight[1]);
    const relief_point point = {g, cell->lower[0] + i, cell->lower[1] + j};
    if (weight > 0.0f) out = np_spectrum_add_scaled(out, weight, eval_point(c, &point, s));
  }
  return out;
}

/* The finest grid first; what it leaves is the next one's. */
np_spectrum np_relief_light_get(const np_relief_light *c, const np_ground_hit *hit) {
  const relief_slope s = make_slope(c, hit);
  np_spectrum out = np_spectrum_grey(0.0f);
  float left = 1.0f;
  for (unsigned n = c->grid_count; n-- > 0 && left > 0.0f;) {
    const relief_cell cell = get_cell(&c->grids[n], hit->position);
    const float share = cell.share * weigh_place(&c->grids[n], hit->position);
    if (!(share > 0.0f)) continue;
    out = np_spectrum_add_scaled(out, left * share, eval_cell(c, &c->grids[n], &cell, &s));
    left *= 1.0f - share;
  }
  if (!(left > 0.0f)) return out;
  return np_spectrum_add_scaled(out, left, np_relief_light_get_bare(c->desc.world, c->desc.ground_light, hit));
}
