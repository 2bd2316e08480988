/* SPDX-License-Identifier: Apache-2.0 */
/* Extinction of a cloud, and optical depth from each voxel's centre along six directions to the border of its box: half
 * of its own voxel, and all of those beyond. */
#include <math.h>

#include "core/alloc.h"
#include "export/texture_cloud.h"

typedef struct depths {
  const np_texture_lattice *lattice;
  size_t slice_count;  /* voxels of a slice */
  double *below, *all; /* sums of extinction along z: of the slices below, and of all */
} depths;

static const float *get_slice(const depths *d, unsigned slice) {
  return d->lattice->extinction + slice * d->slice_count;
}

static neph_result fill_extinction(void *user, unsigned slice, float *out_values) {
  const depths *d = user;
  for (size_t i = 0; i < d->slice_count; i++) out_values[i] = get_slice(d, slice)[i] / d->lattice->greatest;
  return NEPH_OK;
}

/* Optical depths along one line of a slice, forwards and backwards, into two of its four channels. */
static void sum_line(const float *extinction, size_t count, size_t stride, double edge_m, float *out) {
  double sum = 0.0;
  for (size_t i = 0; i < count; i++) {
    const double own = 0.5 * (double)extinction[i * stride];
    out[4 * i * stride + 1] = (float)(edge_m * (sum + own));
    sum += 2.0 * own;
  }
  for (size_t i = 0; i < count; i++) out[4 * i * stride] = (float)(edge_m * sum) - out[4 * i * stride + 1];
}

static neph_result fill_xy(void *user, unsigned slice, float *out_values) {
  const depths *d = user;
  const np_texture_lattice *lattice = d->lattice;
  const size_t nx = lattice->size[0], ny = lattice->size[1];
  const float *extinction = get_slice(d, slice);
  for (size_t y = 0; y < ny; y++) sum_line(extinction + y * nx, nx, 1, lattice->edge_m[0], out_values + 4 * y * nx);
  for (size_t x = 0; x < nx; x++) sum_line(extinction + x, ny, nx, lattice->edge_m[1], out_values + 4 * x + 2);
  return NEPH_OK;
}

static neph_result fill_z(void *user, unsigned slice, float *out_values) {
  const depths *d = user;
  const float *extinction = get_slice(d, slice);
  for (size_t i = 0; i < d->slice_count; i++) {
    const double own = (double)extinction[i], down = d->below[i] + 0.5 * own;
    out_values[2 * i] = (float)(d->lattice->edge_m[2] * fmax(d->all[i] - down, 0.0));
    out_values[2 * i + 1] = (float)(d->lattice->edge_m[2] * down);
    d->below[i] += own;
  }
  return NEPH_OK;
}

static neph_result sum_columns(neph_context *context, depths *d) {
  d->below = np_alloc(context, d->slice_count, sizeof *d->below);
  d->all = np_alloc(context, d->slice_count, sizeof *d->all);
  if (!d->below || !d->all) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned z = 0; z < d->lattice->size[2]; z++)
    for (size_t i = 0; i < d->slice_count; i++) d->all[i] += (double)get_slice(d, z)[i];
  return NEPH_OK;
}

static np_texture describe(const np_texture_lattice *lattice, depths *d) {
  return (np_texture){.mapping = "world = origin_m + u·edges_m[0] + v·edges_m[1] + w·edges_m[2], texel i of n at "
                                 "(i + 1/2)/n; x, y, z are the directions of the edges",
                      .dimensions = 3,
                      .size = {lattice->size[0], lattice->size[1], lattice->size[2]},
                      .has_place = true,
                      .to_world = lattice->to_world,
                      .user = d};
}

static neph_result add_extinction(const np_texture_cloud *cloud, depths *d) {
  np_texture texture = describe(d->lattice, d);
  texture.purpose = "density of the cloud";
  texture.texel = NP_TEXEL_R16F;
  texture.channels[0] =
      (np_texture_channel){"extinction; the value is a share of the greatest", "1/m", (double)d->lattice->greatest};
  texture.fill = fill_extinction;
  return np_texture_cloud_add_one(cloud, "extinction", &texture);
}

static neph_result add_xy(const np_texture_cloud *cloud, depths *d) {
  np_texture texture = describe(d->lattice, d);
  static const char *const meanings[] = {
      "optical depth towards +x, to the border of the box", "optical depth towards -x, to the border of the box",
      "optical depth towards +y, to the border of the box", "optical depth towards -y, to the border of the box"};
  texture.purpose = "light without shadow rays: transmittance along four directions";
  texture.texel = NP_TEXEL_RGBA16F;
  for (int i = 0; i < 4; i++) texture.channels[i] = (np_texture_channel){meanings[i], "1", 1.0};
  texture.fill = fill_xy;
  return np_texture_cloud_add_one(cloud, "depth_xy", &texture);
}

static neph_result add_z(const np_texture_cloud *cloud, depths *d) {
  np_texture texture = describe(d->lattice, d);
  texture.purpose = "light without shadow rays: transmittance upwards and downwards";
  texture.texel = NP_TEXEL_RG16F;
  texture.channels[0] = (np_texture_channel){"optical depth towards +z, to the border of the box", "1", 1.0};
  texture.channels[1] = (np_texture_channel){"optical depth towards -z, to the border of the box", "1", 1.0};
  texture.fill = fill_z;
  return np_texture_cloud_add_one(cloud, "depth_z", &texture);
}

neph_result np_texture_depth_add(const np_texture_cloud *cloud) {
  neph_context *context = cloud->set->context;
  const np_texture_lattice *lattice = &cloud->lattice;
  depths d = {.lattice = lattice, .slice_count = (size_t)lattice->size[0] * lattice->size[1]};
  neph_result result = cloud->set->desc->is_dry_run ? NEPH_OK : sum_columns(context, &d);
  if (!result) result = add_extinction(cloud, &d);
  if (!result) result = add_xy(cloud, &d);
  if (!result) result = add_z(cloud, &d);
  np_alloc_free(context, d.below);
  np_alloc_free(context, d.all);
  return result;
}
