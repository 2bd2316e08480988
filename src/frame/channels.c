/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/channels.h"

#include "core/text.h"

void np_channels_add(np_channels *c, const char *name, np_channel_kind kind, unsigned part) {
  const unsigned index = c->sum_count++;
  c->channel[index] = (np_channel){.kind = kind, .part = part, .index = index};
  if (!name) return;
  np_print(c->channel[index].name, sizeof c->channel[index].name, "%s", name);
  c->count = c->sum_count;
}

float np_channels_sum_components(const np_channels *c, unsigned components, unsigned band,
                                 const np_integrator_sample *sample) {
  float sum = 0.0f;
  for (unsigned i = 0; i < NP_COMPONENT_ALL; i++)
    if (components & 1u << i) sum += sample->component[i].band[band];
  return sum * c->scale;
}

double np_channel_finish_mean(const np_channels *c, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts) {
  (void)c;
  return sums[channel->index] / facts->spread.count;
}

void np_channels_read(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                      float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->sum_count; i++) {
    const np_channel *channel = &channels->channel[i];
    out_values[i] = channel->kind.read ? channel->kind.read(channels, channel, ray, sample) : 0.0f;
  }
}

void np_channels_finish(const np_channels *channels, const double *sums, const np_pixel_facts *facts,
                        float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->count; i++) {
    const np_channel *channel = &channels->channel[i];
    out_values[i] = (float)channel->kind.finish(channels, channel, sums, facts);
  }
}

void np_channels_read_numbers(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                              float out_values[NP_PIXEL_NUMBERS_MAX]) {
  np_channels_read(channels, ray, sample, out_values);
  float *lost = out_values + channels->sum_count, *color = lost + NP_PIXEL_SUMS_OWN;
  lost[NP_BAND_COUNT] = 1.0f - sample->transmittance;
  lost[NP_BAND_COUNT + 1] = (float)sample->cut_count;
  lost[NP_BAND_COUNT + 2] = (float)sample->followed_count;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    lost[b] = sample->lost.band[b] * channels->scale;
    color[b] = np_channels_sum_components(channels, channels->beauty, b, sample);
  }
}

np_spread np_channels_get_spread(const np_channels *channels, const double *numbers, unsigned count) {
  const double *mean = np_channels_get_lost(channels, numbers) + NP_PIXEL_SUMS_OWN;
  np_spread spread = {.count = count};
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    spread.mean[b] = mean[b];
    spread.squares[b] = mean[NP_BAND_COUNT + b];
  }
  return spread;
}

double np_spread_variance(const np_spread *spread, unsigned band) {
  return spread->count < 2 ? 0.0 : spread->squares[band] / spread->count / (spread->count - 1);
}
