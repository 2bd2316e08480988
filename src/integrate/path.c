/* SPDX-License-Identifier: Apache-2.0 */
/* The path tracer: free flights through clouds, air and to the ground, with next-event estimation.
 *
 * Clouds and air are independent media in one place, so that of their free flights the nearer counts. Clouds are
 * tracked against their bricks' bounds (Woodcock, Murphy, Hemmings and Longworth 1965; tracking.h), air as
 * atmosphere/air_flight.h says. Where bands part, in the air and at phase functions with colour, one of them leads and
 * all are weighed (hero.h). At every vertex a path is weighted by the albedo, gathers the sun through an unbiased
 * transmittance, and goes on in a direction drawn from the phase function, from Lambert's cosine, or by the waves of
 * water. Paths that leave the planet see the light beyond the air. The sun's disk is sampled both ways, by next-event
 * estimation and by chance, weighted by the balance heuristic (Veach and Guibas 1995); so is emission, and, where it
 * pays, the sky (sky_next_event.h). So the mean over samples is the solution of the equation of transfer.
 *
 * With the air from tables, paths live in the clouds alone; where one leaves them it sees the sky or ground that the
 * world describes, and ends. Compiled once per instruction-set level.
 */
#include "integrate/ground_scatter.h"

#include <assert.h>
#include "integrate/path_light.h"
#include "integrate/sky_next_event.h"
#include "integrate/sun_branching.h"

/* ---- Sky and ground ---- */

/* Sizes of the stacks of waiting paths. While a stack is full, paths are not branched, or not split. */
enum { BRANCH_DEPTH_MAX = 64, SPLIT_DEPTH_MAX = 256 };

static bool may_branch(const np_path_state *path) { return path->depth < BRANCH_DEPTH_MAX; }

static void follow_past_clouds(const np_tracer *t, np_path_state *path);

static void gather_sky(const np_tracer *t, const np_path_state *path, const np_sky_next_event *sky, float share,
                       float density) {
  np_path_state ray;
  if (np_sky_next_event_start(path, sky, share, density, t->random, &ray)) follow_past_clouds(t, &ray);
}

/* Renames the component of light that clouds scatter once, from sun to sky or ground, when the path meets either. */
static void set_outside_component(const np_tracer *t, np_path_state *path, bool is_ground) {
  if (path->component == NP_COMPONENT_SUN) path->component = is_ground ? NP_COMPONENT_GROUND : NP_COMPONENT_SKY;
  np_sky_next_event_weigh_miss(t, path);
}

/* ---- Clouds ---- */

/* A direction from a scattering in cloud: the phase function there, and the density with which paths and branches take
 * it, in each band; and the mean density over the heroes. */
typedef struct cloud_choice {
  np_spectrum value, density;
  float mean_density, expected_gain;
} cloud_choice;

static cloud_choice eval_grey_cloud(const np_path_state *path, float branches, float versine, np_vec3 direction) {
  const float ahead = np_phase_eval(&path->volume->phase, versine);
  const float steer = path->is_guided ? np_guide_steer(&path->guide, path->direction, direction) : 1.0f;
  const float density = ahead * steer + branches;
  return (cloud_choice){np_spectrum_grey(ahead), np_spectrum_grey(density), density, 0.0f};
}

static cloud_choice eval_cloud(const np_path_state *path, const np_sun_branching *branching, np_vec3 direction) {
  const np_phase *phase = &path->volume->phase;
  const np_vec3 before = path->direction;
  const float versine = np_vec3_versine(before, direction);
  float gain;
  const float branches = np_sun_branching_eval(branching, direction, &gain);
  cloud_choice choice;
  if (!phase->bands) {
    choice = eval_grey_cloud(path, branches, versine, direction);
  } else {
    choice.value = choice.density = np_phase_eval_bands(phase, versine);
    if (path->is_guided)
      choice.density =
          np_spectrum_multiply(choice.density, np_guide_steer_bands(&path->guide, phase->bands, before, direction));
    choice.density = np_spectrum_add(choice.density, np_spectrum_grey(branches));
    choice.mean_density = np_hero_mean(&path->hero, choice.density);
  }
  choice.expected_gain = gain;
  return choice;
}

/* The sky's light, past the clouds; where bands differ, the throughput takes their ratios. */
static void gather_tinted_sky(const np_tracer *t, const np_path_state *path, const np_sky_next_event *sky,
                              np_spectrum value, float density, bool is_tinted) {
  const float share = np_spectrum_max(value);
  if (!(share > 0.0f)) return;
  np_path_state tinted = *path;
  if (is_tinted) tinted.throughput = np_spectrum_multiply(path->throughput, np_spectrum_scale(value, 1.0f / share));
  gather_sky(t, &tinted, sky, share, density);
}

/* Adds light by next-event estimation, and chooses branches by the sun's share in it. */
static void gather_in_cloud(const np_tracer *t, const np_path_state *path, np_sun_branching *branching) {
  np_sun_ray sun;
  if (np_path_aim_at_sun(t, path, np_sun_branching_faint_depth(branching), &sun)) {
    if (may_branch(path)) np_sun_branching_choose(branching, sun.expected);
    if (!np_sun_ray_is_dark(&sun)) {
      const cloud_choice towards = eval_cloud(path, branching, sun.direction);
      np_path_gather_sun(t, path, &sun, towards.value, towards.mean_density);
    }
  }
  np_emitter_ray emitter;
  if (np_path_aim_at_emitter(t, path->position, &emitter)) {
    const cloud_choice towards = eval_cloud(path, branching, emitter.direction);
    np_path_gather_emission(t, path, &emitter, towards.value, towards.mean_density);
  }
  np_sky_next_event sky;
  if (np_sky_next_event_sample(t, path, &sky)) {
    const cloud_choice towards = eval_cloud(path, branching, sky.direction);
    const bool is_tinted = path->volume->phase.bands;
    gather_tinted_sky(t, path, &sky, towards.value, towards.mean_density, is_tinted);
  }
}

/* Turns a path into a direction that was drawn for it or for a branch. */
static void turn(np_path_state *path, const np_sun_branching *branching, np_vec3 direction) {
  const cloud_choice choice = eval_cloud(path, branching, direction);
  const float ahead = choice.value.band[0];
  path->direction = direction;
  path->density = choice.mean_density;
  path->expected_gain = fmaxf(1.0f, choice.expected_gain);
  if (path->volume->phase.bands)
    np_hero_choose(&path->hero, &path->throughput, choice.value, choice.density);
  else if (path->density != ahead)
    path->throughput = np_spectrum_scale(path->throughput, ahead / path->density);
}

static np_vec3 draw_direction(const np_tracer *t, const np_path_state *path) {
  np_random *random = t->random;
  const np_phase phase = np_phase_get_band(&path->volume->phase, path->hero.band);
  if (path->is_guided) return np_guide_sample(&path->guide, &phase, path->direction, random);
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  float value;
  return np_phase_sample(&phase, path->direction, u, &value);
}

static void fly_on(const np_tracer *t, np_path_state *path);

/* Follows the weaker of two paths to its end while the stronger waits: so the stack stays short. */
static void follow_weaker(const np_tracer *t, np_path_state *path, np_path_state *branch) {
  if (np_spectrum_max(branch->throughput) > np_spectrum_max(path->throughput)) {
    const np_path_state kept = *branch;
    *branch = *path;
    *path = kept;
  }
  branch->depth++;
  fly_on(t, branch);
}

static void scatter_in_cloud(const np_tracer *t, np_path_state *path, const np_sun_branching *branching) {
  np_path_state branch = *path;
  np_vec3 direction;
  const bool has_branch = np_sun_branching_sample(branching, t->random, &direction);
  assert(branching->share + branching->broad_share <= 1.0f + 1e-6f);
  if (has_branch) turn(&branch, branching, direction);
  turn(path, branching, draw_direction(t, path));
  if (has_branch) follow_weaker(t, path, &branch);
}

/* Starts to guide a path; false where the solution has no light. */
static bool build_guide(const np_tracer *t, np_path_state *path) {
  const float throughput = np_spectrum_max(path->throughput);
  if (!np_path_may_be_guided(t) || !(throughput > 0.0f)) return false;
  if (!np_guide_make(t->world, t->lighting->scattering, path->volume, path->position, path->direction, &path->guide))
    return false;
  path->weight = throughput;
  if (!(path->reference > 0.0f)) path->reference = path->weight * path->guide.light;
  return true;
}

/* Number of copies in which a guided path continues; 0: it ends, and the solution takes its place. */
static unsigned count_copies(const np_tracer *t, np_path_state *path) {
  const float count = np_guide_count(&path->guide, path->weight, path->reference);
  assert(count >= 0.0f);
  if (count >= 1.0f) return path->depth < SPLIT_DEPTH_MAX ? (unsigned)count : 1;
  const bool goes_on = np_random_float(t->random) < count;
  const float expected = path->guide.light * (goes_on ? 1.0f - 1.0f / count : 1.0f);
  const np_spectrum colour = np_scattering_field_get_medium(t->lighting->scattering)->colour;
  np_path_add_light(t, path, np_path_name_multiple(path), np_spectrum_scale(colour, expected));
  if (goes_on) path->throughput = np_spectrum_scale(path->throughput, 1.0f / count);
  return goes_on;
}

static void scatter_copies(const np_tracer *t, np_path_state *path, const np_sun_branching *branching, unsigned count) {
  if (count > 1) path->throughput = np_spectrum_scale(path->throughput, 1.0f / (float)count);
  if (path->is_guided) path->weight = np_spectrum_max(path->throughput);
  for (; count > 1; count--) {
    np_path_state copy = *path;
    copy.depth++;
    scatter_in_cloud(t, &copy, branching);
    fly_on(t, &copy);
  }
  scatter_in_cloud(t, path, branching);
}

/* False where the path is ended. */
static bool collide_in_cloud(const np_tracer *t, np_path_state *path) {
  path->order++;
  path->throughput = np_spectrum_multiply(path->throughput, path->volume->albedo);
  if (!path->has_component) path->component = path->order == 1 ? NP_COMPONENT_SUN : NP_COMPONENT_MULTIPLE;
  path->is_guided = build_guide(t, path);
  path->has_sky_next_event = t->lighting->sky_guide && may_branch(path);
  np_sun_branching branching = np_sun_branching_make(t->world, &path->volume->phase);
  gather_in_cloud(t, path, &branching);
  const unsigned copies = path->is_guided ? count_copies(t, path) : 1;
  if (copies > 0) scatter_copies(t, path, &branching, copies);
  return copies > 0;
}

/* ---- Air, ground and space ---- */

static void collide_in_air(const np_tracer *t, np_path_state *path) {
  set_outside_component(t, path, path->is_ground_ahead);
  path->is_through_air = true;
  const np_air_scatterer scatterer =
      np_air_scatterer_make(t->world->atmosphere, &t->air_light, &path->air, path->position, path->direction);
  np_sun_ray sun;
  if (np_path_aim_at_sun(t, path, np_track_faint_depth, &sun) && !np_sun_ray_is_dark(&sun)) {
    const np_air_choice towards = np_air_scatterer_eval(&scatterer, sun.direction);
    np_path_gather_sun(t, path, &sun, towards.value, np_hero_mean(&path->hero, towards.density));
  }
  np_emitter_ray emitter;
  if (np_path_aim_at_emitter(t, path->position, &emitter)) {
    const np_air_choice towards = np_air_scatterer_eval(&scatterer, emitter.direction);
    np_path_gather_emission(t, path, &emitter, towards.value, np_hero_mean(&path->hero, towards.density));
  }
  np_air_choice choice;
  path->direction = np_air_scatterer_sample(&scatterer, path->hero.band, t->random, &choice);
  path->density = np_hero_mean(&path->hero, choice.density);
  path->expected_gain = 1.0f;
  np_hero_choose(&path->hero, &path->throughput, choice.value, choice.density);
}

static void gather_sky_on_ground(const np_tracer *t, const np_path_state *path, const np_ground_scatter *scatter) {
  np_sky_next_event sky;
  if (!np_sky_next_event_sample(t, path, &sky)) return;
  const np_ground_choice choice = np_ground_scatter_eval(scatter, sky.direction);
  gather_tinted_sky(t, path, &sky, choice.value, choice.density, path->ground.water);
}

/* False where the path is ended. */
static bool reflect_at_ground(const np_tracer *t, np_path_state *path) {
  set_outside_component(t, path, true);
  path->position = path->ground.position;
  const np_ground_scatter scatter = np_ground_scatter_make(&path->ground, path->direction, &path->throughput);
  path->has_sky_next_event = t->lighting->sky_guide && may_branch(path);
  np_sun_ray sun;
  if (np_path_aim_at_sun(t, path, np_track_faint_depth, &sun) && !np_sun_ray_is_dark(&sun)) {
    const np_ground_choice choice = np_ground_scatter_eval(&scatter, sun.direction);
    if (choice.density > 0.0f) np_path_gather_sun(t, path, &sun, choice.value, choice.density);
  }
  np_emitter_ray emitter;
  if (np_path_aim_at_emitter(t, path->position, &emitter)) {
    const np_ground_choice choice = np_ground_scatter_eval(&scatter, emitter.direction);
    if (choice.density > 0.0f) np_path_gather_emission(t, path, &emitter, choice.value, choice.density);
  }
  gather_sky_on_ground(t, path, &scatter);
  path->expected_gain = 1.0f;
  return np_ground_scatter_sample(&scatter, t->random, &path->throughput, &path->direction, &path->density);
}

static void add_space(const np_tracer *t, np_path_state *path) {
  np_path_add_sun_disk(t, path);
  set_outside_component(t, path, false);
  np_path_add_light(t, path, path->component, np_world_space_radiance(t->world, path->position, path->direction));
}

/* Adds light from the tables of sky or ground to a path that has left the clouds. A path that only water has reflected
 * sees the sky from the water. */
static void add_surroundings(const np_tracer *t, np_path_state *path) {
  bool is_ground;
  const np_reflection *reflection = path->order == 0 ? t->lighting->reflection : NULL;
  const neph_sky *sky = reflection ? reflection->world.camera_sky : t->world->cloud_sky;
  const np_spectrum incoming = np_surroundings_incoming(t->world, t->lighting, t->settings, sky, path->position,
                                                        path->direction, np_path_shadow, t->random, &is_ground);
  if (!is_ground) np_path_add_sun_disk(t, path);
  set_outside_component(t, path, is_ground);
  np_path_add_light(t, path, path->component, incoming);
}

/* ---- Flights ---- */

/* Length of a flight under a low sun above which it is a leap (atmosphere/air_flight.h). */
static const double leap_m = 2e3;

/* Number of panels into which a ray through all of the air is cut. */
enum { PANELS = 12 };

/* Probability of each band to pass the air to what is behind: in proportion to what may come from there and, taken as
 * white, from the air. */
static np_spectrum choose_end(const np_tracer *t, const np_path_state *path, np_path_event end,
                              np_spectrum transmittance) {
  np_spectrum albedo = np_spectrum_grey(1.0f);
  if (end == NP_PATH_GROUND) albedo = path->ground.albedo;
  if (end == NP_PATH_SPACE && !np_world_sun_covers(t->world, path->direction) &&
      np_spectrum_is_zero(np_world_space_radiance(t->world, path->position, path->direction)))
    albedo = np_spectrum_grey(0.0f);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float behind = albedo.band[b] * transmittance.band[b];
    transmittance.band[b] = behind > 0.0f ? behind / (behind + 1.0f - transmittance.band[b]) : 0.0f;
  }
  return transmittance;
}

/* Draws whether a flight of known transmittance collides with the air. */
static bool leap(const np_tracer *t, np_path_state *path, np_path_event end, double length_m,
                 np_air_collision *collision) {
  np_air_flight flight;
  np_air_flight_build(t->world->atmosphere, &t->air_light, path->position, path->direction, length_m, PANELS, &flight);
  if (!flight.path.panel_count) return false;
  const np_spectrum passing = choose_end(t, path, end, flight.transmittance);
  if (np_random_double(t->random) < (double)passing.band[path->hero.band]) {
    np_hero_choose(&path->hero, &path->throughput, flight.transmittance, passing);
    return false;
  }
  np_air_flight_collide(&flight, path->hero.band, np_random_double(t->random), collision);
  const np_spectrum density =
      np_spectrum_multiply(collision->choice.density, np_spectrum_subtract(np_spectrum_grey(1.0f), passing));
  np_hero_choose(&path->hero, &path->throughput, collision->choice.value, density);
  return true;
}

/* Whether the air ends a flight; `collision` is the place. */
static bool collide_with_air(const np_tracer *t, np_path_state *path, np_path_event end, double length_m,
                             np_air_collision *collision) {
  const neph_atmosphere *atmosphere = t->world->atmosphere;
  if (length_m > leap_m && np_air_light_is_low(atmosphere, &t->air_light, path->position))
    return leap(t, path, end, length_m, collision);
  const bool collides =
      np_air_track(atmosphere, path->position, path->direction, length_m, path->hero.band, t->random, collision);
  np_hero_choose(&path->hero, &path->throughput, collision->choice.value, collision->choice.density);
  return collides;
}

/* Searches for ground within a distance. */
static bool intersect_ground(const np_tracer *t, np_path_state *path, double distance) {
  const np_dvec3 next = np_dvec3_along(path->position, path->direction, distance);
  return np_world_may_meet_ground(t->world, path->position, next) &&
         np_world_intersect_ground(t->world, path->position, path->direction, &path->ground) &&
         path->ground.distance_m < distance;
}

/* Event that ends a flight: a collision with air if it comes first, else `end`. `*distance` becomes the distance to a
 * collision with air. */
static np_path_event fly_through_air(const np_tracer *t, np_path_state *path, np_path_event end, double *distance) {
  np_air_collision collision;
  if (!t->settings->is_air_traced || !t->world->atmosphere || !collide_with_air(t, path, end, *distance, &collision))
    return end;
  *distance = collision.distance_m;
  path->air = collision.air;
  return NP_PATH_AIR;
}

/* Whether all that a path may meet outside the clouds is the sun's disk. */
static bool is_dark_outside(const np_world *world) {
  return !world->atmosphere && !world->has_planet && !world->terrain && !world->night && !world->emission &&
         np_spectrum_is_zero(world->environment_radiance);
}

/* Optical depth up to which bounds of clouds are searched: one flight in four hundred goes beyond. */
static const double rim_depth = 6.0;

/* Guided paths do not leave the clouds through a near rim where it is dark outside: each is forced to collide before,
 * and is weighted by the probability. A path that leaves is lost: most of the noise of guided paths in slabs came from
 * such losses. */
static np_flight start_flight(const np_tracer *t, const np_path_state *path) {
  const double stretch_fraction = path->is_guided ? np_guide_get_stretch_fraction(&path->guide, path->direction) : 0.0;
  const np_flight flight = np_flight_start(np_track_flight(t->random), stretch_fraction);
  if (!path->is_guided || !is_dark_outside(t->world) || np_world_sun_covers(t->world, path->direction)) return flight;
  const double bound =
      np_flight_bound(&t->world->clouds, path->position, path->direction, INFINITY, &flight, rim_depth);
  return bound < rim_depth ? np_flight_force(bound, stretch_fraction, t->random) : flight;
}

/* The next collision with a cloud. */
static double fly_through_clouds(const np_tracer *t, np_path_state *path) {
  np_flight flight = start_flight(t, path);
  const double distance = np_track_collision(&t->world->clouds, path->position, path->direction, INFINITY, &flight,
                                             t->random, &path->volume);
  if (path->is_guided) path->throughput = np_spectrum_scale(path->throughput, np_flight_weight(&flight));
  return distance;
}

/* Flies to the next vertex. */
static np_path_event fly(const np_tracer *t, np_path_state *path) {
  double distance = fly_through_clouds(t, path);
  np_path_event event = isinf(distance) ? NP_PATH_SPACE : NP_PATH_CLOUD;
  path->is_ground_ahead = (event != NP_PATH_SPACE || t->settings->is_air_traced) && intersect_ground(t, path, distance);
  if (path->is_ground_ahead) {
    event = NP_PATH_GROUND;
    distance = path->ground.distance_m;
  }
  if (t->world->emission) np_path_collect_emission(t, path, distance);
  if (!t->settings->is_air_traced && (event == NP_PATH_SPACE || event == NP_PATH_GROUND)) return NP_PATH_SURROUNDINGS;
  event = fly_through_air(t, path, event, &distance);
  if (event != NP_PATH_SPACE) path->position = np_dvec3_along(path->position, path->direction, distance);
  return event;
}

/* Continues straight to the light past the clouds, dimmed by their transmittance. */
static np_path_event fly_past_clouds(const np_tracer *t, np_path_state *path) {
  path->is_ground_ahead = intersect_ground(t, path, INFINITY);
  double distance = path->is_ground_ahead ? path->ground.distance_m : HUGE_VAL;
  const np_path_event end = path->is_ground_ahead ? NP_PATH_GROUND : NP_PATH_SPACE;
  const np_path_event event = fly_through_air(t, path, end, &distance);
  const float transmittance = np_track_transmittance(&t->world->clouds, path->position, path->direction, distance,
                                                     np_track_faint_depth, t->random);
  path->throughput = np_spectrum_scale(path->throughput, transmittance);
  if (!t->settings->is_air_traced) return NP_PATH_SURROUNDINGS;
  if (event == NP_PATH_AIR) path->position = np_dvec3_along(path->position, path->direction, distance);
  return event;
}

static void follow_past_clouds(const np_tracer *t, np_path_state *path) {
  const np_path_event event = fly_past_clouds(t, path);
  if (np_spectrum_max(path->throughput) > 0.0f) NP_KERNEL(np_path_follow)(t, path, event);
}

/* ---- Paths ---- */

/* Russian roulette on a path that is weak against the light that it may still find; false ends it. Guided paths are
 * counted. */
static bool survive(np_path_state *path, np_random *random) {
  if (path->is_guided) return true;
  const float weight = np_spectrum_max(path->throughput) / path->weight * path->expected_gain;
  if (weight >= 0.25f) return true;
  if (!(np_random_float(random) < weight)) return false;
  path->throughput = np_spectrum_scale(path->throughput, 1.0f / weight);
  return true;
}

/* Limit on scatterings of a followed path beyond render.max_scatterings; such a path makes the estimate of the loss
 * infinite. */
enum { FOLLOWED_MAX = 1 << 20 };

/* Applies the limit on scatterings: a path beyond it ends, or, with the probability `lost_share`, is followed to
 * estimate the lost light. */
static bool is_ended(const np_tracer *t, np_path_state *path) {
  if (path->order < t->settings->scattering_max) return false;
  if (path->is_cut) {
    const bool is_lost = path->order - t->settings->scattering_max > FOLLOWED_MAX;
    if (is_lost) t->out->lost = np_spectrum_grey(INFINITY);
    return is_lost;
  }
  t->out->cut_count++;
  const float share = t->settings->lost_share;
  if (!(np_random_float(t->random) < share)) return true;
  path->is_cut = true;
  t->out->followed_count++;
  path->throughput = np_spectrum_scale(path->throughput, 1.0f / share);
  path->weight /= share;
  path->reference /= share;
  return false;
}

void NP_KERNEL(np_path_follow)(const np_tracer *t, np_path_state *path, np_path_event event) {
  while (!np_monitor_is_cancelled(t->settings->monitor)) {
    path->is_guided = false;
    switch (event) {
    case NP_PATH_CLOUD:
      if (is_ended(t, path) || !collide_in_cloud(t, path)) return;
      break;
    case NP_PATH_AIR:
      if (t->world->sun_scope == NP_SUN_BEAM) return;
      collide_in_air(t, path);
      break;
    case NP_PATH_GROUND:
      if (!reflect_at_ground(t, path)) return;
      break;
    case NP_PATH_SPACE:
      add_space(t, path);
      return;
    case NP_PATH_SURROUNDINGS:
      add_surroundings(t, path);
      return;
    }
    if (!survive(path, t->random)) return;
    event = fly(t, path);
  }
}

static void fly_on(const np_tracer *t, np_path_state *path) {
  if (survive(path, t->random)) NP_KERNEL(np_path_follow)(t, path, fly(t, path));
}
