/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/instance_period.h"

#include <math.h>

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
  return volume->bricks->period[a] / fabs(volume->world_to_index.m[a][world_axis]);
}

double np_instances_compute_period(const np_instances *clouds, int world_axis) {
  static const double tolerance = 1e-9;
  const np_instance *places = np_instances_get_places(clouds);
  const unsigned count = np_instances_count_places(clouds);
  const double period_m = count > 0 ? get_period(&places[0], world_axis) : 0.0;
  for (unsigned v = 1; v < count; v++)
    if (!(fabs(get_period(&places[v], world_axis) - period_m) <= tolerance * period_m)) return 0.0;
  return period_m;
}
