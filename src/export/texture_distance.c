/* SPDX-License-Identifier: Apache-2.0 */
/* The signed distance from each voxel's centre to the boundary of the voxels that hold cloud: exact between centres,
 * less half a voxel, so that the boundary is on the faces between voxels of both sides. Against the boundary of the
 * cubes themselves it is off by up to (√3 − 1)/2 = 0.37 voxels, where the nearest point is a corner. */
#include <math.h>

#include "core/alloc.h"
#include "export/distance_transform.h"
#include "export/texture_cloud.h"

typedef struct distances {
  const np_texture_lattice *lattice;
  double half_m;
  float *values; /* squared, with a sign */
} distances;

static neph_result fill_slice(void *user, unsigned slice, float *out_values) {
  const distances *d = user;
  const size_t count = (size_t)d->lattice->size[0] * d->lattice->size[1];
  for (size_t i = 0; i < count; i++) {
    const float squared = d->values[slice * count + i];
    out_values[i] = copysignf((float)(sqrt((double)fabsf(squared)) - d->half_m), squared);
  }
  return NEPH_OK;
}

static neph_result measure(const np_texture_cloud *cloud, distances *d) {
  const np_texture_lattice *lattice = &cloud->lattice;
  const size_t count = (size_t)lattice->size[0] * lattice->size[1] * lattice->size[2];
  d->values = np_alloc(cloud->set->context, count, sizeof *d->values);
  if (!d->values) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; i++)
    d->values[i] = lattice->extinction[i] > 0.0f ? -NP_DISTANCE_NONE : NP_DISTANCE_NONE;
  return np_distance_transform(cloud->set->context, cloud->set->monitor, lattice->size, lattice->edge_m, d->values);
}

neph_result np_texture_distance_add(const np_texture_cloud *cloud) {
  const np_texture_lattice *lattice = &cloud->lattice;
  distances d = {.lattice = lattice,
                 .half_m = 0.5 * fmin(lattice->edge_m[0], fmin(lattice->edge_m[1], lattice->edge_m[2]))};
  np_texture texture = {.purpose = "step lengths of rays: distance to the cloud's boundary",
                        .mapping = "world = origin_m + u·edges_m[0] + v·edges_m[1] + w·edges_m[2], texel i of n at "
                                   "(i + 1/2)/n; between voxels' centres exact, less half a voxel",
                        .texel = NP_TEXEL_R16F,
                        .dimensions = 3,
                        .size = {lattice->size[0], lattice->size[1], lattice->size[2]},
                        .has_place = true,
                        .to_world = lattice->to_world,
                        .channels = {{"signed distance to the boundary of the cloud, negative inside", "m", 1.0}},
                        .fill = fill_slice,
                        .user = &d};
  neph_result result = cloud->set->desc->is_dry_run ? NEPH_OK : measure(cloud, &d);
  if (!result) result = np_texture_cloud_add_one(cloud, "distance", &texture);
  np_alloc_free(cloud->set->context, d.values);
  return result;
}
