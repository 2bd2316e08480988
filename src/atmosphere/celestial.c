/* SPDX-License-Identifier: Apache-2.0 */
/* Positions of sun and moon, and rotation of the celestial sphere (Meeus 1998, "Astronomical Algorithms", chapters 11,
 * 21 to 25, 47 and 53): libnova's VSOP87 and ELP 2000-82B positions, aberration, precession, nutation, apparent
 * sidereal time, and parallax, at most 8.8″ for the sun and a degree for the moon.
 *
 * libnova 0.16 refers both positions to the equinox of J2000, even in its functions for apparent positions, which
 * ignores the precession since: a third of a degree by 2024. So nephos takes only ecliptic positions from it, and
 * computes the rest here. */
#include "atmosphere/celestial.h"

#include <math.h>
#include <pthread.h>

#include <libnova/dynamical_time.h>
#include <libnova/lunar.h>
#include <libnova/nutation.h>
#include <libnova/precession.h>
#include <libnova/sidereal_time.h>
#include <libnova/solar.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/time_text.h"
#include "core/units.h"

/* ---- Time ---- */

neph_result np_celestial_parse_time(neph_context *context, const char *text, double *out_unix_s) {
  np_time time;
  char *problem;
  const neph_result result = np_time_parse(context, text, &time, &problem);
  if (problem) np_fail(context, result, "time \"%s\": %s", text, problem);
  np_alloc_free(context, problem);
  if (!result) *out_unix_s = time.unix_s;
  return result;
}

/* ---- The sphere ---- */

static const double julian_day_of_1970 = 2440587.5, julian_day_of_2000 = 2451545.0, days_per_century = 36525.0;
static const double obliquity_of_2000 = 23.4392911 * NP_DEGREE;
static const double arc_second = NP_DEGREE / 3600.0;
static const double astronomical_unit_m = 149597870700.0, moon_radius_m = 1737400.0;

/* libnova caches its last position in static variables. */
static pthread_mutex_t nova_lock = PTHREAD_MUTEX_INITIALIZER;

/* Precession angles from J2000 to a date, and nutation; radians. */
typedef struct sphere_state {
  double along, across; /* nutation in longitude and in obliquity */
  double obliquity;     /* mean obliquity of date */
  double sidereal;      /* apparent, at Greenwich */
} sphere_state;

static np_dvec3 make_direction(double longitude, double latitude) {
  return np_dvec3_make(cos(latitude) * cos(longitude), cos(latitude) * sin(longitude), sin(latitude));
}

/* Dynamical time minus universal time, seconds, every five years from 1970 to 2025 (IERS). libnova's estimate diverges
 * after 2010: to 128 s in 2020, in which the moon moves by half a minute of arc. The Earth's rotation after 2025 is not
 * known; by 2050 the error may be a few seconds. */
static double compute_ephemeris_day(double julian_day) {
  static const double seconds[] = {40.18, 45.48, 50.54, 54.34, 56.86, 60.79, 63.83, 64.69, 66.07, 67.64, 69.36, 69.14};
  enum { LAST = sizeof seconds / sizeof *seconds - 1 };
  const double x = (julian_day - julian_day_of_1970) / (5.0 * 365.25);
  if (x < 0.0) return ln_get_jde(julian_day);
  const int i = (int)fmin(x, LAST - 1);
  const double later = fmin(x - i, 1.0);
  return julian_day + (seconds[i] + later * (seconds[i + 1] - seconds[i])) / 86400.0;
}

/* Rotates from the ecliptic to the equator, about x, the direction of the equinox. */
static np_dvec3 tilt(np_dvec3 v, double obliquity) {
  const double c = cos(obliquity), s = sin(obliquity);
  return np_dvec3_make(v.x, c * v.y - s * v.z, s * v.y + c * v.z);
}

/* Rotates from the mean equator of J2000 to the mean equator of date; `v` of any length. */
static np_dvec3 precess(np_dvec3 v, double ephemeris_day) {
  struct ln_equ_posn of_2000 = {atan2(v.y, v.x) / NP_DEGREE, atan2(v.z, hypot(v.x, v.y)) / NP_DEGREE}, of_date;
  ln_get_equ_prec(&of_2000, ephemeris_day, &of_date);
  return np_dvec3_scale(make_direction(of_date.ra * NP_DEGREE, of_date.dec * NP_DEGREE), np_dvec3_length(v));
}

/* Applies the nutation, as rotations about the ecliptic's pole and the equinox (Meeus 23.1, without its series). */
static np_dvec3 nutate(np_dvec3 v, const sphere_state *s) {
  const np_dvec3 e = tilt(v, -s->obliquity);
  const double c = cos(s->along), d = sin(s->along);
  return tilt(np_dvec3_make(c * e.x - d * e.y, d * e.x + c * e.y, e.z), s->obliquity + s->across);
}

/* Requires nova_lock. */
static sphere_state compute_state(double julian_day) {
  struct ln_nutation nutation;
  ln_get_nutation(julian_day, &nutation);
  return (sphere_state){.along = nutation.longitude * NP_DEGREE,
                        .across = nutation.obliquity * NP_DEGREE,
                        .obliquity = nutation.ecliptic * NP_DEGREE,
                        .sidereal = ln_get_apparent_sidereal_time(julian_day) * 15.0 * NP_DEGREE};
}

/* Rotates from the equator of date to east, north and up. */
static np_dvec3 to_world(np_dvec3 v, double local_sidereal, double latitude_rad) {
  const double c = cos(local_sidereal), s = sin(local_sidereal);
  const double out = c * v.x + s * v.y, east = c * v.y - s * v.x; /* towards the meridian, and towards the east */
  return np_dvec3_make(east, cos(latitude_rad) * v.z - sin(latitude_rad) * out,
                       sin(latitude_rad) * v.z + cos(latitude_rad) * out);
}

double np_celestial_sidereal(double unix_s) {
  pthread_mutex_lock(&nova_lock);
  const double hours = ln_get_apparent_sidereal_time(julian_day_of_1970 + unix_s / 86400.0);
  pthread_mutex_unlock(&nova_lock);
  return hours * 15.0 * NP_DEGREE;
}

static void set_columns(np_celestial_turn *turn, const np_dvec3 column[3]) {
  for (int i = 0; i < 3; i++) {
    turn->row[0][i] = column[i].x;
    turn->row[1][i] = column[i].y;
    turn->row[2][i] = column[i].z;
  }
}

np_celestial_turn np_celestial_turn_by_time(double unix_s, double latitude_rad, double longitude_rad) {
  const double julian_day = julian_day_of_1970 + unix_s / 86400.0;
  const np_dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  np_dvec3 column[3];
  pthread_mutex_lock(&nova_lock);
  const sphere_state state = compute_state(julian_day);
  const double day = compute_ephemeris_day(julian_day), local = state.sidereal + longitude_rad;
  for (int i = 0; i < 3; i++) column[i] = to_world(nutate(precess(axes[i], day), &state), local, latitude_rad);
  pthread_mutex_unlock(&nova_lock);
  np_celestial_turn turn;
  set_columns(&turn, column);
  return turn;
}

np_celestial_turn np_celestial_turn_by_angle(double local_sidereal_rad, double latitude_rad) {
  const np_dvec3 column[3] = {to_world(np_dvec3_make(1, 0, 0), local_sidereal_rad, latitude_rad),
                              to_world(np_dvec3_make(0, 1, 0), local_sidereal_rad, latitude_rad),
                              to_world(np_dvec3_make(0, 0, 1), local_sidereal_rad, latitude_rad)};
  np_celestial_turn turn;
  set_columns(&turn, column);
  return turn;
}

np_dvec3 np_celestial_apply(const np_celestial_turn *turn, np_dvec3 v) {
  double out[3];
  for (int i = 0; i < 3; i++) out[i] = turn->row[i][0] * v.x + turn->row[i][1] * v.y + turn->row[i][2] * v.z;
  return np_dvec3_make(out[0], out[1], out[2]);
}

/* ---- Sun ---- */

/* Vector to the sun in metres, for the true equator of date, with aberration (Meeus 25.10). Requires nova_lock. */
static np_dvec3 compute_sun(double ephemeris_day, const sphere_state *state) {
  struct ln_helio_posn sun;
  ln_get_solar_geom_coords(ephemeris_day, &sun);
  const double longitude = sun.L * NP_DEGREE - 20.4898 * arc_second / sun.R;
  const np_dvec3 of_2000 = tilt(make_direction(longitude, sun.B * NP_DEGREE), obliquity_of_2000);
  return np_dvec3_scale(nutate(precess(of_2000, ephemeris_day), state), sun.R * astronomical_unit_m);
}

np_sun_angles np_celestial_sun(double unix_s, double latitude_rad, double longitude_rad) {
  const double julian_day = julian_day_of_1970 + unix_s / 86400.0;
  pthread_mutex_lock(&nova_lock);
  const sphere_state state = compute_state(julian_day);
  const np_dvec3 sun = compute_sun(compute_ephemeris_day(julian_day), &state);
  pthread_mutex_unlock(&nova_lock);
  const np_dvec3 d = to_world(np_dvec3_normalize(sun), state.sidereal + longitude_rad, latitude_rad);
  const double geocentric = atan2(d.z, hypot(d.x, d.y)), azimuth = atan2(d.x, d.y);
  return (np_sun_angles){.elevation_rad = geocentric - 8.794 * arc_second * cos(geocentric),
                         .azimuth_rad = azimuth < 0.0 ? azimuth + 2.0 * NP_PI : azimuth};
}

/* ---- Moon ---- */

/* Vector to the moon in metres, for the true equator of date, from libnova's ELP 2000-82B for the ecliptic and equinox
 * of J2000. Requires nova_lock. */
static np_dvec3 compute_moon(double ephemeris_day, const sphere_state *state) {
  struct ln_rect_posn moon;
  ln_get_lunar_geo_posn(ephemeris_day, &moon, 0.0);
  const np_dvec3 of_2000 = tilt(np_dvec3_make(moon.X, moon.Y, moon.Z), obliquity_of_2000);
  return np_dvec3_scale(nutate(precess(of_2000, ephemeris_day), state), 1000.0);
}

/* Axes of the moon, for the true equator of date, by Cassini's laws (Meeus, chapter 53): its equator is inclined by I
 * to the ecliptic, with its descending node at the ascending node of the orbit; the prime meridian follows the mean
 * longitude. Physical libration, at most 0.04°, is left out. */
static void compute_axes(double julian_day, const sphere_state *state, np_dvec3 out_axes[3]) {
  static const double inclination = 1.54242 * NP_DEGREE;
  const double t = (julian_day - julian_day_of_2000) / days_per_century;
  const double node = fmod(125.0445479 - 1934.1362891 * t + 0.0020754 * t * t, 360.0) * NP_DEGREE;
  const double latitude_argument = fmod(93.2720950 + 483202.0175233 * t - 0.0036539 * t * t, 360.0) * NP_DEGREE;
  const np_dvec3 ascending = make_direction(node + NP_PI, 0.0);
  const np_dvec3 pole = np_dvec3_make(-sin(inclination) * sin(node), sin(inclination) * cos(node), cos(inclination));
  const np_dvec3 across = np_dvec3_cross(pole, ascending);
  const double c = cos(latitude_argument), s = sin(latitude_argument);
  const np_dvec3 meridian = np_dvec3_add(np_dvec3_scale(ascending, c), np_dvec3_scale(across, s));
  const np_dvec3 axes[3] = {meridian, np_dvec3_cross(pole, meridian), pole};
  for (int i = 0; i < 3; i++) out_axes[i] = nutate(tilt(axes[i], state->obliquity), state);
}

/* Position at sea level on the ellipsoid of 1976 (Meeus, chapter 11), from the centre of the Earth, in metres. */
static np_dvec3 compute_observer(double local_sidereal, double latitude_rad) {
  static const double equator_m = 6378140.0, pole_over_equator = 0.99664719;
  const double u = atan2(pole_over_equator * sin(latitude_rad), cos(latitude_rad));
  return np_dvec3_scale(
      np_dvec3_make(cos(u) * cos(local_sidereal), cos(u) * sin(local_sidereal), pole_over_equator * sin(u)), equator_m);
}

np_moon_place np_celestial_moon(double unix_s, double latitude_rad, double longitude_rad, bool is_geocentric) {
  const double julian_day = julian_day_of_1970 + unix_s / 86400.0;
  np_dvec3 axes[3];
  pthread_mutex_lock(&nova_lock);
  const double ephemeris_day = compute_ephemeris_day(julian_day);
  const sphere_state state = compute_state(julian_day);
  np_dvec3 moon = compute_moon(ephemeris_day, &state);
  const np_dvec3 moon_to_sun = np_dvec3_subtract(compute_sun(ephemeris_day, &state), moon);
  pthread_mutex_unlock(&nova_lock);
  compute_axes(julian_day, &state, axes);
  const double local = state.sidereal + longitude_rad;
  if (!is_geocentric) moon = np_dvec3_subtract(moon, compute_observer(local, latitude_rad));
  const double distance = np_dvec3_length(moon);
  np_moon_place place = {.direction = to_world(np_dvec3_scale(moon, 1.0 / distance), local, latitude_rad),
                         .to_sun = to_world(np_dvec3_normalize(moon_to_sun), local, latitude_rad),
                         .distance_m = distance,
                         .angular_radius_rad = asin(moon_radius_m / distance)};
  for (int i = 0; i < 3; i++) place.axes[i] = to_world(axes[i], local, latitude_rad);
  return place;
}

double np_celestial_phase_angle(const np_moon_place *moon) {
  const np_dvec3 to_observer = np_dvec3_scale(moon->direction, -1.0);
  return atan2(np_dvec3_length(np_dvec3_cross(to_observer, moon->to_sun)), np_dvec3_dot(to_observer, moon->to_sun));
}
