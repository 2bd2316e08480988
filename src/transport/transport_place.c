/* SPDX-License-Identifier: Apache-2.0 */
/* Placement of the cells of the multiple scattering.
 *
 * Their error grows with x = (1−g)·σ·edge, to some 2 % at 0.3 and 4 % at 1, so the densest cloud decides their size;
 * two voxels at least, since the field's own detail ends there, unless a single voxel is thicker than that, one voxel
 * to a cell costs almost nothing, or the picture is so large that it shows what two lack. However deep the clouds,
 * cells end at one voxel, in small files, and in larger ones with detail finer than voxels, at half of one: the light
 * of a deeper cell errs by the depth at which it is lit (np_transport_grid_compute_lit_depth), which soft edges keep
 * small.
 *
 * A flat cloud, an eighth as thick as its box is wide or less, gets cells of less height, since its light changes from
 * top to base: eight to its thickness, down to half a voxel. Where such a cell is too deep, a deck's thin places let
 * half of the light through that they should send back: heights are halved as long as cells are few.
 *
 * Where the memory does not allow as many, cells grow with their distance from the viewer, by planes along each axis:
 * what is far is seen small. No more than eightfold; what is still too many makes all larger.
 *
 * A layer without end that is the same everywhere is a single column of cells. Light that comes in through its faces
 * is spent in a depth of about one, however thick the layer: cells are thin at the faces and grow with the depth from
 * them, so that a layer of depth 10⁶ takes some 300.
 */
#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "transport/thickness.h"
#include "transport/transport_grid.h"
#include "volume/instance_period.h"

/* Cell counts are multiples of this, so that three coarser grids fit. */
enum { COARSEST = 8 };

/* ---- What the clouds are like ---- */

static bool is_wrapped_along(const np_world *world, int axis, np_light_period *out_period) {
  *out_period = np_instances_get_light_period(&world->clouds, axis);
  return out_period->length_m > 0.0;
}

bool np_transport_is_single(const np_world *world, int axis) {
  np_light_period period;
  return is_wrapped_along(world, axis, &period) && period.length_m <= 1.001 * np_transport_get_voxel(world, axis);
}

double np_transport_compute_extinction(const np_world *world) {
  double densest = 0.0;
  for (unsigned v = 0; v < world->clouds.count; v++) {
    const np_instance *volume = &world->clouds.at[v];
    const double extinction = (double)(volume->bricks->value_max * volume->extinction_per_value);
    densest = fmax(densest, (1.0 - fmax(0.0, np_phase_mean_cosine(&volume->phase))) * extinction);
  }
  return densest;
}

/* Limit on the ratio of voxel edges: light leaves elongated voxels by the shortest way. */
static const double stretch_max = 4.0;

double np_transport_get_stretch(const np_world *world) {
  double shortest = INFINITY, longest = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    if (np_transport_is_single(world, axis)) continue;
    const double voxel = np_transport_get_voxel(world, axis);
    shortest = fmin(shortest, voxel);
    longest = fmax(longest, voxel);
  }
  return longest > 0.0 ? fmin(1.0, stretch_max * shortest / longest) : 1.0;
}

/* Edges of cells in voxels: across, and in height. */
typedef struct cell_edges {
  double across, height;
} cell_edges;

/* Optical depth over that of the deepest allowed cell, beyond which cells are halved. */
static const double deepest = 3.5;
/* The same of heights of flat cells that are few. */
static const double deepest_flat = 0.6;

/* Cells to the typical thickness of a cloud, and the least height of one in voxels, and where the cloud is deep. */
static const double cells_per_thickness = 8.0, height_min = 0.5, deep_height_min = 1.0 / 16.0;

/* Heights of cells for clouds of a thickness in voxels, where they are `edge` across. */
static cell_edges flatten(double edge, double thickness) {
  const double height = np_clamp(thickness / cells_per_thickness, height_min, fmax(edge, height_min));
  return (cell_edges){edge, fmin(edge, height)};
}

/* ---- Even cells ---- */

typedef struct even_axis {
  int32_t size, used; /* number of cells, and of the ones that clouds need; the others pad the count, and are thin */
  double origin_m, edge_m;
  bool is_wrapped;
  double repeat_m; /* length of the end that stands for all beyond; 0: the whole axis */
} even_axis;

/* One axis, with cells of `edge_voxels`: lines of cells on samples of the first cloud, one empty cell at either end,
 * and a count that three coarser grids divide; of clouds that repeat, as many periods as that count takes. Where they
 * do not change, one cell as wide as a brick. */
static even_axis compute_even_axis(const np_world *world, const np_transport_desc *desc, int axis, double edge_voxels) {
  const double low[3] = {desc->bounds_min.x, desc->bounds_min.y, desc->bounds_min.z};
  const double high[3] = {desc->bounds_max.x, desc->bounds_max.y, desc->bounds_max.z};
  const double voxel = np_transport_get_voxel(world, axis), edge = edge_voxels * voxel;
  const np_instance *first = &world->clouds.at[0];
  const int a = np_instance_get_index_axis(first, axis);
  const double base = a < 0 ? low[axis] : -first->world_to_index.m[a][3] / first->world_to_index.m[a][axis];
  np_light_period period;
  if (is_wrapped_along(world, axis, &period)) {
    const bool is_single = np_transport_is_single(world, axis), is_common = np_light_period_is_common(period);
    const double least_m = is_single ? NP_BRICK_EDGE * voxel : COARSEST * edge;
    const double length_m = period.length_m * fmax(ceil(0.999 * least_m / period.length_m), 1.0);
    const int32_t size = is_single ? 1 : (int32_t)(1.001 * length_m / edge) / COARSEST * COARSEST;
    return (even_axis){.size = size,
                       .used = size,
                       .origin_m = is_common ? base : base + floor((period.low_m - base) / voxel) * voxel,
                       .edge_m = length_m / size,
                       .is_wrapped = true,
                       .repeat_m = is_common ? 0.0 : period.repeat_m};
  }
  const double origin = base + floor((low[axis] - base) / voxel - 1.0) * voxel - edge;
  const double cells = ceil((high[axis] + voxel - origin) / edge) + 1.0;
  const int32_t size = (int32_t)fmin(ceil(cells / COARSEST) * COARSEST, 1e6);
  return (even_axis){.size = size, .used = (int32_t)fmin(cells, size), .origin_m = origin, .edge_m = edge};
}

static double compute_even_axes(const np_world *world, const np_transport_desc *desc, cell_edges edges,
                                even_axis out[3]) {
  double cells = 1.0;
  for (int axis = 0; axis < 3; axis++) {
    out[axis] = compute_even_axis(world, desc, axis, axis == 2 ? edges.height : edges.across);
    cells *= out[axis].size;
  }
  return cells;
}

/* (1−g)·σ over the longest edge of a voxel that counts; an axis of a single cell does not. */
static double compute_voxel_depth(const np_world *world) {
  double longest = 0.0;
  for (int axis = 0; axis < 3; axis++)
    if (!np_transport_is_single(world, axis)) longest = fmax(longest, np_transport_get_voxel(world, axis));
  return np_transport_compute_extinction(world) * np_transport_get_stretch(world) * longest;
}

static double round_edge(double edge) { return edge > 2.0 ? ceil(4.0 * edge) * 0.25 : edge; }

/* Larger by powers of √2 up to the least edge, so that a moving viewer seldom changes it; but no cell that is so thick
 * that its light is wrong by tens of per cent. */
static double enlarge_edge(const np_world *world, const np_transport_desc *desc, double edge) {
  static const double step = 1.41421356, thickest = 4.0;
  const double voxel = fmax(np_transport_get_voxel(world, 0), np_transport_get_voxel(world, 2));
  const double depth = compute_voxel_depth(world);
  while (step * edge * voxel <= desc->edge_min_m && step * edge * depth <= thickest * desc->cell_depth_max)
    edge *= step;
  return edge;
}

/* Voxels beyond which an edge does not grow further, however thin the clouds are: their shapes would be lost, but those
 * of clouds whose voxels are joined. */
static double get_edge_max(const np_world *world) {
  const np_instance *places = np_instances_get_places(&world->clouds);
  bool are_joined = true;
  for (unsigned v = 0; v < np_instances_count_places(&world->clouds); v++)
    are_joined = are_joined && np_bricks_count_joined(places[v].bricks) > 1.0;
  return are_joined ? 16.0 : 8.0;
}

static double count_even(const np_world *world, const np_transport_desc *desc, double edge) {
  even_axis axes[3];
  return compute_even_axes(world, desc, (cell_edges){edge, edge}, axes);
}

/* Whether cells are too deep, or, below a voxel, deeper than what they resolve, and few enough to be halved: no finer
 * than half a voxel, as a file holds nothing below a voxel, and the usual detail little below half of one. */
static bool is_halved(const np_world *world, const np_transport_desc *desc, double edge) {
  const double half = 0.5 * edge, depth = edge * compute_voxel_depth(world) / desc->cell_depth_max;
  if (half >= 1.0) return depth > deepest;
  const double few = (desc->has_detail ? 6.0 : 2.0) * (double)desc->cell_count_cheap;
  return depth > (desc->has_detail ? 1.0 : deepest) && count_even(world, desc, half) <= few;
}

static double halve_edge(const np_world *world, const np_transport_desc *desc, double edge) {
  while (edge > 0.5 && is_halved(world, desc, edge)) edge *= 0.5;
  return edge;
}

/* Number of cells whose solution costs little, compared with cells of the largest allowed optical depth. */
static double get_cheap_count(const np_transport_desc *desc) {
  static const double depth_usual = 0.35;
  const double coarse = fmax(1.0, desc->cell_depth_max / depth_usual);
  return (double)desc->cell_count_cheap / (coarse * coarse * coarse);
}

/* Edge in voxels that suits the clouds; within `cell_count_max` where there is no viewer. Light is not iterated on
 * cells of two voxels that are too deep, whatever a picture shows. */
static double choose_edge(const np_world *world, const np_transport_desc *desc, bool *out_is_fine) {
  const double voxel_depth = compute_voxel_depth(world), cells = count_even(world, desc, 1.0);
  *out_is_fine = cells > (double)desc->cell_count_cheap && cells <= (double)desc->cell_count_fine &&
                 2.0 * voxel_depth <= deepest * desc->cell_depth_max;
  const double edge_max = get_edge_max(world);
  double edge = cells <= (double)desc->cell_count_cheap || *out_is_fine ? 1.0 : 2.0;
  while (edge < edge_max && 1.5 * edge * voxel_depth <= 0.5 * desc->cell_depth_max &&
         count_even(world, desc, edge) > get_cheap_count(desc))
    edge *= 1.5;
  edge = halve_edge(world, desc, edge);
  const double enlarged = enlarge_edge(world, desc, edge);
  if (enlarged > edge) *out_is_fine = false;
  return enlarged;
}

/* ---- Graded cells ---- */

/* Cells grow with the distance from the viewer, in proportion beyond `near_m`: cells alike on the screen. */
typedef struct grading {
  const np_transport_desc *desc;
  double near_m; /* infinite: none grow */
  bool is_flat;  /* the clouds are */
} grading;

enum { GRADING_STEPS = 512, GRADING_MOST = 8 };

/* Distance of the viewer to the part of the clouds' box that has a coordinate along an axis. */
static double compute_distance(const np_transport_desc *desc, int axis, double coordinate) {
  const double low[3] = {desc->bounds_min.x, desc->bounds_min.y, desc->bounds_min.z};
  const double high[3] = {desc->bounds_max.x, desc->bounds_max.y, desc->bounds_max.z};
  const double at[3] = {desc->viewer.x, desc->viewer.y, desc->viewer.z};
  const double reach[3] = {desc->viewer_reach.x, desc->viewer_reach.y, desc->viewer_reach.z};
  double square = 0.0;
  for (int a = 0; a < 3; a++) {
    const double from = a == axis ? coordinate : low[a], to = a == axis ? coordinate : high[a];
    const double gap = fmax(fmax(from - (at[a] + reach[a]), at[a] - to), 0.0);
    square += gap * gap;
  }
  return sqrt(square);
}

/* Cumulative number of graded cells at each of GRADING_STEPS even steps along an axis; `out[GRADING_STEPS]` is the
 * total. */
static void count_graded(const grading *g, int axis, const even_axis *even, double out[GRADING_STEPS + 1]) {
  const double step = even->size * even->edge_m / GRADING_STEPS;
  out[0] = 0.0;
  for (int i = 0; i < GRADING_STEPS; i++) {
    const double distance = compute_distance(g->desc, axis, even->origin_m + (i + 0.5) * step);
    out[i + 1] = out[i] + step / even->edge_m / fmax(1.0, distance / g->near_m);
  }
}

static int32_t round_count(double cells) { return (int32_t)fmin(ceil(cells / COARSEST - 1e-6) * COARSEST, 1e6); }

static double count_all_graded(const grading *g, const even_axis axes[3]) {
  double cells = 1.0, counts[GRADING_STEPS + 1];
  for (int axis = 0; axis < 3; axis++) {
    count_graded(g, axis, &axes[axis], counts);
    cells *= axes[axis].is_wrapped ? axes[axis].size : round_count(counts[GRADING_STEPS]);
  }
  return cells;
}

/* The largest `near_m` with which the cells are few enough; 0 where that would take cells that grow too much. */
static double search_near(const np_transport_desc *desc, const even_axis axes[3]) {
  double farthest = 0.0;
  for (int axis = 0; axis < 3; axis++)
    for (int end = 0; end < 2; end++)
      farthest =
          fmax(farthest, compute_distance(desc, axis, axes[axis].origin_m + end * axes[axis].size * axes[axis].edge_m));
  for (double near = 0.95 * farthest; near > farthest / GRADING_MOST; near *= 0.95)
    if (count_all_graded(&(grading){.desc = desc, .near_m = near}, axes) <= (double)desc->cell_count_max) return near;
  return 0.0;
}

/* Thickness of clouds whose box is many times as wide; infinite: they are not flat. */
static double measure_flat(const np_world *world, const np_transport_desc *desc) {
  static const double flat = 8.0;
  const double thickness = desc->thickness_m > 0.0 ? desc->thickness_m : np_thickness_measure(world, desc);
  const double x = desc->bounds_max.x - desc->bounds_min.x, y = desc->bounds_max.y - desc->bounds_min.y;
  return fmin(x, y) >= flat * thickness ? thickness : HUGE_VAL;
}

/* Halves the heights of a flat cloud's cells: once where they are too deep, and further within six times
 * `cell_count_cheap` of them, as long as a cell's height counts in the light that comes through. */
static void halve_heights(const np_world *world, const np_transport_desc *desc, cell_edges *edges) {
  const double depth = np_transport_compute_extinction(world) * np_transport_get_voxel(world, 2);
  even_axis axes[3];
  const double whole = compute_even_axes(world, desc, *edges, axes), few = 6.0 * (double)desc->cell_count_cheap;
  while (edges->height > deep_height_min && edges->height * depth > deepest_flat * desc->cell_depth_max) {
    const cell_edges half = {edges->across, 0.5 * edges->height};
    const bool is_deep = edges->height * depth > deepest * desc->cell_depth_max;
    const double most = is_deep ? fmax(2.0 * whole, few) : few;
    if (compute_even_axes(world, desc, half, axes) > fmin(most, (double)desc->cell_count_max)) return;
    *edges = half;
  }
}

/* Cells that suit the clouds; where that is too many, graded ones; where these would be too many, larger ones. */
static grading choose_axes(const np_world *world, const np_transport_desc *desc, even_axis out[3], bool *out_is_fine) {
  const double wanted = choose_edge(world, desc, out_is_fine);
  const double thickness = measure_flat(world, desc) / np_transport_get_voxel(world, 2);
  const bool is_flat = isfinite(thickness);
  for (double edge = wanted;; edge *= 1.25) {
    cell_edges edges = flatten(round_edge(edge), thickness * edge / wanted);
    if (is_flat) halve_heights(world, desc, &edges);
    if (compute_even_axes(world, desc, edges, out) <= (double)desc->cell_count_max)
      return (grading){desc, HUGE_VAL, is_flat};
    const double near = desc->has_viewer ? search_near(desc, out) : 0.0;
    if (near > 0.0) return (grading){desc, near, is_flat};
  }
}

static neph_result store_graded_axis(const grading *g, const even_axis *even, int axis, np_transport_grid *out) {
  double counts[GRADING_STEPS + 1];
  count_graded(g, axis, even, counts);
  const int32_t size = round_count(counts[GRADING_STEPS]);
  assert(size >= COARSEST && size % COARSEST == 0);
  double *edge = np_alloc(out->context, (size_t)size + 1, sizeof *edge);
  if (!edge) return NEPH_ERROR_OUT_OF_MEMORY;
  const double step = even->size * even->edge_m / GRADING_STEPS;
  for (int32_t i = 0, k = 0; i <= size; i++) {
    const double wanted = counts[GRADING_STEPS] * i / size;
    while (k + 1 < GRADING_STEPS && counts[k + 1] < wanted) k++;
    edge[i] = even->origin_m + step * (k + (wanted - counts[k]) / (counts[k + 1] - counts[k]));
  }
  out->size[axis] = out->used[axis] = size;
  out->edge_m[axis] = edge;
  return NEPH_OK;
}

/* ---- Keeping them ---- */

/* Width of padding cells relative to the others. The box of the cells ends close to the clouds, as the air within it is
 * left out. */
static const double thin = 1.0 / 16.0;

static neph_result store_even_axis(const even_axis *even, int axis, np_transport_grid *out) {
  double *edge = np_alloc(out->context, (size_t)even->size + 1, sizeof *edge);
  assert(even->size >= 1 && even->edge_m > 0.0);
  if (!edge) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int32_t i = 0; i <= even->size; i++)
    edge[i] = even->origin_m + even->edge_m * (i <= even->used ? i : even->used + thin * (i - even->used));
  out->size[axis] = even->size;
  out->used[axis] = even->used;
  out->edge_m[axis] = edge;
  out->even_m[axis] = even->edge_m;
  out->is_wrapped[axis] = even->is_wrapped;
  out->repeat_m[axis] = even->repeat_m;
  return NEPH_OK;
}

/* ---- A column ---- */

/* Thickness of the outermost cells in optical depth, at most; that of the others over their depth from a face; and the
 * most over the depth in which light falls to 1/e in the cloud's inside. */
static const double face_depth = 0.05, growth = 0.1, fall_share = 0.25;

/* Thickness in optical depth of a column's cells: `first` at the faces, growing inwards, `most` at most. */
typedef struct thickness {
  double first, most;
} thickness;

/* The axis along which a grid is a column, or −1. */
static int search_column_axis(const even_axis axes[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const even_axis *b = &axes[(axis + 1) % 3], *c = &axes[(axis + 2) % 3];
    if (b->is_wrapped && c->is_wrapped && b->size == 1 && c->size == 1 && !axes[axis].is_wrapped) return axis;
  }
  return -1;
}

/* Optical depth along a column through the middles of its cells, at the samples of its one cloud: between them the
 * extinction is linear. */
typedef struct profile {
  int32_t count; /* number of samples */
  double origin_m, step_m;
  double *extinction, *depth;
} profile;

static neph_result measure_profile(neph_context *context, const np_world *world, const even_axis axes[3], int axis,
                                   profile *out) {
  const double voxel = np_transport_get_voxel(world, axis);
  double at[3];
  for (int a = 0; a < 3; a++) at[a] = axes[a].origin_m + 0.5 * axes[a].edge_m;
  out->step_m = voxel;
  out->origin_m = axes[axis].origin_m + axes[axis].edge_m - voxel;
  out->count = (int32_t)ceil(axes[axis].size * axes[axis].edge_m / voxel) + 1;
  out->extinction = np_alloc(context, (size_t)out->count, 2 * sizeof *out->extinction);
  if (!out->extinction) return NEPH_ERROR_OUT_OF_MEMORY;
  out->depth = out->extinction + out->count;
  for (int32_t k = 0; k < out->count; k++) {
    at[axis] = out->origin_m + k * voxel;
    out->extinction[k] = (double)np_instance_extinction(&world->clouds.at[0], np_dvec3_make(at[0], at[1], at[2]));
    if (k > 0) out->depth[k] = out->depth[k - 1] + 0.5 * voxel * (out->extinction[k - 1] + out->extinction[k]);
  }
  /* Drop empty samples above the cloud. */
  while (out->count > 2 && out->depth[out->count - 2] == out->depth[out->count - 1]) out->count--;
  return NEPH_OK;
}

/* Distance at which an optical depth is reached; extinction that rises by b along a step from a gives a·s + b·s²/2. */
static double compute_distance_to_depth(const profile *p, double depth) {
  int32_t k = 0;
  while (k + 2 < p->count && p->depth[k + 1] <= depth) k++;
  const double a = p->extinction[k], slope = (p->extinction[k + 1] - a) / p->step_m;
  const double rest = fmin(fmax(0.0, depth - p->depth[k]), p->depth[k + 1] - p->depth[k]);
  const double root = sqrt(fmax(0.0, a * a + 2.0 * slope * rest));
  return p->origin_m + k * p->step_m + (rest > 0.0 ? fmin(2.0 * rest / (a + root), p->step_m) : 0.0);
}

/* Range of the optical thickness of cells. Deep inside, light falls as e^{−κτ}, κ² = 3·(1 − ϖ)(1 − ϖg); at most
 * `COLUMN_MAX` cells are used, since light beyond is negligible. */
static thickness choose_thickness(const np_instance *volume, double depth) {
  enum { COLUMN_MAX = 512 };
  const double albedo = (double)np_spectrum_max(volume->albedo), g = np_phase_mean_cosine(&volume->phase);
  const double fall = sqrt(3.0 * (1.0 - albedo) * (1.0 - albedo * g));
  const double most = fmax(fall > 0.0 ? fall_share / fall : HUGE_VAL, depth / COLUMN_MAX);
  return (thickness){fmin(face_depth, depth / 64.0), most};
}

/* Number of cells between a face and an optical depth: equal cells, then growing ones, then equal ones again. */
static double count_to_depth(double depth, thickness t) {
  const double even = t.first / growth, end = fmax(even, t.most / growth);
  if (depth <= even) return depth / t.first;
  const double count = (1.0 + log(fmin(depth, end) / even)) / growth;
  return depth <= end ? count : count + (depth - end) / (growth * end);
}

static double compute_depth_of_count(double count, thickness t) {
  const double even = t.first / growth, end = fmax(even, t.most / growth), end_count = count_to_depth(end, t);
  if (count <= 1.0 / growth) return count * t.first;
  if (count <= end_count) return even * exp(count * growth - 1.0);
  return end + (count - end_count) * growth * end;
}

static void place_column_planes(const profile *p, thickness t, np_transport_grid *out, int axis) {
  const double depth = p->depth[p->count - 1], half = count_to_depth(0.5 * depth, t);
  const int32_t inner = out->size[axis] - 2;
  double *edge = out->edge_m[axis];
  for (int32_t i = 0; i <= inner; i++) {
    const double cells = 2.0 * half * i / inner;
    const double below =
        cells <= half ? compute_depth_of_count(cells, t) : depth - compute_depth_of_count(2.0 * half - cells, t);
    edge[i + 1] = compute_distance_to_depth(p, below);
  }
  edge[0] = 2.0 * edge[1] - edge[2];
  edge[inner + 2] = 2.0 * edge[inner + 1] - edge[inner];
}

static neph_result store_column_axis(const profile *p, thickness t, int axis, np_transport_grid *out) {
  const double depth = p->depth[p->count - 1], cells = 2.0 * count_to_depth(0.5 * depth, t) + 2.0;
  out->size[axis] = out->used[axis] = (int32_t)ceil(cells / COARSEST) * COARSEST;
  out->edge_m[axis] = np_alloc(out->context, (size_t)out->size[axis] + 1, sizeof *out->edge_m[axis]);
  if (!out->edge_m[axis]) return NEPH_ERROR_OUT_OF_MEMORY;
  place_column_planes(p, t, out, axis);
  return NEPH_OK;
}

static neph_result place_column(const np_world *world, const even_axis axes[3], int axis, np_transport_grid *out) {
  profile p = {0};
  neph_result result = measure_profile(out->context, world, axes, axis, &p);
  const double depth = result ? 0.0 : p.depth[p.count - 1];
  if (!result && depth > 0.0) {
    result = store_column_axis(&p, choose_thickness(&world->clouds.at[0], depth), axis, out);
  } else if (!result) {
    result = store_even_axis(&axes[axis], axis, out);
  }
  np_alloc_free(out->context, p.extinction);
  return result;
}

static void open_sides(np_transport_grid *g, int axis) {
  g->is_wrapped[axis] = g->is_wrapped[axis] && !(g->repeat_m[axis] > 0.0);
  g->repeat_m[axis] = 0.0;
}

neph_result np_transport_grid_place(neph_context *context, const np_world *world, const np_transport_desc *desc,
                                    np_transport_grid *out) {
  *out = (np_transport_grid){.context = context, .fold = desc->fold};
  even_axis axes[3];
  const grading g = choose_axes(world, desc, axes, &out->is_fine);
  const int column = search_column_axis(axes);
  neph_result result = NEPH_OK;
  out->is_flat = g.is_flat && column < 0;
  for (int axis = 0; axis < 3 && !result; axis++) {
    if (axis == column) {
      result = place_column(world, axes, axis, out);
    } else if (isfinite(g.near_m) && !axes[axis].is_wrapped) {
      result = store_graded_axis(&g, &axes[axis], axis, out);
    } else {
      result = store_even_axis(&axes[axis], axis, out);
    }
  }
  for (int axis = 0; axis < 3 && desc->has_open_sides; axis++) open_sides(out, axis);
  if (result) np_transport_grid_clear(out);
  return result;
}
