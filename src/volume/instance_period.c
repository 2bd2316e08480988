/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/instance_period.h"

int np_instance_get_index_axis(const np_instance *volume, int world_axis) {
  int found = -1;
  for (int a = 0; a < 3; a++) {
    double others = 0.0;
    for (int j = 0; j < 3; j++)
      if (j != world_axis) others += fabs(volume->world_to_index.m[a][j]);
    if (fabs(volume->world_to_index.m[a][world_axis]) > 1e6 * others) found = a;
  }
  return found;
}

/* Period of one cloud; 0: none. */
static double get_period(const np_instance *volume, int world_axis) {
  const int a = np_instance_get_index_axis(volume, world_axis);
  if (a < 0 || a > 1 || !volume->bricks->is_periodic[a]) return 0.0;
  return volume->bricks->field_period[a] / fabs(volume->world_to_index.m[a][world_axis]);
}

/* Least common multiple of two periods; 0: none up to eight times the first. */
static double join_periods(double a_m, double b_m) {
  static const double tolerance = 1e-9;
  static const int most = 8;
  for (int n = 1; a_m > 0.0 && b_m > 0.0 && n <= most; n++)
    if (fabs(remainder(n * a_m, b_m)) <= tolerance * b_m) return n * a_m;
  return 0.0;
}

double np_instances_compute_period(const np_instances *clouds, int world_axis) {
  const np_instance *places = np_instances_get_places(clouds);
  const unsigned count = np_instances_count_places(clouds);
  double period_m = count > 0 ? get_period(&places[0], world_axis) : 0.0;
  for (unsigned v = 1; v < count && period_m > 0.0; v++)
    period_m = join_periods(period_m, get_period(&places[v], world_axis));
  return period_m;
}

/* ---- Light ---- */

/* Range of a cloud's table along a world axis. */
static void bound(const np_instance *volume, int world_axis, double *low, double *high) {
  const np_bricks *b = volume->bricks;
  np_affine to_world;
  if (!np_affine_invert(&volume->world_to_index, &to_world)) return;
  for (int corner = 0; corner < 8; corner++) {
    double at = to_world.m[world_axis][3];
    for (int a = 0; a < 3; a++)
      at += to_world.m[world_axis][a] * NP_BRICK_EDGE * (b->origin[a] + (corner >> a & 1 ? b->size[a] : 0));
    *low = fmin(*low, at);
    *high = fmax(*high, at);
  }
}

double np_instances_get_longest_period(const np_instances *clouds, int world_axis) {
  double longest_m = 0.0;
  for (unsigned v = 0; v < clouds->count; v++) longest_m = fmax(longest_m, get_period(&clouds->at[v], world_axis));
  return longest_m;
}

np_light_period np_instances_get_light_period(const np_instances *clouds, int world_axis) {
  const np_instance *places = np_instances_get_places(clouds);
  const double common_m = np_instances_compute_period(clouds, world_axis);
  if (common_m > 0.0) return (np_light_period){0.0, common_m, common_m};
  const double longest_m = np_instances_get_longest_period(clouds, world_axis);
  if (!(longest_m > 0.0)) return (np_light_period){0.0, 0.0, 0.0};
  double low = HUGE_VAL, high = -HUGE_VAL, bottom = HUGE_VAL, top = -HUGE_VAL;
  for (unsigned v = 0; v < np_instances_count_places(clouds); v++) {
    if (!(get_period(&places[v], world_axis) > 0.0)) bound(&places[v], world_axis, &low, &high);
    bound(&places[v], 2, &bottom, &top);
  }
  const bool has_ends = low < high;
  const double around_m = top - bottom, held_m = (has_ends ? high - low : 0.0) + 2.0 * around_m;
  const double length_m = longest_m * (1.0 + ceil(held_m / longest_m));
  const double middle_m = has_ends ? 0.5 * (low + high) : 0.0;
  return (np_light_period){middle_m - 0.5 * (length_m - longest_m), length_m, longest_m};
}
