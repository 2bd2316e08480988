/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/air_flight.h"

#include "atmosphere/atmosphere_tables.h"
#include "core/stable.h"

static np_spectrum make_spectrum(const double value[NP_BAND_COUNT]) {
  return np_spectrum_make((float)value[0], (float)value[1], (float)value[2]);
}

/* ---- Tracking ---- */

/* A ray through the shells. */
typedef struct shell_walk {
  const np_medium *medium;
  const np_air_shells *shells;
  np_ray ray;
  double middle; /* distance of the ray's lowest point */
  int shell;
  bool is_rising;
} shell_walk;

static shell_walk start_walk(const neph_atmosphere *atmosphere, const np_ray *ray) {
  shell_walk walk = {&atmosphere->medium, &atmosphere->air_shells, *ray, -ray->r * ray->cosine, 0, false};
  walk.is_rising = walk.middle <= 0.0;
  while (walk.shell + 1 < NP_AIR_SHELLS && walk.shells->floor_m[walk.shell + 1] <= ray->altitude_m) walk.shell++;
  return walk;
}

/* Squared half of the chord that a ray cuts from the sphere at an altitude. */
static double compute_chord(const shell_walk *walk, double altitude_m) {
  const double h = walk->ray.altitude_m;
  return walk->middle * walk->middle - (h - altitude_m) * (2.0 * walk->medium->planet_radius_m + h + altitude_m);
}

/* Distance at which the ray leaves its shell, and the next shell. */
static double compute_exit(shell_walk *walk, int *out_next) {
  if (!walk->is_rising) {
    const double chord = walk->shell > 0 ? compute_chord(walk, walk->shells->floor_m[walk->shell]) : -1.0;
    if (chord > 0.0) {
      *out_next = walk->shell - 1;
      return walk->middle - sqrt(chord);
    }
    walk->is_rising = true;
  }
  *out_next = walk->shell + 1;
  return walk->middle + sqrt(fmax(compute_chord(walk, walk->shells->floor_m[walk->shell + 1]), 0.0));
}

static void compute_shares(const np_medium *medium, double altitude_m, double bound_per_m,
                           double out_share[NP_BAND_COUNT]) {
  for (int b = 0; b < NP_BAND_COUNT; b++) out_share[b] = 0.0;
  for (int i = 0; i < medium->layer_count; i++) {
    const np_layer *layer = &medium->layers[i];
    const double share = np_layer_density_exact(layer, fmax(altitude_m, 0.0)) / bound_per_m;
    for (int b = 0; b < NP_BAND_COUNT; b++) out_share[b] += share * (double)layer->extinction[b];
  }
}

/* Updates a choice for a null collision. */
static void add_null_collision(np_air_choice *choice, const double share[NP_BAND_COUNT]) {
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float none = (float)fmax(1.0 - share[b], 0.0);
    choice->value.band[b] *= none;
    choice->density.band[b] *= none;
  }
}

static void collide(const np_medium *medium, double altitude_m, double bound_per_m, const double share[NP_BAND_COUNT],
                    np_air_collision *out) {
  double scattering[NP_BAND_COUNT];
  np_reference_air_at(medium, altitude_m, &out->air);
  np_reference_air_sum(medium, &out->air, scattering);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    out->choice.value.band[b] *= (float)(scattering[b] / bound_per_m);
    out->choice.density.band[b] *= (float)share[b];
  }
}

/* Tracks through one shell; `*flight` is the bounded optical depth to the first tentative collision. */
static bool track_shell(const shell_walk *walk, double begin, double end, int hero, double *flight, np_random *random,
                        np_air_collision *out) {
  const double bound = walk->shells->bound_per_m[walk->shell];
  while (*flight < bound * (end - begin)) {
    begin += *flight / bound;
    *flight = -log(1.0 - np_random_double(random));
    const double altitude = np_ray_altitude(&walk->ray, begin);
    double share[NP_BAND_COUNT];
    compute_shares(walk->medium, altitude, bound, share);
    if (np_random_double(random) < share[hero]) {
      collide(walk->medium, altitude, bound, share, out);
      out->distance_m = walk->ray.offset_m + begin;
      return true;
    }
    add_null_collision(&out->choice, share);
  }
  *flight -= bound * (end - begin);
  return false;
}

bool np_air_track(const neph_atmosphere *atmosphere, np_dvec3 origin, np_vec3 direction, double length_m, int hero,
                  np_random *random, np_air_collision *out) {
  out->choice = (np_air_choice){np_spectrum_grey(1.0f), np_spectrum_grey(1.0f)};
  const np_ray ray = np_ray_make_free(&atmosphere->medium, origin, direction);
  const double length = fmin(length_m - ray.offset_m, ray.length_m);
  if (!(length > 0.0)) return false;
  shell_walk walk = start_walk(atmosphere, &ray);
  double flight = -log(1.0 - np_random_double(random));
  for (double begin = 0.0; begin < length;) {
    int next;
    const double exit = compute_exit(&walk, &next), end = fmin(fmax(exit, begin), length);
    if (track_shell(&walk, begin, end, hero, &flight, random, out)) return true;
    if (!(exit < length) || next >= NP_AIR_SHELLS) break;
    begin = end;
    walk.shell = next;
  }
  return false;
}

/* ---- Flights with exact transmittance ---- */

/* Mixture weights of the two densities that follow the light; the rest is uniform along the ray. */
static const double scattered_share = 0.35, lit_share = 0.35;

static void add_density(int count, np_reference_weights *weight, int band, double share, double *probability,
                        double *rest) {
  double sum = 0.0;
  for (int i = 0; i < count; i++) sum += weight[i][band];
  if (!(sum > 0.0)) return;
  for (int i = 0; i < count; i++) probability[i] += share / sum * weight[i][band];
  *rest -= share;
}

/* Sets each band's mixture of densities: scattered and transmitted light, its part from direct sunlight, and uniform
 * along the ray. */
static void set_probabilities(const np_reference_guide *guide, np_air_flight *flight) {
  const np_reference_path *path = &flight->path;
  np_reference_weights scattered[NP_REFERENCE_PANELS_MAX], lit[NP_REFERENCE_PANELS_MAX];
  np_reference_path_weigh(path, guide, scattered, lit);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double *probability = flight->probability[b], rest = 1.0;
    for (int i = 0; i < path->panel_count; i++) probability[i] = 0.0;
    add_density(path->panel_count, scattered, b, scattered_share, probability, &rest);
    add_density(path->panel_count, lit, b, lit_share, probability, &rest);
    for (int i = 0; i < path->panel_count; i++)
      probability[i] += rest * np_reference_panel_length(path, i) / path->ray.length_m;
  }
}

/* Sun cosine below which sampling by sunlight pays. */
static const double low_sun = 0.1;

bool np_air_light_is_low(const neph_atmosphere *atmosphere, const np_air_light *light, np_dvec3 position) {
  if (!light->has_sun) return false;
  return (double)np_vec3_dot(np_zenith(position, atmosphere->medium.planet_radius_m), light->to_sun) < low_sun;
}

void np_air_flight_build(const neph_atmosphere *atmosphere, const np_air_light *light, np_dvec3 origin,
                         np_vec3 direction, double length_m, int panels, np_air_flight *out_flight) {
  const np_medium *medium = &atmosphere->medium;
  np_ray ray = np_ray_make_free(medium, origin, direction);
  ray.length_m = np_clamp(length_m - ray.offset_m, 0.0, ray.length_m);
  out_flight->path.ray = ray;
  out_flight->path.panel_count = 0;
  out_flight->transmittance = np_spectrum_grey(1.0f);
  if (!(ray.length_m > 0.0)) return;
  const double reach = fmin(sqrt(ray.length_m / (2.0 * medium->top_m)), 1.0);
  np_reference_path_build(medium, &ray, 1 + (int)(panels * reach), &out_flight->path);
  double transmittance[NP_BAND_COUNT];
  np_reference_path_transmit(&out_flight->path, transmittance);
  out_flight->transmittance = make_spectrum(transmittance);
  const np_dvec3 entry = np_dvec3_along(origin, direction, ray.offset_m);
  np_reference_guide guide = {.depths = np_air_light_is_low(atmosphere, light, entry) ? &atmosphere->depths : NULL};
  guide.sun_cosine = (double)np_vec3_dot(np_zenith(entry, medium->planet_radius_m), light->to_sun);
  guide.angle_cosine = (double)np_vec3_dot(direction, light->to_sun);
  set_probabilities(&guide, out_flight);
}

void np_air_flight_collide(const np_air_flight *flight, int hero, double u, np_air_collision *out) {
  const np_reference_path *path = &flight->path;
  const double *probability = flight->probability[hero];
  int i = 0;
  for (; i + 1 < path->panel_count && u >= probability[i]; i++) u -= probability[i];
  const double span = path->edge[i + 1] - path->edge[i];
  const double w = path->edge[i] + np_clamp(u / probability[i], 0.0, 1.0) * span;
  const double metres_per_panel = 2.0 * fabs(w) * span, t = np_reference_path_distance(path, w);
  double transmittance[NP_BAND_COUNT], scattering[NP_BAND_COUNT];
  np_reference_path_transmit_to(path, i, w, transmittance);
  np_reference_air_at(path->medium, np_ray_altitude(&path->ray, t), &out->air);
  np_reference_air_sum(path->medium, &out->air, scattering);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    out->choice.value.band[b] = (float)(transmittance[b] * scattering[b]);
    out->choice.density.band[b] = (float)(flight->probability[b][i] / metres_per_panel);
  }
  out->distance_m = path->ray.offset_m + t;
}

/* ---- Scattering ---- */

np_air_scatterer np_air_scatterer_make(const neph_atmosphere *atmosphere, const np_air_light *light,
                                       const np_reference_air *air, np_dvec3 position, np_vec3 forward) {
  const np_medium *medium = &atmosphere->medium;
  np_air_scatterer s = {.medium = medium, .forward = forward};
  if (light->has_sun) {
    const np_dvec3 zenith = np_vec3_to_double(np_zenith(position, medium->planet_radius_m));
    const np_dvec3 to_sun = np_vec3_to_double(light->to_sun);
    s.bright = np_dvec3_to_float(np_reference_compute_bright_direction(zenith, to_sun));
    s.bright_share = np_reference_bright_share(zenith, to_sun);
  }
  double sum[NP_BAND_COUNT];
  np_reference_air_sum(medium, air, sum);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    /* A band without scattering has weight 0 in any direction. */
    s.share[b][0] = sum[b] > 0.0 ? air->rayleigh[b] / sum[b] : 1.0;
    for (int i = 0; i < medium->aerosol_count; i++)
      s.share[b][1 + i] = sum[b] > 0.0 ? air->aerosol[i][b] / sum[b] : 0.0;
  }
  return s;
}

static double versine_between(np_vec3 a, np_vec3 b) { return fmin((double)np_vec3_versine(a, b), 2.0); }

np_air_choice np_air_scatterer_eval(const np_air_scatterer *s, np_vec3 direction) {
  const double versine = versine_between(s->forward, direction);
  double phase[NP_AEROSOLS_MAX + 1] = {np_reference_rayleigh(versine)}, about_bright = 0.0;
  for (int i = 0; i < s->medium->aerosol_count; i++)
    phase[1 + i] = (double)np_phase_eval(&s->medium->aerosol[i].phase, (float)versine);
  if (s->bright_share > 0.0) {
    const np_phase lobe = np_phase_henyey_greenstein(NP_REFERENCE_BRIGHT_ASYMMETRY);
    about_bright = s->bright_share * (double)np_phase_eval(&lobe, (float)versine_between(s->bright, direction));
  }
  np_air_choice choice;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double value = 0.0;
    for (int i = 0; i <= s->medium->aerosol_count; i++) value += s->share[b][i] * phase[i];
    choice.value.band[b] = (float)value;
    choice.density.band[b] = (float)((1.0 - s->bright_share) * value + about_bright);
  }
  return choice;
}

np_vec3 np_air_scatterer_sample(const np_air_scatterer *s, int hero, np_random *random, np_air_choice *out_choice) {
  const bool is_bright = np_random_double(random) < s->bright_share;
  double pick = np_random_double(random);
  int i = 0;
  for (; i < s->medium->aerosol_count && pick >= s->share[hero][i]; i++) pick -= s->share[hero][i];
  np_phase phase = i > 0 ? s->medium->aerosol[i - 1].phase : np_phase_rayleigh();
  if (is_bright) phase = np_phase_henyey_greenstein(NP_REFERENCE_BRIGHT_ASYMMETRY);
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  float value;
  const np_vec3 direction = np_vec3_normalize(np_phase_sample(&phase, is_bright ? s->bright : s->forward, u, &value));
  *out_choice = np_air_scatterer_eval(s, direction);
  return direction;
}
