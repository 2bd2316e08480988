/* SPDX-License-Identifier: Apache-2.0 */
/* Optical depth τ = ∫ σ_t dt.
 *
 * Along a ray the air varies fastest about the perigee, where the altitude grows as the square of the distance t′ from
 * it. The signed root w of t′ (t′ = w·|w|) takes that out. Where kinks of the profiles and the perigee cut the ray into
 * pieces, a composite four-point Gauss rule in w integrates each.
 */
#include "atmosphere/optical_depth.h"

#include "atmosphere/ray_cuts.h"
#include "core/alloc.h"
#include "core/parallel.h"

enum { PANELS_MAX = 12, POINTS = 4, CUTS_MAX = 1000 };

static const double gauss_x[POINTS] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                                       0.93056815579702629};
static const double gauss_weight[POINTS] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                            0.17392742256872693};

/* Panels for a stretch: it takes all of them only where it spans the atmosphere. */
static int count_panels(const np_medium *medium, double length) {
  return (int)fmin(1.0 + PANELS_MAX * sqrt(length / (2.0 * medium->top_m)), PANELS_MAX);
}

/* Depth over a piece whose distances from the perigee are w·|w| for w in [begin, end], both of one sign. */
static np_bands integrate_piece(const np_medium *medium, const np_ray *ray, double perigee, double begin, double end,
                                int panels) {
  np_bands depth = np_bands_grey(0.0f);
  const double panel = (end - begin) / panels;
  for (int i = 0; i < panels; i++)
    for (int k = 0; k < POINTS; k++) {
      const double w = begin + (i + gauss_x[k]) * panel;
      depth += (float)(gauss_weight[k] * panel * 2.0 * fabs(w)) *
               np_extinction_at(medium, np_ray_altitude(ray, perigee + w * fabs(w)));
    }
  return depth;
}

static double signed_root(double x) { return copysign(sqrt(fabs(x)), x); }

np_bands np_ray_optical_depth(const np_medium *medium, const np_ray *ray, double begin_m, double end_m) {
  const double perigee = np_clamp(-ray->r * ray->cosine, begin_m, end_m);
  const double extent = sqrt(perigee - begin_m) + sqrt(end_m - perigee);
  const double panels_per_unit = count_panels(medium, end_m - begin_m) / extent;
  np_ray_cuts cuts = np_ray_cuts_make(medium, ray, CUTS_MAX);
  np_bands depth = np_bands_grey(0.0f);
  for (double from = begin_m; from < end_m;) {
    const double cut = np_ray_cuts_next(&cuts), to = fmin(cut, end_m);
    if (cut <= from) continue;
    const double begin = signed_root(from - perigee), end = signed_root(to - perigee);
    depth += integrate_piece(medium, ray, perigee, begin, end, (int)fmax(ceil((end - begin) * panels_per_unit), 1.0));
    from = to;
  }
  return depth;
}

/* Rows are even in the distance to the horizon, from 0 at sea level to its greatest at the top. */
static double altitude_of_row(const np_medium *medium, int row) {
  const double radius = medium->planet_radius_m;
  const double rho = np_horizon_distance(medium, medium->top_m, 0.0) * row / (NP_DEPTH_HEIGHT - 1);
  return fmin(rho * rho / (radius + sqrt(radius * radius + rho * rho)), medium->top_m);
}

/* Writes one row of the table; `user` is the table. */
static neph_result build_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_depth_table *table = user;
  const np_medium *medium = table->medium;
  const double radius = medium->planet_radius_m, horizon_max = np_horizon_distance(medium, medium->top_m, 0.0);
  for (size_t row = begin; row < end; row++) {
    const double altitude = altitude_of_row(medium, (int)row), rho = np_horizon_distance(medium, altitude, 0.0);
    const double exit = (medium->top_m - altitude) * (2.0 * radius + medium->top_m + altitude);
    const double distance_min = medium->top_m - altitude, distance_max = rho + horizon_max;
    for (int column = 0; column < NP_DEPTH_WIDTH; column++) {
      const double d = distance_min + (distance_max - distance_min) * column / (NP_DEPTH_WIDTH - 1);
      const double cosine = d > 0.0 ? np_clamp((exit - d * d) / (2.0 * (radius + altitude) * d), -1.0, 1.0) : 1.0;
      const np_ray ray = np_ray_on_side(medium, altitude, cosine, false);
      table->texels[row * NP_DEPTH_WIDTH + (size_t)column] = np_ray_optical_depth(medium, &ray, 0.0, ray.length_m);
    }
  }
  return NEPH_OK;
}

neph_result np_depth_table_build(neph_context *context, const np_medium *medium, np_depth_table *out_table) {
  *out_table = (np_depth_table){medium, np_alloc(context, NP_DEPTH_WIDTH * NP_DEPTH_HEIGHT, sizeof(np_bands))};
  if (!out_table->texels) return NEPH_ERROR_OUT_OF_MEMORY;
  return np_parallel_for(context, NULL, NP_DEPTH_HEIGHT, 4, build_rows, out_table);
}

void np_depth_table_free(neph_context *context, np_depth_table *table) {
  np_alloc_free(context, table->texels);
  table->texels = NULL;
}

np_depth_row np_depth_table_row(const np_depth_table *table, double altitude_m) {
  const np_medium *medium = table->medium;
  const double h = np_clamp(altitude_m, 0.0, medium->top_m), r = medium->planet_radius_m + h;
  const double horizon_max = np_horizon_distance(medium, medium->top_m, 0.0);
  const double rho = np_horizon_distance(medium, h, 0.0), distance_min = medium->top_m - h;
  const double y = rho / horizon_max * (NP_DEPTH_HEIGHT - 1);
  const int j = y < NP_DEPTH_HEIGHT - 2 ? (int)y : NP_DEPTH_HEIGHT - 2;
  const np_bands *texels = table->texels + (size_t)j * NP_DEPTH_WIDTH;
  return (np_depth_row){
      .lower = texels,
      .upper = texels + NP_DEPTH_WIDTH,
      .upper_weight = (float)(y - j),
      .r = (float)r,
      .exit = (float)((medium->top_m - h) * (2.0 * medium->planet_radius_m + medium->top_m + h)),
      .distance_min = (float)distance_min,
      .texels_per_m = (float)((NP_DEPTH_WIDTH - 1) / (rho + horizon_max - distance_min)),
      .horizon_cosine = (float)(-rho / r),
      .disk_scale = (float)(r / medium->planet_radius_m),
  };
}
