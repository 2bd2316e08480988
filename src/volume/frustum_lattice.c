/* SPDX-License-Identifier: Apache-2.0 */
/* Map of a frustum (OpenVDB 10, NonlinearFrustumMap in math/Maps.h), and its lattices.
 *
 * The width of a voxel, s(z) = scale·(1 + growth·z), is linear in depth; its length along the axis, `step`, is
 * constant. Rays of the frustum are oblique in a lattice: over a voxel of depth c they move by c·t across, with t their
 * largest slope. So c is at most h/t, which limits that to one voxel, and at most `step` in the level with the longest
 * voxels. The levels of a frustum of n × n × m voxels that widens by a factor f have about n²·m·ln f voxels. */
#include "volume/frustum.h"

#include <float.h>

/* Width of voxels at which the frustum is cut off, relative to the first plane that is not empty. */
static const double width_share_min = 0.5;

/* Largest plausible ratio of the widest to the narrowest voxels. */
static const double widening_max = 1e6;

static double get_width(const np_frustum *map, double k) {
  return map->scale * (1.0 + map->growth * map->step * (k - map->origin[2]));
}

np_dvec3 np_frustum_map_point(const np_frustum *map, np_dvec3 index) {
  const double width = get_width(map, index.z);
  return np_affine_point(&map->local_to_world,
                         np_dvec3_make(width * (index.x - map->origin[0]), width * (index.y - map->origin[1]),
                                       map->step * (index.z - map->origin[2])));
}

static double get_length(const np_affine *m, int axis) {
  return np_dvec3_length(np_dvec3_make(m->m[0][axis], m->m[1][axis], m->m[2][axis]));
}

void np_frustum_get_voxel(const np_frustum *map, double k, double out_edges[3]) {
  const double width = fabs(get_width(map, k));
  out_edges[0] = width * get_length(&map->local_to_world, 0);
  out_edges[1] = width * get_length(&map->local_to_world, 1);
  out_edges[2] = fabs(map->step) * get_length(&map->local_to_world, 2);
}

void np_frustum_bound_box(const np_frustum *map, const int32_t low[3], const int32_t high[3], double out_min[3],
                          double out_max[3]) {
  for (int a = 0; a < 3; a++) out_min[a] = DBL_MAX, out_max[a] = -DBL_MAX;
  for (int n = 0; n < 8; n++) {
    const np_dvec3 p = np_frustum_map_point(
        map, np_dvec3_make(n & 1 ? high[0] : low[0], n & 2 ? high[1] : low[1], n & 4 ? high[2] : low[2]));
    const double at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++) out_min[a] = fmin(out_min[a], at[a]), out_max[a] = fmax(out_max[a], at[a]);
  }
}

/* ---- Lattices ---- */

/* Depth of a plane, towards wider voxels. */
static double get_w(const np_frustum_lattice *l, double k) { return l->sign * l->map.step * (k - l->map.origin[2]); }

static double get_width_at(const np_frustum_lattice *l, double w) {
  return l->map.scale * (1.0 + l->map.growth * l->sign * w);
}

/* Depth at which voxels have a width; only for frustums that widen. */
static double search_width(const np_frustum_lattice *l, double width) {
  return (width / l->map.scale - 1.0) / (l->map.growth * l->sign);
}

/* Largest slope of a ray against the axis, in the frustum's local lengths. */
static double get_slope(const np_frustum *map, const np_frustum_block *box) {
  double away = 0.0;
  for (int a = 0; a < 2; a++)
    away = fmax(away, fmax(fabs(box->low[a] - map->origin[a]), fabs(box->high[a] - map->origin[a])));
  return away * fabs(map->scale * map->growth);
}

/* Divides the lattice into slabs. Level k + 1 begins at the first plane between its cells beyond which the frustum's
 * voxels are as wide as its own, 2ᵏ⁺¹·h. */
static void set_slabs(np_frustum_lattice *l, double width) {
  l->slabs[0].first = INT32_MIN;
  for (unsigned k = 1; k < l->level_count; k++) {
    const double cell = ldexp(NP_LEAF_EDGE * l->depth, (int)k);
    const int32_t first = (int32_t)ceil((search_width(l, ldexp(width, (int)k)) - l->start) / cell - 1e-9);
    l->slabs[k].first = first > 0 ? first : 0;
    l->slabs[k - 1].end = 2 * l->slabs[k].first;
  }
  l->slabs[l->level_count - 1].end = INT32_MAX;
}

static bool is_sound(const np_frustum *map) {
  np_affine inverse;
  return map->is_enabled && isfinite(map->scale) && map->scale != 0.0 && isfinite(map->growth) && isfinite(map->step) &&
         map->step != 0.0 && np_affine_invert(&map->local_to_world, &inverse);
}

bool np_frustum_lattice_make(const np_frustum *map, const np_frustum_block *box, double refinement, unsigned level_max,
                             np_frustum_lattice *out) {
  *out = (np_frustum_lattice){.map = *map, .sign = map->growth * map->scale < 0.0 ? -1.0 : 1.0};
  if (!is_sound(map)) return false;
  const double ends[2] = {get_w(out, box->low[2]), get_w(out, box->high[2])};
  const double begin = fmin(ends[0], ends[1]), end = fmax(ends[0], ends[1]), step = fabs(map->step);
  const double width_max = get_width_at(out, end), width_first = get_width_at(out, fmin(begin + step, end));
  if (!(width_first > 0.0) || !(width_max < widening_max * width_first)) return false;
  out->width_min = fmax(get_width_at(out, begin), width_share_min * width_first);
  out->start = out->width_min > get_width_at(out, begin) ? search_width(out, out->width_min) : begin;
  const double levels = floor(log2(width_max / out->width_min) + 1e-9);
  out->level_count = 1 + (levels < level_max ? (unsigned)levels : level_max - 1);
  out->edge = out->width_min / refinement;
  const double slope = get_slope(map, box), longest = ldexp(out->edge, (int)out->level_count - 1);
  const double ratio = fmin(slope > 0.0 ? 1.0 / slope : HUGE_VAL, step / (refinement * longest));
  out->depth = ratio * out->edge;
  if (!(out->edge > 0.0) || !(out->depth > 0.0) || !((end - begin) / out->depth < 1e8)) return false;
  set_slabs(out, out->width_min);
  return true;
}

np_affine np_frustum_lattice_get_affine(const np_frustum_lattice *lattice, unsigned level) {
  const double edge = ldexp(lattice->edge, (int)level), depth = lattice->sign * ldexp(lattice->depth, (int)level);
  const np_affine own = {{{edge, 0, 0, 0}, {0, edge, 0, 0}, {0, 0, depth, lattice->sign * lattice->start}}};
  return np_affine_compose(&lattice->map.local_to_world, &own);
}

/* Clips an interval to the samples of a level, from its first cell to the first plane beyond its last. */
static void clip_to_slab(const np_frustum_lattice *l, unsigned level, double depth, double w[2]) {
  const np_frustum_slab *slab = &l->slabs[level];
  if (slab->first != INT32_MIN) w[0] = fmax(w[0], l->start + NP_LEAF_EDGE * depth * slab->first);
  if (slab->end != INT32_MAX) w[1] = fmin(w[1], l->start + NP_LEAF_EDGE * depth * slab->end);
}

static int32_t get_cell(double sample) {
  static const double far = 1e9;
  return (int32_t)floor(fmin(fmax(sample, -far), far) / NP_LEAF_EDGE);
}

bool np_frustum_lattice_get_cells(const np_frustum_lattice *lattice, unsigned level, const np_frustum_block *block,
                                  int32_t out_first[3], int32_t out_last[3]) {
  const np_frustum_lattice *l = lattice;
  const double edge = ldexp(l->edge, (int)level), depth = ldexp(l->depth, (int)level);
  const double ends[2] = {get_w(l, block->low[2]), get_w(l, block->high[2])};
  double w[2] = {fmax(fmin(ends[0], ends[1]), l->start), fmax(ends[0], ends[1])};
  clip_to_slab(l, level, depth, w);
  if (w[0] > w[1]) return false;
  for (int a = 0; a < 2; a++) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int n = 0; n < 4; n++) {
      const double away = (n & 1 ? block->high : block->low)[a] - l->map.origin[a];
      const double x = away * get_width_at(l, w[n >> 1]);
      low = fmin(low, x), high = fmax(high, x);
    }
    out_first[a] = get_cell(low / edge - 0.5);
    out_last[a] = get_cell(high / edge + 0.5);
  }
  out_first[2] = get_cell((w[0] - l->start) / depth - 0.25);
  out_last[2] = get_cell((w[1] - l->start) / depth + 0.25);
  const np_frustum_slab *slab = &l->slabs[level];
  if (out_first[2] < slab->first) out_first[2] = slab->first;
  if (out_last[2] > slab->end) out_last[2] = slab->end;
  return true;
}

bool np_frustum_lattice_locate(const np_frustum_lattice *lattice, unsigned level, const double at[3], double out[3]) {
  const np_frustum_lattice *l = lattice;
  const double edge = ldexp(l->edge, (int)level), depth = ldexp(l->depth, (int)level);
  const double w = l->start + depth * at[2], width = get_width_at(l, w);
  if (width < l->width_min * (1.0 - 1e-9)) return false;
  out[0] = l->map.origin[0] + edge * at[0] / width;
  out[1] = l->map.origin[1] + edge * at[1] / width;
  out[2] = l->map.origin[2] + l->sign * w / l->map.step;
  return true;
}
