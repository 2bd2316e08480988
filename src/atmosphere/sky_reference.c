/* SPDX-License-Identifier: Apache-2.0 */
/* Backward Monte Carlo in a spherical atmosphere, with next-event estimation at every vertex.
 *
 * One path serves all bands: its directions and distances come from one density, and each band has its own weight.
 * Distances come from a mixture of scattered and transmitted light, sunlight, and uniform sampling of the chord, over
 * panels with exact transmittance (reference_path.h); the latter two make twilight affordable, whose light comes from
 * far away. The alternative is the ground at the ray's end. Directions come from the mixture of all phase functions;
 * the ground is Lambertian, with cosine sampling and its albedo as a weight. Later orders play Russian roulette.
 *
 * The first distance is stratified within a batch; standard errors come from the variance of the batch means, which are
 * independent.
 *
 * Phase functions are evaluated at the centre of the sun's disk: for a lobe of g = 0.8 that omits 6e-4 in the middle of
 * the aureole. */
#include "atmosphere/sky_reference.h"

#include <string.h>

#include "atmosphere/quadrature.h"
#include "core/random.h"
#include "core/stable.h"

enum { BATCHES = 64, FIRST_PANELS = 32, PANELS = 12, DISK_POINTS = 8, ROULETTE_FROM = 4 };

/* ---- Geometry ---- */

static np_dvec3 compute_zenith(const np_medium *medium, np_dvec3 p) {
  return np_dvec3_zenith(p, medium->planet_radius_m);
}

static double compute_altitude(const np_medium *medium, np_dvec3 p) {
  return fmax(np_altitude(p, medium->planet_radius_m), 0.0);
}

static np_dvec3 move(np_dvec3 p, np_dvec3 direction, double t) { return np_dvec3_add(p, np_dvec3_scale(direction, t)); }

static np_ray make_ray(const np_medium *medium, np_dvec3 origin, np_dvec3 direction, double distance_m) {
  const double cosine = np_clamp(np_dvec3_dot(compute_zenith(medium, origin), direction), -1.0, 1.0);
  np_ray ray = np_ray_make(medium, compute_altitude(medium, origin), cosine);
  const double end = distance_m - ray.offset_m;
  if (end < ray.length_m) {
    ray.length_m = fmax(end, 0.0);
    ray.hits_ground = false;
  }
  return ray;
}

/* Unit vector with a given cosine to an axis and an azimuth around it. */
static np_dvec3 turn_from(np_dvec3 axis, double cosine, double azimuth) {
  np_vec3 a, b;
  np_frame_around(np_dvec3_to_float(axis), &a, &b);
  const double sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
  const np_dvec3 across = np_dvec3_add(np_dvec3_scale(np_vec3_to_double(a), sine * cos(azimuth)),
                                       np_dvec3_scale(np_vec3_to_double(b), sine * sin(azimuth)));
  return np_dvec3_normalize(np_dvec3_add(np_dvec3_scale(axis, cosine), across));
}

static np_dvec3 sample_cosine(np_dvec3 normal, np_random *random) {
  const double u = np_random_double(random);
  return turn_from(normal, sqrt(1.0 - u), 2.0 * NP_PI * np_random_double(random));
}

static double versine_between(np_dvec3 a, np_dvec3 b) {
  const np_dvec3 d = np_dvec3_subtract(a, b);
  return fmin(0.5 * np_dvec3_dot(d, d), 2.0);
}

void np_reference_transmittance(const np_medium *medium, const np_reference_query *query, bool is_to_space,
                                double out_transmittance[NP_REFERENCE_BANDS]) {
  enum { EXACT_PANELS = 32 };
  const np_ray ray = make_ray(medium, query->origin, query->direction, query->distance_m);
  np_reference_path path;
  np_reference_path_build(medium, &ray, EXACT_PANELS, &path);
  np_reference_path_transmit(&path, out_transmittance);
  if (is_to_space && ray.hits_ground) memset(out_transmittance, 0, NP_REFERENCE_BANDS * sizeof *out_transmittance);
}

/* ---- Light ---- */

/* Sunlight from `offset` disk radii above the disk's centre. */
static void transmit_from_disk(const np_reference_scene *scene, np_dvec3 position, double offset,
                               double out_light[NP_REFERENCE_BANDS]) {
  memset(out_light, 0, NP_REFERENCE_BANDS * sizeof *out_light);
  const np_medium *medium = scene->medium;
  const double h = compute_altitude(medium, position), horizon = np_horizon_cosine(medium, h);
  const double center = np_clamp(np_dvec3_dot(compute_zenith(medium, position), scene->to_sun), -1.0, 1.0);
  const double angle = scene->sun_angular_radius_rad;
  if (scene->light == NP_REFERENCE_POINT) {
    const double span = (medium->planet_radius_m + h) / medium->planet_radius_m;
    const double x = np_clamp((center - horizon) * span / (2.0 * fmax(angle, 1e-6)) + 0.5, 0.0, 1.0);
    if (x <= 0.0) return;
    np_reference_transmit_to_space(medium, h, fmax(center, horizon), out_light);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_light[b] *= x * x * (3.0 - 2.0 * x);
    return;
  }
  const double sine = sqrt(fmax(1.0 - center * center, 0.0));
  const double cosine = np_clamp(center * cos(angle * offset) + sine * sin(angle * offset), -1.0, 1.0);
  if (cosine >= horizon) np_reference_transmit_to_space(medium, h, cosine, out_light);
}

/* Height of the horizon above the disk's centre at a point, in disk radii. */
static double horizon_on_disk(const np_reference_scene *scene, np_dvec3 position) {
  const np_medium *medium = scene->medium;
  const double sun = acos(np_clamp(np_dvec3_dot(compute_zenith(medium, position), scene->to_sun), -1.0, 1.0));
  const double down = np_horizon_angle(medium, compute_altitude(medium, position), 0.0) - sun;
  return -down / fmax(scene->sun_angular_radius_rad, 1e-9);
}

/* Integral over the visible part of the disk, offset = cos φ: ∫ T·(2/π)·sin²φ dφ from its upper edge to the horizon. */
void np_reference_sunlight(const np_reference_scene *scene, np_dvec3 position, double out_light[NP_REFERENCE_BANDS]) {
  const double horizon = horizon_on_disk(scene, position);
  /* Half a radian above the horizon the depth is linear over the disk to 1e-5. */
  const bool is_high = -horizon * scene->sun_angular_radius_rad > 0.5;
  if (scene->light == NP_REFERENCE_POINT || is_high) {
    transmit_from_disk(scene, position, 0.0, out_light);
    return;
  }
  memset(out_light, 0, NP_REFERENCE_BANDS * sizeof *out_light);
  if (horizon >= 1.0) return;
  const np_quadrature rule = np_quadrature_gauss(DISK_POINTS);
  const double last = acos(np_clamp(horizon, -1.0, 1.0));
  for (int i = 0; i < DISK_POINTS; i++) {
    const double phi = last * rule.x[i], weight = 2.0 / NP_PI * sin(phi) * sin(phi) * last * rule.weight[i];
    double light[NP_REFERENCE_BANDS];
    transmit_from_disk(scene, position, cos(phi), light);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_light[b] += weight * light[b];
  }
}

/* ---- Paths ---- */

typedef struct walker {
  const np_reference_scene *scene;
  np_random *random;
  np_dvec3 position, direction;
  double weight[NP_REFERENCE_BANDS];
  double *sum;
} walker;

/* Direction and amount of light. Multiplied by the phase function, or by the cosine over π, it estimates the light
 * scattered at `position`. */
typedef struct light_sample {
  np_dvec3 direction;
  double light[NP_REFERENCE_BANDS];
} light_sample;

static light_sample sample_light(walker *w) {
  light_sample s;
  np_random *random = w->random;
  if (w->scene->light != NP_REFERENCE_FURNACE) {
    s.direction = w->scene->to_sun;
    const double radius = sqrt(np_random_double(random));
    transmit_from_disk(w->scene, w->position, radius * cos(2.0 * NP_PI * np_random_double(random)), s.light);
    return s;
  }
  const double cosine = 2.0 * np_random_double(random) - 1.0;
  s.direction = turn_from(np_dvec3_make(0, 0, 1), cosine, 2.0 * NP_PI * np_random_double(random));
  const np_ray ray = make_ray(w->scene->medium, w->position, s.direction, INFINITY);
  memset(s.light, 0, sizeof s.light);
  if (ray.hits_ground) return s;
  np_reference_transmit_to_space(w->scene->medium, ray.altitude_m, ray.cosine, s.light);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) s.light[b] *= 4.0 * NP_PI;
  return s;
}

static void add_scattered_light(walker *w, const np_reference_air *air) {
  const light_sample s = sample_light(w);
  double scattering[NP_REFERENCE_BANDS];
  np_reference_air_eval(w->scene->medium, air, versine_between(w->direction, s.direction), scattering);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) w->sum[b] += w->weight[b] * scattering[b] * s.light[b];
}

static void add_reflected_light(walker *w, np_dvec3 zenith) {
  const light_sample s = sample_light(w);
  const double cosine = fmax(np_dvec3_dot(zenith, s.direction), 0.0);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) w->sum[b] += w->weight[b] * cosine / NP_PI * s.light[b];
}

/* Share of each constituent in the scattered light, as the mean of the bands: molecules, then aerosols. The last one
 * takes the rest. */
static void share_scattering(const np_medium *medium, const np_reference_air *air,
                             double out_share[NP_AEROSOLS_MAX + 1]) {
  const int count = medium->aerosol_count;
  memset(out_share, 0, (NP_AEROSOLS_MAX + 1) * sizeof *out_share);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    double sum = air->rayleigh[b];
    for (int i = 0; i < count; i++) sum += air->aerosol[i][b];
    if (!(sum > 0.0)) continue;
    out_share[0] += air->rayleigh[b] / sum / NP_REFERENCE_BANDS;
    for (int i = 0; i < count; i++) out_share[1 + i] += air->aerosol[i][b] / sum / NP_REFERENCE_BANDS;
  }
  out_share[count] = 1.0;
  for (int i = 0; i < count; i++) out_share[count] -= out_share[i];
}

/* Chooses a phase function by the shares, from a number in [0, 1). */
static np_phase pick_phase(const np_medium *medium, const double share[NP_AEROSOLS_MAX + 1], double u) {
  int i = 0;
  for (; i < medium->aerosol_count && u >= share[i]; i++) u -= share[i];
  return i > 0 ? medium->aerosol[i - 1].phase : np_phase_rayleigh();
}

static double eval_mixture(const np_medium *medium, const double share[NP_AEROSOLS_MAX + 1], double versine) {
  double sum = share[0] * np_reference_rayleigh(versine);
  for (int i = 0; i < medium->aerosol_count; i++)
    sum += share[1 + i] * (double)np_phase_eval(&medium->aerosol[i].phase, (float)versine);
  return sum;
}

/* Samples the next direction by one of the phase functions or around the sun, and weights it by multiple importance
 * sampling. */
static void scatter(walker *w, const np_reference_air *air) {
  const np_medium *medium = w->scene->medium;
  double share[NP_AEROSOLS_MAX + 1], scattering[NP_REFERENCE_BANDS];
  share_scattering(medium, air, share);
  const bool has_sun = w->scene->light != NP_REFERENCE_FURNACE;
  const np_dvec3 zenith = compute_zenith(medium, w->position);
  const double bright = has_sun ? np_reference_bright_share(zenith, w->scene->to_sun) : 0.0;
  const np_phase lobe = np_phase_henyey_greenstein(NP_REFERENCE_BRIGHT_ASYMMETRY);
  const np_dvec3 axis = has_sun ? np_reference_compute_bright_direction(zenith, w->scene->to_sun) : w->direction;
  const bool is_bright = np_random_double(w->random) < bright;
  const np_phase phase = pick_phase(medium, share, np_random_double(w->random));
  float u[3], value;
  for (int i = 0; i < 3; i++) u[i] = np_random_float(w->random);
  const np_vec3 forward = np_dvec3_to_float(is_bright ? axis : w->direction);
  const np_dvec3 to =
      np_dvec3_normalize(np_vec3_to_double(np_phase_sample(is_bright ? &lobe : &phase, forward, u, &value)));
  const double versine = versine_between(w->direction, to);
  np_reference_air_eval(medium, air, versine, scattering);
  const double pdf = (1.0 - bright) * eval_mixture(medium, share, versine) +
                     bright * (double)np_phase_eval(&lobe, (float)versine_between(axis, to));
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) w->weight[b] *= scattering[b] / pdf;
  w->direction = to;
}

/* Probability that a path continues to the ground at the ray's end. */
static double ground_probability(const np_reference_path *path, const double transmittance[NP_REFERENCE_BANDS]) {
  double albedo = 0.0, seen = 0.0;
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    albedo = fmax(albedo, (double)path->medium->ground_albedo[b]);
    seen += transmittance[b] / NP_REFERENCE_BANDS;
  }
  if (!path->ray.hits_ground || !(albedo > 0.0)) return 0.0;
  if (!path->panel_count) return 1.0;
  return np_clamp(albedo * seen / (albedo * seen + 1.0 - seen), 0.1, 0.9);
}

static void reach_ground(walker *w, const np_reference_path *path, const double transmittance[NP_REFERENCE_BANDS],
                         double probability, bool is_wanted) {
  const np_medium *medium = w->scene->medium;
  w->position = move(w->position, w->direction, path->ray.offset_m + path->ray.length_m);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++)
    w->weight[b] *= transmittance[b] * (double)medium->ground_albedo[b] / probability;
  const np_dvec3 zenith = compute_zenith(medium, w->position);
  if (is_wanted) add_reflected_light(w, zenith);
  w->direction = sample_cosine(zenith, w->random);
}

static void reach_air(walker *w, const np_reference_path *path, double u, double probability, bool is_wanted) {
  const np_reference_sample s = np_reference_path_sample(path, u);
  np_reference_air air;
  np_reference_air_at(w->scene->medium, np_ray_altitude(&path->ray, s.t), &air);
  w->position = move(w->position, w->direction, path->ray.offset_m + s.t);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) w->weight[b] *= s.transmittance[b] * s.inverse_pdf_m / probability;
  if (is_wanted) add_scattered_light(w, &air);
  scatter(w, &air);
}

static double greatest(const double weight[NP_REFERENCE_BANDS]) { return fmax(weight[0], fmax(weight[1], weight[2])); }

static void prepare(const np_reference_scene *scene, np_dvec3 origin, np_dvec3 direction, np_reference_path *path) {
  const np_medium *medium = scene->medium;
  np_reference_guide guide = {.depths = scene->light == NP_REFERENCE_FURNACE ? NULL : scene->guide};
  if (guide.depths) {
    const np_dvec3 entry = move(origin, direction, path->ray.offset_m);
    guide.sun_cosine = np_dvec3_dot(compute_zenith(medium, entry), scene->to_sun);
    guide.angle_cosine = np_dvec3_dot(direction, scene->to_sun);
  }
  np_reference_path_prepare(path, &guide);
}

/* Russian roulette on a faint path. */
static bool survives(walker *w, double first) {
  const double chance = fmin(5.0 * greatest(w->weight) / first, 1.0);
  if (!(np_random_double(w->random) < chance)) return false;
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) w->weight[b] /= chance;
  return true;
}

/* Follows one path from its first ray; `u` places its first vertex. */
static void walk(walker *w, const np_reference_path *first, double u) {
  np_reference_path next;
  const np_reference_path *path = first;
  const np_reference_scene *scene = w->scene;
  double weight_first = 0.0;
  for (unsigned order = 1; order <= scene->order_max; order++) {
    double transmittance[NP_REFERENCE_BANDS];
    np_reference_path_transmit(path, transmittance);
    const double ground = order > 1 || scene->has_ground ? ground_probability(path, transmittance) : 0.0;
    if (ground > 0.0 && np_random_double(w->random) < ground)
      reach_ground(w, path, transmittance, ground, order >= scene->order_min);
    else if (path->panel_count)
      reach_air(w, path, order == 1 ? u : np_random_double(w->random), 1.0 - ground, order >= scene->order_min);
    else
      return;
    if (order == 1) weight_first = greatest(w->weight);
    if (!(greatest(w->weight) > 0.0) || order == scene->order_max) return;
    if (order >= ROULETTE_FROM && !survives(w, weight_first)) return;
    const np_ray ray = make_ray(scene->medium, w->position, w->direction, INFINITY);
    np_reference_path_build(scene->medium, &ray, PANELS, &next);
    prepare(scene, w->position, w->direction, &next);
    path = &next;
  }
}

typedef struct trace_job {
  const np_reference_scene *scene;
  const np_reference_query *query;
  unsigned paths_in_batch;
  uint64_t seed;
  double mean[BATCHES][NP_REFERENCE_BANDS];
} trace_job;

static neph_result trace_batch(trace_job *job, size_t batch) {
  const np_reference_query *q = job->query;
  const np_medium *medium = job->scene->medium;
  np_random random = np_random_start(job->seed, 0, (uint32_t)batch, 0, 0);
  double sum[NP_REFERENCE_BANDS] = {0};
  np_reference_path first;
  for (unsigned i = 0; i < job->paths_in_batch; i++) {
    walker w = {job->scene, &random, q->origin, q->direction, {1.0, 1.0, 1.0}, sum};
    if (q->is_irradiance) {
      w.direction = sample_cosine(compute_zenith(medium, q->origin), &random);
      for (int b = 0; b < NP_REFERENCE_BANDS; b++) w.weight[b] = NP_PI;
    }
    if (i == 0 || q->is_irradiance) {
      const np_ray ray = make_ray(medium, q->origin, w.direction, q->distance_m);
      np_reference_path_build(medium, &ray, FIRST_PANELS, &first);
      prepare(job->scene, q->origin, w.direction, &first);
    }
    walk(&w, &first, (i + np_random_double(&random)) / job->paths_in_batch);
  }
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) job->mean[batch][b] = sum[b] / job->paths_in_batch;
  return NEPH_OK;
}

static neph_result trace_batches(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t i = begin; i < end; i++) trace_batch(user, i);
  return NEPH_OK;
}

static void summarize(const trace_job *job, np_reference_value *out) {
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < BATCHES; i++) sum += job->mean[i][b];
    const double mean = sum / BATCHES;
    for (int i = 0; i < BATCHES; i++) square += (job->mean[i][b] - mean) * (job->mean[i][b] - mean);
    out->mean[b] = mean;
    out->error[b] = sqrt(square / (BATCHES - 1.0) / BATCHES);
  }
}

neph_result np_reference_trace(neph_context *context, np_monitor *monitor, const np_reference_scene *scene,
                               const np_reference_query *query, unsigned paths, uint64_t seed,
                               np_reference_value *out_value) {
  const unsigned each = (unsigned)(((uint64_t)paths + BATCHES - 1) / BATCHES);
  trace_job job = {.scene = scene, .query = query, .paths_in_batch = each ? each : 1, .seed = seed};
  neph_result result = np_parallel_for(context, monitor, BATCHES, 1, trace_batches, &job);
  if (!result) summarize(&job, out_value);
  return result;
}

/* ---- Order 1 ---- */

typedef struct traced_order {
  const np_reference_scene *scene;
  const np_reference_query *query;
  const np_reference_path *path;
  double versine;                   /* 1 − cosine between ray and sun */
  double bound[NP_REFERENCE_BANDS]; /* tolerated error of a piece */
} traced_order;

/* Integrates one piece of a panel by the Gauss rule in w. */
static void integrate_piece(const traced_order *f, int panel, double begin, double end, const np_quadrature *rule,
                            double out[NP_REFERENCE_BANDS]) {
  memset(out, 0, NP_REFERENCE_BANDS * sizeof *out);
  for (int i = 0; i < rule->count; i++) {
    const double w = begin + rule->x[i] * (end - begin), t = np_reference_path_distance(f->path, w);
    const double weight = rule->weight[i] * (end - begin) * 2.0 * fabs(w);
    np_reference_air air;
    double scattering[NP_REFERENCE_BANDS], light[NP_REFERENCE_BANDS], transmittance[NP_REFERENCE_BANDS];
    np_reference_air_at(f->scene->medium, np_ray_altitude(&f->path->ray, t), &air);
    np_reference_air_eval(f->scene->medium, &air, f->versine, scattering);
    np_reference_sunlight(f->scene, move(f->query->origin, f->query->direction, f->path->ray.offset_m + t), light);
    np_reference_path_transmit_to(f->path, panel, w, transmittance);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) out[b] += weight * transmittance[b] * light[b] * scattering[b];
  }
}

/* Bisects a piece until the halves agree with the whole: the sun sets somewhere along the ray. */
static void add_piece(const traced_order *f, int panel, double begin, double end,
                      const double whole[NP_REFERENCE_BANDS], int level, const np_quadrature *rule,
                      double sum[NP_REFERENCE_BANDS]) {
  const double middle = 0.5 * (begin + end);
  double near[NP_REFERENCE_BANDS], far[NP_REFERENCE_BANDS];
  integrate_piece(f, panel, begin, middle, rule, near);
  integrate_piece(f, panel, middle, end, rule, far);
  bool is_good = true;
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) is_good &= fabs(near[b] + far[b] - whole[b]) <= f->bound[b];
  if (is_good || level == 0) {
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) sum[b] += near[b] + far[b];
    return;
  }
  add_piece(f, panel, begin, middle, near, level - 1, rule, sum);
  add_piece(f, panel, middle, end, far, level - 1, rule, sum);
}

void np_reference_first_order(const np_reference_scene *scene, const np_reference_query *query, double tolerance,
                              double out_radiance[NP_REFERENCE_BANDS]) {
  enum { FIRST = 16, LEVELS = 24 };
  const np_ray ray = make_ray(scene->medium, query->origin, query->direction, query->distance_m);
  np_reference_path path;
  np_reference_path_build(scene->medium, &ray, FIRST, &path);
  const np_quadrature rule = np_quadrature_gauss(4);
  traced_order f = {.scene = scene, .query = query, .path = &path};
  f.versine = versine_between(query->direction, scene->to_sun);
  double whole[NP_REFERENCE_PANELS_MAX][NP_REFERENCE_BANDS];
  for (int i = 0; i < path.panel_count; i++) {
    integrate_piece(&f, i, path.edge[i], path.edge[i + 1], &rule, whole[i]);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) f.bound[b] += 0.1 * tolerance * whole[i][b];
  }
  memset(out_radiance, 0, NP_REFERENCE_BANDS * sizeof *out_radiance);
  for (int i = 0; i < path.panel_count; i++)
    add_piece(&f, i, path.edge[i], path.edge[i + 1], whole[i], LEVELS, &rule, out_radiance);
}

neph_result np_reference_radiance(neph_context *context, np_monitor *monitor, const np_reference_scene *scene,
                                  const np_reference_query *query, unsigned paths, uint64_t seed,
                                  np_reference_value *out_value) {
  *out_value = (np_reference_value){0};
  np_reference_scene later = *scene;
  double first[NP_REFERENCE_BANDS] = {0};
  if (scene->order_min <= 1 && !scene->has_ground && !query->is_irradiance && scene->light != NP_REFERENCE_FURNACE) {
    np_reference_first_order(scene, query, 1e-5, first);
    later.order_min = 2;
  }
  if (later.order_max >= later.order_min) {
    neph_result result = np_reference_trace(context, monitor, &later, query, paths, seed, out_value);
    if (result) return result;
  }
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_value->mean[b] += first[b];
  return NEPH_OK;
}
