/* SPDX-License-Identifier: Apache-2.0 */
/* The values of a pixel by its numbers on the film: by samples that were taken now, or are read from parts. */
#include <math.h>

#include "frame/frame_state.h"

/* Largest relative standard error of one sample over the bands; radiances below `dim` count as `dim`. */
static double compute_relative_spread(const np_frame *f, const np_spread *spread) {
  double worst = 0.0;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    const double level = fmax(fabs(spread->mean[b]), f->dim[b]);
    const double deviation = sqrt(np_spread_variance(spread, b) * spread->count);
    if (deviation > 0.0) worst = fmax(worst, deviation / level);
  }
  return worst;
}

np_pixel_luminance np_frame_get_luminance(const np_frame *f, const np_spread *spread) {
  np_pixel_luminance out = {.count = (float)spread->count};
  double deviation = 0.0;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    out.value += (float)(f->luminance_weights[b] * spread->mean[b]);
    deviation += f->luminance_weights[b] * sqrt(np_spread_variance(spread, b));
  }
  out.variance = (float)(deviation * deviation);
  return out;
}

void np_frame_develop_pixel(const np_frame *f, size_t index, const np_pixel_facts *facts, const double *numbers,
                            np_tile_total *total) {
  const np_spread *spread = &facts->spread;
  const double *lost = np_channels_get_lost(&f->channels, numbers);
  float values[NP_CHANNELS_MAX];
  np_channels_finish(&f->channels, numbers, facts, values);
  for (unsigned c = 0; c < f->channels.count; c++) f->planes[c][index] = values[c];
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    total->sum[b] += spread->mean[b];
    total->variance[b] += np_spread_variance(spread, b);
    total->lost[b] += lost[b] / spread->count;
  }
  total->cut_count += (uint64_t)np_channels_get_cuts(&f->channels, numbers)[0];
  total->followed_count += (uint64_t)np_channels_get_cuts(&f->channels, numbers)[1];
  total->samples += spread->count;
  if (f->luminances) {
    f->luminances[index] = np_frame_get_luminance(f, spread);
    f->luminances[index].opacity = (float)(np_channels_get_opacity(&f->channels, numbers) / spread->count);
  }
  total->squares += pow(compute_relative_spread(f, spread), 2.0) / spread->count;
}
