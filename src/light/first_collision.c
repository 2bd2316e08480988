/* SPDX-License-Identifier: Apache-2.0 */
/* Where sunlight first collides.
 *
 * A cell's source is even in it, while sunlight collides first on the side of the cell that the sun shines on: what is
 * thrown back from there has less cloud before it. So the first moments of what a cell takes are counted too, and a
 * share goes over to the neighbours, such that the centre of all that is taken stays where it is. Without that clouds
 * that are seen from where the sun stands are too dark, by as much as the cells are large. */
#include "core/alloc.h"
#include "light/transport_grid.h"

/* What a cell takes, in whole units of 2⁻³²: sums of integers come out the same in any order, whatever thread adds
 * them. The moments are about the cell's middle, over its widths. */
typedef struct loss {
  int64_t sum, moment[3];
} loss;

/* One scaled medium that the rays cross. */
typedef struct medium {
  float scale[NP_VIEW_VOLUMES_MAX]; /* scaled extinction of each cloud over its extinction */
  loss *losses;                     /* of each live cell, of one face's rays */
  float *power;                     /* what each live cell takes of a unit irradiance, m² */
  float *moment;                    /* [live][axis]: the same over the cell's width */
} medium;

enum { MEDIA = 2 };

/* What the second medium lets through beyond the first in a live cell, times the length of ray that is lit by it, and
 * that length, in units of a loss times the longest step; the same of all faces' rays in m³. */
typedef struct surplus {
  int64_t sum, length;
  double volume, of_volume;
} surplus;

/* Parallel rays start on every face that the sun shines on, at low-discrepancy points, each for an equal area. */
typedef struct sun_rays {
  const np_scene_view *view;
  np_monitor *monitor;
  np_transport_grid *grid;
  medium media[MEDIA];
  unsigned media_count;
  surplus *surpluses;  /* of each live cell; NULL: there is one medium */
  double direction[3]; /* of flight */
  double step_m;       /* the longest */
  int face_axis;
  size_t first[4]; /* ray number at which each face begins */
} sun_rays;

enum { RAYS_PER_CELL_EDGE = 3 };

static size_t count_face_rays(const np_transport_grid *g, int axis, const double direction[3]) {
  if (g->is_wrapped[axis]) return 0;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const double cells = (double)g->size[b] * (double)g->size[c] * fabs(direction[axis]);
  const double least = g->size[b] == 1 || g->size[c] == 1 ? 64.0 : 1.0;
  return fabs(direction[axis]) < 1e-6 ? 0 : (size_t)fmax(ceil(cells * RAYS_PER_CELL_EDGE * RAYS_PER_CELL_EDGE), least);
}

/* Live cell of a position, and where in it that is, from its middle over its widths. */
static int32_t locate(const np_transport_grid *g, const double p[3], double out_offset[3]) {
  int32_t at[3];
  for (int a = 0; a < 3; a++) {
    at[a] = np_transport_grid_locate(g, a, p[a]);
    if (at[a] == g->size[a] && g->is_wrapped[a]) at[a] = 0;
    if (at[a] < 0 || at[a] >= g->size[a]) return NP_TRANSPORT_CELL_NONE;
    const double from_middle = np_transport_grid_wrap(g, a, p[a]) - np_transport_grid_middle(g, a, at[a]);
    out_offset[a] = np_clamp(from_middle / np_transport_grid_width(g, a, at[a]), -0.5, 0.5);
  }
  return g->live[np_transport_grid_join(g, at)];
}

static double find_exit(const np_transport_grid *g, const double p[3], const double d[3]) {
  double exit = INFINITY;
  for (int a = 0; a < 3; a++) {
    if (g->is_wrapped[a] || fabs(d[a]) < 1e-12) continue;
    const double plane = g->edge_m[a][d[a] > 0.0 ? g->size[a] : 0];
    exit = fmin(exit, (plane - p[a]) / d[a]);
  }
  return exit;
}

/* A step from `t` on; where cells differ, no longer than half of one. */
static double find_step(const sun_rays *r, const double start[3], double t) {
  const np_transport_grid *g = r->grid;
  double step = r->step_m;
  for (int a = 0; a < 3; a++) {
    if (g->even_m[a] > 0.0 || fabs(r->direction[a]) < 1e-9) continue;
    const int32_t at = np_transport_grid_locate(g, a, start[a] + t * r->direction[a]);
    const int32_t inside = at < 0 ? 0 : at < g->size[a] ? at : g->size[a] - 1;
    step = fmin(step, 0.5 * np_transport_grid_width(g, a, inside) / fabs(r->direction[a]));
  }
  return step;
}

static void count_loss(const medium *m, const np_transport_grid *g, int32_t live, const double offset[3], double lost) {
  loss *l = &m->losses[live];
  (void)__atomic_fetch_add(&l->sum, (int64_t)(lost + 0.5), __ATOMIC_RELAXED);
  for (int a = 0; a < 3; a++)
    if (g->size[a] > 1) (void)__atomic_fetch_add(&l->moment[a], (int64_t)(offset[a] * lost), __ATOMIC_RELAXED);
}

/* Of a step that is a share of the longest: what the second medium has left beyond the first in its middle. */
static void count_surplus(const sun_rays *r, int32_t live, double share, double beyond, double weight) {
  surplus *s = &r->surpluses[live];
  if (beyond > 0.0) (void)__atomic_fetch_add(&s->sum, (int64_t)(beyond * share), __ATOMIC_RELAXED);
  (void)__atomic_fetch_add(&s->length, (int64_t)(weight * 0x1p32 * share), __ATOMIC_RELAXED);
}

/* What the media take from a step around `p`; `power` is what is left of the ray in each. */
static void cross_step(const sun_rays *r, const double p[3], double h, double weight, double power[MEDIA]) {
  double depth[MEDIA] = {0.0}, middle[MEDIA] = {power[0], power[1]}, offset[3];
  const np_dvec3 position = np_dvec3_make(p[0], p[1], p[2]);
  for (unsigned v = 0; v < r->view->volume_count; v++) {
    const double own = h * (double)np_view_extinction(&r->view->volumes[v], position);
    for (unsigned m = 0; m < r->media_count; m++) depth[m] += own * (double)r->media[m].scale[v];
  }
  const bool is_lost = depth[0] > 0.0;
  if (!is_lost && !r->surpluses) return;
  const int32_t live = locate(r->grid, p, offset);
  if (live < 0) return;
  for (unsigned m = 0; m < r->media_count && is_lost; m++) {
    const double lost = -expm1(-depth[m]) * power[m];
    count_loss(&r->media[m], r->grid, live, offset, lost);
    middle[m] -= 0.5 * lost;
    power[m] -= lost;
  }
  if (r->surpluses) count_surplus(r, live, h / r->step_m, middle[1] - middle[0], weight);
}

/* `weight` is the ray's area over that of a cell's share in the units. */
static void follow_ray(const sun_rays *r, const double start[3], double weight) {
  const double exit = find_exit(r->grid, start, r->direction);
  double power[MEDIA] = {weight * 0x1p32, r->media_count > 1 ? weight * 0x1p32 : 0.0};
  double t = 0.0;
  while (t < exit && fmax(power[0], power[1]) > weight * 0x1p14) {
    const double h = fmin(find_step(r, start, t), exit - t), middle = t + 0.5 * h;
    t += h;
    cross_step(r,
               (const double[3]){start[0] + middle * r->direction[0], start[1] + middle * r->direction[1],
                                 start[2] + middle * r->direction[2]},
               h, weight, power);
  }
}

static double fraction(double x) { return x - floor(x); }

static double find_length(const np_transport_grid *g, int axis) {
  return g->edge_m[axis][g->size[axis]] - g->edge_m[axis][0];
}

static void start_ray(const sun_rays *r, int axis, size_t number, size_t count) {
  const np_transport_grid *g = r->grid;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  double start[3];
  start[axis] = g->edge_m[axis][r->direction[axis] < 0.0 ? g->size[axis] : 0];
  start[b] = g->edge_m[b][0] + fraction(0.5 + 0.7548776662466927 * (double)number) * find_length(g, b);
  start[c] = g->edge_m[c][0] + fraction(0.5 + 0.5698402909980532 * (double)number) * find_length(g, c);
  const double face_cells = (double)g->size[b] * (double)g->size[c];
  /* Irradiance on the face times area, over the mean area of a cell's face. */
  follow_ray(r, start, fabs(r->direction[axis]) * face_cells / (double)count);
}

static neph_result follow_rays(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sun_rays *r = user;
  for (size_t number = begin; number < end; number++) {
    if (np_monitor_is_cancelled(r->monitor)) return NEPH_ERROR_CANCELLED;
    start_ray(r, r->face_axis, number, r->first[r->face_axis]);
  }
  return NEPH_OK;
}

static double find_volume(const np_transport_grid *g, int32_t cell) {
  int32_t at[3];
  double volume = 1.0;
  np_transport_grid_split(g, cell, at);
  for (int a = 0; a < 3; a++) volume *= np_transport_grid_width(g, a, at[a]);
  return volume;
}

/* Between the middles of neighbours, also through a wrapped side. */
static double find_distance(const np_transport_grid *g, int axis, size_t a, int32_t b) {
  int32_t first[3], second[3];
  np_transport_grid_split(g, g->cell[a], first);
  np_transport_grid_split(g, g->cell[b], second);
  return 0.5 * (np_transport_grid_width(g, axis, first[axis]) + np_transport_grid_width(g, axis, second[axis]));
}

/* Adds what one face's rays leave behind. */
static neph_result light_face(sun_rays *r, int axis) {
  const np_transport_grid *g = r->grid;
  r->face_axis = axis;
  r->first[axis] = count_face_rays(g, axis, r->direction);
  neph_result result = np_parallel_for(g->context, r->monitor, r->first[axis], 256, follow_rays, r);
  if (result) return result;
  double unit = 0x1p-32;
  for (int a = 0; a < 3; a++) unit *= a == axis ? 1.0 : find_length(g, a) / g->size[a];
  for (size_t live = 0; live < g->live_count && r->surpluses; live++) {
    surplus *s = &r->surpluses[live];
    s->volume += unit * r->step_m * (double)s->sum;
    s->of_volume += unit * r->step_m * (double)s->length;
    s->sum = s->length = 0;
  }
  for (unsigned m = 0; m < r->media_count; m++)
    for (size_t live = 0; live < g->live_count; live++) {
      loss *l = &r->media[m].losses[live];
      r->media[m].power[live] += (float)((double)l->sum * unit);
      for (int a = 0; a < 3; a++) r->media[m].moment[3 * live + a] += (float)((double)l->moment[a] * unit);
      *l = (loss){0};
    }
  return NEPH_OK;
}

/* Moves a first moment of `moment`, in `width`, along an axis of a cell into its neighbours: half of it from the one to
 * the other, as far as there is something to give, the rest out of the cell itself. */
static void shift_along(const np_transport_grid *g, size_t live, int axis, double moment, const float *power,
                        float *deposit) {
  int32_t at[3];
  np_transport_grid_split(g, g->cell[live], at);
  const int step = moment > 0.0 ? 1 : -1;
  const int32_t to = np_transport_grid_neighbour(g, at, axis, step);
  const int32_t from = np_transport_grid_neighbour(g, at, axis, -step);
  if (to < 0 || from < 0) return;
  const double wanted = fabs(moment) * np_transport_grid_width(g, axis, at[axis]);
  const double ahead = find_distance(g, axis, live, to), behind = find_distance(g, axis, live, from);
  const double across = fmin(wanted / (ahead + behind), (double)power[from] / 8.0);
  const double out = np_clamp((wanted - across * (ahead + behind)) / ahead, 0.0, 0.25 * (double)power[live]);
  deposit[from] -= (float)across;
  deposit[live] -= (float)out;
  deposit[to] += (float)(across + out);
}

/* From what each cell took to the source per volume. */
static void spread(const np_transport_grid *g, const medium *m, float *deposit) {
  for (size_t live = 0; live < g->live_count; live++) deposit[live] = m->power[live];
  for (size_t live = 0; live < g->live_count; live++)
    for (int a = 0; a < 3; a++)
      if (m->moment[3 * live + a] != 0.0f) shift_along(g, live, a, (double)m->moment[3 * live + a], m->power, deposit);
  for (size_t live = 0; live < g->live_count; live++)
    deposit[live] = fmaxf(0.0f, deposit[live]) / (float)find_volume(g, g->cell[live]);
}

static neph_result start_medium(sun_rays *r, np_transport_grid *grid) {
  medium *m = &r->media[r->media_count++];
  neph_context *context = r->grid->context;
  const size_t count = r->grid->live_count;
  for (unsigned v = 0; v < r->view->volume_count; v++) m->scale[v] = grid->scale[v];
  m->losses = np_alloc(context, count, sizeof *m->losses);
  m->power = np_alloc(context, count, sizeof *m->power);
  m->moment = np_alloc(context, count, 3 * sizeof *m->moment);
  grid->deposit = np_alloc(context, count, sizeof *grid->deposit);
  return m->losses && m->power && m->moment && grid->deposit ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result start_surpluses(sun_rays *r, np_transport_grid *grid) {
  r->surpluses = np_alloc(grid->context, grid->live_count, sizeof *r->surpluses);
  grid->narrow = np_alloc(grid->context, grid->live_count, sizeof *grid->narrow);
  return r->surpluses && grid->narrow ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void keep_surpluses(const sun_rays *r, np_transport_grid *grid) {
  for (size_t live = 0; live < grid->live_count && r->surpluses; live++) {
    const surplus *s = &r->surpluses[live];
    grid->narrow[live] = s->of_volume > 0.0 ? (float)(s->volume / s->of_volume) : 0.0f;
  }
}

static void clear_medium(const np_transport_grid *g, medium *m) {
  np_alloc_free(g->context, m->losses);
  np_alloc_free(g->context, m->power);
  np_alloc_free(g->context, m->moment);
}

static void find_direction(sun_rays *r, np_vec3 to_sun, double length) {
  r->direction[0] = -(double)to_sun.x / length;
  r->direction[1] = -(double)to_sun.y / length;
  r->direction[2] = -(double)to_sun.z / length;
  r->step_m = INFINITY;
  for (int a = 0; a < 3; a++) {
    r->step_m = fmin(r->step_m, 0.75 * np_transport_find_voxel(r->view, a));
    if (!r->grid->is_wrapped[a] && r->grid->even_m[a] > 0.0) r->step_m = fmin(r->step_m, 0.5 * r->grid->even_m[a]);
  }
}

neph_result np_transport_grid_light(const np_scene_view *view, np_monitor *monitor, np_transport_grid *grid,
                                    np_transport_grid *broad) {
  sun_rays r = {.view = view, .monitor = monitor, .grid = grid};
  const double length = (double)np_vec3_length(view->to_sun);
  if (!(length > 0.0)) return NEPH_OK;
  find_direction(&r, view->to_sun, length);
  neph_result result = start_medium(&r, grid);
  if (!result && broad) result = start_medium(&r, broad);
  if (!result && broad) result = start_surpluses(&r, grid);
  for (int axis = 0; axis < 3 && !result; axis++) result = light_face(&r, axis);
  if (!result) spread(grid, &r.media[0], grid->deposit);
  if (!result && broad) spread(grid, &r.media[1], broad->deposit);
  if (!result) keep_surpluses(&r, grid);
  for (unsigned m = 0; m < r.media_count; m++) clear_medium(grid, &r.media[m]);
  np_alloc_free(grid->context, r.surpluses);
  return result;
}
