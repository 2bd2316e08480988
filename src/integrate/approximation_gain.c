/* SPDX-License-Identifier: Apache-2.0 */
#include "integrate/approximation_gain.h"

#include "volume/tracking.h"

/* ---- Effective optical depth ---- */

enum { COLUMNS = 12 }; /* along each of two axes */

/* Index position from its coordinate `along` an axis and its coordinates u and v along the other two. */
static np_dvec3 make_index(int axis, double along, double u, double v) {
  double index[3];
  index[axis] = along, index[(axis + 1) % 3] = u, index[(axis + 2) % 3] = v;
  return np_dvec3_make(index[0], index[1], index[2]);
}

typedef struct index_box {
  double low[3], high[3];
} index_box;

/* Voxels that the bricks of one period cover. */
static index_box get_box(const np_bricks *bricks) {
  index_box box;
  for (int a = 0; a < 3; a++) {
    box.low[a] = 8.0 * bricks->origin[a];
    box.high[a] = box.low[a] + 8.0 * bricks->size[a];
  }
  return box;
}

/* Depth of a column along an axis: no light is followed, so that it counts to the far side of any cloud. */
static double compute_column(const np_instance *cloud, const np_affine *to_world, const index_box *box, int axis,
                             double u, double v) {
  static const np_depth_query query = {.fade = 1e-4f, .error = 0.05f};
  const np_dvec3 from = np_affine_point(to_world, make_index(axis, box->low[axis] - 1.0, u, v));
  const np_dvec3 to = np_affine_point(to_world, make_index(axis, box->high[axis] + 1.0, u, v));
  const np_dvec3 way = np_dvec3_subtract(to, from);
  const double length = np_dvec3_length(way);
  const np_dvec3 direction = np_dvec3_scale(way, 1.0 / length);
  return (double)np_track_volume_depth(
      cloud, from, np_vec3_make((float)direction.x, (float)direction.y, (float)direction.z), length, &query, 0.0f);
}

static double mix(double a, double b, double t) { return a + t * (b - a); }

static double compute_axis_depth(const np_instance *cloud, const np_affine *to_world, const index_box *box, int axis) {
  const int across = (axis + 1) % 3, up = (axis + 2) % 3;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < COLUMNS * COLUMNS; i++) {
    const double u = (i % COLUMNS + 0.5) / COLUMNS, v = (i / COLUMNS + 0.5) / COLUMNS;
    const double depth = compute_column(cloud, to_world, box, axis, mix(box->low[across], box->high[across], u),
                                        mix(box->low[up], box->high[up], v));
    sum += depth, squares += depth * depth;
  }
  return sum > 0.0 ? squares / sum : 0.0;
}

float np_cloud_gain_compute_depth(const np_instance *cloud) {
  const index_box box = get_box(cloud->bricks);
  np_affine to_world;
  double sum = 0.0;
  if (!np_affine_invert(&cloud->world_to_index, &to_world)) return 0.0f;
  for (int axis = 0; axis < 3; axis++) {
    if (axis < 2 && cloud->bricks->is_periodic[axis]) continue;
    const double depth = compute_axis_depth(cloud, &to_world, &box, axis);
    if (!(depth > 0.0)) return 0.0f;
    sum += 1.0 / (depth * depth);
  }
  return (float)sqrt(3.0 / sum);
}

/* ---- Table ---- */

/* Two neighbouring nodes, and the weight of the second. */
typedef struct span {
  int node;
  double share;
} span;

static span locate(double x, const double *nodes, int count) {
  int node = 0;
  while (node + 2 < count && x > nodes[node + 1]) node++;
  const double share = (x - nodes[node]) / (nodes[node + 1] - nodes[node]);
  return (span){node, fmin(fmax(share, 0.0), 1.0)};
}

static span locate_depth(double depth) {
  const double place = log(fmax(depth, np_gain_depth_first) / np_gain_depth_first) / log(np_gain_depth_ratio);
  const int node = place < NP_GAIN_DEPTHS - 2 ? (int)place : NP_GAIN_DEPTHS - 2;
  return (span){node, fmin(place - node, 1.0)};
}

/* Interpolation interval in √(1 − ϖ): the logarithm of a deep cloud's reflectance is nearly linear in it. */
static span locate_albedo(double albedo) {
  double nodes[NP_GAIN_ALBEDOS];
  for (int i = 0; i < NP_GAIN_ALBEDOS; i++) nodes[i] = sqrt(1.0 - np_gain_albedos[i]);
  return locate(sqrt(fmax(1.0 - albedo, 0.0)), nodes, NP_GAIN_ALBEDOS);
}

/* Linear in the logarithm of the gain. */
static float get_gain(const np_gain_table table, const span place[3], int angle, double gain_max) {
  double sum = 0.0;
  for (int corner = 0; corner < 8; corner++) {
    double share = 1.0;
    int node[3];
    for (int a = 0; a < 3; a++) {
      const bool is_upper = corner >> a & 1;
      share *= is_upper ? place[a].share : 1.0 - place[a].share;
      node[a] = place[a].node + is_upper;
    }
    sum += share * log((double)table[node[0]][node[1]][node[2]][angle]);
  }
  return (float)fmin(exp(sum), gain_max);
}

static const np_gain_table *get_table(neph_multiple_scattering method, bool is_sun) {
  switch (method) {
  case NEPH_MULTIPLE_SCATTERING_OCTAVES:
    return &np_gain_table_octaves;
  case NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER:
    return &np_gain_table_softened_beer;
  case NEPH_MULTIPLE_SCATTERING_POWDER:
    return &np_gain_table_powder;
  case NEPH_MULTIPLE_SCATTERING_DERIVATIVE:
    return is_sun ? &np_gain_table_derivative : &np_gain_table_none;
  case NEPH_MULTIPLE_SCATTERING_ORDINATES:
  case NEPH_MULTIPLE_SCATTERING_NONE:
    break;
  }
  return &np_gain_table_none;
}

/* The derivative is darkened alone: its gains above 1 represent slopes that clouds have and the calibration's lack. */
static double get_gain_max(neph_multiple_scattering method, bool is_sun) {
  return method == NEPH_MULTIPLE_SCATTERING_DERIVATIVE && is_sun ? 1.0 : (double)INFINITY;
}

void np_cloud_gain_fill(neph_multiple_scattering method, const np_instance *cloud, float depth, np_cloud_gain *out) {
  const double asymmetry = np_phase_mean_cosine(&cloud->phase);
  *out = (np_cloud_gain){.depth = depth, .phase = np_phase_henyey_greenstein((float)asymmetry)};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const span place[3] = {locate(asymmetry, np_gain_asymmetries, NP_GAIN_ASYMMETRIES), locate_depth((double)depth),
                           locate_albedo((double)cloud->albedo.band[b])};
    for (int angle = 0; angle < NP_GAIN_ANGLES; angle++) {
      out->sun[angle].band[b] = get_gain(*get_table(method, true), place, angle, get_gain_max(method, true));
      out->surroundings[angle].band[b] = get_gain(*get_table(method, false), place, angle, get_gain_max(method, false));
    }
  }
}
