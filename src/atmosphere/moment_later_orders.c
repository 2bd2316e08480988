/* SPDX-License-Identifier: Apache-2.0 */
/* Later orders: the source from the previous order, gathered at the nodes. */
#include "atmosphere/moment_builder.h"
#include "core/parallel.h"

/* Skylight reflected along a direction by the ground at its end. */
static void add_ground_light(const np_moment_builder *b, const np_moment_direction *d, const np_fan *fan,
                             np_bands *radiance) {
  np_fan_point point;
  b->kernels->compute_sun_cosines(fan, (float)d->ray.length_m, (float)b->medium->planet_radius_m, &point);
  const np_bands scale = (float)(1.0 / NP_PI) * d->path.end_transmittance * b->medium->ground_albedo;
  for (int i = 0; i < fan->count; i++)
    radiance[i] += scale * np_moment_table_irradiance(b->table, 0.0, point.sun_cosine[i]);
}

/* Radiance along every ray of a fan. */
static void compute_radiance(const np_moment_builder *b, const np_moment_direction *d, const np_fan *fan,
                             np_bands *out_radiance) {
  memset(out_radiance, 0, (size_t)np_fan_count_steps(fan->count) * NP_FAN_STEP * sizeof *out_radiance);
  for (int i = 0; i < d->path.count; i++) {
    const np_path_node *node = &d->path.node[i];
    const np_fan_source source = np_fan_source_make(b->table, node, node->weight_m * node->transmittance, true);
    np_fan_point point;
    b->kernels->compute_sun_cosines(fan, (float)node->t, node->r, &point);
    b->kernels->compute_columns(&b->table->sun, fan, node->cosine, &point);
    b->kernels->add_source(&source, &point, out_radiance, NULL);
  }
  if (d->ray.hits_ground) add_ground_light(b, d, fan, out_radiance);
}

/* Reduces the radiance along one direction to moments and irradiance, for every sun. */
static void reduce_direction(np_moment_builder *b, size_t row, int k, const np_bands *radiance) {
  const np_moment_direction *d = np_moment_direction_at(b, row, k);
  const float sine = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f));
  for (int column = 0; column < b->n->node_columns; column++) {
    const size_t node = np_moment_node_at(b, row, column);
    for (int p = 0; p < NP_MOMENT_AZIMUTHS; p++, radiance++) {
      const np_bands light = d->weight * np_bands_max(*radiance, np_bands_grey(0.0f));
      np_moment_add(b->gathered + node * NP_MOMENT_COUNT, light, sine * b->cos_azimuth[p], d->wz);
      b->irradiance[node] += np_maxf(d->wz, 0.0f) * light;
    }
  }
}

static neph_result gather_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  np_moment_builder *b = user;
  for (size_t row = begin; row < end; row++)
    for (int k = 0; k < np_moment_count_directions(b); k++) {
      np_fan fan;
      np_bands radiance[NP_FAN_MAX];
      np_moment_fan_make(b, np_moment_direction_at(b, row, k), &fan);
      compute_radiance(b, np_moment_direction_at(b, row, k), &fan, radiance);
      reduce_direction(b, row, k, radiance);
    }
  return NEPH_OK;
}

neph_result np_moment_gather_later(np_moment_builder *b) {
  return np_parallel_for(b->context, b->monitor, (size_t)b->n->node_rows, 1, gather_rows, b);
}
