/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/terrain_surroundings.h"

#include "terrain/heightfield.h"

enum { SPOTS = 64, PLACES = 16 };

double np_terrain_measure_water(const neph_terrain *terrain, double level_m) {
  if (!np_terrain_get_field(terrain)->elevation_m) return 1.0;
  double low[2], high[2];
  np_terrain_get_core(terrain, low, high);
  unsigned covered = 0;
  for (unsigned i = 0; i < SPOTS; i++)
    for (unsigned j = 0; j < SPOTS; j++) {
      const np_terrain_spot spot = np_terrain_choose_spot(low, high, (i + 0.5) / SPOTS, (j + 0.5) / SPOTS);
      covered += !(neph_terrain_get_elevation_m(terrain, spot.x_m, spot.y_m) > level_m);
    }
  return (double)covered / (SPOTS * SPOTS);
}

/* Heights of air above the ground or the water. */
static const double heights_m[] = {100.0, 500.0, 2000.0};

/* Height above the water of rays to it, which ground just below it must not hide. */
static const double clearance_m = 1.0;

/* Sine of the sun's elevation below which its glint is looked for no farther away. */
static const float sine_least = 0.05f;

/* A place above the sphere. */
static np_dvec3 place_above(const neph_terrain *terrain, double x, double y, double elevation_m) {
  return np_dvec3_make(x, y, elevation_m - 0.5 * (x * x + y * y) / np_terrain_get_planet_radius_m(terrain));
}

/* Whether the air at an elevation sees the sun in flat water. */
static bool sees_glint(const neph_terrain *terrain, double x, double y, double elevation_m, double level_m,
                       np_vec3 to_sun) {
  const double distance_m = (elevation_m - level_m) / (double)to_sun.z;
  const np_dvec3 air = place_above(terrain, x, y, elevation_m);
  const np_dvec3 water =
      place_above(terrain, x + distance_m * (double)to_sun.x, y + distance_m * (double)to_sun.y, level_m + clearance_m);
  const np_dvec3 down = np_dvec3_subtract(water, air);
  return !np_terrain_is_occluded(terrain, air, np_dvec3_to_float(np_dvec3_normalize(down)), np_dvec3_length(down)) &&
         !np_terrain_is_occluded(terrain, water, to_sun, INFINITY);
}

double np_terrain_measure_glint(const neph_terrain *terrain, double level_m, np_vec3 to_sun) {
  enum { HEIGHTS = sizeof heights_m / sizeof *heights_m };
  double low[2], high[2];
  unsigned count = 0;
  np_terrain_get_core(terrain, low, high);
  to_sun.z = np_maxf(to_sun.z, sine_least);
  for (unsigned i = 0; i < PLACES; i++)
    for (unsigned j = 0; j < PLACES; j++) {
      const double x = low[0] + (high[0] - low[0]) * (i + 0.5) / PLACES,
                   y = low[1] + (high[1] - low[1]) * (j + 0.5) / PLACES;
      const double surface_m = fmax(neph_terrain_get_elevation_m(terrain, x, y), level_m);
      for (unsigned h = 0; h < HEIGHTS; h++)
        count += sees_glint(terrain, x, y, surface_m + heights_m[h], level_m, to_sun);
    }
  return (double)count / (PLACES * PLACES * HEIGHTS);
}
