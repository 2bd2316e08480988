/* SPDX-License-Identifier: Apache-2.0 */
/* Optical depth τ = ∫ σ_t dt.
 *
 * Along a ray the air varies fastest at the perigee, where the altitude grows as the square of the distance t′ from it.
 * The signed root w of t′ (t′ = w·|w|) removes that. A composite four-point Gauss rule in w integrates each piece of
 * the ray between kinks of the profiles and the perigee. */
#include "atmosphere/optical_depth.h"

#include "atmosphere/ray_cuts.h"
#include "atmosphere/spline.h"
#include "atmosphere/table_sizes.h"
#include "core/alloc.h"
#include "core/parallel.h"

enum { PANELS_MAX = 12, POINTS = 4, CUTS_MAX = 1000 };

/* Smallest depth in logarithms; less counts as 0. */
static const float depth_floor = 1e-9f;

static const double gauss_x[POINTS] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                                       0.93056815579702629};
static const double gauss_weight[POINTS] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                            0.17392742256872693};

/* Number of panels for a segment: all of them only if it spans the atmosphere. */
static int count_panels(const np_medium *medium, double length) {
  return (int)fmin(1.0 + PANELS_MAX * sqrt(length / (2.0 * medium->top_m)), PANELS_MAX);
}

/* Depth over a piece with distances w·|w| from the perigee for w in [begin, end], which have one sign. */
static np_bands integrate_piece(const np_medium *medium, const np_ray *ray, double perigee, double begin, double end,
                                int panels) {
  np_bands depth = np_bands_grey(0.0f);
  const double panel = (end - begin) / panels;
  for (int i = 0; i < panels; i++) {
    float weight[POINTS];
    np_bands altitude, extinction[POINTS];
    for (int k = 0; k < POINTS; k++) {
      const double w = begin + (i + gauss_x[k]) * panel;
      weight[k] = (float)(gauss_weight[k] * panel * 2.0 * fabs(w));
      altitude[k] = (float)np_ray_altitude(ray, perigee + w * fabs(w));
    }
    np_extinction_at_four(medium, altitude, extinction);
    for (int k = 0; k < POINTS; k++) depth += weight[k] * extinction[k];
  }
  return depth;
}

static double signed_root(double x) { return copysign(sqrt(fabs(x)), x); }

np_bands np_ray_optical_depth(const np_medium *medium, const np_ray *ray, double begin_m, double end_m) {
  return np_ray_optical_depth_in(medium, ray, begin_m, end_m, count_panels(medium, end_m - begin_m));
}

np_bands np_ray_optical_depth_in(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int panels) {
  const double perigee = np_clamp(-ray->r * ray->cosine, begin_m, end_m);
  const double extent = sqrt(perigee - begin_m) + sqrt(end_m - perigee);
  const double panels_per_unit = panels / extent;
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

/* ---- Table ---- */

/* Rows are uniform in the distance to the horizon, from 0 at sea level to its maximum at the top. */
static double altitude_of_row(const np_medium *medium, double fraction) {
  const double radius = medium->planet_radius_m;
  const double rho = np_horizon_distance(medium, medium->top_m, 0.0) * fraction;
  return fmin(rho * rho / (radius + sqrt(radius * radius + rho * rho)), medium->top_m);
}

/* Squared distance from an altitude to the top along a level ray. */
static double exit_of(const np_medium *medium, double altitude) {
  return (medium->top_m - altitude) * (2.0 * medium->planet_radius_m + medium->top_m + altitude);
}

static np_bands integrate_to_top(const np_medium *medium, double altitude, double cosine) {
  const np_ray ray = np_ray_on_side(medium, altitude, cosine, false);
  return np_ray_optical_depth(medium, &ray, 0.0, ray.length_m);
}

typedef struct depth_job {
  np_depth_table *table;
  np_depth_sizes sizes;
  np_bands *nodes; /* node_rows × columns: already refined along each row */
  np_bands *level_nodes;
} depth_job;

/* Integrates one row's nodes and refines them along it; the last item is the level rays. */
static neph_result build_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  depth_job *job = user;
  const np_medium *medium = job->table->medium;
  const np_depth_sizes *n = &job->sizes;
  for (size_t row = begin; row < end; row++) {
    np_bands node[NP_DEPTH_COLUMNS_MAX];
    const double altitude = altitude_of_row(medium, (double)row / (n->node_rows - 1));
    const double exit = exit_of(medium, altitude), near = medium->top_m - altitude, far = sqrt(exit);
    for (int i = 0; i < n->node_columns; i++) {
      const double d = near + (far - near) * i / (n->node_columns - 1);
      const double cosine =
          d > 0.0 ? np_clamp((exit - d * d) / (2.0 * (medium->planet_radius_m + altitude) * d), 0.0, 1.0) : 1.0;
      node[i] = integrate_to_top(medium, altitude, cosine);
    }
    for (int i = 0; i < n->columns; i++) {
      const np_spline s = np_spline_make(i, n->columns, n->node_columns);
      job->nodes[row * (size_t)n->columns + (size_t)i] = np_spline_eval(&s, node, 1);
    }
  }
  return NEPH_OK;
}

static neph_result build_levels(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  depth_job *job = user;
  const np_medium *medium = job->table->medium;
  for (size_t i = begin; i < end; i++) {
    const double root = (double)i / (job->sizes.node_levels - 1);
    job->level_nodes[i] = integrate_to_top(medium, root * root * medium->top_m, 0.0);
  }
  return NEPH_OK;
}

/* Depths fall by decades with altitude, so that their logarithms are refined; the floor keeps the top finite. In very
 * thin air a spline between nodes may be negative. */
static np_bands log_depth(np_bands depth) {
  return np_bands_log(np_bands_max(depth, np_bands_grey(0.0f)) + depth_floor);
}
static np_bands undo_log(np_bands logarithm) {
  return np_bands_max(np_bands_exp(logarithm) - depth_floor, np_bands_grey(0.0f));
}

static void refine_table(const depth_job *job) {
  const np_depth_sizes *n = &job->sizes;
  const size_t columns = (size_t)n->columns;
  for (size_t i = 0; i < (size_t)n->node_rows * columns; i++) job->nodes[i] = log_depth(job->nodes[i]);
  for (int row = 0; row < n->rows; row++) {
    const np_spline s = np_spline_make(row, n->rows, n->node_rows);
    np_bands *out = job->table->texels + (size_t)row * columns;
    for (size_t i = 0; i < columns; i++) out[i] = undo_log(np_spline_eval(&s, job->nodes + i, columns));
  }
  for (int i = 0; i < n->node_levels; i++) job->level_nodes[i] = log_depth(job->level_nodes[i]);
  for (int i = 0; i < n->levels; i++) {
    const np_spline s = np_spline_make(i, n->levels, n->node_levels);
    job->table->level[i] = undo_log(np_spline_eval(&s, job->level_nodes, 1));
  }
}

neph_result np_depth_table_build(neph_context *context, const np_medium *medium, const np_depth_sizes *sizes,
                                 np_monitor *monitor, np_depth_table *out_table) {
  *out_table = (np_depth_table){medium, sizes->rows, sizes->columns, sizes->levels, NULL, NULL};
  depth_job job = {.table = out_table, .sizes = *sizes};
  const size_t columns = (size_t)sizes->columns, node_count = (size_t)sizes->node_rows * columns;
  out_table->texels = np_alloc(context, (size_t)sizes->rows * columns, sizeof(np_bands));
  if (out_table->texels) out_table->level = np_alloc(context, (size_t)sizes->levels, sizeof(np_bands));
  if (out_table->level) job.nodes = np_alloc(context, node_count + (size_t)sizes->node_levels, sizeof(np_bands));
  if (!job.nodes) return NEPH_ERROR_OUT_OF_MEMORY;
  job.level_nodes = job.nodes + node_count;
  neph_result result = np_parallel_for(context, monitor, (size_t)sizes->node_rows, 2, build_nodes, &job);
  if (!result) result = np_parallel_for(context, monitor, (size_t)sizes->node_levels, 8, build_levels, &job);
  if (!result) refine_table(&job);
  np_alloc_free(context, job.nodes);
  return result;
}

void np_depth_table_free(neph_context *context, np_depth_table *table) {
  np_alloc_free(context, table->texels);
  np_alloc_free(context, table->level);
  table->texels = table->level = NULL;
}

np_depth_row np_depth_table_row(const np_depth_table *table, double altitude_m) {
  const np_medium *medium = table->medium;
  const double h = np_clamp(altitude_m, 0.0, medium->top_m), r = medium->planet_radius_m + h;
  const double horizon_max = np_horizon_distance(medium, medium->top_m, 0.0);
  const double rho = np_horizon_distance(medium, h, 0.0), distance_min = medium->top_m - h, exit = exit_of(medium, h);
  const double y = rho / horizon_max * (table->rows - 1);
  const int j = y < table->rows - 2 ? (int)y : table->rows - 2;
  const np_bands *texels = table->texels + (size_t)j * (size_t)table->columns;
  np_depth_row row = {
      .lower = texels,
      .upper = texels + table->columns,
      .level = table->level,
      .upper_weight = (float)(y - j),
      .altitude_m = (float)h,
      .r = (float)r,
      .exit = (float)exit,
      .distance_min = (float)distance_min,
      .texels_per_m = (float)((table->columns - 1) / fmax(sqrt(exit) - distance_min, 1e-3)),
      .levels_per_root_m = (float)((table->levels - 1) / sqrt(medium->top_m)),
      .columns = table->columns,
      .levels = table->levels,
      .horizon_cosine = (float)(-rho / r),
      .disk_scale = (float)(r / medium->planet_radius_m),
  };
  row.level_offset = np_bands_mix(row.lower[row.columns - 1], row.upper[row.columns - 1], row.upper_weight) -
                     np_depth_row_level(&row, row.altitude_m);
  return row;
}
