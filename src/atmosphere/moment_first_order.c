/* SPDX-License-Identifier: Apache-2.0 */
/* Order 1: sunlight scattered once, or reflected by the ground, gathered at the nodes.
 *
 * The aerosol's phase function is cut after degree 2: the table holds moments up to 2 only, and the rule then need not
 * resolve the forward peak. */
#include "atmosphere/moment_builder.h"
#include "core/parallel.h"

/* Sums along the rays of a fan, without phase functions. */
typedef struct first_order {
  np_bands rayleigh[NP_FAN_MAX], aerosol[NP_AEROSOLS_MAX][NP_FAN_MAX];
} first_order;

static void clear_sums(const np_medium *medium, int count, first_order *sum) {
  memset(sum->rayleigh, 0, (size_t)count * sizeof *sum->rayleigh);
  for (int i = 0; i < medium->aerosol_count; i++) memset(sum->aerosol[i], 0, (size_t)count * sizeof *sum->rayleigh);
}

static void add_scaled(np_bands *sum, np_bands scale, const np_bands *light, int count) {
  for (int i = 0; i < count; i++) sum[i] += scale * light[i];
}

static void sum_first_order(const np_moment_builder *b, const np_path *path, const np_fan *fan, first_order *sum) {
  clear_sums(b->medium, fan->count, sum);
  for (int i = 0; i < path->count; i++) {
    const np_path_node *node = &path->node[i];
    const np_depth_row row = np_depth_table_row(b->depths, (double)node->altitude_m);
    np_fan_point point;
    np_bands sunlight[NP_FAN_MAX];
    b->kernels->compute_sun_cosines(fan, (float)node->t, node->r, &point);
    b->kernels->compute_sunlight(&row, b->disk, &point, sunlight);
    const np_bands weight = node->weight_m * node->transmittance;
    add_scaled(sum->rayleigh, weight * node->air.rayleigh, sunlight, fan->count);
    for (int k = 0; k < b->medium->aerosol_count; k++)
      add_scaled(sum->aerosol[k], weight * node->air.aerosol[k], sunlight, fan->count);
  }
}

/* Sunlight reflected along a direction by the ground at its end. */
static void compute_ground_light(const np_moment_builder *b, const np_moment_direction *d, const np_fan *fan,
                                 np_bands *out) {
  const np_depth_row row = np_depth_table_row(b->depths, 0.0);
  np_fan_point point;
  b->kernels->compute_sun_cosines(fan, (float)d->ray.length_m, (float)b->medium->planet_radius_m, &point);
  b->kernels->compute_sunlight(&row, b->disk, &point, out);
  const np_bands scale = (float)(1.0 / NP_PI) * d->path.end_transmittance * b->medium->ground_albedo;
  for (int i = 0; i < fan->count; i++) out[i] *= np_maxf(point.sun_cosine[i], 0.0f) * scale;
}

/* Aerosol in-scatter into one ray, by phase functions cut after degree 2. */
static np_bands cut_aerosol_light(const np_medium *medium, const first_order *first, int ray, float c) {
  np_scattering light;
  for (int i = 0; i < medium->aerosol_count; i++) light.aerosol[i] = first->aerosol[i][ray];
  return (float)(0.25 / NP_PI) * (np_aerosol_sum(medium, &light, 0) + 3.0f * c * np_aerosol_sum(medium, &light, 1) +
                                  2.5f * (3.0f * c * c - 1.0f) * np_aerosol_sum(medium, &light, 2));
}

/* Adds one direction's light to the nodes of a row. */
static void reduce_first_order(np_moment_builder *b, size_t row, int k, const np_fan *fan, const first_order *first) {
  const np_medium *medium = b->medium;
  const np_moment_direction *d = np_moment_direction_at(b, row, k);
  const float sine = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f));
  np_bands ground[NP_FAN_MAX];
  if (d->ray.hits_ground) compute_ground_light(b, d, fan, ground);
  for (int ray = 0; ray < fan->count; ray++) {
    const int column = ray / NP_MOMENT_AZIMUTHS;
    const size_t node = np_moment_node_at(b, row, column);
    const float c = fan->angle_cosine[ray], wx = sine * b->cos_azimuth[ray % NP_MOMENT_AZIMUTHS];
    np_bands light = first->rayleigh[ray] * np_phase_rayleigh_eval(c);
    if (d->ray.hits_ground) light += ground[ray];
    const np_bands cut = light + cut_aerosol_light(medium, first, ray, c);
    np_moment_add(b->gathered + node * NP_MOMENT_COUNT, d->weight * cut, wx, d->wz);
    b->irradiance[node] += np_maxf(d->wz, 0.0f) * d->weight * cut;
  }
}

static neph_result gather_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  np_moment_builder *b = user;
  for (size_t row = begin; row < end; row++)
    for (int k = 0; k < np_moment_count_directions(b); k++) {
      const np_moment_direction *d = np_moment_direction_at(b, row, k);
      np_fan fan;
      first_order first;
      np_moment_fan_make(b, d, &fan);
      sum_first_order(b, &d->path, &fan, &first);
      reduce_first_order(b, row, k, &fan, &first);
    }
  return NEPH_OK;
}

/* ---- Irradiance on the ground ---- */

/* Below an altitude at which there is no ground, an Earth's highest mountains, uses the whole phase function and a rule
 * around the sun instead of the zenith, Θ = π·u². It resolves the peak, and the cut at the horizon costs little,
 * because the integrand vanishes there as the cosine. */
enum { ANGLES = 16, AZIMUTHS = 8, POINTS = 12 };
static const double highest_m = 1e4;

typedef struct irradiance_job {
  np_moment_builder *builder;
  np_path_rule path;
  np_quadrature angles;
} irradiance_job;

/* Radiance towards ground at an altitude from a zenith cosine `wz` at an angle to the sun. */
static np_bands trace_to_ground(const irradiance_job *job, double altitude_m, float sun_cosine, float wz,
                                float angle_cosine) {
  const np_moment_builder *b = job->builder;
  const np_ray ray = np_ray_on_side(b->medium, altitude_m, (double)wz, false);
  np_path path;
  np_path_build(b->medium, &ray, &job->path, &path);
  np_bands rayleigh = np_bands_grey(0.0f), aerosol = rayleigh;
  float phase[NP_AEROSOLS_MAX];
  for (int i = 0; i < b->medium->aerosol_count; i++)
    phase[i] = np_phase_eval(&b->medium->aerosol[i].phase, 1.0f - angle_cosine);
  for (int n = 0; n < path.count; n++) {
    const np_path_node *node = &path.node[n];
    const np_depth_row row = np_depth_table_row(b->depths, (double)node->altitude_m);
    const float sun = ((float)ray.r * sun_cosine + (float)node->t * angle_cosine) / node->r;
    const np_bands sunlight = np_depth_row_sun(&row, np_clampf(sun, -1.0f, 1.0f), b->disk);
    const np_bands light = node->weight_m * node->transmittance * sunlight;
    rayleigh += light * node->air.rayleigh;
    for (int i = 0; i < b->medium->aerosol_count; i++) aerosol += phase[i] * light * node->air.aerosol[i];
  }
  return np_phase_rayleigh_eval(angle_cosine) * rayleigh + aerosol;
}

static np_bands sum_irradiance(const irradiance_job *job, double altitude_m, float sun_cosine) {
  const float sun_sine = sqrtf(np_maxf(1.0f - sun_cosine * sun_cosine, 0.0f));
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < ANGLES; i++) {
    const double u = job->angles.x[i], angle = NP_PI * u * u;
    const double weight = 2.0 * NP_PI * u * job->angles.weight[i] * sin(angle) * 2.0 * NP_PI / AZIMUTHS;
    const float c = (float)cos(angle), s = (float)sin(angle);
    for (int k = 0; k < AZIMUTHS; k++) {
      const float wz = sun_cosine * c + sun_sine * s * (float)cos(NP_PI * (k + 0.5) / AZIMUTHS);
      if (wz > 0.0f) sum += (float)weight * wz * trace_to_ground(job, altitude_m, sun_cosine, wz, c);
    }
  }
  return sum;
}

static neph_result gather_irradiance(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const irradiance_job *job = user;
  np_moment_builder *b = job->builder;
  const size_t columns = (size_t)b->n->node_columns;
  for (size_t node = begin; node < end; node++)
    b->irradiance[node] =
        sum_irradiance(job, np_moment_altitude_of_node(b, node / columns), b->sun_cosine[node % columns]);
  return NEPH_OK;
}

neph_result np_moment_gather_first(np_moment_builder *b) {
  irradiance_job job = {b, np_path_rule_make(POINTS), np_quadrature_gauss(ANGLES)};
  neph_result result = np_parallel_for(b->context, b->monitor, (size_t)b->n->node_rows, 1, gather_rows, b);
  if (result) return result;
  size_t rows = 1;
  while (rows < (size_t)b->n->node_rows && np_moment_altitude_of_node(b, rows) < highest_m) rows++;
  return np_parallel_for(b->context, b->monitor, rows * (size_t)b->n->node_columns, 1, gather_irradiance, &job);
}
