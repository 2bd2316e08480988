/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/thickness.h"

#include "transport/transport_grid.h"

enum { COLUMNS = 32, SAMPLES_MAX = 256 };

/* Extinction from which a point counts as cloud, relative to the largest of all clouds. */
static const double cloud_share = 0.01;

static bool is_sampled(const np_world *world) {
  for (unsigned v = 0; v < world->clouds.count; v++)
    if (!world->clouds.at[v].bricks->table) return false;
  return true;
}

double np_thickness_measure(const np_world *world, const np_transport_desc *desc) {
  const np_dvec3 low = desc->bounds_min, size = np_dvec3_subtract(desc->bounds_max, low);
  const int samples = (int)np_clamp(ceil(size.z / np_transport_get_voxel(world, 2)), 1.0, SAMPLES_MAX);
  double densest = 0.0, lengths = 0.0, squares = 0.0;
  if (!is_sampled(world)) return size.z;
  for (unsigned v = 0; v < world->clouds.count; v++)
    densest = fmax(densest, (double)(world->clouds.at[v].bricks->value_max * world->clouds.at[v].extinction_per_value));
  for (int column = 0; column < COLUMNS * COLUMNS; column++) {
    /* Places within the squares by the golden ratio, so that no rows of clouds are missed. */
    const double x = (column % COLUMNS + fmod(0.7548776662466927 * column, 1.0)) / COLUMNS;
    const double y = (column / COLUMNS + fmod(0.5698402909980532 * column, 1.0)) / COLUMNS;
    int layer = 0;
    for (int k = 0; k <= samples; k++) {
      const np_dvec3 at = np_dvec3_make(low.x + x * size.x, low.y + y * size.y, low.z + (k + 0.5) / samples * size.z);
      if (k < samples && (double)np_instances_extinction(&world->clouds, at) > cloud_share * densest) {
        layer++;
        continue;
      }
      lengths += layer;
      squares += (double)layer * layer;
      layer = 0;
    }
  }
  return lengths > 0.0 ? squares / lengths * size.z / samples : HUGE_VAL;
}
