/* SPDX-License-Identifier: Apache-2.0 */
/* A sky: one atmosphere, one light, one observer. */
#include "atmosphere/atmosphere_tables.h"

#include "core/alloc.h"
#include "core/given.h"
#include "core/parallel.h"
#include "core/stable.h"
#include "core/text.h"

static bool is_finite_vector(const double v[3]) { return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]); }

static neph_result check_desc(neph_context *context, const neph_sky_desc *d) {
  const double *s = d->sun_direction, *e = d->sun_irradiance_w_m2_nm;
  const double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
  /* Normalises the direction: one typed with three digits is off by 1e-3. */
  if (!is_finite_vector(s) || fabs(length - 1.0) > 1e-2)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "sky: sun_direction (%g, %g, %g) must be a unit vector", s[0],
                   s[1], s[2]);
  if (!is_finite_vector(e) || e[0] < 0.0 || e[1] < 0.0 || e[2] < 0.0)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "sky: sun_irradiance_w_m2_nm (%g, %g, %g) must be finite and at least 0", e[0], e[1], e[2]);
  if (!(d->sun_angular_radius_rad >= 0.0 && d->sun_angular_radius_rad <= 0.5))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "sky: sun_angular_radius_rad is %g, must be in [0, 0.5]",
                   d->sun_angular_radius_rad);
  if (!is_finite_vector(d->observer_m))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "sky: observer_m (%g, %g, %g) must be finite",
                   d->observer_m[0], d->observer_m[1], d->observer_m[2]);
  return NEPH_OK;
}

/* Fade-out of the sun's sky from 18° to 19° (on the Earth) below the true horizon. */
static float compute_twilight(const np_medium *medium, const np_sky_frame *frame) {
  const double degree = NP_DEGREE * np_twilight_scale(medium) / 0.1753;
  const double below = acos((double)frame->sun_cosine) - frame->horizon_angle;
  return np_smoothstepf((float)(19.0 - below / degree));
}

/* Frame whose azimuth 0 is the sun's; under a sun at the zenith, a fixed azimuth. */
static np_sky_frame make_frame(const np_medium *medium, np_dvec3 observer, np_dvec3 sun) {
  const double radius = medium->planet_radius_m, h = np_altitude(observer, radius);
  const np_dvec3 up = np_dvec3_zenith(observer, radius);
  const double cosine = np_clamp(np_dvec3_dot(up, sun), -1.0, 1.0);
  const np_dvec3 level = np_dvec3_subtract(sun, np_dvec3_scale(up, cosine));
  const double sine = np_dvec3_length(level);
  np_sky_frame frame = {
      .up = np_dvec3_to_float(up), .altitude_m = fmax(h, 0.0), .sun_cosine = (float)cosine, .sun_sine = (float)sine};
  if (sine > 1e-6) {
    frame.toward = np_dvec3_to_float(np_dvec3_scale(level, 1.0 / sine));
    frame.across = np_vec3_cross(frame.up, frame.toward);
  } else {
    np_frame_around(frame.up, &frame.toward, &frame.across);
  }
  frame.horizon_angle = np_horizon_angle(medium, frame.altitude_m, 0.0);
  frame.top_angle = frame.altitude_m > medium->top_m ? np_horizon_angle(medium, frame.altitude_m, medium->top_m) : 0.0;
  /* The band of air above the horizon gets thinner with altitude; from space the rows cover that band alone. */
  const float height = (float)(frame.altitude_m / medium->top_m);
  frame.aerial_power = height > 1.0f ? 2.0f : 3.0f + 2.0f * height;
  /* Between 50 and 100 km on the Earth the air near the observer becomes negligible. */
  frame.inward = (double)np_smoothstepf((height - 0.5f) / 0.5f);
  frame.twilight = compute_twilight(medium, &frame);
  /* 1/2 at 20 km on the Earth. */
  frame.downward = frame.altitude_m / (frame.altitude_m + 0.2 * medium->top_m);
  return frame;
}

static void set_light(neph_sky *sky, const neph_sky_desc *d) {
  const double *s = d->sun_direction, *e = d->sun_irradiance_w_m2_nm, *o = d->observer_m;
  const np_dvec3 sun = np_dvec3_normalize(np_dvec3_make(s[0], s[1], s[2]));
  sky->irradiance = np_spectrum_make((float)e[0], (float)e[1], (float)e[2]);
  sky->sun = np_dvec3_to_float(sun);
  sky->sun_angular_radius = (float)d->sun_angular_radius_rad;
  sky->observer = np_dvec3_make(o[0], o[1], o[2]);
  sky->frame = make_frame(&sky->atmosphere->medium, sky->observer, sun);
}

/* Points of the rules for parts of a ray (sky_along.c). */
static const int part_counts[NP_SKY_PART_RULES] = {4, 6, 8, 10, 12, 16};

neph_result neph_sky_create(neph_atmosphere *atmosphere, const neph_sky_desc *desc, neph_sky **out_sky) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(atmosphere), out_sky)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_sky_create_monitored(atmosphere, desc, NULL, out_sky);
}

neph_result np_sky_create_monitored(neph_atmosphere *atmosphere, const neph_sky_desc *desc, np_monitor *monitor,
                                    neph_sky **out_sky) {
  *out_sky = NULL;
  neph_context *context = atmosphere->context;
  const neph_sky_desc defaults = NEPH_SKY_DESC_DEFAULT;
  neph_sky_desc read;
  neph_result result = np_desc_read(context, "neph_sky_desc", &defaults, sizeof read, desc, &read);
  if (!result) result = check_desc(context, &read);
  if (result) return result;
  neph_sky *sky = np_alloc(context, 1, sizeof *sky);
  if (!sky) return NEPH_ERROR_OUT_OF_MEMORY;
  sky->atmosphere = neph_atmosphere_retain(atmosphere);
  sky->monitor = monitor;
  sky->ray_rule = np_path_rule_make(atmosphere->sizes.view.points);
  for (int i = 0; i < NP_SKY_PART_RULES; i++) sky->part_rules[i] = np_quadrature_gauss(part_counts[i]);
  set_light(sky, &read);
  sky->built = sky->frame;
  sky->built_angular_radius = sky->sun_angular_radius;
  const unsigned mode = np_float_mode_enter();
  result = np_sky_tables_build(sky);
  np_float_mode_leave(mode);
  sky->monitor = NULL;
  if (result) {
    neph_sky_destroy(sky);
    return result;
  }
  *out_sky = sky;
  return NEPH_OK;
}

/* Largest changes within the tolerance: twilight fades by a factor e per degree, of which half counts; haze thins by a
 * factor e in 1.2 km on the Earth, or in as much of the height above the atmosphere. */
static double get_turn_max(const neph_atmosphere *a) {
  return 0.5 * NP_DEGREE * a->desc.tolerance * np_twilight_scale(&a->medium) / 0.1753;
}

static double get_climb_max(const neph_atmosphere *a, double above_air_m) {
  return a->desc.tolerance * fmax(0.012 * a->medium.top_m, 0.1 * above_air_m);
}

/* Snaps sun and observer to a lattice with steps of half the tolerance. Both are rounded up, so that no light is lost
 * to the night. */
void np_sky_snap(const neph_atmosphere *a, const neph_sky_desc *desc, neph_sky_desc *out) {
  const double *s = desc->sun_direction, *o = desc->observer_m, radius = a->medium.planet_radius_m;
  const np_dvec3 observer = np_dvec3_make(o[0], o[1], o[2]), sun = np_dvec3_normalize(np_dvec3_make(s[0], s[1], s[2]));
  const double altitude = fmax(np_altitude(observer, radius), 0.0), above = altitude - a->medium.top_m;
  const double climb = 0.5 * get_climb_max(a, above > 1.0 ? exp2(floor(log2(above))) : 0.0),
               turn = 0.5 * get_turn_max(a);
  const double cosine = np_clamp(np_dvec3_dot(np_dvec3_zenith(observer, radius), sun), -1.0, 1.0);
  const double angle = turn * floor(acos(cosine) / turn);
  *out = *desc;
  out->sun_direction[0] = sin(angle), out->sun_direction[1] = 0.0, out->sun_direction[2] = cos(angle);
  out->observer_m[0] = out->observer_m[1] = 0.0, out->observer_m[2] = climb * ceil(altitude / climb);
}

bool np_sky_move(neph_sky *sky, const neph_sky_desc *desc, char *out_reason, size_t reason_size) {
  const neph_atmosphere *a = sky->atmosphere;
  const np_medium *medium = &a->medium;
  const np_dvec3 to_sun = np_dvec3_make(desc->sun_direction[0], desc->sun_direction[1], desc->sun_direction[2]);
  const np_dvec3 observer = np_dvec3_make(desc->observer_m[0], desc->observer_m[1], desc->observer_m[2]);
  if (check_desc(a->context, desc)) return false;
  const np_sky_frame frame = make_frame(medium, observer, np_dvec3_normalize(to_sun));
  const double turn = fabs(acos((double)frame.sun_cosine) - acos((double)sky->built.sun_cosine));
  const double above = fmax(sky->built.altitude_m - medium->top_m, 0.0);
  const double climb = fabs(frame.altitude_m - sky->built.altitude_m);
  const double radius = (double)sky->built_angular_radius;
  if (turn > get_turn_max(a))
    np_print(out_reason, reason_size, "the sun stands %.3g degrees higher or lower", turn / NP_DEGREE);
  else if (climb > get_climb_max(a, above))
    np_print(out_reason, reason_size, "the observer stands %.3g m higher or lower", climb);
  else if (fabs(desc->sun_angular_radius_rad - radius) > a->desc.tolerance * radius)
    np_print(out_reason, reason_size, "the sun's size changed");
  else if (!sky->view && frame.twilight > 0.0f)
    np_print(out_reason, reason_size, "night ends");
  else
    return set_light(sky, desc), true;
  return false;
}

void neph_sky_destroy(neph_sky *sky) {
  if (!sky) return;
  neph_atmosphere *atmosphere = sky->atmosphere;
  np_sky_tables_free(sky);
  np_alloc_free(atmosphere->context, sky);
  neph_atmosphere_release(atmosphere);
}

static np_bands compute_aerosol_phase(const neph_sky *sky, np_vec3 direction) {
  return np_aerosol_phase(&sky->atmosphere->medium, np_vec3_versine(direction, sky->sun));
}

/* Multiplies the peak by the aerosol's phase function, and both parts by the solar irradiance. */
static np_spectrum shade(const neph_sky *sky, np_bands phase, np_scattered s) {
  return np_spectrum_multiply(np_bands_to_spectrum(sky->frame.twilight * (s.smooth + phase * s.peak)), sky->irradiance);
}

/* Zenith cosine of a direction, exact even near the nadir, where a distant observer sees the whole planet. */
static double compute_cosine(const np_sky_frame *frame, np_vec3 direction) {
  const double x = (double)np_vec3_dot(direction, frame->toward), y = (double)np_vec3_dot(direction, frame->across);
  const double z = (double)np_vec3_dot(direction, frame->up);
  return fabs(z) > 0.7 ? copysign(sqrt(fmax(1.0 - x * x - y * y, 0.0)), z) : z;
}

np_spectrum np_sky_radiance(const neph_sky *sky, np_vec3 direction) {
  const np_sky_layout layout = np_sky_view_layout(sky);
  const np_sky_place place = np_sky_locate(&sky->frame, direction, &layout);
  if (!place.is_in_air || !sky->view) return np_spectrum_grey(0.0f);
  const double cosine = compute_cosine(&sky->frame, direction);
  return shade(sky, compute_aerosol_phase(sky, direction),
               np_sky_view_lookup(sky, &place, np_sky_view_length(sky, cosine, place.is_below)));
}

/* Air along a ray: its optical depth, its light and the first order of it, where that is wanted. */
typedef struct air_column {
  np_bands depth;
  np_scattered light, first;
} air_column;

np_sky_ray np_sky_ray_start(const neph_sky *sky, np_vec3 direction) {
  np_sky_ray r = {.sky = sky, .direction = direction};
  const np_sky_layout layout = np_sky_aerial_layout(sky);
  r.place = np_sky_locate(&sky->frame, direction, &layout);
  if (!r.place.is_in_air) return r;
  r.ray =
      np_aerial_ray(&sky->atmosphere->medium, &sky->frame, compute_cosine(&sky->frame, direction), r.place.is_below);
  r.has_air = r.ray.length_m > 0.0;
  return r;
}

/* False: there is no air up to that distance. */
static bool sample_aerial(const np_sky_ray *r, double distance_m, bool has_first, air_column *out) {
  *out = (air_column){0};
  if (!r->has_air || !(distance_m > 0.0)) return false;
  np_bands molecules = {0};
  const np_aerial_sample s =
      np_sky_aerial_lookup(r->sky, &r->place, &r->ray, distance_m, has_first ? &molecules : NULL);
  *out = (air_column){s.depth, s.inscatter, {molecules, s.inscatter.peak}};
  return true;
}

np_aerial_perspective np_sky_ray_get_air(const np_sky_ray *r, double distance_m, np_spectrum *out_first) {
  air_column air;
  if (out_first) *out_first = np_spectrum_grey(0.0f);
  if (!sample_aerial(r, distance_m, out_first != NULL, &air))
    return (np_aerial_perspective){np_spectrum_grey(1.0f), np_spectrum_grey(0.0f)};
  const np_bands phase = compute_aerosol_phase(r->sky, r->direction);
  if (out_first) *out_first = shade(r->sky, phase, air.first);
  return (np_aerial_perspective){np_bands_to_spectrum(np_bands_exp(-air.depth)), shade(r->sky, phase, air.light)};
}

np_aerial_perspective np_sky_aerial_perspective(const neph_sky *sky, np_vec3 direction, double distance_m) {
  const np_sky_ray ray = np_sky_ray_start(sky, direction);
  return np_sky_ray_get_air(&ray, distance_m, NULL);
}

/* Angles of the hemisphere integral, denser towards the forward peak. */
enum { SHARE_ANGLES = 96 };

/* Directions at one angle to a ray form a cone, of which an arc lies in the upper hemisphere. */
np_hemisphere_shares np_sky_compute_hemisphere_shares(const neph_sky *sky, np_vec3 direction) {
  const double cosine = compute_cosine(&sky->frame, direction), sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
  np_bands upper = np_bands_grey(0.0f), all = upper;
  for (int i = 0; i < SHARE_ANGLES; i++) {
    const double u = (i + 0.5) / SHARE_ANGLES, angle = NP_PI * u * u, width = 2.0 * NP_PI * u / SHARE_ANGLES;
    const double rise = cosine * cos(angle), swing = sine * sin(angle);
    const double arc = acos(np_clamp(swing > 1e-9 ? -rise / swing : (rise > 0.0 ? -1.0 : 1.0), -1.0, 1.0)) / NP_PI;
    const float versine = (float)(2.0 * sin(0.5 * angle) * sin(0.5 * angle));
    const np_bands ring = (float)(sin(angle) * width) * np_aerosol_phase(&sky->atmosphere->medium, versine);
    all += ring;
    upper += (float)arc * ring;
  }
  /* Without aerosols there is no light to share. */
  const np_spectrum share = np_bands_to_spectrum(np_bands_select(all > 0.0f, upper / all, np_bands_grey(0.5f)));
  return (np_hemisphere_shares){share, np_spectrum_subtract(np_spectrum_grey(1.0f), share)};
}

np_even_inscatter np_sky_compute_even_inscatter(const np_sky_ray *ray, double distance_m,
                                                const np_hemisphere_shares *shares) {
  const neph_sky *sky = ray->sky;
  air_column air;
  (void)sample_aerial(ray, distance_m, true, &air);
  const float rayleigh = np_phase_rayleigh_eval(np_vec3_dot(ray->direction, sky->sun));
  const float scale = sky->frame.twilight / (2.0f * NP_PI_F);
  const np_spectrum light = np_spectrum_scale(sky->irradiance, scale);
  const np_spectrum molecules = np_spectrum_multiply(np_bands_to_spectrum(air.first.smooth * (0.5f / rayleigh)), light);
  const np_spectrum aerosols = np_spectrum_multiply(np_bands_to_spectrum(air.first.peak), light);
  return (np_even_inscatter){.upper = np_spectrum_add(molecules, np_spectrum_multiply(shares->upper, aerosols)),
                             .lower = np_spectrum_add(molecules, np_spectrum_multiply(shares->lower, aerosols)),
                             .first = shade(sky, compute_aerosol_phase(sky, ray->direction), air.first)};
}

static np_vec3 read_direction(const double direction[3]) {
  return np_dvec3_to_float(np_dvec3_normalize(np_dvec3_make(direction[0], direction[1], direction[2])));
}

/* `out` may be NULL. */
static void write_spectrum(np_spectrum s, double out[3]) {
  for (int i = 0; out && i < 3; i++) out[i] = (double)s.band[i];
}

void neph_sky_get_radiance(const neph_sky *sky, const double direction[3], double out_radiance_w_m2_sr_nm[3]) {
  const bool is_given = sky && direction;
  write_spectrum(is_given ? np_sky_radiance(sky, read_direction(direction)) : np_spectrum_grey(0.0f),
                 out_radiance_w_m2_sr_nm);
}

void neph_sky_get_aerial_perspective(const neph_sky *sky, const double direction[3], double distance_m,
                                     double out_transmittance[3], double out_inscatter_w_m2_sr_nm[3]) {
  np_aerial_perspective ap = {.transmittance = np_spectrum_grey(0.0f), .inscatter = np_spectrum_grey(0.0f)};
  if (sky && direction) ap = np_sky_aerial_perspective(sky, read_direction(direction), distance_m);
  write_spectrum(ap.transmittance, out_transmittance);
  write_spectrum(ap.inscatter, out_inscatter_w_m2_sr_nm);
}

enum { ANGLES = 48, AZIMUTHS = 48 };

/* Sky irradiance on a level surface, by a rule around the sun, Θ = π·u², which resolves the aureole. */
static np_spectrum integrate_sky(const neph_sky *sky) {
  const np_quadrature rule = np_quadrature_gauss(ANGLES);
  const np_sky_frame *frame = &sky->frame;
  np_vec3 a, b;
  np_frame_around(sky->sun, &a, &b);
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < ANGLES; i++) {
    const double angle = NP_PI * rule.x[i] * rule.x[i];
    const double weight = 2.0 * NP_PI * rule.x[i] * rule.weight[i] * sin(angle) * 2.0 * NP_PI / AZIMUTHS;
    for (int k = 0; k < AZIMUTHS; k++) {
      const double turn = 2.0 * NP_PI * (k + 0.5) / AZIMUTHS, s = sin(angle);
      const np_vec3 d =
          np_vec3_add(np_vec3_scale(sky->sun, (float)cos(angle)),
                      np_vec3_add(np_vec3_scale(a, (float)(s * cos(turn))), np_vec3_scale(b, (float)(s * sin(turn)))));
      const float cosine = np_vec3_dot(d, frame->up);
      if (cosine > 0.0f) sum = np_spectrum_add_scaled(sum, (float)weight * cosine, np_sky_radiance(sky, d));
    }
  }
  return sum;
}

void neph_sky_get_irradiance(const neph_sky *sky, double out_sun_w_m2_nm[3], double out_sky_w_m2_nm[3]) {
  if (!sky) {
    write_spectrum(np_spectrum_grey(0.0f), out_sun_w_m2_nm);
    write_spectrum(np_spectrum_grey(0.0f), out_sky_w_m2_nm);
    return;
  }
  const np_spectrum transmittance =
      np_atmosphere_transmittance_to_sun(sky->atmosphere, sky->observer, sky->sun, sky->sun_angular_radius);
  const float cosine = np_maxf(sky->frame.sun_cosine, 0.0f);
  write_spectrum(np_spectrum_scale(np_spectrum_multiply(transmittance, sky->irradiance), cosine), out_sun_w_m2_nm);
  write_spectrum(integrate_sky(sky), out_sky_w_m2_nm);
}
