/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/air_shadow.h"

#include "atmosphere/sky_along.h"
#include "core/alloc.h"
#include "core/units.h"

enum { CELLS = NP_AIR_SHADOW_CELLS, PLANES = NP_AIR_SHADOW_PLANES };

/* Share of a ray's remaining light below which shadows are neglected. */
static const float light_rest = 0.01f;
/* Length above which a cell is sampled at two places. */
static const double cell_long_m = 250.0;

/* ---- Rays and cells ---- */

static size_t count_nodes(const np_air_rays *rays) {
  return (size_t)(rays->end[0] - rays->begin[0]) * (size_t)(rays->end[1] - rays->begin[1]);
}

static np_vec3 compute_direction(const np_air_rays *rays, float i, float j) {
  const np_air_film *film = &rays->film;
  if (film->camera) return film->get_direction(film->camera, i * film->spacing, j * film->spacing);
  const np_vec3 level = np_vec3_add(rays->forward, np_vec3_scale(rays->right, i - rays->middle[0]));
  return np_vec3_normalize(np_vec3_add(level, np_vec3_scale(rays->down, j - rays->middle[1])));
}

/* Distance of a plane, the first at the end of the first cell. */
static double compute_plane(double reach_m, int plane) {
  if (plane >= CELLS) return plane < PLANES - 1 ? ldexp(reach_m, plane + 1 - CELLS) : HUGE_VAL;
  const double s = (plane + 1.0) / CELLS;
  return reach_m * s * s;
}

/* Index of the plane before a distance, or the first, and the fraction to the next. */
static int compute_plane_before(double reach_m, double distance_m, float *out_part) {
  int plane = 0;
  if (distance_m < reach_m) {
    const double x = sqrt(distance_m / reach_m) * CELLS - 1.0;
    plane = x > 0.0 ? (int)x : 0;
    *out_part = (float)fmax(x - plane, 0.0);
    return plane;
  }
  for (plane = CELLS - 1; plane + 2 < PLANES && compute_plane(reach_m, plane + 1) <= distance_m; plane++) continue;
  const double near = compute_plane(reach_m, plane), far = compute_plane(reach_m, plane + 1);
  *out_part = isfinite(far) ? (float)((distance_m - near) / (far - near)) : (float)(1.0 - near / distance_m);
  return plane;
}

/* ---- Regions with shadow ---- */

/* A box along three axes: a caster's shadow, whose third axis points away from the sun, or lit air, along the world's
 * axes. */
typedef struct axis_box {
  double low[3], high[3];
} axis_box;

typedef struct shadow_probe {
  const np_world *world;
  const np_sun_optical_depths *depths;
  np_air_visibility *out;
  np_dvec3 axis[3];
  axis_box shafts[2], lit;
  unsigned shaft_count;
  bool has_lit, is_lit_by_fire;
  float fade[NP_INSTANCES_MAX]; /* factor on optical depth in each cloud: light in the forward peak is not lost to the
                                   air */
} shadow_probe;

static axis_box make_shaft(const shadow_probe *p, np_dvec3 low, np_dvec3 high) {
  axis_box s = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, INFINITY}};
  for (int corner = 0; corner < 8; corner++) {
    const np_dvec3 at =
        np_dvec3_make(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z);
    for (int a = 0; a < 3; a++) {
      const double x = np_dvec3_dot(p->axis[a], at);
      s.low[a] = fmin(s.low[a], x);
      s.high[a] = fmax(s.high[a], x);
    }
  }
  return s;
}

/* Clips a ray to a box along the axes of its coordinates; begin > end: no overlap. */
static void clip(const axis_box *s, const double origin[3], const double direction[3], double *out_begin,
                 double *out_end) {
  *out_begin = 0.0;
  *out_end = INFINITY;
  for (int a = 0; a < 3; a++) {
    const double o = origin[a], d = direction[a];
    if (fabs(d) < 1e-9) {
      if (o < s->low[a] || o > s->high[a]) *out_end = -1.0;
      continue;
    }
    const double t[2] = {(s->low[a] - o) / d, (s->high[a] - o) / d};
    *out_begin = fmax(*out_begin, fmin(t[0], t[1]));
    *out_end = fmin(*out_end, fmax(t[0], t[1]));
  }
}

/* Interval of a ray that holds all its shadow. */
static void compute_interval(const shadow_probe *p, np_vec3 direction, double *out_begin, double *out_end) {
  double origin[3], along[3];
  for (int a = 0; a < 3; a++) {
    origin[a] = np_dvec3_dot(p->axis[a], p->out->rays.origin);
    along[a] = np_dvec3_dot(p->axis[a], np_vec3_to_double(direction));
  }
  *out_begin = INFINITY;
  *out_end = 0.0;
  for (unsigned i = 0; i < p->shaft_count; i++) {
    double begin, end;
    clip(&p->shafts[i], origin, along, &begin, &end);
    if (!(begin < end)) continue;
    *out_begin = fmin(*out_begin, begin);
    *out_end = fmax(*out_end, end);
  }
}

/* Distance at which a ray leaves the air that clouds light; 0: it misses it. */
static double compute_lit_end(const shadow_probe *p, np_vec3 direction) {
  const np_dvec3 o = p->out->rays.origin;
  const double origin[3] = {o.x, o.y, o.z}, along[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  double begin, end;
  if (!p->has_lit) return 0.0;
  clip(&p->lit, origin, along, &begin, &end);
  return begin < end ? end : 0.0;
}

static double compute_ground_distance(const shadow_probe *p, np_vec3 direction) {
  np_ground_hit hit;
  return np_world_intersect_ground(p->world, p->out->rays.origin, direction, &hit) ? hit.distance_m : HUGE_VAL;
}

static np_spectrum compute_first_order(const np_sky_ray *ray, double distance_m) {
  np_spectrum first;
  (void)np_sky_ray_get_air(ray, distance_m, &first);
  return first;
}

/* Distance along a ray beyond which the air adds at most the share `light_rest` of its light. */
static double search_light_end(const neph_sky *sky, np_vec3 direction, double end) {
  const np_sky_ray ray = np_sky_ray_start(sky, direction);
  const float all = np_spectrum_max(compute_first_order(&ray, end));
  double low = 0.0, high = fmin(end, 3e6);
  for (int k = 0; k < 12; k++) {
    const double middle = 0.5 * (low + high);
    *(np_spectrum_max(compute_first_order(&ray, middle)) < (1.0f - light_rest) * all ? &low : &high) = middle;
  }
  return high;
}

enum { REACH_RAYS = 9 };

/* Greatest distance along any ray of the whole picture at which shadows and light of clouds count. */
static double compute_reach(const shadow_probe *p) {
  const np_air_rays *r = &p->out->rays;
  double reach = 0.0;
  for (int n = 0; n < REACH_RAYS * REACH_RAYS; n++) {
    const float u = (float)(n % REACH_RAYS) / (REACH_RAYS - 1), v = (float)(n / REACH_RAYS) / (REACH_RAYS - 1);
    const np_vec3 direction = compute_direction(r, np_mixf((float)r->whole_begin[0], (float)r->whole_end[0], u),
                                                np_mixf((float)r->whole_begin[1], (float)r->whole_end[1], v));
    double begin, end;
    compute_interval(p, direction, &begin, &end);
    const double ground = compute_ground_distance(p, direction), lit_end = fmin(compute_lit_end(p, direction), ground);
    end = fmax(begin < end ? fmin(end, ground) : 0.0, lit_end);
    if (end > 0.0) reach = fmax(reach, search_light_end(p->world->camera_sky, direction, end));
    if (p->is_lit_by_fire) reach = fmax(reach, lit_end);
  }
  return reach;
}

/* ---- Visibility ---- */

static float compute_visibility(const shadow_probe *p, np_dvec3 position, np_vec3 to_sun) {
  if (np_world_is_behind_terrain(p->world, position, to_sun)) return 0.0f;
  return np_transmittance(np_sun_optical_depths_get_scaled(p->depths, position, to_sun, p->fade, 12.0f));
}

static float turn(double value) { return (float)(value - floor(value)); }

/* Mean visibility over a segment of a ray, at `count` places, spread over nodes and cells by the plastic number and the
 * golden ratio (Roberts 2018). */
static float average_segment(const shadow_probe *p, np_vec3 direction, int i, int j, int cell, double begin,
                             double end) {
  const int count = end - begin > cell_long_m ? 2 : 1;
  float sum = 0.0f;
  for (int k = 0; k < count; k++) {
    const double at = 0.7548776662466927 * i + 0.5698402909980532 * j + 0.6180339887498949 * (2 * cell + k);
    const double t = begin + (end - begin) * (k + (double)turn(at)) / count;
    const np_vec3 to_sun = np_world_sample_sun(p->world, turn(1.3247179572447460 * at + 0.37), turn(3.0 * at + 0.71));
    sum += compute_visibility(p, np_dvec3_along(p->out->rays.origin, direction, t), to_sun);
  }
  return sum / (float)count;
}

static void fill_node(const shadow_probe *p, size_t node) {
  np_air_visibility *out = p->out;
  const int32_t width = out->rays.end[0] - out->rays.begin[0];
  const int i = out->rays.begin[0] + (int)(node % (size_t)width), j = out->rays.begin[1] + (int)(node / (size_t)width);
  const np_vec3 direction = compute_direction(&out->rays, (float)i, (float)j);
  const double ground = compute_ground_distance(p, direction);
  double shade_begin, shade_end, begin = 0.0;
  compute_interval(p, direction, &shade_begin, &shade_end);
  out->ground_m[node] = (float)ground;
  for (int c = 0; c < CELLS; c++) {
    const double end = compute_plane(out->reach_m, c), stop = fmin(end, ground);
    float *seen = &out->seen[node * CELLS + (size_t)c];
    if (begin >= ground)
      *seen = c > 0 ? seen[-1] : 1.0f;
    else
      *seen = stop > shade_begin && begin < shade_end ? average_segment(p, direction, i, j, c, begin, stop) : 1.0f;
    begin = end;
  }
}

static neph_result fill_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t node = begin; node < end; node++) fill_node(user, node);
  return NEPH_OK;
}

/* ---- Smoothing ---- */

typedef struct smoothing {
  const np_air_visibility *from;
  float *to;
} smoothing;

/* Filters 3 × 3 rays by 1-2-1, about as wide as the sun's disk. Rays that have ended do not contribute. */
static void smooth_node(const smoothing *s, size_t node) {
  const np_air_rays *r = &s->from->rays;
  const int32_t width = r->end[0] - r->begin[0], height = r->end[1] - r->begin[1];
  const int32_t i = (int32_t)(node % (size_t)width), j = (int32_t)(node / (size_t)width);
  float sum[CELLS] = {0.0f}, weights[CELLS] = {0.0f};
  for (int32_t y = j > 0 ? j - 1 : 0; y <= j + 1 && y < height; y++)
    for (int32_t x = i > 0 ? i - 1 : 0; x <= i + 1 && x < width; x++) {
      const size_t near = (size_t)y * (size_t)width + (size_t)x;
      const float weight = (x == i ? 2.0f : 1.0f) * (y == j ? 2.0f : 1.0f);
      for (int c = 0; c < CELLS; c++) {
        const bool is_visible =
            c == 0 || near == node || compute_plane(s->from->reach_m, c - 1) < (double)s->from->ground_m[near];
        sum[c] += is_visible ? weight * s->from->seen[near * CELLS + (size_t)c] : 0.0f;
        weights[c] += is_visible ? weight : 0.0f;
      }
    }
  for (int c = 0; c < CELLS; c++) s->to[node * CELLS + (size_t)c] = sum[c] / weights[c];
}

static neph_result smooth_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t node = begin; node < end; node++) smooth_node(user, node);
  return NEPH_OK;
}

static neph_result smooth(np_air_visibility *v, np_monitor *monitor) {
  const size_t count = count_nodes(&v->rays);
  smoothing s = {v, np_alloc(v->context, count * CELLS, sizeof *s.to)};
  if (!s.to) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(v->context, monitor, count, 64, smooth_nodes, &s);
  np_alloc_free(v->context, v->seen);
  v->seen = s.to;
  return result;
}

static void place_shafts(shadow_probe *p, const np_air_casters *casters) {
  const np_dvec3 to_sun = np_dvec3_normalize(np_vec3_to_double(p->world->to_sun));
  const np_dvec3 level = np_dvec3_make(-to_sun.y, to_sun.x, 0.0);
  p->axis[2] = np_dvec3_scale(to_sun, -1.0);
  p->axis[0] = np_dvec3_length(level) > 1e-6 ? np_dvec3_normalize(level) : np_dvec3_make(1.0, 0.0, 0.0);
  p->axis[1] = np_dvec3_cross(p->axis[2], p->axis[0]);
  p->shaft_count = casters->count;
  for (unsigned i = 0; i < casters->count; i++) p->shafts[i] = make_shaft(p, casters->low[i], casters->high[i]);
  p->has_lit = casters->has_lit;
  p->is_lit_by_fire = casters->has_lit && casters->is_lit_by_fire;
  p->lit = (axis_box){{casters->lit_low.x, casters->lit_low.y, casters->lit_low.z},
                      {casters->lit_high.x, casters->lit_high.y, casters->lit_high.z}};
}

neph_result np_air_visibility_build(neph_context *context, const np_world *world, const np_sun_optical_depths *depths,
                                    const np_air_rays *rays, const np_air_casters *casters, np_monitor *monitor,
                                    np_air_visibility *out) {
  *out = (np_air_visibility){.context = context, .rays = *rays};
  shadow_probe p = {.world = world, .depths = depths, .out = out};
  for (unsigned v = 0; v < world->clouds.count; v++)
    p.fade[v] = np_scattering_compute_least_scale(&world->clouds.at[v].phase, world->clouds.at[v].albedo);
  place_shafts(&p, casters);
  out->reach_m = compute_reach(&p);
  if (!(out->reach_m > 0.0)) return NEPH_OK;
  const size_t count = count_nodes(rays);
  out->seen = np_alloc(context, count * CELLS, sizeof *out->seen);
  out->ground_m = np_alloc(context, count, sizeof *out->ground_m);
  neph_result result = out->seen && out->ground_m ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(monitor, "casting shadows into the air");
  np_monitor_set_range(monitor, 0.0, 0.8);
  if (!result) result = np_parallel_for(context, monitor, count, 16, fill_nodes, &p);
  np_monitor_set_range(monitor, 0.8, 0.9);
  if (!result) result = smooth(out, monitor);
  if (result) np_air_visibility_clear(out);
  return result;
}

void np_air_visibility_clear(np_air_visibility *visibility) {
  np_alloc_free(visibility->context, visibility->seen);
  np_alloc_free(visibility->context, visibility->ground_m);
  *visibility = (np_air_visibility){0};
}

/* ---- Lost light ---- */

/* Levels for the light around the sun, denser near the ground: at the height of the last haze is thin. */
enum { SUN_LEVELS = 64 };
static const double sun_top_m = 20e3;

typedef struct loss_job {
  const np_air_visibility *visibility;
  const np_world *world;
  const np_lit_air *lit_air;     /* change by clouds; NULL: unknown */
  const np_lit_air *among_hills; /* change by hills; NULL: unknown */
  np_air_shadow *out;
  np_spectrum sun_forward[SUN_LEVELS]; /* optical depth from each level to the sun of what haze scatters straight on */
} loss_job;

/* A cell of the air along a ray, and radiance of clear air along that ray as the eye sees it. */
typedef struct ray_cell {
  np_dvec3 middle;
  double length_m;
  np_vec3 direction;
  float shaded;              /* share of the sun that is hidden */
  np_spectrum first, higher; /* light that the cell adds, of the first and of the higher orders */
  np_spectrum beyond;        /* light from behind the cell's middle */
} ray_cell;

static double compute_level_height(int level) {
  const double s = (double)level / (SUN_LEVELS - 1);
  return sun_top_m * s * s;
}

static np_spectrum get_sun_forward(const loss_job *job, double height_m) {
  const float x = (float)sqrt(fmax(fmin(height_m / sun_top_m, 1.0), 0.0)) * (SUN_LEVELS - 1);
  const int level = (int)fminf(x, SUN_LEVELS - 2);
  return np_spectrum_mix(job->sun_forward[level], job->sun_forward[level + 1], x - (float)level);
}

/* Light that a cell scatters after haze has scattered it straight on: on its way from the sun, of the higher orders. */
static np_spectrum compute_aureole(const loss_job *job, const ray_cell *c) {
  const np_spectrum forward = get_sun_forward(job, c->middle.z);
  np_spectrum out;
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out.band[b] = fminf(expm1f(forward.band[b]) * c->first.band[b], fmaxf(c->higher.band[b], 0.0f));
  return out;
}

/* Share of a loss of even light from above that counts: the true light of the higher orders, but that from below and
 * what haze scatters straight on, over what it would be if it came evenly. Towards the sun haze scatters several times
 * as much. */
static const float share_max = 8.0f;

static np_spectrum compute_unevenness(const ray_cell *c, np_spectrum aureole, const np_air_cell *cell,
                                      const np_clear_flux *clear) {
  const np_spectrum even = np_spectrum_multiply(clear->upper, cell->upper);
  np_spectrum share = np_spectrum_grey(1.0f);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float straight = cell->forward.band[b] * c->beyond.band[b] + aureole.band[b],
                turned = c->higher.band[b] - straight - clear->lower.band[b] * cell->lower.band[b];
    if (even.band[b] > 0.0f) share.band[b] = np_clampf(turned / even.band[b], 0.0f, share_max);
  }
  return share;
}

/* Change of the air's light by clouds and hills. */
static np_lit_air_value get_change(const loss_job *job, np_dvec3 place) {
  np_lit_air_value out = {.way = {0}};
  if (job->lit_air) out = np_lit_air_get(job->lit_air, place);
  if (!job->among_hills) return out;
  const np_lit_air_value hills = np_lit_air_get(job->among_hills, place);
  out.upper = np_spectrum_add(out.upper, hills.upper);
  out.lower = np_spectrum_add(out.lower, hills.lower);
  return out;
}

/* Change of a cell's light around the sun: it is lost in the shade, and where clouds or hills hide the sky. */
static float lose_aureole(const ray_cell *c, float aureole, float change, float clear) {
  const float hidden = clear > 0.0f ? np_clampf(-change / clear, 0.0f, 1.0f) : 0.0f;
  return -aureole * np_maxf(c->shaded, hidden);
}

/* Radiance that clouds and hills add to a ray in a cell. `*forward`: optical depth of what it scatters straight on. */
static np_spectrum scatter(const loss_job *job, const ray_cell *c, const np_hemisphere_shares *shares,
                           np_spectrum *transmittance, np_spectrum *forward) {
  const np_lit_air_value change = get_change(job, c->middle);
  const np_clear_flux clear = np_lit_air_get_clear(job->lit_air ? job->lit_air : job->among_hills, c->middle.z);
  const float length = np_vec3_length(change.way);
  const float cosine = length > 0.0f ? np_vec3_dot(c->direction, change.way) / length : 0.0f;
  const np_air_beam beam = {np_clampf(1.0f - cosine, 0.0f, 2.0f), np_minf(length, 1.0f)};
  const np_air_cell cell =
      np_air_cell_cross(job->world->atmosphere, c->middle, c->length_m, shares, &beam, transmittance);
  const np_spectrum aureole = compute_aureole(job, c), unevenness = compute_unevenness(c, aureole, &cell, &clear);
  np_spectrum out =
      np_spectrum_add(np_spectrum_multiply(change.beam, cell.beam), np_spectrum_multiply(change.lower, cell.lower));
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float upper = change.upper.band[b];
    out.band[b] += upper * cell.upper.band[b] * (upper < 0.0f ? unevenness.band[b] : 1.0f) +
                   lose_aureole(c, aureole.band[b], upper, clear.upper.band[b]);
  }
  *forward = cell.forward;
  return out;
}

/* Adds a cell's change to that of the cells before it, which scatter its loss straight on: what is lost along a ray is
 * lost to the haze before it too. Gains are not handed on. `*passed`: optical depth of what those cells scatter so. */
static void add_cell(const ray_cell *c, np_spectrum change, np_spectrum forward, np_spectrum *passed,
                     np_spectrum *added) {
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float handed = expm1f(passed->band[b] + 0.5f * forward.band[b]);
    added->band[b] += change.band[b] + handed * (fminf(change.band[b], 0.0f) - c->shaded * c->first.band[b]);
    passed->band[b] += forward.band[b];
  }
}

static void keep(np_spectrum lost, np_spectrum all, uint16_t out[NP_BAND_COUNT]) {
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float visible = all.band[b] > 0.0f ? 1.0f - lost.band[b] / all.band[b] : 1.0f;
    out[b] = (uint16_t)(NP_AIR_SHADOW_UNIT * np_clampf(visible, 0.0f, 1.0f) + 0.5f);
  }
}

/* Light of the air up to a plane. */
typedef struct air_sums {
  np_spectrum first, all;
} air_sums;

static air_sums sum_air(const np_sky_ray *ray, double distance_m) {
  air_sums sums;
  sums.all = np_sky_ray_get_air(ray, distance_m, &sums.first).inscatter;
  return sums;
}

/* Computes a node's changes from plane to plane; past the ray's end they stay constant. */
static void lose_node(const loss_job *job, size_t node) {
  const np_air_visibility *v = job->visibility;
  const np_air_rays *r = &v->rays;
  const size_t width = (size_t)(r->end[0] - r->begin[0]);
  const np_vec3 direction =
      compute_direction(r, (float)(r->begin[0] + (int)(node % width)), (float)(r->begin[1] + (int)(node / width)));
  const double ground = (double)v->ground_m[node];
  const np_sky_ray ray = np_sky_ray_start(job->world->camera_sky, direction);
  const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(ray.sky, direction);
  const np_spectrum whole = sum_air(&ray, INFINITY).all;
  np_spectrum lost = np_spectrum_grey(0.0f), added = lost, passed = lost, transmittance = np_spectrum_grey(1.0f);
  air_sums before = {lost, lost};
  double begin = 0.0;
  for (int c = 0; c < PLANES; c++) {
    const double end = fmin(compute_plane(v->reach_m, c), ground);
    const air_sums up_to = c > 0 && !(end > begin) ? before : sum_air(&ray, end);
    if (c < CELLS && end > begin) {
      const np_spectrum first = np_spectrum_subtract(up_to.first, before.first);
      const ray_cell cell = {
          .middle = np_dvec3_along(r->origin, direction, 0.5 * (begin + end)),
          .length_m = end - begin,
          .direction = direction,
          .shaded = 1.0f - v->seen[node * CELLS + (size_t)c],
          .first = first,
          .higher = np_spectrum_subtract(np_spectrum_subtract(up_to.all, before.all), first),
          .beyond = np_spectrum_subtract(whole, np_spectrum_mix(before.all, up_to.all, 0.5f)),
      };
      lost = np_spectrum_add_scaled(lost, cell.shaded, first);
      if (job->out->added) {
        np_spectrum forward;
        const np_spectrum change = scatter(job, &cell, &shares, &transmittance, &forward);
        add_cell(&cell, change, forward, &passed, &added);
      }
    }
    before = up_to;
    begin = end;
    keep(lost, up_to.first, job->out->visible_fraction[node * PLANES + (size_t)c]);
    if (job->out->added) job->out->added[node * PLANES + (size_t)c] = added;
  }
}

static neph_result lose_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t node = begin; node < end; node++) lose_node(user, node);
  return NEPH_OK;
}

neph_result np_air_shadow_build(const np_air_visibility *visibility, const np_world *world, const np_lit_air *lit_air,
                                const np_lit_air *among_hills, np_monitor *monitor, np_air_shadow *out) {
  *out = (np_air_shadow){.context = visibility->context, .visibility = visibility};
  const size_t count = count_nodes(&visibility->rays);
  out->visible_fraction = np_alloc(out->context, count * PLANES, sizeof *out->visible_fraction);
  const bool is_lit = (lit_air || among_hills) && world->atmosphere;
  if (is_lit) out->added = np_alloc(out->context, count * PLANES, sizeof *out->added);
  if (!out->visible_fraction || (is_lit && !out->added)) return np_air_shadow_clear(out), NEPH_ERROR_OUT_OF_MEMORY;
  loss_job job = {visibility, world, lit_air, among_hills, out, {{{0.0f}}}};
  for (int level = 0; is_lit && level < SUN_LEVELS; level++)
    job.sun_forward[level] =
        np_atmosphere_get_forward_depth(world->atmosphere, compute_level_height(level), world->to_sun);
  np_monitor_set_range(monitor, 0.9, 1.0);
  neph_result result = np_parallel_for(out->context, monitor, count, 64, lose_nodes, &job);
  if (result) np_air_shadow_clear(out);
  return result;
}

void np_air_shadow_clear(np_air_shadow *shadow) {
  np_alloc_free(shadow->context, shadow->visible_fraction);
  np_alloc_free(shadow->context, shadow->added);
  *shadow = (np_air_shadow){0};
}

double np_air_shadow_measure(const np_air_shadow *shadow) {
  const size_t count = count_nodes(&shadow->visibility->rays);
  double seen = 0.0;
  for (size_t node = 0; node < count; node++)
    for (int b = 0; b < NP_BAND_COUNT; b++) seen += (double)shadow->visible_fraction[node * PLANES + PLANES - 1][b];
  return 1.0 - seen / ((double)count * NP_BAND_COUNT * (double)NP_AIR_SHADOW_UNIT);
}

/* ---- Queries ---- */

/* Weight of a ray that ends at `ground_m`, at a distance. */
static float compute_weight(float ground_m, double distance_m) {
  if ((double)ground_m >= distance_m) return 1.0f;
  const float ratio = (float)((double)ground_m / distance_m), square = ratio * ratio;
  return np_maxf(square * square, 1e-6f);
}

/* Loss between two planes: shares are interpolated linearly in the shade, and inversely past it, where the lost light
 * is constant and the total grows. */
static float mix_losses(uint16_t near, uint16_t far, float part, bool is_past) {
  const float a = 1.0f - (float)near / NP_AIR_SHADOW_UNIT, b = 1.0f - (float)far / NP_AIR_SHADOW_UNIT;
  if (!is_past || !(a * b > 0.0f)) return np_mixf(a, b, part);
  return a * b / np_mixf(b, a, part);
}

/* Position of a ray in the grid, in nodes: by its direction in a plane, after the lens. */
static void compute_node(const np_air_rays *r, const np_view_ray *view, float out[2]) {
  const float depth = np_maxf(np_vec3_dot(view->direction, r->forward), 1e-6f);
  const np_vec3 step[2] = {r->right, r->down};
  for (int a = 0; a < 2; a++)
    out[a] = r->film.camera
                 ? view->film[a] / r->film.spacing
                 : r->middle[a] + np_vec3_dot(view->direction, step[a]) / (depth * np_vec3_dot(step[a], step[a]));
}

/* Lower neighbours of a ray among the stored nodes, and fractions. */
static void locate(const np_air_rays *r, const np_view_ray *view, int32_t out_lower[2], float out_part[2]) {
  float node[2];
  compute_node(r, view, node);
  for (int a = 0; a < 2; a++) {
    const float x = node[a];
    const float inside = np_clampf(x, (float)r->begin[a], (float)(r->end[a] - 1)), below = floorf(inside);
    const int32_t lower = (int32_t)below < r->end[a] - 2 ? (int32_t)below : r->end[a] - 2;
    out_lower[a] = lower - r->begin[a];
    out_part[a] = inside - (float)lower;
  }
}

np_air_change np_air_shadow_get(const np_air_shadow *shadow, const np_view_ray *view, double distance_m) {
  const np_air_visibility *v = shadow->visibility;
  const np_air_rays *r = &v->rays;
  int32_t lower[2];
  float part[2], along, weights = 0.0f;
  locate(r, view, lower, part);
  const int plane = compute_plane_before(v->reach_m, distance_m, &along);
  const double within = fmin(distance_m, 1e9);
  const float begun = (float)fmin(distance_m / compute_plane(v->reach_m, 0), 1.0);
  const size_t width = (size_t)(r->end[0] - r->begin[0]);
  np_air_change sum = {np_spectrum_grey(0.0f), np_spectrum_grey(0.0f)};
  for (int corner = 0; corner < 4; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const size_t node = (size_t)(lower[1] + j) * width + (size_t)(lower[0] + i);
    const size_t first = node * PLANES + (size_t)plane;
    const float weight =
        (i ? part[0] : 1.0f - part[0]) * (j ? part[1] : 1.0f - part[1]) * compute_weight(v->ground_m[node], within);
    const uint16_t *near = shadow->visible_fraction[first], *far = near + NP_BAND_COUNT;
    for (int b = 0; b < NP_BAND_COUNT; b++)
      sum.lost_share.band[b] += weight * mix_losses(near[b], far[b], along, plane >= CELLS - 1);
    if (shadow->added)
      sum.added = np_spectrum_add_scaled(sum.added, weight * begun,
                                         np_spectrum_mix(shadow->added[first], shadow->added[first + 1], along));
    weights += weight;
  }
  return (np_air_change){np_spectrum_scale(sum.lost_share, 1.0f / weights),
                         np_spectrum_scale(sum.added, 1.0f / weights)};
}
