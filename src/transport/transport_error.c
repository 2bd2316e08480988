/* SPDX-License-Identifier: Apache-2.0 */
/* Error and memory that cells of the multiple scattering are expected to have. */
#include "core/parallel.h"
#include "transport/transport_grid.h"

void np_transport_grid_compute_depths(const np_world *world, const np_transport_grid *grid, double *out_least,
                                      double *out_most) {
  double least = 0.0, most = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    if (grid->size[axis] == 1) continue;
    const double even = grid->even_m[axis]; /* the width of all cells with cloud */
    double narrow = even > 0.0 ? even : HUGE_VAL, wide = even;
    for (int32_t i = 0; i < grid->size[axis] && !(even > 0.0); i++) {
      narrow = fmin(narrow, np_transport_grid_width(grid, axis, i));
      wide = fmax(wide, np_transport_grid_width(grid, axis, i));
    }
    least = fmax(least, narrow);
    most = fmax(most, wide);
  }
  const double per_m = np_transport_compute_extinction(world) * np_transport_get_stretch(world);
  *out_least = least * per_m;
  *out_most = most * per_m;
}

double np_transport_expect_error(double cell_depth) {
  static const double nodes[][2] = {{0.35, 0.02}, {1.0, 0.04}, {2.0, 0.07}, {4.0, 0.14}};
  enum { COUNT = sizeof nodes / sizeof *nodes };
  if (cell_depth <= nodes[0][0]) return nodes[0][1];
  for (int i = 1; i < COUNT; i++)
    if (cell_depth <= nodes[i][0] || i + 1 == COUNT) {
      const double t = (cell_depth - nodes[i - 1][0]) / (nodes[i][0] - nodes[i - 1][0]);
      return fmin(1.0, nodes[i - 1][1] + t * (nodes[i][1] - nodes[i - 1][1]));
    }
  return 1.0;
}

double np_transport_grid_compute_lit_depth(const np_transport_grid *grid) {
  double power = 0.0, depth = 0.0;
  for (size_t active = 0; active < grid->active_count && grid->first_collision_source; active++) {
    const double own = (double)grid->first_collision_source[active];
    power += own;
    depth += own * (double)grid->transport_depth[active];
  }
  return power > 0.0 ? depth / power : HUGE_VAL;
}

/* Depth beyond which no cells were measured by their densest point: deep clouds alone have such cells, whose error goes
 * by the depth at which they are lit, up to a most: walls reflect as they should, however deep they are. Balls, lumps
 * and a large cloud of depths 300 to 1e6, with sharp and with soft rims, err by 0.4 to 1.2 times what follows for their
 * pixels. */
static const double measured_depth_max = 4.0, error_per_lit_depth = 0.06, deep_error_max = 0.1;

/* Decks are seen from below too, by what their thin places let through: half of what falls on a place one deep cell
 * thick. Light below decks of depths 100 to 476 over black ground erred by 0.5 to 0.57 times the square of that depth,
 * for depths of 0.2 to 1.4; over ground that sends it back, by 3 to 15 % where the square is small. */
static const double error_per_lit_depth_squared = 0.55, deck_error = 0.06;

double np_transport_expect_deep_error(double cell_depth, double lit_depth, bool is_flat) {
  const double error = np_transport_expect_error(cell_depth), least = np_transport_expect_error(0.0);
  if (cell_depth <= measured_depth_max || !isfinite(lit_depth)) return error;
  const double reflected = fmin(error, np_clamp(error_per_lit_depth * lit_depth, least, deep_error_max));
  const double transmitted = is_flat ? hypot(error_per_lit_depth_squared * lit_depth * lit_depth, deck_error) : 0.0;
  return fmin(fmax(reflected, transmitted), 1.0);
}

/* Place that sunlight is followed to (first_collision.h), cells with and without cloud, and data beside the moments. */
static const double other_bytes = 300.0;

/* Unknowns of the diffusion equation, their links and vectors, on all of its grids. */
static const double diffusion_bytes = 100.0;

/* Vectors of moments: the solution, that of a sweep, and three bands kept as halves. */
double np_transport_count_swept_bytes(unsigned degree) {
  return 3.5 * sizeof(float) * np_harmonics_count(degree) + other_bytes;
}

/* Bytes for each cell while light is iterated: six vectors of Anderson's method, the first band, a sharpened copy, and
 * the diffusion system. Coarser grids add a seventh. */
double np_transport_count_iterated_bytes(unsigned degree) {
  return 8.0 / 7.0 *
         (8.0 * sizeof(float) * np_harmonics_count(degree) + diffusion_bytes + np_transport_count_swept_bytes(degree));
}
