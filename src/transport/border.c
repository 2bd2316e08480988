/* SPDX-License-Identifier: Apache-2.0 */
/* Air outside is that of a node's height, traced once for each direction and five heights; the shadow of clouds and
 * hills on it is the share of its first order of scattering that they take, by cells whose length grows with the
 * distance. */
#include "transport/border.h"
#include "transport/cell_air.h"
#include "transport/scattering_field.h"

#include <stdlib.h>
#include <string.h>

#include "atmosphere/sky_along.h"
#include "core/alloc.h"
#include "core/units.h"

enum {
  NODES = NP_BORDER_NODES,
  EVEN = 5,               /* number of equidistant nodes along an axis */
  DIRECTIONS = 1024,      /* directions over the whole sphere, of which half leave through a face, … */
  DIRECTIONS_ROUGH = 256, /* … and for a rough solution */
  AIR_CELLS = 12,
  FACES = 6,
  MARGIN = (NP_BORDER_WIDE - NP_BORDER_PLAN) / 2
};

static const double reach_m = 60e3;    /* shadows on air farther off are left out */
static const double clearance_m = 1.0; /* above ground, of nodes that hills would bury */

/* ---- The directions and their air ---- */

/* Air along one direction, traced from each height of the nodes; and its in-scatter as seen from the middle of the
 * clouds, all orders, the first, and of even light, up to the end of each cell. */
typedef struct air_ray {
  np_aerial_perspective whole[EVEN];
  np_spectrum all[AIR_CELLS + 1], first[AIR_CELLS + 1], even[AIR_CELLS + 1][NP_BORDER_WAYS], all_whole;
} air_ray;

typedef struct border_fill {
  const np_transport_grid *grid;
  const np_world *world;
  const np_sun_optical_depth_source *depths;
  const float *fade;
  const np_border_set *sets;
  unsigned set_count;
  double low[3], high[3];
  unsigned direction_count;
  int cells_a_place;                                /* cells of air that share a place of shadows */
  np_vec3 direction[DIRECTIONS];                    /* looking out */
  uint16_t nearest[NP_BORDER_SETS_MAX][DIRECTIONS]; /* octant × lanes + ordinate */
  air_ray *air;                                     /* NULL: no air that shines */
  float glint; /* factor on the sun's light that waves reflect along these directions */
} border_fill;

enum { OCTANT = NP_ORDINATE_BLOCKS_MAX * NP_ORDINATE_LANES, ALL = NP_OCTANT_COUNT * OCTANT };

static double compute_cell_end(int cell) { return reach_m * cell * cell / (AIR_CELLS * AIR_CELLS); }

static double compute_place(const border_fill *f, int axis, double share) {
  return f->low[axis] + (f->high[axis] - f->low[axis]) * share;
}

static void choose_directions(border_fill *f) {
  for (unsigned i = 0; i < f->direction_count; i++) {
    const double z = 1.0 - (2.0 * i + 1.0) / f->direction_count, azimuth = i * (NP_PI * (3.0 - sqrt(5.0)));
    const float r = (float)sqrt(1.0 - z * z);
    f->direction[i] = np_vec3_make(r * (float)cos(azimuth), r * (float)sin(azimuth), (float)z);
    for (unsigned s = 0; s < f->set_count; s++)
      f->nearest[s][i] =
          (uint16_t)np_ordinates_search_nearest(f->sets[s].ordinates, np_vec3_scale(f->direction[i], -1.0f));
  }
}

/* Share of the sun's light that the waves of level water reflect against a direction, 1/sr. */
static float reflect_sun(const border_fill *f, unsigned direction) {
  const np_vec3 zenith = np_vec3_make(0.0f, 0.0f, 1.0f), to_viewer = np_vec3_scale(f->direction[direction], -1.0f);
  return to_viewer.z > 0.0f ? np_water_eval(f->world->water, zenith, to_viewer, f->world->to_sun).reflected : 0.0f;
}

/* Flux of sunlight reflected by level water, relative to its sum over the directions that look down. A
 * lobe between ordinates is lost. */
static float compute_glint(const border_fill *f) {
  const float cosine = f->world->to_sun.z;
  if (!f->world->water || !(cosine > 0.0f)) return 1.0f;
  double sum = 0.0;
  for (unsigned i = 0; i < f->direction_count; i++) sum -= (double)(f->direction[i].z * reflect_sun(f, i));
  const double flux = (double)(cosine * np_water_reflectance(f->world->water, cosine));
  return (float)np_clamp(flux / (sum * 4.0 * NP_PI / f->direction_count), 0.0, 4.0);
}

/* The same light along the ordinates, over its mean in Lambert's sense: Σ weight·cosine·glint = π. */
static void fill_glint(const border_fill *f, unsigned set) {
  const np_ordinates *o = f->sets[set].ordinates;
  float *out = &f->sets[set].border->glint[0][0][0];
  unsigned counts[ALL] = {0};
  if (!f->world->water || !(f->world->to_sun.z > 0.0f)) return;
  for (unsigned i = 0; i < f->direction_count; i++) {
    out[f->nearest[set][i]] += reflect_sun(f, i);
    counts[f->nearest[set][i]]++;
  }
  double flux = 0.0;
  for (unsigned n = 0; n < ALL; n++) {
    const unsigned block = n % OCTANT / NP_ORDINATE_LANES, lane = n % NP_ORDINATE_LANES;
    if (counts[n]) out[n] /= (float)counts[n];
    flux += (double)(out[n] * o->weight[block][lane] * o->cosine[2][block][lane]);
  }
  for (unsigned n = 0; n < ALL; n++) out[n] *= flux > 0.0 ? (float)(NP_PI / flux) : 0.0f;
}

static neph_result trace_air(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const border_fill *f = user;
  const neph_sky *sky = f->world->cloud_sky;
  for (size_t i = begin; i < end; i++) {
    const np_vec3 towards = f->direction[i];
    air_ray *a = &f->air[i];
    for (unsigned h = 0; h < EVEN; h++) {
      const np_dvec3 from =
          np_dvec3_make(compute_place(f, 0, 0.5), compute_place(f, 1, 0.5), compute_place(f, 2, h / (EVEN - 1.0)));
      a->whole[h] = np_sky_trace_air(sky, from, towards, INFINITY);
    }
    const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(sky, towards);
    const np_sky_ray ray = np_sky_ray_start(sky, towards);
    for (int c = 1; c <= AIR_CELLS; c++) {
      a->all[c] = np_sky_ray_get_air(&ray, compute_cell_end(c), &a->first[c]).inscatter;
      const np_even_inscatter even = np_sky_compute_even_inscatter(&ray, compute_cell_end(c), &shares);
      a->even[c][NP_BORDER_DOWN] = even.upper;
      a->even[c][NP_BORDER_UP] = even.lower;
    }
    a->all_whole = np_sky_ray_get_air(&ray, INFINITY, NULL).inscatter;
  }
  return NEPH_OK;
}

/* ---- A node ---- */

/* Gains of a node's radiances in one set. The next node reuses the room. */
typedef struct node_responses {
  np_border_response *at;
  size_t count, room;
} node_responses;

typedef struct border_node {
  const border_fill *fill;
  np_dvec3 position;
  int axis, side; /* side: −1 low, 1 high */
  unsigned u, v;
  neph_result result;
  double sums[NP_BORDER_SETS_MAX][ALL][NP_BAND_COUNT];
  unsigned counts[NP_BORDER_SETS_MAX][ALL];
  uint16_t sampled[DIRECTIONS], sampled_count; /* directions that look out */
  np_spectrum radiance[DIRECTIONS];            /* radiances along the directions */
  node_responses responses[NP_BORDER_SETS_MAX];
} border_node;

static neph_result add_response(neph_context *context, node_responses *list, np_border_response response) {
  if (list->count == list->room) {
    const size_t room = list->room ? 2 * list->room : 1024;
    np_border_response *grown = np_alloc_resize(context, list->at, room, sizeof *grown);
    if (!grown) return NEPH_ERROR_OUT_OF_MEMORY;
    list->at = grown;
    list->room = room;
  }
  list->at[list->count++] = response;
  return NEPH_OK;
}

/* The square, at a level past the box, that a place is in; false: light of the box does not reach it. */
static bool locate_square(const border_fill *f, np_border_way way, np_dvec3 place, uint32_t *out) {
  if (f->grid->fold.period_m > 0.0) place = np_transport_fold_match(&f->grid->fold, place);
  double at[2] = {place.x, place.y};
  uint32_t cell[2];
  for (int a = 0; a < 2; a++) {
    double t = (at[a] - f->low[a]) / (f->high[a] - f->low[a]);
    if (f->grid->is_wrapped[a]) t -= floor(t);
    const double n = floor(t * NP_BORDER_PLAN) + MARGIN;
    if (!(n >= 0.0 && n < NP_BORDER_WIDE)) return false;
    cell[a] = (uint32_t)n;
  }
  const double past_m = way == NP_BORDER_DOWN ? f->low[2] - place.z : place.z - f->high[2];
  const uint32_t level = (uint32_t)np_border_search_level(f->sets[0].border, way, past_m);
  *out = ((way * NP_BORDER_LEVELS + level) * NP_BORDER_WIDE + cell[1]) * NP_BORDER_WIDE + cell[0];
  return true;
}

/* Adds a gain to the ordinate nearest to a direction. */
static void add_gain(border_node *n, unsigned direction, uint32_t square, np_spectrum per_irradiance) {
  for (unsigned s = 0; s < n->fill->set_count && !n->result; s++)
    n->result = add_response(n->fill->grid->context, &n->responses[s],
                             (np_border_response){n->fill->nearest[s][direction], square, per_irradiance});
}

static float get_beam(const border_fill *f, np_dvec3 place) {
  return np_transmittance(f->depths->get(f->depths->user, place, f->world->to_sun, f->fade, 16.0f));
}

static float get_sun_visibility(const border_fill *f, np_dvec3 place) {
  if (np_world_is_behind_terrain(f->world, place, f->world->to_sun)) return 0.0f;
  return get_beam(f, place);
}

/* Gain of even in-scatter for a unit of irradiance from a hemisphere, whose even light has an actinic flux of twice its
 * irradiance. */
static np_spectrum compute_even_gain(const np_world *world, np_dvec3 place) {
  const np_spectrum sun = np_spectrum_multiply(
      world->sun_irradiance,
      np_atmosphere_transmittance_to_sun(world->atmosphere, place, world->to_sun, world->sun_angular_radius_rad));
  np_spectrum out = np_spectrum_grey(0.0f);
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    if (sun.band[b] > 1e-3f * world->sun_irradiance.band[b]) out.band[b] = 2.0f / sun.band[b];
  return out;
}

/* Shadow and light of the clouds at a place in the air. */
typedef struct air_place {
  float shadow;
  bool is_reached; /* light that leaves the box through `square` reaches it */
  np_border_way way;
  uint32_t square;
  np_spectrum gain; /* compute_even_gain */
} air_place;

/* Draws a place between two distances along a direction. */
static air_place draw_place(const border_node *n, unsigned direction, int cell, double near_m, double far_m) {
  const border_fill *f = n->fill;
  const double jitter = fmod(0.618033988749895 * (direction * AIR_CELLS + (unsigned)cell) + 0.7548776662466927 * n->u +
                                 0.5698402909980532 * n->v,
                             1.0);
  const np_dvec3 place = np_dvec3_along(n->position, f->direction[direction], near_m + jitter * (far_m - near_m));
  air_place out = {.shadow = 1.0f - get_sun_visibility(f, place),
                   .way = place.z < f->low[2] ? NP_BORDER_DOWN : NP_BORDER_UP};
  out.is_reached = (place.z < f->low[2] || place.z > f->high[2]) && locate_square(f, out.way, place, &out.square);
  if (out.is_reached) out.gain = compute_even_gain(f->world, place);
  return out;
}

/* In-scatter of air up to a distance, dimmed by shadows; `air` is the in-scatter without shadows. */
static np_spectrum shade_air(border_node *n, unsigned direction, double distance_m, np_spectrum air) {
  const border_fill *f = n->fill;
  const air_ray *a = &f->air[direction];
  np_spectrum lost = np_spectrum_grey(0.0f), total = a->all_whole, ratio;
  const bool is_short = distance_m < reach_m;
  const int last = is_short ? (int)(AIR_CELLS * sqrt(distance_m / reach_m)) : AIR_CELLS - 1;
  const double begin = compute_cell_end(last), end = compute_cell_end(last + 1);
  const float part = is_short ? (float)((distance_m - begin) / (end - begin)) : 1.0f;
  if (is_short) total = np_spectrum_mix(a->all[last], a->all[last + 1], part);
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    ratio.band[b] = total.band[b] > 0.0f ? air.band[b] / total.band[b] : 0.0f;
  air_place place = {.shadow = 0.0f};
  for (int c = 0; c <= last; c++) {
    if (c % f->cells_a_place == 0)
      place =
          draw_place(n, direction, c, compute_cell_end(c), fmin(compute_cell_end(c + f->cells_a_place), distance_m));
    const float share = c == last ? part : 1.0f;
    lost = np_spectrum_add_scaled(lost, share * place.shadow, np_spectrum_subtract(a->first[c + 1], a->first[c]));
    if (!place.is_reached) continue;
    const np_spectrum even =
        np_spectrum_scale(np_spectrum_subtract(a->even[c + 1][place.way], a->even[c][place.way]), share);
    add_gain(n, direction, place.square, np_spectrum_multiply(np_spectrum_multiply(even, ratio), place.gain));
  }
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    air.band[b] = fmaxf(0.0f, air.band[b] - ratio.band[b] * fmaxf(0.0f, lost.band[b]));
  return air;
}

/* Air of the node's height. */
static np_aerial_perspective get_whole_air(const border_node *n, unsigned direction) {
  const border_fill *f = n->fill;
  const np_aerial_perspective *whole = f->air[direction].whole;
  const double at = np_clamp((n->position.z - f->low[2]) / (f->high[2] - f->low[2]), 0.0, 1.0) * (EVEN - 1);
  const unsigned i = at < EVEN - 2 ? (unsigned)at : EVEN - 2;
  const float t = (float)(at - i);
  return (np_aerial_perspective){np_spectrum_mix(whole[i].transmittance, whole[i + 1].transmittance, t),
                                 np_spectrum_mix(whole[i].inscatter, whole[i + 1].inscatter, t)};
}

static np_spectrum trace_radiance(border_node *n, unsigned direction) {
  const border_fill *f = n->fill;
  const np_vec3 towards = f->direction[direction];
  np_ground_hit hit;
  const bool has_hit = np_world_intersect_ground(f->world, n->position, towards, &hit);
  const double distance_m = has_hit ? hit.distance_m : (double)INFINITY;
  np_aerial_perspective air = {np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  if (f->air) {
    const bool is_sphere = has_hit && !f->world->terrain;
    air = has_hit && !is_sphere ? np_sky_trace_air(f->world->cloud_sky, n->position, towards, distance_m)
                                : get_whole_air(n, direction);
    air.inscatter = shade_air(n, direction, distance_m, air.inscatter);
  } else if (has_hit) {
    air = np_world_air(f->world, NULL, n->position, towards, distance_m);
  }
  if (!has_hit) return np_world_add_beyond(f->world, n->position, towards, air.inscatter);
  np_spectrum ground_gain;
  const np_spectrum ground =
      np_boundary_radiance_light_ground(f->world, f->depths, f->fade, &hit, towards, f->glint, &ground_gain);
  uint32_t square;
  if (locate_square(f, NP_BORDER_DOWN, hit.position, &square))
    add_gain(n, direction, square, np_spectrum_multiply(ground_gain, air.transmittance));
  return np_spectrum_add(np_spectrum_multiply(ground, air.transmittance), air.inscatter);
}

/* Directions that look out of the node's face. */
static void sample_node(border_node *n) {
  for (unsigned i = 0; i < n->fill->direction_count; i++) {
    const np_vec3 d = n->fill->direction[i];
    const float along = n->axis == 0 ? d.x : n->axis == 1 ? d.y : d.z;
    if (along * (float)n->side <= 0.0f) continue;
    n->radiance[i] = trace_radiance(n, i);
    n->sampled[n->sampled_count++] = (uint16_t)i;
    for (unsigned s = 0; s < n->fill->set_count; s++) {
      const unsigned ordinate = n->fill->nearest[s][i];
      for (unsigned b = 0; b < NP_BAND_COUNT; b++) n->sums[s][ordinate][b] += (double)n->radiance[i].band[b];
      n->counts[s][ordinate]++;
    }
  }
}

/* An ordinate that is nearest to none of the directions takes the one nearest to it. */
static np_spectrum get_nearest_sample(const border_node *n, const np_ordinates *o, unsigned octant, unsigned number) {
  const np_vec3 flight = np_ordinates_direction(o, octant, number / NP_ORDINATE_LANES, number % NP_ORDINATE_LANES);
  unsigned best = n->sampled[0];
  for (unsigned k = 1; k < n->sampled_count; k++)
    if (np_vec3_dot(n->fill->direction[n->sampled[k]], flight) < np_vec3_dot(n->fill->direction[best], flight))
      best = n->sampled[k];
  return n->radiance[best];
}

/* Averages radiances over the Voronoi cells of the ordinates. These differ a little from the ordinates' weights: a
 * factor for each band restores the octant's irradiance. */
static void fill_octant(const border_node *n, unsigned set, unsigned octant, np_spectrum *out_factor) {
  const np_ordinates *o = n->fill->sets[set].ordinates;
  np_border *border = n->fill->sets[set].border;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    float *out = np_border_get_node(&border->clear[b], octant, n->axis, n->v, n->u);
    double sum = 0.0, found = 0.0, weight = 0.0;
    unsigned count = 0;
    for (unsigned i = 0; i < o->count; i++) {
      const unsigned at = octant * OCTANT + i, own = n->counts[set][at];
      const double share = (double)o->weight[i / NP_ORDINATE_LANES][i % NP_ORDINATE_LANES];
      out[i] = own ? (float)(n->sums[set][at][b] / own) : get_nearest_sample(n, o, octant, i).band[b];
      sum += n->sums[set][at][b];
      count += own;
      found += share * (double)out[i];
      weight += share;
    }
    const float factor = found > 0.0 && count > 0 ? (float)(sum / count * weight / found) : 1.0f;
    for (unsigned i = 0; i < o->count; i++) out[i] *= factor;
    out_factor->band[b] = factor;
  }
}

static int compare_responses(const void *a, const void *b) {
  const np_border_response *one = a, *other = b;
  if (one->radiance != other->radiance) return one->radiance < other->radiance ? -1 : 1;
  return one->square < other->square ? -1 : one->square > other->square;
}

/* Sums the responses of one radiance and square. The order of equal keys is that of qsort: on another C library sums
 * may differ by rounding. */
static void merge_responses(node_responses *list) {
  size_t kept = 0;
  if (list->count > 1) qsort(list->at, list->count, sizeof *list->at, compare_responses);
  for (size_t i = 0; i < list->count; i++) {
    if (kept > 0 && compare_responses(&list->at[kept - 1], &list->at[i]) == 0)
      list->at[kept - 1].gain = np_spectrum_add(list->at[kept - 1].gain, list->at[i].gain);
    else
      list->at[kept++] = list->at[i];
  }
  list->count = kept;
}

/* Turns gains of single directions into gains of the radiances, which are means over directions. */
static void finish_responses(border_node *n, unsigned set, const np_spectrum factor[NP_OCTANT_COUNT]) {
  const np_border *border = n->fill->sets[set].border;
  node_responses *list = &n->responses[set];
  for (size_t i = 0; i < list->count; i++) {
    np_border_response *r = &list->at[i];
    const unsigned octant = r->radiance / OCTANT, ordinate = r->radiance % OCTANT;
    const float share = 1.0f / (float)n->counts[set][r->radiance];
    r->gain = np_spectrum_scale(np_spectrum_multiply(r->gain, factor[octant]), share);
    const np_border_faces *clear = &border->clear[0];
    r->radiance = (uint32_t)(np_border_get_node(clear, octant, n->axis, n->v, n->u) + ordinate - clear->radiance);
  }
  merge_responses(list);
}

static neph_result store_responses(const node_responses *list, neph_context *context, np_border *border, size_t node) {
  border->responses[node].at = np_alloc(context, list->count, sizeof *list->at);
  if (!border->responses[node].at) return NEPH_ERROR_OUT_OF_MEMORY;
  if (list->count) memcpy(border->responses[node].at, list->at, list->count * sizeof *list->at);
  border->responses[node].count = list->count;
  return NEPH_OK;
}

/* Moves a point below the ground to just above it. */
static void lift_above_ground(const border_fill *f, np_dvec3 *place) {
  const np_world *world = f->world;
  if (!world->terrain && !world->has_planet) return;
  const double top = fmax(world->terrain ? world->terrain_max.z : f->high[2], f->high[2]) + clearance_m;
  np_dvec3 ground = *place;
  const np_dvec3 above = np_dvec3_make(place->x, place->y, top);
  if (isfinite(np_world_find_ground(world, above, np_vec3_make(0.0f, 0.0f, -1.0f), &ground)))
    place->z = fmax(place->z, ground.z + clearance_m);
}

static void start_node(border_node *n, const border_fill *f) {
  node_responses kept[NP_BORDER_SETS_MAX];
  memcpy(kept, n->responses, sizeof kept);
  memset(n, 0, sizeof *n);
  n->fill = f;
  for (unsigned s = 0; s < NP_BORDER_SETS_MAX; s++) n->responses[s] = (node_responses){kept[s].at, 0, kept[s].room};
}

static neph_result fill_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const border_fill *f = user;
  neph_context *context = f->grid->context;
  border_node *n = np_alloc(context, 1, sizeof *n);
  neph_result result = n ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = begin; i < end && !result; i++) {
    const int face = (int)(i / (NODES * NODES));
    start_node(n, f);
    n->axis = face / 2;
    n->side = face % 2 ? 1 : -1;
    n->v = (unsigned)(i / NODES % NODES);
    n->u = (unsigned)(i % NODES);
    const np_border_nodes *nodes = f->sets[0].border->layout.nodes[n->axis][n->side > 0];
    if (f->grid->is_wrapped[n->axis] || n->u >= nodes[0].count || n->v >= nodes[1].count) continue;
    double place[3];
    const int across = n->axis == 0 ? 1 : 0, up = n->axis == 2 ? 1 : 2;
    place[n->axis] = n->side > 0 ? f->high[n->axis] : f->low[n->axis];
    place[across] = compute_place(f, across, (double)nodes[0].at[n->u]);
    place[up] = compute_place(f, up, (double)nodes[1].at[n->v]);
    n->position = np_dvec3_make(place[0], place[1], place[2]);
    lift_above_ground(f, &n->position);
    sample_node(n);
    result = n->result;
    for (unsigned s = 0; s < f->set_count; s++) {
      np_spectrum factor[NP_OCTANT_COUNT];
      for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
        if ((octant >> n->axis & 1u) == (n->side > 0 ? 1u : 0u)) fill_octant(n, s, octant, &factor[octant]);
      finish_responses(n, s, factor);
      if (!result) result = store_responses(&n->responses[s], context, f->sets[s].border, i);
    }
  }
  for (unsigned s = 0; n && s < NP_BORDER_SETS_MAX; s++) np_alloc_free(context, n->responses[s].at);
  np_alloc_free(context, n);
  return result;
}

/* ---- All nodes ---- */

static neph_result allocate_faces(neph_context *context, unsigned block_count, np_border *out) {
  const size_t count = np_border_count_radiances(block_count);
  float *all = np_alloc(context, 2 * NP_BAND_COUNT * count, sizeof *all);
  if (!all) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    out->faces[b] = (np_border_faces){block_count, all + b * count, &out->layout, &out->glint[0][0][0]};
    out->clear[b] =
        (np_border_faces){block_count, all + (NP_BAND_COUNT + b) * count, &out->layout, &out->glint[0][0][0]};
  }
  return NEPH_OK;
}

/* Area of a face that belongs to a node, as a share of the face. */
static double get_node_share(const np_border_nodes nodes[2], unsigned v, unsigned u) {
  const unsigned at[2] = {u, v};
  double share = 1.0;
  for (int along = 0; along < 2; along++) {
    const np_border_nodes *n = &nodes[along];
    const unsigned i = at[along];
    if (i >= n->count) return 0.0;
    share *= 0.5 * (double)((i + 1 < n->count ? n->at[i + 1] : 1.0f) - (i > 0 ? n->at[i - 1] : 0.0f));
  }
  return share;
}

static float get_no_depth(const void *user, np_dvec3 position, np_vec3 to_sun, const float *fade, float depth_max) {
  (void)user, (void)position, (void)to_sun, (void)fade, (void)depth_max;
  return 0.0f;
}

/* Irradiance from below on the box's top, without clouds: over the directions that look down from its middle. */
static np_spectrum measure_clear_below(const border_fill *f) {
  const np_sun_optical_depth_source none = {NULL, get_no_depth};
  const np_dvec3 from = np_dvec3_make(compute_place(f, 0, 0.5), compute_place(f, 1, 0.5), f->high[2]);
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned i = 0; i < f->direction_count; i++) {
    if (f->direction[i].z >= 0.0f) continue;
    const np_spectrum radiance = np_boundary_radiance_compute(f->world, &none, from, f->direction[i]);
    sum = np_spectrum_add_scaled(sum, -f->direction[i].z * 4.0f * NP_PI_F / (float)f->direction_count, radiance);
  }
  return sum;
}

/* Irradiance that enters the box through its top or bottom, as the ordinates have it, the mean over its nodes. */
static float measure_entering(const np_ordinates *o, const np_border *border, unsigned band, np_border_way way) {
  const unsigned first = way == NP_BORDER_DOWN ? NP_OCTANT_COUNT / 2 : 0; /* octants of light in this direction */
  double sum = 0.0;
  for (unsigned octant = first; octant < first + NP_OCTANT_COUNT / 2; octant++)
    for (unsigned i = 0; i < o->count; i++) {
      const unsigned block = i / NP_ORDINATE_LANES, lane = i % NP_ORDINATE_LANES;
      for (unsigned node = 0; node < NODES * NODES; node++)
        sum += get_node_share(border->layout.nodes[2][way == NP_BORDER_DOWN], node / NODES, node % NODES) *
               (double)(o->weight[block][lane] * o->cosine[2][block][lane] *
                        np_border_get_node(&border->clear[band], octant, 2, node / NODES, node % NODES)[i]);
    }
  return (float)sum;
}

static void measure_ways(const border_fill *f, unsigned set) {
  np_border *out = f->sets[set].border;
  const np_ground_hit level = {.position = np_dvec3_make(compute_place(f, 0, 0.5), compute_place(f, 1, 0.5), f->low[2]),
                               .normal = np_vec3_make(0.0f, 0.0f, 1.0f)};
  out->way[NP_BORDER_DOWN].clear = np_world_level_irradiance(f->world, &level);
  out->way[NP_BORDER_UP].clear = measure_clear_below(f);
  out->way[NP_BORDER_DOWN].air = np_cell_air_compute_irradiance(f->grid, f->world, NP_CELL_AIR_DOWN);
  out->way[NP_BORDER_UP].air = np_cell_air_compute_irradiance(f->grid, f->world, NP_CELL_AIR_UP);
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    for (int way = 0; way < NP_BORDER_WAYS; way++)
      out->way[way].entering.band[b] = measure_entering(f->sets[set].ordinates, out, b, (np_border_way)way);
}

/* Mean over 2 × 2 places of each square. */
static void measure_gaps(const border_fill *f, np_border *out) {
  const np_vec3 to_sun = f->world->to_sun;
  for (int n = 0; n < 4 * NP_BORDER_PLAN * NP_BORDER_PLAN; n++) {
    const int u = n / 2 % NP_BORDER_PLAN, v = n / (4 * NP_BORDER_PLAN);
    const double x = (u + 0.25 + 0.5 * (n % 2)) * out->square_m[0],
                 y = (v + 0.25 + 0.5 * (n / (2 * NP_BORDER_PLAN) % 2)) * out->square_m[1];
    const np_dvec3 place = np_dvec3_make(f->low[0] + x, f->low[1] + y, f->low[2]);
    const float passed =
        to_sun.z > 0.0f ? np_transmittance(f->depths->get(f->depths->user, place, to_sun, f->fade, 16.0f)) : 1.0f;
    out->open[v][u] += 0.25f * passed;
  }
}

/* Inserts a node where there is none within a tenth of the even distance. */
static void add_node(np_border_nodes *nodes, float at) {
  const float apart = 0.1f / (EVEN - 1);
  unsigned i = 0;
  while (nodes->at[i] < at) i++;
  if (at - nodes->at[i - 1] < apart || nodes->at[i] - at < apart) return;
  memmove(&nodes->at[i + 1], &nodes->at[i], (nodes->count - i) * sizeof nodes->at[0]);
  nodes->at[i] = at;
  nodes->count++;
}

/* Places equidistant nodes; on the lower face also nodes at one and three ground clearances from each rim. */
static void place_nodes(const border_fill *f, double height_m, np_border_layout *out) {
  for (int face = 0; face < FACES; face++)
    for (int along = 0; along < 2; along++) {
      const int axis = face / 2, is_high = face % 2;
      const int across = along == 0 ? (axis == 0 ? 1 : 0) : (axis == 2 ? 1 : 2);
      np_border_nodes *nodes = &out->nodes[axis][is_high][along];
      nodes->count = EVEN;
      for (unsigned i = 0; i < EVEN; i++) nodes->at[i] = (float)i / (EVEN - 1);
      if (axis != 2 || is_high || f->grid->is_wrapped[across]) continue;
      for (int n = 1; n <= 3; n += 2) {
        const float share = (float)(n * height_m / (f->high[across] - f->low[across]));
        if (share >= 1.0f / (EVEN - 1)) continue;
        add_node(nodes, share);
        add_node(nodes, 1.0f - share);
      }
    }
}

static void set_plan(const border_fill *f, np_border *out) {
  for (int a = 0; a < 2; a++) {
    out->square_m[a] = (f->high[a] - f->low[a]) / NP_BORDER_PLAN;
    out->is_wrapped[a] = f->grid->is_wrapped[a];
  }
  out->depth_m = fmax(1.0, f->low[2] - (f->world->terrain ? f->world->terrain_min.z : 0.0));
  place_nodes(f, out->depth_m, &out->layout);
}

static neph_result fill_sets(border_fill *f, np_monitor *monitor) {
  neph_context *context = f->grid->context;
  neph_result result = NEPH_OK;
  if (f->world->cloud_sky) {
    f->air = np_alloc(context, f->direction_count, sizeof *f->air);
    if (!f->air) return NEPH_ERROR_OUT_OF_MEMORY;
    result = np_parallel_for(context, monitor, f->direction_count, 16, trace_air, f);
  }
  for (unsigned s = 0; s < f->set_count && !result; s++) {
    result = allocate_faces(context, f->sets[s].ordinates->block_count, f->sets[s].border);
    set_plan(f, f->sets[s].border);
    measure_gaps(f, f->sets[s].border);
    fill_glint(f, s);
  }
  if (!result) result = np_parallel_for(context, monitor, FACES * NODES * NODES, 1, fill_nodes, f);
  for (unsigned s = 0; s < f->set_count && !result; s++) {
    for (int a = 0; a < 3; a++) f->sets[s].border->axis_count += !f->grid->is_wrapped[a];
    measure_ways(f, s);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) np_border_reset(f->sets[s].border, b);
  }
  return result;
}

neph_result np_border_fill(const np_transport_grid *grid, const np_world *world,
                           const np_sun_optical_depth_source *depths, const float *fade, np_monitor *monitor,
                           bool is_rough, const np_border_set *sets, unsigned set_count) {
  border_fill *f = np_alloc(grid->context, 1, sizeof *f);
  if (!f) return NEPH_ERROR_OUT_OF_MEMORY;
  *f =
      (border_fill){.grid = grid, .world = world, .depths = depths, .fade = fade, .sets = sets, .set_count = set_count};
  for (int a = 0; a < 3; a++) {
    f->low[a] = grid->edge_m[a][0];
    f->high[a] = grid->edge_m[a][grid->size[a]];
  }
  f->direction_count = is_rough ? DIRECTIONS_ROUGH : DIRECTIONS;
  f->cells_a_place = is_rough ? 2 : 1;
  choose_directions(f);
  f->glint = compute_glint(f);
  const neph_result result = fill_sets(f, monitor);
  np_alloc_free(grid->context, f->air);
  np_alloc_free(grid->context, f);
  return result;
}

void np_border_clear(neph_context *context, np_border *border) {
  np_alloc_free(context, border->faces[0].radiance);
  for (int i = 0; i < FACES * NODES * NODES; i++) np_alloc_free(context, border->responses[i].at);
  *border = (np_border){0};
}

/* Mean radiance of faces over the nodes through which an octant's light enters, summed over the axes. */
static double average_nodes(const np_border_faces *faces, unsigned octant, size_t lane) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; axis++)
    for (unsigned node = 0; node < NODES * NODES; node++)
      sum += get_node_share(np_border_get_nodes(faces, octant, axis), node / NODES, node % NODES) *
             (double)np_border_get_node(faces, octant, axis, node / NODES, node % NODES)[lane];
  return sum;
}

double np_border_get_mean(const np_border *border, unsigned band, unsigned octant, unsigned block, unsigned lane) {
  return average_nodes(&border->clear[band], octant, block * NP_ORDINATE_LANES + lane) / border->axis_count;
}

double np_border_sum_change(const np_border *border, unsigned band, const np_ordinates *ordinates) {
  double sum = 0.0;
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
    for (unsigned i = 0; i < ordinates->count; i++)
      sum += fabs(average_nodes(&border->faces[band], octant, i) - average_nodes(&border->clear[band], octant, i));
  return sum / border->axis_count;
}
