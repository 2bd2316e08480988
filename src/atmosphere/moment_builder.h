/* SPDX-License-Identifier: Apache-2.0 */
/* State of the moments under construction: nodes, the directions gathered at each of them, and the results.
 *
 * Rays of one altitude and zenith cosine are a fan (fan.h): NP_MOMENT_AZIMUTHS rays for each column of suns. */
#ifndef NP_ATMOSPHERE_MOMENT_BUILDER_H
#define NP_ATMOSPHERE_MOMENT_BUILDER_H

#include "atmosphere/fan.h"
#include "atmosphere/ray_path.h"
#include "atmosphere/scattering_moments.h"

enum { NP_MOMENT_AZIMUTHS = 4 }; /* azimuths on the half circle */

/* Radiance moments below this are 0, per unit of irradiance. */
static const float np_moment_least = 1e-13f;

typedef struct np_moment_direction {
  float wz;
  float weight; /* quadrature weight of the zenith angle, for each azimuth */
  np_ray ray;
  np_path path;
} np_moment_direction;

typedef struct np_moment_builder {
  neph_context *context;
  np_monitor *monitor;
  const np_fan_kernels *kernels;
  const np_medium *medium;
  const np_depth_table *depths;
  const np_moment_sizes *n;
  np_moment_table *table; /* holds the previous order while the next is gathered */
  np_sun_disk disk;
  unsigned order, order_max;
  bool is_series; /* the last order represents all orders after it */
  size_t node_count;
  float sun_cosine[NP_MOMENT_NODE_COLUMNS_MAX], sun_sine[NP_MOMENT_NODE_COLUMNS_MAX];
  float cos_azimuth[NP_MOMENT_AZIMUTHS];
  np_moment_direction *directions; /* node rows × directions */
  np_bands *gathered, *total;      /* nodes × NP_MOMENT_COUNT: the current order, and the sum */
  np_bands *last;                  /* nodes: M of the previous order */
  np_bands *irradiance, *irradiance_total, *irradiance_last; /* nodes: on level ground there */
  np_bands *quantity, *refined_rows, *refined; /* one quantity at the nodes, along node rows, and in the whole table */
} np_moment_builder;

static inline size_t np_moment_node_at(const np_moment_builder *b, size_t row, int column) {
  return row * (size_t)b->n->node_columns + (size_t)column;
}

static inline double np_moment_altitude_of_node(const np_moment_builder *b, size_t row) {
  const double y = (double)row / (b->n->node_rows - 1);
  return b->medium->top_m * y * y;
}

static inline int np_moment_count_directions(const np_moment_builder *b) { return b->n->up + b->n->down; }

static inline const np_moment_direction *np_moment_direction_at(const np_moment_builder *b, size_t row, int k) {
  return &b->directions[row * (size_t)np_moment_count_directions(b) + (size_t)k];
}

/* Makes the rays along a direction: azimuth by azimuth for each column of suns. */
static inline void np_moment_fan_make(const np_moment_builder *b, const np_moment_direction *d, np_fan *out_fan) {
  const float sine = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f));
  out_fan->count = b->n->node_columns * NP_MOMENT_AZIMUTHS;
  out_fan->r = (float)d->ray.r;
  for (int i = 0; i < out_fan->count; i++) {
    const int column = i / NP_MOMENT_AZIMUTHS;
    out_fan->sun_cosine[i] = b->sun_cosine[column];
    out_fan->angle_cosine[i] =
        d->wz * b->sun_cosine[column] + sine * b->sun_sine[column] * b->cos_azimuth[i % NP_MOMENT_AZIMUTHS];
  }
  np_fan_pad(out_fan);
}

/* Adds the radiance of a ray to a node's moments. */
static inline void np_moment_add(np_bands *moments, np_bands light, float wx, float wz) {
  moments[NP_MOMENT_M] += light;
  moments[NP_MOMENT_FX] += wx * light;
  moments[NP_MOMENT_FZ] += wz * light;
  moments[NP_MOMENT_KXX] += wx * wx * light;
  moments[NP_MOMENT_KZZ] += wz * wz * light;
  moments[NP_MOMENT_KXZ] += wx * wz * light;
}

/* The first gathers order 1, sunlight scattered once or reflected by the ground; the second gathers the next order from
 * the previous one in the table. */
neph_result np_moment_gather_first(np_moment_builder *b);
neph_result np_moment_gather_later(np_moment_builder *b);

/* Fills the table from the nodes: with the current order, or with the sum of all, faded at its dark end. */
void np_moment_refine_order(np_moment_builder *b);
void np_moment_refine_total(np_moment_builder *b);

/* Sums the first `order_max` orders of scattering in the medium of `depths`, under a disk or a point sun; the method is
 * in moment_builder.c. */
neph_result np_moment_table_build(neph_context *context, const np_depth_table *depths, const np_moment_sizes *sizes,
                                  unsigned order_max, bool has_point_sun, np_monitor *monitor,
                                  np_moment_table *out_table);

/* Adds the difference of sunlight through `brighter` and `darker` air, as scattered light from the sun's direction. */
void np_moment_table_add_beam(np_moment_table *table, const np_depth_table *brighter, const np_depth_table *darker,
                              bool has_point_sun);

/* np_moment_table_build of all orders with delta-M scaling of the air. */
neph_result np_delta_moments_build(neph_context *context, const np_depth_table *depths, const np_table_sizes *sizes,
                                   bool has_point_sun, np_monitor *monitor, np_moment_table *out_table);

#endif
