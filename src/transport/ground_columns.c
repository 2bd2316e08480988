/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/ground_columns.h"
#include "transport/scattering_field.h"

#include "core/alloc.h"

/* Share of a cell's height above which ground fills it: of 1/2, 3/4 and 1 the one that agrees best with paths over
 * three landscapes of ridges with fog, −0.8 % against −7 and +4 % at cells of 120 m (docs/transport.md). */
static const double solid_share = 0.75;

typedef struct column_fill {
  const np_world *world;
  const np_sun_optical_depth_source *depths;
  const float *fade;
  np_transport_grid *grid; /* grid whose cells are buried */
  const np_transport_grid *solid;
  bool *holds;
  np_ground_columns *out;
} column_fill;

/* Intersects the ground below a column's middle. */
static bool intersect_down(const np_world *world, const np_transport_grid *g, size_t column, np_ground_hit *hit) {
  const int32_t i = (int32_t)(column % (size_t)g->size[0]), j = (int32_t)(column / (size_t)g->size[0]);
  const double top = g->edge_m[2][g->size[2]], summit = world->terrain ? world->terrain_max.z : top;
  const np_dvec3 from =
      np_dvec3_make(np_transport_grid_middle(g, 0, i), np_transport_grid_middle(g, 1, j), fmax(top, summit) + 1.0);
  return np_world_intersect_ground(world, from, np_vec3_make(0.0f, 0.0f, -1.0f), hit);
}

/* Height of the highest ground, −∞: there is none that the cells' columns stand on. Hills are not periodic. */
static double get_ground_top(const np_world *world, const np_transport_grid *g) {
  if (world->terrain) return g->is_wrapped[0] || g->is_wrapped[1] ? -(double)INFINITY : world->terrain_max.z;
  return world->has_planet ? 0.0 : -(double)INFINITY;
}

/* Whether ground is closer below a column's cells than the cells are wide. It is then lit column by column: the
 * border's nodes are too far apart for its shadows. */
static bool is_near(const np_transport_grid *g, double height_m, double width_m) {
  return height_m >= g->edge_m[2][0] - width_m;
}

static neph_result mark_solid_columns(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const column_fill *f = user;
  const np_transport_grid *g = f->grid;
  const size_t layer = (size_t)g->size[0] * (size_t)g->size[1];
  for (size_t column = begin; column < end; column++) {
    np_ground_hit hit;
    if (!intersect_down(f->world, g, column, &hit)) continue;
    for (int32_t k = 0; k < g->size[2]; k++) {
      const double low = g->edge_m[2][k], height = np_transport_grid_width(g, 2, k);
      if (low + solid_share * height >= hit.position.z) break;
      g->active[(size_t)k * layer + column] = NP_TRANSPORT_CELL_SOLID;
      f->holds[(size_t)k * layer + column] = false;
    }
  }
  return NEPH_OK;
}

neph_result np_ground_columns_bury(const np_world *world, np_monitor *monitor, np_transport_grid *grid, bool *holds) {
  double widest_m = 0.0;
  for (int32_t i = 0; i < grid->size[0]; i++) widest_m = fmax(widest_m, np_transport_grid_width(grid, 0, i));
  grid->has_ground = is_near(grid, get_ground_top(world, grid), widest_m);
  if (!grid->has_ground || grid->is_wrapped[0] || grid->is_wrapped[1]) return NEPH_OK;
  column_fill f = {.world = world, .grid = grid, .holds = holds};
  const size_t columns = (size_t)grid->size[0] * (size_t)grid->size[1];
  return np_parallel_for(grid->context, monitor, columns, 64, mark_solid_columns, &f);
}

static neph_result light_columns(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const column_fill *f = user;
  const np_transport_grid *g = f->solid;
  for (size_t column = begin; column < end; column++) {
    np_ground_column *out = &f->out->at[column];
    np_ground_hit hit;
    out->is_near = intersect_down(f->world, g, column, &hit) &&
                   is_near(g, hit.position.z, np_transport_grid_width(g, 0, (int32_t)column % g->size[0]));
    if (out->is_near)
      out->clear = np_boundary_radiance_light_column(f->world, f->depths, f->fade, &hit, &out->glint, &out->gain);
  }
  return NEPH_OK;
}

neph_result np_ground_columns_fill(const np_transport_grid *grid, const np_world *world,
                                   const np_sun_optical_depth_source *depths, const float *fade, np_monitor *monitor,
                                   np_ground_columns *out) {
  *out = (np_ground_columns){.size = {grid->size[0], grid->size[1]}};
  if (!grid->has_ground) return NEPH_OK;
  const size_t columns = (size_t)grid->size[0] * (size_t)grid->size[1];
  out->at = np_alloc(grid->context, columns, sizeof *out->at);
  column_fill f = {.world = world, .depths = depths, .fade = fade, .solid = grid, .out = out};
  if (!out->at) return NEPH_ERROR_OUT_OF_MEMORY;
  return np_parallel_for(grid->context, monitor, columns, 64, light_columns, &f);
}

void np_ground_columns_clear(neph_context *context, np_ground_columns *columns) {
  np_alloc_free(context, columns->at);
  *columns = (np_ground_columns){0};
}

/* Averages the columns with ground into each column of a coarser grid. */
void np_ground_columns_get(const np_ground_columns *columns, const np_border *border, unsigned band,
                           const np_outflow *outflow, const np_transport_grid *grid, np_column_light *out) {
  const int32_t *fine = columns->size, *size = grid->size;
  const int32_t wide[2] = {fine[0] / size[0], fine[1] / size[1]};
  for (int32_t j = 0; j < size[1]; j++)
    for (int32_t i = 0; i < size[0]; i++) {
      const int32_t u = i * NP_BORDER_PLAN / size[0], v = j * NP_BORDER_PLAN / size[1];
      const float excess =
          outflow ? np_border_compute_excess(border, band, NP_BORDER_DOWN, v, u, outflow->way[NP_BORDER_DOWN][v][u])
                  : 0.0f;
      float even = 0.0f, glint = 0.0f, count = 0.0f;
      for (int32_t n = 0; n < wide[0] * wide[1]; n++) {
        const size_t at = (size_t)(j * wide[1] + n / wide[0]) * (size_t)fine[0] + (size_t)(i * wide[0] + n % wide[0]);
        const np_ground_column *column = &columns->at[at];
        if (!column->is_near) continue;
        even += fmaxf(0.0f, column->clear.band[band] + column->gain.band[band] * excess);
        glint += column->glint.band[band];
        count += 1.0f;
      }
      out[(size_t)j * (size_t)size[0] + (size_t)i] =
          count > 0.0f ? (np_column_light){even / count, glint / count} : (np_column_light){-1.0f, 0.0f};
    }
}
