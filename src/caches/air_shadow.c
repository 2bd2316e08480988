/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/air_shadow.h"

#include "atmosphere/sky_along.h"
#include "core/alloc.h"
#include "core/units.h"

enum { CELLS = NP_AIR_SHADOW_CELLS, PLANES = NP_AIR_SHADOW_PLANES };

/* ---- Lost light ---- */

/* Levels for the light around the sun, denser near the ground: at the height of the last haze is thin. */
enum { SUN_LEVELS = 64 };
static const double sun_top_m = 20e3;

/* Ridges that rise above the sun, and the share of the light around it that straight ones hide: half of it and more. */
enum { RIDGES = 3 };
static const struct {
  double rise_rad;
  float hidden;
} ridges[RIDGES] = {{5.0 * NP_DEGREE, 0.65f}, {10.0 * NP_DEGREE, 0.8f}, {20.0 * NP_DEGREE, 1.0f}};
static const float lowest_ridge = 0.5f;

typedef struct loss_job {
  const np_air_visibility *visibility;
  const np_world *world;
  const np_world *bare;          /* the same without terrain, its ground lit by the camera's sky */
  const np_lit_air *lit_air;     /* change by clouds; NULL: unknown */
  const np_lit_air *among_hills; /* change by hills; NULL: unknown */
  np_air_shadow *out;
  np_spectrum sun_forward[SUN_LEVELS]; /* optical depth from each level to the sun of what haze scatters straight on */
  np_vec3 above_sun[RIDGES];           /* directions at the rises of `ridges` above the sun */
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

/* Light of the higher orders that a cell scatters out of clear air, but for what haze scatters straight on from behind
 * it, which is the first to be counted where the sum would be more than there is. */
typedef struct clear_parts {
  np_spectrum aureole; /* light from around the sun, which haze has scattered straight on, on its way from there */
  np_spectrum turned;  /* other light from above */
  np_spectrum even;    /* what that would be if the light came evenly from above */
} clear_parts;

static clear_parts split_clear(const loss_job *job, const ray_cell *c, const np_air_cell *cell,
                               const np_clear_flux *clear) {
  const np_spectrum forward = get_sun_forward(job, c->middle.z);
  clear_parts out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float higher = np_maxf(c->higher.band[b], 0.0f);
    const float behind = np_clampf(cell->forward.band[b] * c->beyond.band[b], 0.0f, higher);
    out.aureole.band[b] = np_minf(expm1f(forward.band[b]) * c->first.band[b], higher - behind);
    const float straight = out.aureole.band[b] + behind;
    out.turned.band[b] = np_maxf(higher - straight - clear->lower.band[b] * cell->lower.band[b], 0.0f);
    out.even.band[b] = clear->upper.band[b] * cell->upper.band[b];
  }
  return out;
}

/* Change of the radiance of a ray: light of the higher orders that is lost, 0 or less, and other light. */
typedef struct ray_change {
  np_spectrum lost, other;
} ray_change;

/* Light of the higher orders is several times even light towards the sun, and less away from it. */
static const float unevenness_max = 8.0f;

static np_vec3 raise_direction(np_vec3 towards, double rise_rad) {
  const double level = hypot((double)towards.x, (double)towards.y);
  const double elevation = fmin(atan2((double)towards.z, level) + rise_rad, 0.5 * NP_PI);
  const double scale = level > 0.0 ? cos(elevation) / level : 0.0;
  return np_vec3_make((float)(scale * (double)towards.x), (float)(scale * (double)towards.y), (float)sin(elevation));
}

/* Share of the light around the sun that a ridge hides which hides the sun. */
static float estimate_hidden(const loss_job *job, np_dvec3 place) {
  float hidden = lowest_ridge;
  for (int i = 0; i < RIDGES && np_world_is_behind_terrain(job->world, place, job->above_sun[i]); i++)
    hidden = ridges[i].hidden;
  return hidden;
}

/* Share of the light around the sun that is hidden from a cell: all in the shade of a cloud, and in that of a hill all
 * but what comes over the ridge. Points of the hills' lattice may lie beyond the shade's edge. */
static float get_sun_hidden(const loss_job *job, const ray_cell *c, const np_lit_air_value *hills) {
  if (!job->among_hills) return c->shaded;
  if (!(c->shaded > 0.0f)) return hills->sun_hidden;
  const bool is_by_hill = np_world_is_behind_terrain(job->world, c->middle, job->world->to_sun);
  return np_maxf(is_by_hill ? c->shaded * estimate_hidden(job, c->middle) : c->shaded, hills->sun_hidden);
}

/* Share of the light around the sun that a cell lacks: what is hidden there, as much as clouds take of the sky's light,
 * and, where hills hide more than half of that, as the last of it. */
static float lack_aureole(float sun_hidden, float by_clouds, float by_hills, float clear) {
  if (!(clear > 0.0f)) return sun_hidden;
  return np_minf(np_maxf(sun_hidden, np_maxf(-by_clouds / clear, -2.0f * by_hills / clear - 1.0f)), 1.0f);
}

/* The change of a cell's light by clouds and hills. `*straight`: optical depth of what the cell scatters straight on.
 *
 * What clouds take from above counts as a share of the turned light that there is in clear air; towards the sun that is
 * more than their light, which comes evenly, replaces. Among hills turned light is even light, of which the hidden
 * share is lost, and what the light around the sun adds to it, of which the share is lost that is lacking itself. */
static ray_change scatter(const loss_job *job, const ray_cell *c, const np_hemisphere_shares *shares,
                          np_spectrum *transmittance, np_spectrum *straight) {
  const np_lit_air *air = job->lit_air, *hilly = job->among_hills;
  const np_lit_air_value clouds = air ? np_lit_air_get(air, c->middle) : (np_lit_air_value){.way = {0}},
                         hills = hilly ? np_lit_air_get(hilly, c->middle) : (np_lit_air_value){.way = {0}};
  const np_clear_flux clear = np_lit_air_get_clear(air ? air : hilly, c->middle.z);
  const float length = np_vec3_length(clouds.way);
  const float cosine = length > 0.0f ? np_vec3_dot(c->direction, clouds.way) / length : 0.0f;
  const np_air_beam beam = {np_clampf(1.0f - cosine, 0.0f, 2.0f), np_minf(length, 1.0f)};
  const np_air_cell cell =
      np_air_cell_cross(job->world->atmosphere, c->middle, c->length_m, shares, c->direction.z, &beam, transmittance);
  const clear_parts parts = split_clear(job, c, &cell, &clear);
  const float sun_hidden = get_sun_hidden(job, c, &hills);
  ray_change out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float turned = parts.turned.band[b], even = parts.even.band[b], upper = cell.upper.band[b],
                by_clouds = clouds.upper.band[b], by_hills = hills.hidden.band[b];
    const float lacking = lack_aureole(sun_hidden, by_clouds, by_hills, clear.upper.band[b]);
    const float unevenness = even > 0.0f ? np_minf(turned / even, unevenness_max) : 1.0f;
    const float taken = unevenness > 1.0f ? clouds.hidden.band[b] : np_minf(by_clouds, 0.0f);
    out.lost.band[b] = taken * unevenness * upper - lacking * parts.aureole.band[b];
    if (hilly)
      out.lost.band[b] += by_hills * upper * np_minf(unevenness, 1.0f) - lacking * np_maxf(turned - even, 0.0f);
    out.other.band[b] = (by_clouds - taken + hills.upper.band[b] - by_hills) * upper +
                        (clouds.lower.band[b] + hills.lower.band[b]) * cell.lower.band[b] +
                        clouds.beam.band[b] * cell.beam.band[b];
  }
  *straight = cell.forward;
  return out;
}

/* ---- Around a ray ---- */

/* Directions around a ray, and sine of their angle to it: that of the middle of what haze scatters straight on. */
enum { AROUND = 12 };
static const float around_sine = 0.26f;

/* Distances of the ground along a ray and around it; infinite: there is none. */
typedef struct ground_around {
  double distance_m[AROUND + 1];
} ground_around;

static double compute_ground(const loss_job *job, np_vec3 towards) {
  return np_world_find_ground(job->world, job->visibility->rays.origin, towards, NULL);
}

static void find_ground(const loss_job *job, np_vec3 direction, ground_around *out) {
  out->distance_m[AROUND] = compute_ground(job, direction);
  for (int i = 0; i < AROUND; i++) {
    const float angle = 2.0f * NP_PI_F * ((float)i + 0.5f) / AROUND;
    out->distance_m[i] = compute_ground(job, np_gather_air_lean(direction, around_sine, angle));
  }
}

/* Share of those directions in which no ground is nearer than a distance. */
static float compute_open_share(const ground_around *around, double distance_m) {
  int count = 0;
  for (int i = 0; i <= AROUND; i++) count += around->distance_m[i] >= distance_m;
  return (float)count / (AROUND + 1);
}

/* Sums along a ray. */
typedef struct ray_sums {
  ray_change change;
  np_spectrum straight; /* optical depth of what haze scatters straight on */
  float shaded;         /* share of it in the shade */
} ray_sums;

/* Adds a cell's change to that of the cells before it, which hand on straight what is lost on the whole. */
static void add_cell(const ray_cell *c, const ray_change *change, np_spectrum straight, ray_sums *sums) {
  const float before = np_spectrum_mean(sums->straight), length = np_spectrum_mean(straight);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float half = np_minf(0.5f * straight.band[b], NP_STRAIGHT_DEPTH_MAX), lost = change->lost.band[b];
    const float handed = np_growth(sums->straight.band[b] + half), whole = np_minf(lost + change->other.band[b], 0.0f);
    sums->change.lost.band[b] += lost + handed * (whole - c->shaded * c->first.band[b]);
    sums->change.other.band[b] += change->other.band[b];
    sums->straight.band[b] = np_minf(sums->straight.band[b] + straight.band[b], NP_STRAIGHT_DEPTH_MAX);
  }
  if (length > 0.0f) sums->shaded += (c->shaded - sums->shaded) * length / (before + length);
}

static uint16_t keep_share(float share) { return (uint16_t)(NP_AIR_SHADOW_UNIT * np_clampf(share, 0.0f, 1.0f) + 0.5f); }

/* Light of the air up to a plane. */
typedef struct air_sums {
  np_spectrum first, all;
} air_sums;

/* `air`: clear air's light up to the place; `behind`: that from behind it. */
static np_air_part keep_part(const ray_sums *sums, const air_sums *air, np_spectrum behind, float open) {
  np_air_part out = {.other = sums->change.other, .covered = keep_share(open * sums->shaded)};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float higher = air->all.band[b] - air->first.band[b], per = higher > 0.0f ? 1.0f / higher : 0.0f;
    const float ahead = np_growth(sums->straight.band[b]) * behind.band[b];
    out.lost[b] = keep_share(-per * sums->change.lost.band[b]);
    out.ahead[b] = keep_share(per * ahead);
    out.straight[b] = keep_share(sums->straight.band[b] / NP_STRAIGHT_DEPTH_MAX);
  }
  return out;
}

static void keep(np_spectrum lost, np_spectrum all, uint16_t out[NP_BAND_COUNT]) {
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float visible = all.band[b] > 0.0f ? 1.0f - lost.band[b] / all.band[b] : 1.0f;
    out[b] = keep_share(visible);
  }
}

static air_sums sum_air(const np_sky_ray *ray, double distance_m) {
  air_sums sums;
  sums.all = np_sky_ray_get_air(ray, distance_m, &sums.first).inscatter;
  return sums;
}

/* Radiance along a ray of clear air: of the sky, or of bare ground and the air before it. */
static np_spectrum compute_clear(const loss_job *job, np_vec3 direction, const np_sky_ray *ray) {
  np_ground_hit hit;
  if (!np_world_intersect_ground(job->bare, job->visibility->rays.origin, direction, &hit))
    return np_sky_ray_get_air(ray, INFINITY, NULL).inscatter;
  const np_aerial_perspective air = np_sky_ray_get_air(ray, hit.distance_m, NULL);
  const np_spectrum light = np_spectrum_multiply(air.transmittance, np_gather_air_light_ground(job->bare, &hit));
  return np_spectrum_add(air.inscatter, light);
}

/* Computes a node's changes from plane to plane; past the ray's end they stay constant. */
static void lose_node(const loss_job *job, size_t node) {
  const np_air_visibility *v = job->visibility;
  const np_air_rays *r = &v->rays;
  const size_t width = (size_t)(r->end[0] - r->begin[0]);
  const np_vec3 direction = np_air_rays_get_direction(r, (float)(r->begin[0] + (int)(node % width)),
                                                      (float)(r->begin[1] + (int)(node / width)));
  const double ground = (double)v->ground_m[node];
  const np_sky_ray ray = np_sky_ray_start(job->world->camera_sky, direction);
  const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(ray.sky, direction);
  np_spectrum lost = np_spectrum_grey(0.0f), transmittance = np_spectrum_grey(1.0f);
  ray_sums sums = {.shaded = 0.0f};
  ground_around around;
  np_spectrum clear = lost;
  if (job->out->parts) {
    find_ground(job, direction, &around);
    clear = compute_clear(job, direction, &ray);
  }
  air_sums before = {lost, lost};
  double begin = 0.0;
  for (int c = 0; c < PLANES; c++) {
    const double end = fmin(np_air_rays_get_plane(v->reach_m, c), ground);
    const size_t place = node * PLANES + (size_t)c;
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
          .beyond = np_spectrum_subtract(clear, np_spectrum_mix(before.all, up_to.all, 0.5f)),
      };
      lost = np_spectrum_add_scaled(lost, cell.shaded, first);
      if (job->out->parts) {
        np_spectrum straight;
        const ray_change change = scatter(job, &cell, &shares, &transmittance, &straight);
        add_cell(&cell, &change, straight, &sums);
      }
    }
    before = up_to;
    begin = end;
    keep(lost, up_to.first, job->out->visible_fraction[place]);
    if (!job->out->parts) continue;
    job->out->parts[place] =
        keep_part(&sums, &up_to, np_spectrum_subtract(clear, up_to.all), compute_open_share(&around, end));
  }
  if (job->out->parts) job->out->ground_share[node] = 1.0f - compute_open_share(&around, HUGE_VAL);
}

static neph_result lose_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t node = begin; node < end; node++) lose_node(user, node);
  return NEPH_OK;
}

neph_result np_air_shadow_build(const np_air_visibility *visibility, const np_world *world, const np_lit_air *lit_air,
                                const np_lit_air *among_hills, np_monitor *monitor, np_air_shadow *out) {
  *out = (np_air_shadow){.context = visibility->context, .visibility = visibility};
  const size_t count = np_air_rays_count(&visibility->rays);
  out->visible_fraction = np_alloc(out->context, count * PLANES, sizeof *out->visible_fraction);
  const bool is_lit = (lit_air || among_hills) && world->atmosphere;
  if (is_lit) {
    out->parts = np_alloc(out->context, count * PLANES, sizeof *out->parts);
    out->ground_share = np_alloc(out->context, count, sizeof *out->ground_share);
  }
  const bool has_all = out->visible_fraction && (!is_lit || (out->parts && out->ground_share));
  if (!has_all) return np_air_shadow_clear(out), NEPH_ERROR_OUT_OF_MEMORY;
  np_world bare = *world;
  bare.terrain = NULL;
  bare.cloud_sky = bare.camera_sky;
  loss_job job = {.visibility = visibility,
                  .world = world,
                  .bare = &bare,
                  .lit_air = lit_air,
                  .among_hills = among_hills,
                  .out = out};
  for (int i = 0; i < RIDGES; i++) job.above_sun[i] = raise_direction(world->to_sun, ridges[i].rise_rad);
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
  np_alloc_free(shadow->context, shadow->parts);
  np_alloc_free(shadow->context, shadow->ground_share);
  *shadow = (np_air_shadow){0};
}

double np_air_shadow_measure(const np_air_shadow *shadow) {
  const size_t count = np_air_rays_count(&shadow->visibility->rays);
  double seen = 0.0;
  for (size_t node = 0; node < count; node++)
    for (int b = 0; b < NP_BAND_COUNT; b++) seen += (double)shadow->visible_fraction[node * PLANES + PLANES - 1][b];
  return 1.0 - seen / ((double)count * NP_BAND_COUNT * (double)NP_AIR_SHADOW_UNIT);
}

/* ---- Queries ---- */

/* Index of the plane before a distance, or the first, and the fraction to the next. */
static int compute_plane_before(double reach_m, double distance_m, float *out_part) {
  int plane = 0;
  if (distance_m < reach_m) {
    const double x = sqrt(distance_m / reach_m) * CELLS - 1.0;
    plane = x > 0.0 ? (int)x : 0;
    *out_part = (float)fmax(x - plane, 0.0);
    return plane;
  }
  for (plane = CELLS - 1; plane + 2 < PLANES && np_air_rays_get_plane(reach_m, plane + 1) <= distance_m; plane++)
    continue;
  const double near = np_air_rays_get_plane(reach_m, plane), far = np_air_rays_get_plane(reach_m, plane + 1);
  *out_part = isfinite(far) ? (float)((distance_m - near) / (far - near)) : (float)(1.0 - near / distance_m);
  return plane;
}

/* The fraction between the planes of a node whose ray may end before the farther one, where it has that one's values.
 */
static float compute_part(const double plane_m[2], float ground_m, double distance_m, float part) {
  const double end_m = (double)ground_m;
  if (!(end_m < plane_m[1])) return part;
  return end_m > plane_m[0] ? np_clampf((float)((distance_m - plane_m[0]) / (end_m - plane_m[0])), 0.0f, 1.0f) : 1.0f;
}

/* Weight of a ray that ends at `ground_m`, at a distance. */
static float compute_weight(float ground_m, double distance_m) {
  if ((double)ground_m >= distance_m) return 1.0f;
  const float ratio = (float)((double)ground_m / distance_m), square = ratio * ratio;
  return np_maxf(square * square, 1e-6f);
}

/* Loss between two planes: shares are interpolated linearly in the shade, and inversely past it, where the lost light
 * is constant and the total grows. */
static float mix_losses(float near, float far, float part, bool is_past) {
  if (!is_past || !(near * far > 0.0f)) return np_mixf(near, far, part);
  return near * far / np_mixf(far, near, part);
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

/* A kept share between two planes, in units. */
static float mix_units(uint16_t near, uint16_t far, float part) { return np_mixf((float)near, (float)far, part); }

static const float share_per_unit = 1.0f / NP_AIR_SHADOW_UNIT;

enum { CORNERS = 4 };

/* Haze before the end of a ray, which scatters the end's light straight on: at the corners around the ray. */
typedef struct end_haze {
  float weight[CORNERS], depth[CORNERS * NP_BAND_COUNT];
} end_haze;

/* Fills a corner, and adds what the end hides of the light behind it. Ground ends the node's ray before the last of its
 * planes. */
static void add_end(const np_air_shadow *shadow, size_t node, int plane, float part, np_ray_end end, int corner,
                    end_haze *haze, np_air_change *sum) {
  const np_air_part *near = &shadow->parts[node * PLANES + (size_t)plane], *far = near + 1;
  const bool is_ground = end == NP_RAY_END_GROUND;
  haze->weight[corner] *=
      is_ground ? shadow->ground_share[node] : share_per_unit * mix_units(near->covered, far->covered, part);
  if (is_ground) near = far = &shadow->parts[node * PLANES + PLANES - 1];
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    haze->depth[corner * NP_BAND_COUNT + b] =
        NP_STRAIGHT_DEPTH_MAX * share_per_unit * mix_units(near->straight[b], far->straight[b], part);
    sum->higher_share.band[b] += haze->weight[corner] * mix_units(near->ahead[b], far->ahead[b], part);
  }
}

static np_spectrum sum_passed(const end_haze *haze) {
  float growth[CORNERS * NP_BAND_COUNT];
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < CORNERS * NP_BAND_COUNT; i++) growth[i] = np_growth(haze->depth[i]);
  for (int i = 0; i < CORNERS * NP_BAND_COUNT; i++)
    sum.band[i % NP_BAND_COUNT] += haze->weight[i / NP_BAND_COUNT] * growth[i];
  return sum;
}

/* Adds the change between two planes of a node, `part` of the way from the nearer, losses in units. Before the first
 * plane, `begun` of the way there, losses are the same share of less light. */
static void add_parts(const np_air_shadow *shadow, size_t node, int plane, float part, float begun, float weight,
                      np_air_change *sum) {
  const np_air_part *near = &shadow->parts[node * PLANES + (size_t)plane], *far = near + 1;
  const bool is_past = plane >= CELLS - 1;
  sum->other = np_spectrum_add_scaled(sum->other, weight * begun, np_spectrum_mix(near->other, far->other, part));
  for (int b = 0; b < NP_BAND_COUNT; b++)
    sum->higher_share.band[b] += weight * mix_losses((float)near->lost[b], (float)far->lost[b], part, is_past);
}

np_air_change np_air_shadow_get(const np_air_shadow *shadow, const np_view_ray *view, double distance_m,
                                np_ray_end end) {
  const np_air_visibility *v = shadow->visibility;
  const np_air_rays *r = &v->rays;
  int32_t lower[2];
  float part[2], along, weights = 0.0f;
  locate(r, view, lower, part);
  const int plane = compute_plane_before(v->reach_m, distance_m, &along);
  const double within = fmin(distance_m, 1e9),
               plane_m[2] = {np_air_rays_get_plane(v->reach_m, plane), np_air_rays_get_plane(v->reach_m, plane + 1)};
  const bool is_past = plane >= CELLS - 1;
  const float begun = (float)fmin(distance_m / np_air_rays_get_plane(v->reach_m, 0), 1.0);
  const size_t width = (size_t)(r->end[0] - r->begin[0]);
  np_air_change sum = {.lost_share = {{0.0f}}};
  end_haze haze;
  for (int corner = 0; corner < CORNERS; corner++) {
    const int i = corner & 1, j = corner >> 1;
    const size_t node = (size_t)(lower[1] + j) * width + (size_t)(lower[0] + i);
    const size_t first = node * PLANES + (size_t)plane;
    const float weight =
        (i ? part[0] : 1.0f - part[0]) * (j ? part[1] : 1.0f - part[1]) * compute_weight(v->ground_m[node], within);
    const float own = compute_part(plane_m, v->ground_m[node], distance_m, along);
    const uint16_t *near = shadow->visible_fraction[first], *far = near + NP_BAND_COUNT;
    for (int b = 0; b < NP_BAND_COUNT; b++)
      sum.lost_share.band[b] +=
          weight * mix_losses(NP_AIR_SHADOW_UNIT - (float)near[b], NP_AIR_SHADOW_UNIT - (float)far[b], own, is_past);
    if (shadow->parts) add_parts(shadow, node, plane, own, begun, weight, &sum);
    haze.weight[corner] = weight;
    if (shadow->parts && end != NP_RAY_END_NONE) add_end(shadow, node, plane, own, end, corner, &haze, &sum);
    weights += weight;
  }
  if (shadow->parts && end != NP_RAY_END_NONE) sum.passed = np_spectrum_scale(sum_passed(&haze), begun);
  const float all = 1.0f / weights, per_unit = all * share_per_unit;
  return (np_air_change){np_spectrum_scale(sum.lost_share, per_unit), np_spectrum_scale(sum.higher_share, per_unit),
                         np_spectrum_scale(sum.other, all), np_spectrum_scale(sum.passed, all)};
}
