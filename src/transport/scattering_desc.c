/* SPDX-License-Identifier: Apache-2.0 */
/* The choice of cells and of degrees for a solution of the multiple scattering, from the memory and the time that they
 * take. */
#include "core/alloc.h"
#include "transport/scattering_solver.h"

enum { RESOLVED_DEGREE = 7 };

/* A fine cell takes half as long as a ray of the march, with or without cloud in both: where these many are no more, of
 * a picture's time less than half goes into cells. */
static const double cells_per_ray = 1.5;

/* The highest degree, of those whose harmonics fill whole vectors, that the cells' number allows. */
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

/* The same of a fine one; those twice as wide are an eighth as many, and at the clouds' rim more. */
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

neph_result np_scattering_desc_forecast(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                                        np_scattering_forecast *out) {
  np_transport_grid grid;
  neph_result result = np_transport_grid_place(context, world, &desc->cells, &grid);
  if (result) return result;
  double least, most, volume_m3 = 1.0;
  np_transport_grid_compute_depths(world, &grid, &least, &most);
  *out = (np_scattering_forecast){.errors = {np_transport_expect_error(least), np_transport_expect_error(most)},
                                  .cell_count = (double)grid.size[0] * grid.size[1] * grid.size[2]};
  for (int a = 0; a < 3; a++) volume_m3 *= np_transport_grid_length(&grid, a);
  out->volume_m3 = volume_m3;
  np_transport_grid_clear(&grid);
  return NEPH_OK;
}

neph_result np_scattering_desc_add_to_hash(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                                           np_hash *hash) {
  np_transport_grid grid;
  neph_result result = np_transport_grid_place(context, world, &desc->cells, &grid);
  if (result) return result;
  for (int a = 0; a < 3; a++) np_hash_add(hash, grid.edge_m[a], ((size_t)grid.size[a] + 1) * sizeof *grid.edge_m[a]);
  NP_HASH_ADD(hash, desc->work_max);
  NP_HASH_ADD(hash, desc->degree_max);
  NP_HASH_ADD(hash, desc->tolerance);
  NP_HASH_ADD(hash, desc->has_importance);
  np_transport_grid_clear(&grid);
  return NEPH_OK;
}
