/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/air_visibility.h"

#include "core/alloc.h"
#include "core/units.h"
#include "transport/scattering_field.h"

enum { CELLS = NP_AIR_SHADOW_CELLS, PLANES = NP_AIR_SHADOW_PLANES };

/* Share of a ray's remaining light below which shadows are neglected. */
static const float light_rest = 0.01f;
/* Length above which a cell is sampled at two places. */
static const double cell_long_m = 250.0;

/* ---- Rays and cells ---- */

size_t np_air_rays_count(const np_air_rays *rays) {
  return (size_t)(rays->end[0] - rays->begin[0]) * (size_t)(rays->end[1] - rays->begin[1]);
}

np_vec3 np_air_rays_get_direction(const np_air_rays *rays, float i, float j) {
  const np_air_film *film = &rays->film;
  if (film->camera) return film->get_direction(film->camera, i * film->spacing, j * film->spacing);
  const np_vec3 level = np_vec3_add(rays->forward, np_vec3_scale(rays->right, i - rays->middle[0]));
  return np_vec3_normalize(np_vec3_add(level, np_vec3_scale(rays->down, j - rays->middle[1])));
}

double np_air_rays_get_plane(double reach_m, int plane) {
  if (plane >= CELLS) return plane < PLANES - 1 ? ldexp(reach_m, plane + 1 - CELLS) : HUGE_VAL;
  const double s = (plane + 1.0) / CELLS;
  return reach_m * s * s;
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
  return np_world_find_ground(p->world, p->out->rays.origin, direction, NULL);
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
    const np_vec3 direction = np_air_rays_get_direction(r, np_mixf((float)r->whole_begin[0], (float)r->whole_end[0], u),
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
  const np_vec3 direction = np_air_rays_get_direction(&out->rays, (float)i, (float)j);
  const double ground = compute_ground_distance(p, direction);
  double shade_begin, shade_end, begin = 0.0;
  compute_interval(p, direction, &shade_begin, &shade_end);
  out->ground_m[node] = (float)ground;
  for (int c = 0; c < CELLS; c++) {
    const double end = np_air_rays_get_plane(out->reach_m, c), stop = fmin(end, ground);
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
            c == 0 || near == node || np_air_rays_get_plane(s->from->reach_m, c - 1) < (double)s->from->ground_m[near];
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
  const size_t count = np_air_rays_count(&v->rays);
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
  const size_t count = np_air_rays_count(rays);
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
