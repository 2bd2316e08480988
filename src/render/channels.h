/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of a picture: from samples to sums, from a pixel's sums to its values. */
#ifndef NP_RENDER_CHANNELS_H
#define NP_RENDER_CHANNELS_H

#include "integrate/integrator.h"
#include "render/plan.h"

enum { NP_CHANNELS_MAX = 64, NP_CHANNEL_NAME_MAX = 32 };

typedef struct np_channels np_channels;
typedef struct np_channel np_channel;

/* The spread of a pixel's samples about their mean (Welford 1962), in R, G and B. */
typedef struct np_spread {
  unsigned count;
  double mean[NP_BAND_COUNT], squares[NP_BAND_COUNT]; /* Σ(x − mean)² */
} np_spread;

/* Values of a pixel as a whole. */
typedef struct np_pixel_facts {
  double distance, depth; /* to where half is hidden; along the ray, along the camera's axis */
  np_spread spread;
} np_pixel_facts;

/* Rules by which channels are filled. */
typedef struct np_channel_kind {
  /* Adds one sample to the sum; NULL: nothing. */
  float (*read)(const np_channels *channels, const np_channel *channel, const np_camera_ray *ray,
                const np_integrator_sample *sample);
  /* A pixel's value from its sum; `opaque` is the sum of A. */
  double (*finish)(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts);
  unsigned components; /* bit c: component c is part of it */
} np_channel_kind;

struct np_channel {
  char name[NP_CHANNEL_NAME_MAX];
  np_channel_kind kind;
  unsigned part; /* band, or axis */
};

struct np_channels {
  unsigned count, alpha; /* `alpha`: number of the channel A */
  np_channel channel[NP_CHANNELS_MAX];
  unsigned beauty; /* components of the picture */
  float scale;     /* on radiances */
};

/* The picture's own channels and the plan's AOVs. */
void np_channels_choose(const np_plan *plan, bool has_background, float scale, np_channels *out);

/* Adds one sample to the sum of each channel. */
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
