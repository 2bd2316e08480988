/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/gather_ground.h"

/* Directions into which a ray's part of the hemisphere is split. */
enum { SPLIT_ROWS = 4, SPLIT_AZIMUTHS = 8 };

typedef struct ground_light {
  const np_sky_light *light;
  const np_water *water;
  const np_water_skylight *skylight;
  np_depth_row sunlight; /* depths of the sun's beam on the ground */
} ground_light;

static np_bands compute_beam(const ground_light *g, float sun_cosine) {
  return np_depth_row_sun(&g->sunlight, sun_cosine, g->light->disk);
}

static np_bands compute_skylight(const ground_light *g, float sun_cosine) {
  return g->light->moments ? np_moment_table_irradiance(g->light->moments, sun_cosine) : np_bands_grey(0.0f);
}

static void add_land(const ground_light *g, const np_fan *fan, const np_fan_point *point, np_bands transmittance,
                     np_scattered *sums) {
  const np_bands scale = (float)(1.0 / NP_PI) * g->light->medium->ground_albedo * transmittance;
  for (int i = 0; i < fan->count; i++) {
    const float c = point->sun_cosine[i];
    sums[i].smooth += scale * (np_maxf(c, 0.0f) * compute_beam(g, c) + compute_skylight(g, c));
  }
}

/* Radiance of the sun's glint and of light out of the water, towards a ray from radius `r` that goes down at a cosine.
 */
static np_bands compute_glint(const ground_light *g, double r, float cosine, float sun_cosine, float angle_cosine) {
  const double radius = g->light->medium->planet_radius_m, sine2 = 1.0 - (double)cosine * (double)cosine;
  const double to_viewer = sqrt(fmax(1.0 - sine2 * (r / radius) * (r / radius), 0.0));
  const double length = fmax(-r * (double)cosine - radius * to_viewer, 0.0);
  const float to_sun = (float)((r * (double)sun_cosine + length * (double)angle_cosine) / radius);
  if (!(to_sun > 0.0f)) return np_bands_grey(0.0f);
  const np_bands beam =
      compute_beam(g, to_sun) + compute_skylight(g, to_sun) * g->skylight->beam / np_maxf(to_sun, 0.01f);
  return beam * np_bands_from_spectrum(np_water_reflect_beam(g->water, (float)to_viewer, to_sun, -angle_cosine));
}

/* Part of the hemisphere that a row of the dome stands for: directions of cosine horizon − (1 + horizon)·u². */
typedef struct row_part {
  double r, horizon;   /* radius of the rays' origin, and the horizon's cosine there */
  double begin, width; /* range of u */
} row_part;

static row_part find_row_part(const np_gather_kernel *kernel, int altitude, int row) {
  const np_quadrature rule = np_quadrature_gauss(kernel->down);
  row_part out = {.r = kernel->ray[altitude][row].r,
                  .horizon = np_horizon_cosine(kernel->medium, kernel->altitude_m[altitude]),
                  .width = rule.weight[row - kernel->up]};
  for (int i = kernel->up; i < row; i++) out.begin += rule.weight[i - kernel->up];
  return out;
}

/* Mean of the glint over azimuths of a part, per solid angle: the `turn`-th of `turns` on the half circle. */
static np_bands average_glint(const ground_light *g, const row_part *part, int turn, int turns, float sun_cosine) {
  const np_vec3 sun = np_gather_direction(sun_cosine, 0.0);
  double weights = 0.0;
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < SPLIT_ROWS; i++) {
    const double u = part->begin + part->width * (i + 0.5) / SPLIT_ROWS;
    const float cosine = (float)(part->horizon - (1.0 + part->horizon) * u * u);
    for (int j = 0; j < SPLIT_AZIMUTHS; j++) {
      const double azimuth = NP_PI * (turn + (j + 0.5) / SPLIT_AZIMUTHS) / turns;
      const float angle_cosine = np_vec3_dot(np_gather_direction(cosine, azimuth), sun);
      sum += (float)u * compute_glint(g, part->r, cosine, sun_cosine, angle_cosine);
      weights += u;
    }
  }
  return sum / (float)weights;
}

static void add_water(const ground_light *g, const np_gather_kernel *kernel, int altitude, int row, const np_fan *fan,
                      const np_fan_point *point, np_bands transmittance, np_scattered *sums) {
  const np_ray *ray = &kernel->ray[altitude][row];
  const row_part part = find_row_part(kernel, altitude, row);
  const float to_viewer = (float)-np_ray_cosine(ray, ray->length_m);
  const np_bands even = (1.0f - g->skylight->beam) * g->skylight->gain * (float)(1.0 / NP_PI) *
                        np_bands_from_spectrum(np_water_reflect_even(g->water, to_viewer));
  for (int i = 0; i < fan->count; i++)
    sums[i].smooth += transmittance * (average_glint(g, &part, i, kernel->azimuth_count, fan->sun_cosine[i]) +
                                       even * compute_skylight(g, point->sun_cosine[i]));
}

np_water_skylight np_gather_ground_split(const np_gather_kernel *kernel, const np_water *water,
                                         const np_scattered *dome, const np_bands *phase) {
  const int turns = kernel->azimuth_count;
  const np_quadrature rule = np_quadrature_gauss(kernel->up);
  np_bands beam = np_bands_grey(0.0f), rest = beam, reflected = beam;
  for (int row = 0; row < kernel->up; row++) {
    const float cosine = np_maxf(kernel->input_cosine[0][row], 0.0f);
    const float weight = (float)(rule.x[row] * rule.weight[row]) * cosine;
    const float reflectance = np_water_reflectance(water, cosine) / (1.0f - water->mean_transmittance);
    for (int turn = 0; turn < turns; turn++) {
      const int at = row * turns + turn, other = row * turns + turns - 1 - turn;
      const np_bands here = dome[at].smooth + phase[at] * dome[at].peak;
      const np_bands excess =
          np_bands_max(here - dome[other].smooth - phase[other] * dome[other].peak, np_bands_grey(0.0f));
      beam += weight * excess;
      rest += weight * (here - excess);
      reflected += weight * reflectance * (here - excess);
    }
  }
  const np_bands least = np_bands_grey(1e-20f);
  return (np_water_skylight){beam / np_bands_max(beam + rest, least), reflected / np_bands_max(rest, least)};
}

void np_gather_ground_add(const np_gather_kernel *kernel, const np_sky_light *light, const np_water *water,
                          const np_water_skylight *skylight, int altitude, int row, const np_fan *fan,
                          np_scattered *sums) {
  const np_ray *ray = &kernel->ray[altitude][row];
  if (!ray->hits_ground) return;
  const ground_light g = {light, water, skylight, np_depth_table_row(light->depths, 0.0)};
  const np_bands transmittance = kernel->path[altitude][row].end_transmittance;
  np_fan_point point;
  light->kernels->compute_sun_cosines(fan, (float)ray->length_m, (float)light->medium->planet_radius_m, &point);
  if (water)
    add_water(&g, kernel, altitude, row, fan, &point, transmittance, sums);
  else
    add_land(&g, fan, &point, transmittance, sums);
}
