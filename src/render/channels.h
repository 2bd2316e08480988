/* SPDX-License-Identifier: Apache-2.0 */
/* What the channels of a picture hold: from samples to sums, from a pixel's sums to its values. */
#ifndef NP_RENDER_CHANNELS_H
#define NP_RENDER_CHANNELS_H

#include "integrate/integrator.h"
#include "scene/plan.h"

enum { NP_CHANNELS_MAX = 56 };

/* A sum over components, or one of the others. */
typedef enum np_channel_source {
  NP_CHANNEL_COMPONENTS,
  NP_CHANNEL_ALPHA,
  NP_CHANNEL_TRANSMITTANCE,
  NP_CHANNEL_ALBEDO,        /* mean over what is not transparent */
  NP_CHANNEL_MEAN_DISTANCE, /* likewise */
  NP_CHANNEL_POSITION,      /* likewise */
  NP_CHANNEL_DEPTH,
  NP_CHANNEL_DISTANCE,
  NP_CHANNEL_VARIANCE,
  NP_CHANNEL_STANDARD_ERROR,
  NP_CHANNEL_SAMPLE_COUNT
} np_channel_source;

typedef struct np_channel {
  const char *name;
  np_channel_source source;
  unsigned components; /* bit c: component c is part of it */
  unsigned part;       /* band, or axis */
} np_channel;

typedef struct np_channels {
  unsigned count, alpha; /* `alpha`: number of the channel A */
  np_channel channel[NP_CHANNELS_MAX];
  unsigned beauty; /* components of the picture */
  float scale;     /* on radiances */
} np_channels;

/* The spread of a pixel's samples about their mean (Welford 1962), in R, G and B. */
typedef struct np_spread {
  unsigned count;
  double mean[NP_BAND_COUNT], squares[NP_BAND_COUNT]; /* Σ(x − mean)² */
} np_spread;

/* Of a pixel as a whole. */
typedef struct np_pixel_facts {
  double distance, depth; /* to where half is hidden; along the ray, along the camera's axis */
  np_spread spread;
} np_pixel_facts;

/* The picture's own channels and the plan's AOVs. */
void np_channels_choose(const np_plan *plan, bool has_background, float scale, np_channels *out);

/* What one sample adds to the sum of each channel. */
void np_channels_read(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                      float out_values[NP_CHANNELS_MAX]);

/* A pixel's values, from the sums over its samples. */
void np_channels_finish(const np_channels *channels, const double *sums, const np_pixel_facts *facts,
                        float out_values[NP_CHANNELS_MAX]);

void np_spread_add(const np_channels *channels, const np_integrator_sample *sample, np_spread *spread);

/* Squared standard error of the mean as of independent samples: the spread of their points over the pixel makes it
 * less, never more. 0 where one sample tells nothing. */
double np_spread_variance(const np_spread *spread, unsigned band);

#endif
