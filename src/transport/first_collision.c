/* SPDX-License-Identifier: Apache-2.0 */
/* First collisions of sunlight.
 *
 * A cell's source is even in it, while sunlight collides first on the side of the cell that the sun shines on: what is
 * scattered back from there has less cloud before it. So the first moments of what a cell takes are counted too, and a
 * share goes over to the neighbours, such that the centre of all that is taken stays where it is. Without that clouds
 * that are seen from where the sun stands are too dark, by as much as the cells are large. */
#include "core/alloc.h"
#include "core/isa.h"
#include "transport/first_collision.h"

/* Points along an edge of a cell; fewer suffice where cells are no larger than voxels. */
enum { RAYS_PER_EDGE = 3, RAYS_PER_FINE_EDGE = 2 };

neph_result np_first_rays_follow_v1(void *, size_t, size_t, unsigned);
neph_result np_first_rays_follow_v3(void *, size_t, size_t, unsigned);
neph_result np_first_rays_follow_v4(void *, size_t, size_t, unsigned);

static np_parallel_fn get_kernel(const neph_context *context) {
  static const np_parallel_fn kernels[NP_ISA_COUNT] = {np_first_rays_follow_v1, np_first_rays_follow_v3,
                                                       np_first_rays_follow_v4};
  return kernels[neph_context_get_isa(context)];
}

static double compute_sine(const np_first_rays *r, int axis) {
  return sqrt(fmax(0.0, 1.0 - r->direction[axis] * r->direction[axis]));
}

/* Number of rays along a side of the face, in proportion to its cells, with the same spacing perpendicular to the sun's
 * direction along both sides; a single cell gets 8 at least. */
static size_t count_along(const np_first_rays *r, int axis, int other) {
  const int32_t size = r->grid->used[axis];
  const double stretch = compute_sine(r, axis) / fmax(compute_sine(r, other), 1e-6);
  const int per_edge = r->grid->is_fine ? RAYS_PER_FINE_EDGE : RAYS_PER_EDGE;
  const double density = per_edge * sqrt(fabs(r->direction[r->face_axis]) * stretch);
  return (size_t)fmax(ceil((double)size * density), size == 1 ? 8.0 : 1.0);
}

static double compute_volume(const np_transport_grid *g, int32_t cell) {
  int32_t at[3];
  double volume = 1.0;
  np_transport_grid_split(g, cell, at);
  for (int a = 0; a < 3; a++) volume *= np_transport_grid_width(g, a, at[a]);
  return volume;
}

/* Between the middles of neighbours, also through a wrapped side. */
static double compute_distance(const np_transport_grid *g, int axis, size_t a, int32_t b) {
  int32_t first[3], second[3];
  np_transport_grid_split(g, g->cell[a], first);
  np_transport_grid_split(g, g->cell[b], second);
  return 0.5 * (np_transport_grid_width(g, axis, first[axis]) + np_transport_grid_width(g, axis, second[axis]));
}

/* Traces the rays of one face, and adds their losses to the cells. */
static neph_result light_face(np_first_rays *r, int axis) {
  const np_transport_grid *g = r->grid;
  const int across = (axis + 1) % 3, along = (axis + 2) % 3;
  if (g->is_wrapped[axis] || fabs(r->direction[axis]) < 1e-6) return NEPH_OK;
  r->face_axis = axis;
  r->columns = count_along(r, across, along);
  r->rows = count_along(r, along, across);
  neph_result result = np_parallel_for(g->context, r->monitor, r->rows * r->columns, 256, get_kernel(g->context), r);
  if (result) return result;
  double unit = 0x1p-32;
  for (int a = 0; a < 3; a++)
    unit *= a == axis ? 1.0 : (np_transport_grid_get_end(g, a) - g->edge_m[a][0]) / g->used[a];
  for (size_t active = 0; active < g->active_count && r->surpluses; active++) {
    np_first_surplus *s = &r->surpluses[active];
    s->volume += unit * r->step_m * (double)s->sum;
    s->of_volume += unit * r->step_m * (double)s->length;
    s->sum = s->length = 0;
  }
  for (unsigned m = 0; m < r->media_count; m++)
    for (size_t active = 0; active < g->active_count; active++) {
      np_first_loss *l = &r->media[m].losses[active];
      r->media[m].power[active] += (float)((double)l->sum * unit);
      for (int a = 0; a < 3; a++) r->media[m].moment[3 * active + a] += (float)((double)l->moment[a] * unit);
      *l = (np_first_loss){0};
    }
  return NEPH_OK;
}

/* Shifts the first moment of a cell's power along an axis to its neighbours: half is taken from one neighbour and given
 * to the other, as far as there is power, the rest is taken from the cell. */
static void shift_along(const np_transport_grid *g, size_t active, int axis, double moment, const float *power,
                        float *first_collision_source) {
  int32_t at[3];
  np_transport_grid_split(g, g->cell[active], at);
  const int step = moment > 0.0 ? 1 : -1;
  const int32_t to = np_transport_grid_neighbour(g, at, axis, step);
  const int32_t from = np_transport_grid_neighbour(g, at, axis, -step);
  if (to < 0 || from < 0) return;
  const double wanted = fabs(moment) * np_transport_grid_width(g, axis, at[axis]);
  const double ahead = compute_distance(g, axis, active, to), behind = compute_distance(g, axis, active, from);
  const double across = fmin(wanted / (ahead + behind), (double)power[from] / 8.0);
  const double out = np_clamp((wanted - across * (ahead + behind)) / ahead, 0.0, 0.25 * (double)power[active]);
  first_collision_source[from] -= (float)across;
  first_collision_source[active] -= (float)out;
  first_collision_source[to] += (float)(across + out);
}

/* Converts power to power per volume, after shifting it between cells by its moments. */
static void spread(const np_transport_grid *g, const np_first_medium *m, float *first_collision_source) {
  for (size_t active = 0; active < g->active_count; active++) first_collision_source[active] = m->power[active];
  for (size_t active = 0; active < g->active_count; active++)
    for (int a = 0; a < 3; a++)
      if (m->moment[3 * active + a] != 0.0f)
        shift_along(g, active, a, (double)m->moment[3 * active + a], m->power, first_collision_source);
  for (size_t active = 0; active < g->active_count; active++)
    first_collision_source[active] =
        fmaxf(0.0f, first_collision_source[active]) / (float)compute_volume(g, g->cell[active]);
}

static neph_result start_medium(np_first_rays *r, float **out_deposit) {
  np_first_medium *m = &r->media[r->media_count++];
  neph_context *context = r->grid->context;
  const size_t count = r->grid->active_count;
  m->losses = np_alloc(context, count, sizeof *m->losses);
  m->power = np_alloc(context, count, sizeof *m->power);
  m->moment = np_alloc(context, count, 3 * sizeof *m->moment);
  *out_deposit = np_alloc(context, count, sizeof **out_deposit);
  return m->losses && m->power && m->moment && *out_deposit ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Sets the scales of the two media: of the grid's degree, and of the lower degree. */
static void compute_scales(np_first_rays *r, unsigned band, unsigned broad_degree) {
  for (unsigned v = 0; v < r->world->clouds.count; v++) {
    const np_instance *volume = &r->world->clouds.at[v];
    r->media[0].scale[v] = r->grid->scale[v];
    r->media[1].scale[v] =
        np_transport_scale(volume, np_scaled_phase_compute_forward(&volume->phase, broad_degree), band);
  }
}

static neph_result start_surpluses(np_first_rays *r, np_transport_grid *grid) {
  r->surpluses = np_alloc(grid->context, grid->active_count, sizeof *r->surpluses);
  grid->delta_m_residual = np_alloc(grid->context, grid->active_count, sizeof *grid->delta_m_residual);
  return r->surpluses && grid->delta_m_residual ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void store_surpluses(const np_first_rays *r, np_transport_grid *grid) {
  for (size_t active = 0; active < grid->active_count && r->surpluses; active++) {
    const np_first_surplus *s = &r->surpluses[active];
    grid->delta_m_residual[active] = s->of_volume > 0.0 ? (float)(s->volume / s->of_volume) : 0.0f;
  }
}

static void clear_medium(const np_transport_grid *g, np_first_medium *m) {
  np_alloc_free(g->context, m->losses);
  np_alloc_free(g->context, m->power);
  np_alloc_free(g->context, m->moment);
}

/* Sets direction and step length: a step is at most a voxel long, but at least an eighth of a cell, since only means
 * over cells are needed. */
static void set_direction(np_first_rays *r, np_vec3 to_sun, double length) {
  r->direction[0] = -(double)to_sun.x / length;
  r->direction[1] = -(double)to_sun.y / length;
  r->direction[2] = -(double)to_sun.z / length;
  double even_m = INFINITY;
  r->step_m = INFINITY;
  r->has_even_steps = true;
  for (int a = 0; a < 3; a++) {
    r->has_even_steps = r->has_even_steps && r->grid->even_m[a] > 0.0;
    r->step_m = fmin(r->step_m, 0.75 * np_transport_get_voxel(r->world, a));
    if (!r->grid->is_wrapped[a] && r->grid->even_m[a] > 0.0) even_m = fmin(even_m, r->grid->even_m[a]);
  }
  if (r->has_even_steps && isfinite(even_m)) r->step_m = fmax(r->step_m, 0.125 * even_m);
  r->step_m = fmin(r->step_m, 0.5 * even_m);
}

neph_result np_transport_grid_light(const np_world *world, const np_sun_optical_depth_source *depths,
                                    np_monitor *monitor, unsigned band, unsigned broad_degree,
                                    np_transport_grid *grid) {
  np_first_rays r = {
      .world = world, .depths = grid->fold.period_m > 0.0 ? depths : NULL, .monitor = monitor, .grid = grid};
  const double length = (double)np_vec3_length(world->to_sun);
  const bool has_broad = broad_degree < grid->degree;
  if (!(length > 0.0)) return NEPH_OK;
  set_direction(&r, world->to_sun, length);
  compute_scales(&r, band, broad_degree);
  neph_result result = start_medium(&r, &grid->first_collision_source);
  if (!result && has_broad) result = start_medium(&r, &grid->low_order_source);
  if (!result && has_broad) result = start_surpluses(&r, grid);
  for (int axis = 0; axis < 3 && !result; axis++) {
    np_monitor_set_range(monitor, axis / 3.0, (axis + 1) / 3.0);
    result = light_face(&r, axis);
  }
  if (!result) spread(grid, &r.media[0], grid->first_collision_source);
  if (!result && has_broad) spread(grid, &r.media[1], grid->low_order_source);
  if (!result) store_surpluses(&r, grid);
  for (unsigned m = 0; m < r.media_count; m++) clear_medium(grid, &r.media[m]);
  np_alloc_free(grid->context, r.surpluses);
  return result;
}
