/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/frame_layers.h"

#include <string.h>

#include "image/deep.h"

np_integrator_layers *np_frame_start_layers(const np_frame *f, np_integrator_layers *layers) {
  memset(layers->cloud_opacity, 0, sizeof layers->cloud_opacity);
  memset(layers->group, 0, sizeof layers->group);
  memset(layers->motion, 0, sizeof layers->motion);
  layers->depth_components = f->depth_components;
  layers->depth_count = 0;
  return layers;
}

void np_frame_convert_layers(const np_packet *packet, np_integrator_layers *layers) {
  for (unsigned i = 0; i < layers->depth_count; i++)
    layers->depths[i].light = np_packet_add_color(packet, np_spectrum_grey(0.0f), layers->depths[i].light);
  for (unsigned g = 0; g < NP_LIGHT_GROUPS_MAX; g++)
    layers->group[g] = np_packet_add_color(packet, np_spectrum_grey(0.0f), layers->group[g]);
}

void np_frame_add_group(const np_frame *f, const np_camera_ray *ray, unsigned group,
                        const np_integrator_sample *sample) {
  np_spectrum *light = &ray->layers->group[group];
  *light = np_spectrum_add(*light, np_integrator_sum_light(sample, f->channels.beauty));
}

void np_frame_add_deep(const np_frame *f, const np_integrator_sample *sample, const np_integrator_layers *layers,
                       np_deep_bins *bins) {
  np_spectrum light = np_integrator_sum_light(sample, f->depth_components);
  if (f->depth_components & 1u << NP_COMPONENT_AIR)
    light = np_spectrum_subtract(light, sample->component[NP_COMPONENT_GROUND_AIR]);
  np_deep_bins_add(bins, layers, light, 1.0f - sample->transmittance - sample->held_out);
}

neph_result np_frame_set_deep(const np_frame *f, const np_pixel_state *p, size_t index, double cosine) {
  np_deep_bins bins;
  np_deep_sample samples[NP_DEEP_SAMPLES_MAX];
  np_deep_bins_load(&p->deep, &bins);
  const unsigned count = np_deep_bins_finish(&bins, p->next - p->begin, f->channels.scale, cosine, samples);
  return np_image_set_deep(f->image, index, samples, count);
}
