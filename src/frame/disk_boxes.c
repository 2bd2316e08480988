/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/disk_boxes.h"

#include "scene/camera_kinds.h"

/* Pixels that a disk's edge reaches beyond it, by the width of the filter. */
static const double disk_margin = 2.0;

/* False: the light has no disk in view. */
static bool get_disk(const np_frame *f, const np_packet_light *light, np_pixel_box *out) {
  double film[2];
  if (!(light->beam.angular_radius_rad > 0.0) ||
      !np_camera_project_direction(&f->assembly->camera, light->beam.direction, film))
    return false;
  const double sr = np_camera_get_pixel_sr(&f->assembly->camera, (int)film[0], (int)film[1]);
  const double radius = disk_margin + (sr > 0.0 ? light->beam.angular_radius_rad / sqrt(sr) : 0.0);
  for (int a = 0; a < 2; a++) {
    out->min[a] = (int)fmax(floor(film[a] - radius), f->view_min[a]);
    out->max[a] = (int)fmin(ceil(film[a] + radius), f->view_max[a]);
    if (out->min[a] >= out->max[a]) return false;
  }
  return true;
}

unsigned np_frame_get_disks(const np_frame *f, np_pixel_box out[NP_LIGHTS_MAX]) {
  const np_packet *packet = &f->assembly->packets[0];
  unsigned count = 0;
  for (unsigned l = 0; l < packet->light_count; l++) count += get_disk(f, &packet->lights[l], &out[count]);
  return count;
}
