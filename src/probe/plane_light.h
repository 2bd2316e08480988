/* SPDX-License-Identifier: Apache-2.0 */
/* Light through level planes of a lit world, and light that clouds absorb between two of them, by camera rays of the
 * integrators that render pictures; by columns of a rectangle, and in the mean. */
#ifndef NP_PROBE_PLANE_LIGHT_H
#define NP_PROBE_PLANE_LIGHT_H

#include "core/parallel.h"
#include "integrate/integrator.h"

/* One light's view of the world; radiances of all views add up. */
typedef struct np_plane_view {
  const np_world *world; /* world without visible disks: unscattered light is added separately */
  const np_lighting *lighting;
} np_plane_view;

typedef struct np_plane_source {
  neph_context *context;
  const np_plane_view *views;
  unsigned view_count;
  np_integrator_settings settings;
  np_integrator_fn integrate;
  uint64_t seed;
} np_plane_source;

typedef enum np_plane_kind {
  NP_PLANE_FLUX,     /* irradiance of the plane from one side, sunlight included, W m⁻² nm⁻¹ */
  NP_PLANE_RADIANCE, /* scattered radiance in one direction of travel, W m⁻² sr⁻¹ nm⁻¹ */
  NP_PLANE_ABSORBED  /* absorbed by clouds between the planes at low_m and high_m, W m⁻² nm⁻¹ of the rectangle */
} np_plane_kind;

typedef struct np_plane_query {
  np_plane_kind kind;
  double box_min_m[2], box_max_m[2]; /* rectangle, along x and y */
  double low_m, high_m;              /* height of the plane; both of the layer that absorbs */
  bool is_up;                        /* true: upward light; false: downward */
  np_vec3 travel;                    /* direction of travel of a radiance, unit */
  unsigned columns[2];               /* columns along x and y, at least 1 */
} np_plane_query;

/* Mean and its standard error, by bands. */
typedef struct np_plane_answer {
  double value[NP_BAND_COUNT], error[NP_BAND_COUNT];
} np_plane_answer;

enum { NP_PLANE_BATCHES = 64 };

/* Measures by `ray_count` rays, rounded up to whole batches. `stream` and `run` separate the random numbers of one
 * query from those of others. `out_columns` has an answer for each column, x fastest; NULL: none. The same bits for any
 * number of threads. */
neph_result np_plane_measure(const np_plane_source *source, const np_plane_query *query, unsigned ray_count,
                             uint32_t stream, uint32_t run, np_monitor *monitor, np_plane_answer *out_whole,
                             np_plane_answer *out_columns);

/* Measures by as many rays as bring the standard error of the band's mean to the share `target_error` of it, as pilots
 * predict, and a fifth more; at most `ray_count_max`. Infinite: `ray_count_max`. */
neph_result np_plane_measure_to_target(const np_plane_source *source, const np_plane_query *query, double target_error,
                                       unsigned ray_count_max, uint32_t stream, np_monitor *monitor,
                                       unsigned *out_ray_count, np_plane_answer *out_whole,
                                       np_plane_answer *out_columns);

#endif
