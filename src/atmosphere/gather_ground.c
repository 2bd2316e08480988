/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/gather_ground.h"

#include "core/alloc.h"

/* Directions into which a ray's part of the hemisphere is split. */
enum { SPLIT_ROWS = 4, SPLIT_AZIMUTHS = 8 };

typedef struct ground_light {
  const np_sky_light *light;
  const np_water *water; /* NULL: none */
  float water_share, glint_share;
  np_bands land_albedo;
  const np_water_skylight *skylight;
  np_depth_row sunlight; /* depths of the sun's beam on the ground */
} ground_light;

static np_bands compute_beam(const ground_light *g, float sun_cosine) {
  return np_depth_row_sun(&g->sunlight, sun_cosine, g->light->disk);
}

static np_bands compute_skylight(const ground_light *g, float sun_cosine) {
  return g->light->moments ? np_moment_table_irradiance(g->light->moments, 0.0, sun_cosine) : np_bands_grey(0.0f);
}

static void add_land(const ground_light *g, const np_fan *fan, const np_fan_point *point, np_bands transmittance,
                     np_scattered *sums) {
  const np_bands scale = (float)(1.0 / NP_PI) * (1.0f - g->water_share) * g->land_albedo * transmittance;
  for (int i = 0; i < fan->count; i++) {
    const float c = point->sun_cosine[i];
    sums[i].smooth += scale * (np_maxf(c, 0.0f) * compute_beam(g, c) + compute_skylight(g, c));
  }
}

/* Radiance of the sun's glint and of its light out of the water, towards a ray from radius `r` that goes down at a
 * cosine.
 */
static np_bands compute_glint(const ground_light *g, double r, float cosine, float sun_cosine, float angle_cosine) {
  const double radius = g->light->medium->planet_radius_m, sine2 = 1.0 - (double)cosine * (double)cosine;
  const double to_viewer = sqrt(fmax(1.0 - sine2 * (r / radius) * (r / radius), 0.0));
  const double length = fmax(-r * (double)cosine - radius * to_viewer, 0.0);
  const float to_sun = (float)((r * (double)sun_cosine + length * (double)angle_cosine) / radius);
  if (!(to_sun > 0.0f)) return np_bands_grey(0.0f);
  return compute_beam(g, to_sun) *
         np_bands_from_spectrum(np_water_reflect_beam(g->water, (float)to_viewer, to_sun, -angle_cosine));
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

/* ---- Skylight on water ---- */

/* Fractional index of a view by its cosine. */
static float compute_view(float cosine) { return sqrtf(np_clampf(cosine, 0.0f, 1.0f)) * (NP_GATHER_VIEWS - 1); }

static float get_view_cosine(int view) {
  const float root = np_maxf((float)view, 0.25f) / (NP_GATHER_VIEWS - 1); /* none is level */
  return root * root;
}

static float *get_weights(const np_water_mirror *mirror, const np_gather_kernel *kernel, int view, int turn) {
  const size_t inputs = (size_t)(kernel->up * kernel->azimuth_count);
  return mirror->weight + ((size_t)view * (size_t)kernel->azimuth_count + (size_t)turn) * inputs;
}

/* Fills the weights of one view, at the `turn`-th azimuth. */
static void fill_weights(const np_gather_kernel *kernel, const np_water *water, int view, int turn, float *weights) {
  const np_quadrature rule = np_quadrature_gauss(kernel->up);
  const np_vec3 zenith = np_vec3_make(0.0f, 0.0f, 1.0f);
  const float cosine = get_view_cosine(view);
  const np_vec3 to_viewer = np_gather_direction(cosine, NP_PI * (turn + 0.5) / kernel->azimuth_count + NP_PI);
  float sum = 0.0f;
  for (int row = 0; row < kernel->up; row++)
    for (int k = 0; k < kernel->azimuth_count; k++) {
      const np_vec3 from = np_gather_kernel_get_input(kernel, 0, row, k), twin = np_vec3_make(from.x, -from.y, from.z);
      float *weight = &weights[row * kernel->azimuth_count + k];
      *weight = (float)(rule.x[row] * rule.weight[row]) * (np_water_eval(water, zenith, to_viewer, from).reflected +
                                                           np_water_eval(water, zenith, to_viewer, twin).reflected);
      sum += *weight;
    }
  const float scale = np_water_reflectance(water, cosine) / np_maxf(sum, 1e-20f);
  for (int i = 0; i < kernel->up * kernel->azimuth_count; i++) weights[i] *= scale;
}

neph_result np_water_mirror_init(neph_context *context, const np_gather_kernel *kernel, const np_water *water,
                                 np_water_mirror *out) {
  const int turns = kernel->azimuth_count;
  *out = (np_water_mirror){.context = context};
  out->weight = np_alloc(context, (size_t)(NP_GATHER_VIEWS * turns * kernel->up * turns), sizeof *out->weight);
  if (!out->weight) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int view = 0; view < NP_GATHER_VIEWS; view++)
    for (int turn = 0; turn < turns; turn++)
      fill_weights(kernel, water, view, turn, get_weights(out, kernel, view, turn));
  return NEPH_OK;
}

void np_water_mirror_clear(np_water_mirror *mirror) {
  if (mirror->weight) np_alloc_free(mirror->context, mirror->weight);
  *mirror = (np_water_mirror){0};
}

void np_water_mirror_reflect(const np_water_mirror *mirror, const np_gather_kernel *kernel, const np_scattered *dome,
                             const np_bands *phase, np_water_skylight *out) {
  const np_quadrature rule = np_quadrature_gauss(kernel->up);
  const int turns = kernel->azimuth_count, inputs = kernel->up * turns;
  const double range = 1.0 - np_horizon_cosine(kernel->medium, kernel->altitude_m[0]);
  np_bands light[NP_GATHER_INPUTS_MAX], irradiance = np_bands_grey(1e-20f);
  for (int in = 0; in < inputs; in++) {
    const int row = in / turns;
    light[in] = dome[in].smooth + phase[in] * dome[in].peak;
    const float cosine = np_maxf(kernel->input_cosine[0][row], 0.0f);
    const float solid_angle = (float)(2.0 * range * rule.x[row] * rule.weight[row] * 2.0 * NP_PI / turns);
    irradiance += cosine * solid_angle * light[in];
  }
  for (int view = 0; view < NP_GATHER_VIEWS; view++)
    for (int turn = 0; turn < turns; turn++) {
      const float *weight = get_weights(mirror, kernel, view, turn);
      np_bands sum = np_bands_grey(0.0f);
      for (int in = 0; in < inputs; in++) sum += weight[in] * light[in];
      out->reflected[view][turn] = sum / irradiance;
    }
}

static void add_water(const ground_light *g, const np_gather_kernel *kernel, int altitude, int row, const np_fan *fan,
                      const np_fan_point *point, np_bands transmittance, np_scattered *sums) {
  const np_ray *ray = &kernel->ray[altitude][row];
  const row_part part = find_row_part(kernel, altitude, row);
  const float to_viewer = (float)-np_ray_cosine(ray, ray->length_m), view = compute_view(to_viewer);
  const int low = view < NP_GATHER_VIEWS - 2 ? (int)view : NP_GATHER_VIEWS - 2;
  const np_bands diffuse = (float)(1.0 / NP_PI) * (1.0f - np_water_reflectance(g->water, to_viewer)) *
                           np_bands_from_spectrum(g->water->albedo);
  for (int i = 0; i < fan->count; i++) {
    const np_bands reflected =
        np_bands_mix(g->skylight->reflected[low][i], g->skylight->reflected[low + 1][i], view - (float)low);
    sums[i].smooth += g->water_share * transmittance *
                      (g->glint_share * average_glint(g, &part, i, kernel->azimuth_count, fan->sun_cosine[i]) +
                       (reflected + diffuse) * compute_skylight(g, point->sun_cosine[i]));
  }
}

/* ---- All ground ---- */

void np_gather_ground_add(const np_gather_kernel *kernel, const np_sky_light *light, const np_sea *sea,
                          const np_water_skylight *skylight, int altitude, int row, const np_fan *fan,
                          np_scattered *sums) {
  const np_ray *ray = &kernel->ray[altitude][row];
  if (!ray->hits_ground) return;
  const ground_light g = {.light = light,
                          .water = sea ? &sea->water : NULL,
                          .water_share = sea ? sea->share : 0.0f,
                          .glint_share = sea ? sea->glint / sea->share : 0.0f,
                          .land_albedo = sea ? sea->land_albedo : light->medium->ground_albedo,
                          .skylight = skylight,
                          .sunlight = np_depth_table_row(light->depths, 0.0)};
  const np_bands transmittance = kernel->path[altitude][row].end_transmittance;
  np_fan_point point;
  light->kernels->compute_sun_cosines(fan, (float)ray->length_m, (float)light->medium->planet_radius_m, &point);
  if (sea) add_water(&g, kernel, altitude, row, fan, &point, transmittance, sums);
  if (g.water_share < 1.0f) add_land(&g, fan, &point, transmittance, sums);
}
