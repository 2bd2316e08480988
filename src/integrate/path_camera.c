/* SPDX-License-Identifier: Apache-2.0 */
/* The path tracer's first step: what a camera's ray meets, clouds, air and what is behind them.
 *
 * A ray through thin clouds is forced to collide with them, one through air always collides with it, and both go on to
 * what is behind: however little there is in the way, it is seen without noise of its own. From each first vertex a
 * path is followed (path.c). Compiled once per instruction-set level.
 */
#include "integrate/emission_rays.h"
#include "integrate/path_state.h"

void NP_KERNEL(np_path_sample)(const np_world *world, const np_lighting *lighting,
                               const np_integrator_settings *settings, const np_camera_ray *ray, np_random *random,
                               np_integrator_sample *out);

static np_path_state start_path(const np_camera_ray *ray, double distance, np_spectrum throughput) {
  return (np_path_state){.position = np_dvec3_along(ray->origin, ray->direction, distance),
                         .direction = ray->direction,
                         .throughput = throughput,
                         .hero = {0, np_spectrum_grey(1.0f)},
                         .weight = np_spectrum_max(throughput),
                         .expected_gain = 1.0f};
}

/* First collision of a ray with a cloud, if there is one. */
typedef struct cloud_hit {
  double distance; /* in metres; infinite: the ray meets no cloud */
  const np_instance *volume;
  float weight;
  float expected; /* expected radiance of the ray by the view's solution; 0: unknown */
} cloud_hit;

/* Depth of clouds below which the camera's ray is forced to collide. */
static const double thin_depth = 1.0;

/* Starts a flight along the camera's ray, guided by the importance at the first cloud. Its stretch is not negative:
 * shorter flights would see the background with large weights. */
static np_flight guide_flight(const np_tracer *t, const np_camera_ray *ray, float *out_expected) {
  np_guide guide;
  double stretch_fraction = 0.0;
  if (np_path_may_be_guided(t) &&
      np_guide_make_entry(t->world, t->lighting->scattering, ray->origin, ray->direction, &guide)) {
    stretch_fraction = fmax(np_guide_get_stretch_fraction(&guide, ray->direction), 0.0);
    *out_expected = guide.light;
  }
  return np_flight_start(np_track_flight(t->random), stretch_fraction);
}

/* A ray of little depth M, counted in the clouds' bounds, has a tentative collision with probability 1 − e^{−M}. It is
 * given one, with that weight, and passes with the weight e^{−M}: a veil of depth 1e-8 has as little relative noise as
 * any. */
static cloud_hit sample_cloud(const np_tracer *t, const np_camera_ray *ray, double distance_end) {
  cloud_hit hit = {.distance = HUGE_VAL, .weight = 1.0f};
  const np_flight whole = np_flight_start(0.0, 0.0);
  const double bound =
      np_flight_bound(&t->world->clouds, ray->origin, ray->direction, distance_end, &whole, thin_depth);
  if (!(bound > 0.0)) return hit;
  const bool is_thin = bound < thin_depth;
  np_flight flight = is_thin ? np_flight_force(bound, 0.0, t->random) : guide_flight(t, ray, &hit.expected);
  hit.distance =
      np_track_collision(&t->world->clouds, ray->origin, ray->direction, distance_end, &flight, t->random, &hit.volume);
  hit.weight = np_flight_weight(&flight);
  if (!isinf(hit.distance))
    t->out->transmittance = is_thin ? (float)exp(-bound) : 0.0f;
  else if (!is_thin)
    t->out->transmittance = hit.weight;
  return hit;
}

static bool is_shown(const cloud_hit *hit) { return !isinf(hit->distance) && !hit->volume->is_held_out; }

static void add_opaque_cloud(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *hit) {
  if (hit->volume->is_held_out) {
    t->out->held_out = hit->weight;
    return;
  }
  np_integrator_add_cloud(ray, hit->volume, hit->weight);
  const np_dvec3 position = np_dvec3_along(ray->origin, ray->direction, hit->distance);
  const float sun_share =
      np_surroundings_get_sun_share(t->world, t->lighting, t->settings, position, np_path_shadow, t->random);
  np_integrator_add_opaque(
      t->out, hit->weight,
      &(np_opaque){.distance_m = hit->distance, .albedo = hit->volume->albedo, .sun_share = sun_share});
}

/* Light scattered in the clouds after a first collision, and the air before it, from the camera's table. */
static void add_cloud_by_tables(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *hit) {
  np_integrator_sample scattered = {.transmittance = 0.0f};
  np_tracer inner = *t;
  inner.out = &scattered;
  np_path_state path = start_path(ray, hit->distance, np_spectrum_grey(hit->weight));
  path.volume = hit->volume;
  path.reference = hit->expected;
  NP_KERNEL(np_path_follow)(&inner, &path, NP_PATH_CLOUD);
  const np_aerial_perspective air = np_camera_ray_get_air(t->lighting, t->world, ray, hit->distance, NP_RAY_END_CLOUD);
  for (int c = 0; c < NP_COMPONENT_COUNT; c++)
    np_path_add(t->out, (np_component)c, np_spectrum_multiply(scattered.component[c], air.transmittance));
  t->out->lost = np_spectrum_multiply(scattered.lost, air.transmittance);
  t->out->cut_count = scattered.cut_count;
  t->out->followed_count = scattered.followed_count;
  np_path_add(t->out, NP_COMPONENT_AIR, np_spectrum_scale(air.inscatter, hit->weight));
}

/* Light that water scatters, and the air before it, from the camera's table. */
static void add_water_by_tables(const np_tracer *t, const np_camera_ray *ray, const np_ground_hit *water) {
  if (!(t->out->transmittance > 0.0f) || t->settings->is_ground_held_out) return;
  const np_aerial_perspective air =
      np_camera_ray_get_air(t->lighting, t->world, ray, water->distance_m, NP_RAY_END_NONE);
  const np_spectrum inscatter = np_spectrum_scale(air.inscatter, t->out->transmittance);
  np_path_add(t->out, NP_COMPONENT_AIR, inscatter);
  t->out->component[NP_COMPONENT_GROUND_AIR] = inscatter;
  np_path_state path = start_path(ray, water->distance_m, np_spectrum_scale(air.transmittance, t->out->transmittance));
  path.component = NP_COMPONENT_TERRAIN;
  path.has_component = true;
  path.ground = *water;
  path.hero = np_path_draw_hero(t);
  if (path.weight > 0.0f) NP_KERNEL(np_path_follow)(t, &path, NP_PATH_GROUND);
}

/* Number of panels into which a camera ray through all of the air is cut: more than of other rays, as there is one a
 * sample. */
enum { CAMERA_PANELS = 20 };

/* The air from the eye to a distance from the origin: its transmittance, and, added to a component, its in-scatter. */
static np_spectrum add_air(const np_tracer *t, const np_camera_ray *ray, double distance, np_component component,
                           bool is_seen) {
  if (!t->world->atmosphere) return np_spectrum_grey(1.0f);
  np_air_flight flight;
  const np_dvec3 eye = np_camera_ray_get_view(ray).eye;
  np_air_flight_build(t->world->atmosphere, &t->air_light, eye, ray->direction, ray->begin_m + distance, CAMERA_PANELS,
                      &flight);
  if (!is_seen || !flight.path.panel_count) return flight.transmittance;
  double place;
  const np_hero hero = np_hero_choose_first((double)ray->choice, &place);
  np_air_collision collision;
  np_air_flight_collide(&flight, hero.band, place, &collision);
  np_path_state path = start_path(ray, collision.distance_m - ray->begin_m, np_spectrum_grey(1.0f));
  path.component = component;
  path.has_component = true;
  path.air = collision.air;
  path.hero = hero;
  np_hero_choose(&path.hero, &path.throughput, collision.choice.value, collision.choice.density);
  path.weight = np_spectrum_max(path.throughput);
  if (path.weight > 0.0f) NP_KERNEL(np_path_follow)(t, &path, NP_PATH_AIR);
  return flight.transmittance;
}

static void add_traced_cloud(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *hit, bool is_air_seen) {
  const np_spectrum air = add_air(t, ray, hit->distance, NP_COMPONENT_AIR, is_air_seen);
  np_path_state path = start_path(ray, hit->distance, np_spectrum_scale(air, hit->weight));
  if (!(path.weight > 0.0f)) return;
  path.volume = hit->volume;
  path.reference = hit->expected * np_spectrum_max(air);
  path.hero = np_path_draw_hero(t);
  NP_KERNEL(np_path_follow)(t, &path, NP_PATH_CLOUD);
}

static void add_cloud(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *hit, bool is_air_seen) {
  if (!t->settings->is_air_traced)
    add_cloud_by_tables(t, ray, hit);
  else
    add_traced_cloud(t, ray, hit, is_air_seen);
}

/* Adds a cloud's light, and its collision to the list of depths. */
static void record_cloud(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *hit, bool is_air_seen) {
  const np_integrator_sample before = *t->out;
  add_cloud(t, ray, hit, is_air_seen);
  np_integrator_record_depth(ray, &before, t->out, hit->distance, hit->distance);
  ray->layers->depths[ray->layers->depth_count - 1].opacity = hit->weight;
}

static void add_tabulated_air(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *cloud,
                              const np_ground_hit *ground) {
  if (is_shown(cloud)) (np_integrator_has_depths(ray) ? record_cloud : add_cloud)(t, ray, cloud, true);
  if (ground && ground->water) {
    add_water_by_tables(t, ray, ground);
    return;
  }
  const np_behind behind = {.hit = ground};
  np_surroundings_add_behind(t->world, t->lighting, t->settings, ray, &behind, t->out->transmittance, np_path_shadow,
                             t->random, t->out);
}

static void add_behind(const np_tracer *t, const np_camera_ray *ray, const np_ground_hit *ground, bool is_air_seen) {
  const np_component component = ground ? NP_COMPONENT_AIR : NP_COMPONENT_BACKGROUND;
  const np_spectrum before = t->out->component[component];
  const np_spectrum air = add_air(t, ray, ground ? ground->distance_m : HUGE_VAL, component, is_air_seen);
  if (ground) t->out->component[NP_COMPONENT_GROUND_AIR] = np_spectrum_subtract(t->out->component[component], before);
  const np_spectrum transmittance = np_spectrum_scale(air, t->out->transmittance);
  if (!ground) {
    const np_dvec3 eye = np_camera_ray_get_view(ray).eye;
    const np_spectrum light = np_spectrum_add(np_world_space_radiance(t->world, eye, ray->direction),
                                              np_world_disk_radiance(t->world, ray->direction));
    np_path_add(t->out, component, np_spectrum_multiply(transmittance, light));
    return;
  }
  np_path_state path = start_path(ray, ground->distance_m, transmittance);
  if (!(path.weight > 0.0f)) return;
  path.component = NP_COMPONENT_TERRAIN;
  path.has_component = true;
  path.ground = *ground;
  path.hero = np_path_draw_hero(t);
  NP_KERNEL(np_path_follow)(t, &path, NP_PATH_GROUND);
}

/* Traces a camera ray to the cloud and to the surface behind it. The air before each is counted with the probability
 * that the ray ends there. */
static void look(const np_tracer *t, const np_camera_ray *ray, const cloud_hit *cloud, const np_ground_hit *ground) {
  const bool is_cloud = !isinf(cloud->distance), is_behind = t->out->transmittance > 0.0f;
  const bool is_cloud_end = is_cloud && (!is_behind || np_random_float(t->random) < cloud->weight);
  if (is_shown(cloud)) (np_integrator_has_depths(ray) ? record_cloud : add_cloud)(t, ray, cloud, is_cloud_end);
  if (is_behind && !(ground && t->settings->is_ground_held_out)) add_behind(t, ray, ground, !is_cloud_end);
}

/* Adds the disks of sun and moon with the clouds' transmittance: free flights would make them noisy. */
static void add_disks(const np_tracer *t, const np_camera_ray *ray) {
  if (np_spectrum_is_zero(np_world_disk_radiance(t->world, ray->direction))) return;
  t->out->transmittance = np_track_transmittance(&t->world->clouds, ray->origin, ray->direction,
                                                 np_camera_ray_get_end(ray), np_track_faint_depth, t->random);
}

static void add_emission(const np_tracer *t, const np_camera_ray *ray, double distance_end) {
  const np_emission *emission = t->world->emission;
  for (unsigned g = 0; g < emission->emitter_count; g++)
    if (!emission->emitters[g].is_held_out)
      np_path_add(t->out, NP_COMPONENT_EMISSION,
                  np_emitter_along(t->world, &emission->emitters[g], ray->origin, ray->direction, distance_end, 1.0f,
                                   true, ray->begin_m, t->random, np_integrator_has_depths(ray) ? ray->layers : NULL));
}

void NP_KERNEL(np_path_sample)(const np_world *world, const np_lighting *lighting,
                               const np_integrator_settings *settings, const np_camera_ray *ray, np_random *random,
                               np_integrator_sample *out) {
  *out = (np_integrator_sample){.transmittance = 1.0f};
  const bool has_sun = !np_spectrum_is_zero(world->sun_irradiance);
  const np_tracer t = {
      world, lighting, settings, random, out, {world->to_sun, has_sun}, np_world_sun_solid_angle(world)};
  np_ground_hit ground;
  out->is_ground_behind = np_camera_ray_intersect_ground(world, ray, &ground);
  const double distance_end = out->is_ground_behind ? ground.distance_m : np_camera_ray_get_end(ray);
  if (world->emission) add_emission(&t, ray, distance_end);
  const cloud_hit cloud = sample_cloud(&t, ray, distance_end);
  if (!isinf(cloud.distance)) add_opaque_cloud(&t, ray, &cloud);
  if (out->is_ground_behind)
    np_surroundings_add_opaque_ground(world, lighting, settings, &ground, out->transmittance, np_path_shadow, random,
                                      out);
  if (!out->is_ground_behind) add_disks(&t, ray);
  (settings->is_air_traced ? look : add_tabulated_air)(&t, ray, &cloud, out->is_ground_behind ? &ground : NULL);
}
