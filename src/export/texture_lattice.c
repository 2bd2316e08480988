/* SPDX-License-Identifier: Apache-2.0 */
/* A cloud baked on the voxels of its textures, and its place in the world. */
#include <math.h>
#include <string.h>

#include "cloud/bake_grid.h"
#include "core/alloc.h"
#include "export/texture_cloud.h"
#include "plan/placement.h"
#include "volume/volume_private.h"

enum { TRIES = 6, BYTES_PER_VOXEL = 8 }; /* extinction and distance */

/* ---- Baking ---- */

/* Longest edge of the box that may hold cloud: its field with the rain below it. */
static double compute_edge_m(const np_texture_cloud *cloud) {
  const neph_cloud_desc *desc = &cloud->in_frame.desc;
  const double height_m = desc->thickness_m + desc->precipitation * fmax(desc->base_altitude_m, 0.0);
  return fmax(height_m, fmax(desc->extent_m[0], desc->extent_m[1]));
}

static neph_result bake(const np_texture_cloud *cloud, double voxel_m, np_sparse_grid *out_grid) {
  neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  neph_cloud_desc desc = cloud->in_frame.desc;
  bake_desc.planet_radius_m = cloud->scene->atmosphere.planet_radius_m;
  desc.voxel_m = voxel_m;
  np_monitor_set_stage(cloud->set->monitor, "baking");
  return np_cloud_bake_grid(cloud->set->context, &desc, &bake_desc, "density", cloud->set->monitor, out_grid);
}

static unsigned count_longest(const np_grid_extent *extent) {
  int32_t longest = 0;
  for (int a = 0; a < 3; a++)
    longest = extent->max[a] - extent->min[a] > longest ? extent->max[a] - extent->min[a] : longest;
  return (unsigned)longest + 3; /* both ends, and a clear voxel at each */
}

/* Bakes with at most `size` voxels along an edge. Voxels of a field that repeats are rounded, and may be too many. */
static neph_result bake_within(const np_texture_cloud *cloud, np_sparse_grid *out_grid, np_grid_extent *out_extent,
                               bool *out_has_content) {
  const unsigned size = cloud->set->desc->size;
  double voxel_m = compute_edge_m(cloud) / (size - 3);
  neph_result result = NEPH_OK;
  for (int try = 0; try < TRIES; try++, voxel_m *= 1.2) {
    result = bake(cloud, voxel_m, out_grid);
    *out_has_content = !result && np_sparse_grid_measure(out_grid, out_extent);
    if (result || !*out_has_content || count_longest(out_extent) <= size) return result;
    np_sparse_grid_clear(out_grid);
  }
  return np_fail(cloud->set->context, NEPH_ERROR_LIMIT,
                 "export: cloud %s: its voxels cannot be chosen so that its longest edge has at most %u of them: "
                 "enlarge size",
                 cloud->cloud->name, size);
}

/* ---- Place ---- */

/* Position, voxel edge and optical depth depend on the cloud's own bake, whatever the voxels of its textures. */
static neph_result anchor_cloud(const np_texture_cloud *cloud, const neph_volume *on_lattice, np_anchor *out_anchor) {
  neph_context *context = cloud->set->context;
  np_monitor *monitor = cloud->set->monitor;
  np_sparse_grid grid = {.context = NULL};
  neph_volume *own = NULL;
  if (!np_placement_needs_reference(cloud->cloud))
    return np_placement_anchor(cloud->cloud, on_lattice, monitor, out_anchor);
  neph_result result = bake(cloud, cloud->in_frame.desc.voxel_m, &grid);
  if (!result) result = np_volume_create_from_grid(context, &grid, NEPH_PRECISION_HALF, monitor, &own);
  np_sparse_grid_clear(&grid);
  if (!result) result = np_placement_anchor(cloud->cloud, own, monitor, out_anchor);
  neph_volume_release(own);
  return result;
}

static neph_result place(np_texture_cloud *cloud, const np_sparse_grid *grid, const np_grid_extent *extent) {
  neph_volume *volume = NULL;
  np_anchor anchor;
  np_placement placement;
  np_monitor *monitor = cloud->set->monitor;
  np_texture_lattice *lattice = &cloud->lattice;
  neph_result result = np_volume_create_from_grid(cloud->set->context, grid, NEPH_PRECISION_HALF, monitor, &volume);
  if (result) return result;
  result = anchor_cloud(cloud, volume, &anchor);
  if (!result) result = np_placement_make(cloud->cloud, &anchor, volume, monitor, &placement);
  neph_volume_release(volume);
  if (result) return result;
  cloud->bake_to_world = anchor.file_to_world;
  cloud->extinction_factor = (double)placement.world.extinction_per_value;
  np_affine from_texture = np_affine_identity();
  for (int a = 0; a < 3; a++) {
    from_texture.m[a][a] = lattice->size[a];
    from_texture.m[a][3] = extent->min[a] - 1.5;
  }
  lattice->to_world = np_affine_compose(&placement.index_to_world, &from_texture);
  for (int a = 0; a < 3; a++) {
    const double *const m[3] = {lattice->to_world.m[0], lattice->to_world.m[1], lattice->to_world.m[2]};
    lattice->edge_m[a] = sqrt(m[0][a] * m[0][a] + m[1][a] * m[1][a] + m[2][a] * m[2][a]) / lattice->size[a];
  }
  return NEPH_OK;
}

/* ---- Values ---- */

/* Writes a cube of voxels from `origin`; `values` NULL: one value in all of it. */
static void put_cube(const np_texture_lattice *lattice, const np_grid_extent *extent, const int32_t origin[3],
                     int32_t edge, const float *values, float value) {
  int32_t low[3], high[3];
  for (int a = 0; a < 3; a++) {
    low[a] = origin[a] > extent->min[a] ? origin[a] : extent->min[a];
    high[a] = origin[a] + edge - 1 < extent->max[a] ? origin[a] + edge - 1 : extent->max[a];
  }
  for (int32_t k = low[2]; k <= high[2]; k++)
    for (int32_t j = low[1]; j <= high[1]; j++)
      for (int32_t i = low[0]; i <= high[0]; i++) {
        const size_t x = (size_t)(i - extent->min[0]) + 1, y = (size_t)(j - extent->min[1]) + 1;
        const size_t z = (size_t)(k - extent->min[2]) + 1;
        const int32_t n = (i - origin[0]) * 64 + (j - origin[1]) * 8 + (k - origin[2]);
        lattice->extinction[(z * lattice->size[1] + y) * lattice->size[0] + x] = values ? values[n] : value;
      }
}

static void put_values(np_texture_cloud *cloud, const np_sparse_grid *grid, const np_grid_extent *extent) {
  np_texture_lattice *lattice = &cloud->lattice;
  const size_t count = (size_t)lattice->size[0] * lattice->size[1] * lattice->size[2];
  for (size_t i = 0; i < grid->tile_count; i++)
    put_cube(lattice, extent, grid->tiles[i].origin, grid->tiles[i].edge, NULL, grid->tiles[i].value);
  for (size_t i = 0; i < grid->leaf_count; i++)
    put_cube(lattice, extent, grid->leaves[i].origin, NP_LEAF_EDGE, grid->leaves[i].values, 0.0f);
  for (size_t i = 0; i < count; i++) {
    lattice->extinction[i] = (float)((double)lattice->extinction[i] * cloud->extinction_factor);
    lattice->greatest = np_maxf(lattice->greatest, lattice->extinction[i]);
  }
}

static neph_result fill(np_texture_cloud *cloud, const np_sparse_grid *grid, const np_grid_extent *extent) {
  np_texture_lattice *lattice = &cloud->lattice;
  neph_context *context = cloud->set->context;
  double count = 1.0;
  for (int a = 0; a < 3; a++) {
    lattice->size[a] = (unsigned)(extent->max[a] - extent->min[a]) + 3;
    count *= lattice->size[a];
  }
  const double bytes = BYTES_PER_VOXEL * count, machine = (double)np_memory_size();
  if (bytes > machine)
    return np_fail(context, NEPH_ERROR_LIMIT,
                   "export: cloud %s: %u × %u × %u voxels need %.3g GB, more than the %.3g GB of this machine: reduce "
                   "size",
                   cloud->cloud->name, lattice->size[0], lattice->size[1], lattice->size[2], bytes / 1e9,
                   machine / 1e9);
  const neph_result result = place(cloud, grid, extent);
  if (result) return result;
  np_log(context, NEPH_LOG_INFO, "export: cloud %s: %u × %u × %u voxels of %.4g × %.4g × %.4g m, %.3g MB in memory",
         cloud->cloud->name, lattice->size[0], lattice->size[1], lattice->size[2], lattice->edge_m[0],
         lattice->edge_m[1], lattice->edge_m[2], bytes / 1e6);
  lattice->extinction = np_alloc(context, (size_t)count, sizeof *lattice->extinction);
  if (!lattice->extinction) return NEPH_ERROR_OUT_OF_MEMORY;
  put_values(cloud, grid, extent);
  return NEPH_OK;
}

neph_result np_texture_lattice_make(np_texture_cloud *cloud) {
  np_sparse_grid grid = {.context = NULL};
  np_grid_extent extent;
  bool has_content = false;
  neph_result result = bake_within(cloud, &grid, &extent, &has_content);
  if (result) return result;
  if (has_content)
    result = fill(cloud, &grid, &extent);
  else
    np_log(cloud->set->context, NEPH_LOG_WARNING,
           "export: cloud %s is empty in this frame: it has no distances and optical depths", cloud->cloud->name);
  np_sparse_grid_clear(&grid);
  return result;
}
