/* SPDX-License-Identifier: Apache-2.0 */
/* The choice of cells and of degrees for a solution of the multiple scattering, from the memory and the time that they
 * take. */
#include "core/alloc.h"
#include "transport/scattering_solver.h"
#include "transport/solved_clouds.h"

enum { RESOLVED_DEGREE = 7 };

/* A fine cell takes half as long as a ray of the march, with or without cloud in both: where these many are no more, of
 * a picture's time less than half goes into cells. */
static const double cells_per_ray = 1.5;

/* Highest degree that the number of cells allows, among the degrees whose harmonics fill whole vectors. */
static unsigned choose_degree(double cells, bool is_layered, const np_scattering_desc *desc) {
  static const unsigned degrees[] = {NP_DEGREE_MAX, 7};
  for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
    const double directions = np_ordinates_count(degrees[i], is_layered);
    const bool is_cheap = cells * directions * np_harmonics_count(degrees[i]) <= desc->work_max;
    if (is_cheap && degrees[i] <= desc->degree_max) return degrees[i];
  }
  return NP_DEGREE_MIN;
}

/* Bytes that a cell takes whose light is iterated in the least degree, and resolved into more. */
static double count_resolved_bytes(void) {
  return np_transport_count_iterated_bytes(NP_DEGREE_MIN) + np_transport_count_swept_bytes(RESOLVED_DEGREE);
}

/* Bytes for each cell of a fine grid. Cells twice as wide are an eighth as many, and more along the clouds' rim. */
static double count_fine_bytes(void) {
  return np_transport_count_swept_bytes(RESOLVED_DEGREE) + 1.0 / 6.0 * count_resolved_bytes();
}

static double count_bytes_max(const np_transport_desc *cells) {
  return (double)cells->cell_count_max * np_transport_count_iterated_bytes(NP_DEGREE_MIN);
}

/* The degree that a solution of the least degree is resolved into, where the memory that so many cells of the least
 * degree could take is enough. */
static unsigned choose_resolved(double cells, bool is_fine_wanted, unsigned degree, const np_scattering_desc *desc) {
  const double bytes = cells * (is_fine_wanted ? count_fine_bytes() : count_resolved_bytes());
  const bool is_resolved = degree == NP_DEGREE_MIN && desc->degree_max >= RESOLVED_DEGREE;
  return is_resolved && bytes <= count_bytes_max(&desc->cells) ? RESOLVED_DEGREE : degree;
}

void np_scattering_desc_set_rays(np_scattering_desc *desc, double rays) {
  desc->cells.cell_count_fine = (size_t)fmin(cells_per_ray * rays, count_bytes_max(&desc->cells) / count_fine_bytes());
}

void np_scattering_desc_set_memory(np_scattering_desc *desc, double bytes) {
  desc->cells.cell_count_max = (size_t)fmin(bytes / np_transport_count_iterated_bytes(NP_DEGREE_MIN), 1e9);
}

np_scattering_degrees np_scattering_desc_choose_degrees(const np_scattering_desc *desc, double cells, bool is_layered,
                                                        bool is_fine_wanted) {
  const unsigned degree = choose_degree(cells, is_layered, desc);
  return (np_scattering_degrees){degree, choose_resolved(cells, is_fine_wanted, degree, desc)};
}

/* Number of cells, in all, that a forecast samples. */
static const double looked_at_max = 32768.0;

/* Estimates by a sample the number of cells, each `width` finest cells wide, that hold cloud or touch a cell that
 * does. */
static double count_active(const np_transport_grid *g, int32_t width, const np_cloud_finder *finder) {
  double looked_at = 0.0, active = 0.0, all = 1.0, stride = 1.0;
  int32_t count[3], step[3];
  for (int a = 0; a < 3; a++) all *= count[a] = g->size[a] / width > 0 ? g->size[a] / width : 1;
  while (all > looked_at_max * stride * stride * stride) stride += 1.0;
  for (int a = 0; a < 3; a++) step[a] = (int32_t)fmin(stride, fmax(count[a] / 8.0, 1.0));
  if (!finder) return all;
  int32_t at[3];
  for (at[2] = step[2] / 2; at[2] < count[2]; at[2] += step[2])
    for (at[1] = step[1] / 2; at[1] < count[1]; at[1] += step[1])
      for (at[0] = step[0] / 2; at[0] < count[0]; at[0] += step[0]) {
        double low[3], high[3];
        for (int a = 0; a < 3; a++) {
          const int32_t first = (at[a] - 1) * width, end = (at[a] + 2) * width;
          low[a] = g->edge_m[a][first > 0 ? first : 0];
          high[a] = g->edge_m[a][end < g->size[a] ? end : g->size[a]];
        }
        looked_at += 1.0;
        active += finder->has_cloud(finder->user, np_dvec3_make(low[0], low[1], low[2]),
                                    np_dvec3_make(high[0], high[1], high[2]));
      }
  return looked_at > 0.0 ? all * active / looked_at : all;
}

static double count_work(unsigned degree, bool is_layered) {
  return (double)np_ordinates_count(degree, is_layered) * np_harmonics_count(degree);
}

/* Steps remembered by the solution that np_transport_count_iterated_bytes counts. */
static const double usual_depth = 3.0;

/* Memory and work of a solution's levels: the result's `active` cells, `iterated` ones twice as wide where these are
 * fine, the same in the degree that is iterated, and coarser ones. */
static np_cell_counts count_levels(const np_scattering_desc *desc, const np_scattering_degrees *d, bool is_layered,
                                   double active, double iterated) {
  const double fine = iterated < active ? active : 0.0, resolved = d->resolved != d->iterated ? iterated : 0.0;
  const double moments = iterated * np_harmonics_count(d->iterated),
               further = 2.0 * (np_transport_level_get_depth(moments, desc->tolerance) - usual_depth);
  return (np_cell_counts){
      .cells = active,
      .bytes = iterated * np_transport_count_iterated_bytes(d->iterated) + further * sizeof(float) * moments +
               (fine + resolved) * np_transport_count_swept_bytes(d->resolved),
      .sweep_work = 8.0 / 7.0 * iterated * count_work(d->iterated, is_layered),
      .last_work = (NP_RESOLVING_SWEEPS * resolved + NP_REFINING_SWEEPS * fine) * count_work(d->resolved, is_layered)};
}

np_cell_counts np_scattering_desc_count(const np_scattering_desc *desc, double cells) {
  const np_scattering_degrees d = np_scattering_desc_choose_degrees(desc, cells, false, false);
  return count_levels(desc, &d, false, cells, cells);
}

static np_cell_counts count_cells(const np_scattering_desc *desc, const np_transport_grid *g,
                                  const np_cloud_finder *finder) {
  const bool is_layered = g->is_wrapped[0] || g->is_wrapped[1];
  const double all = (double)np_transport_grid_count(g), active = count_active(g, 1, finder);
  const np_scattering_degrees d = np_scattering_desc_choose_degrees(desc, all, is_layered, g->is_fine);
  const double iterated = g->is_fine ? fmin(count_active(g, 2, finder), 0.99 * active) : active;
  np_cell_counts counts = count_levels(desc, &d, is_layered, active, iterated);
  counts.places = all;
  return counts;
}

static neph_result forecast(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                            const np_cloud_finder *finder, np_scattering_forecast *out) {
  np_transport_grid grid;
  neph_result result = np_transport_grid_place(context, world, &desc->cells, &grid);
  if (result) return result;
  double least, most, volume_m3 = 1.0;
  np_transport_grid_compute_depths(world, &grid, &least, &most);
  *out = (np_scattering_forecast){.errors = {np_transport_expect_error(least), np_transport_expect_error(most)},
                                  .cell_count = (double)grid.size[0] * grid.size[1] * grid.size[2]};
  for (int a = 0; a < 3; a++) volume_m3 *= np_transport_grid_length(&grid, a);
  out->volume_m3 = volume_m3;
  out->counts = count_cells(desc, &grid, finder);
  np_transport_grid_clear(&grid);
  return NEPH_OK;
}

neph_result np_scattering_desc_forecast(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                                        const np_cloud_finder *finder, np_scattering_forecast *out) {
  np_solved_clouds solved;
  *out = (np_scattering_forecast){.cell_count = 0.0};
  neph_result result = np_solved_clouds_list(context, world, desc->left_out, &solved);
  if (!result && solved.world.clouds.count > 0) result = forecast(context, &solved.world, desc, finder, out);
  np_solved_clouds_clear(&solved);
  return result;
}

static neph_result add_cells(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                             np_hash *hash) {
  np_transport_grid grid;
  neph_result result = np_transport_grid_place(context, world, &desc->cells, &grid);
  if (result) return result;
  for (int a = 0; a < 3; a++) np_hash_add(hash, grid.edge_m[a], ((size_t)grid.size[a] + 1) * sizeof *grid.edge_m[a]);
  np_transport_grid_clear(&grid);
  if (desc->cells.fold.period_m > 0.0) NP_HASH_ADD(hash, desc->cells.fold);
  return NEPH_OK;
}

neph_result np_scattering_desc_add_to_hash(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                                           np_hash *hash) {
  np_solved_clouds solved;
  neph_result result = np_solved_clouds_list(context, world, desc->left_out, &solved);
  if (!result && solved.world.clouds.count > 0) result = add_cells(context, &solved.world, desc, hash);
  np_solved_clouds_clear(&solved);
  if (result) return result;
  NP_HASH_ADD(hash, desc->work_max);
  NP_HASH_ADD(hash, desc->degree_max);
  NP_HASH_ADD(hash, desc->tolerance);
  NP_HASH_ADD(hash, desc->has_importance);
  if (desc->left_out) NP_HASH_ADD(hash, desc->left_out);
  return NEPH_OK;
}
