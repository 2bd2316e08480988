/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of a picture: samples are added up, and a pixel's values follow from its sums. */
#ifndef NP_FRAME_CHANNELS_H
#define NP_FRAME_CHANNELS_H

#include "integrate/integrator.h"
#include "plan/plan.h"

enum { NP_CHANNELS_MAX = 512, NP_CHANNEL_NAME_MAX = 256, NP_CHANNEL_NONE = NP_CHANNELS_MAX };

/* Numbers that the film keeps of a pixel: the sums of the channels, of the light that a limit on scatterings took, by
 * bands, of the opacity of clouds, and of paths cut and followed; mean and squared distances of the picture's R, G and
 * B (image/film.h). */
enum {
  NP_PIXEL_SUMS_OWN = NP_BAND_COUNT + 3, /* besides the sums of the channels */
  NP_PIXEL_NUMBERS_MAX = NP_CHANNELS_MAX + NP_PIXEL_SUMS_OWN + 2 * NP_BAND_COUNT
};

typedef struct np_channels np_channels;
typedef struct np_channel np_channel;

/* The spread of a pixel's samples about their mean, in R, G and B. */
typedef struct np_spread {
  unsigned count;
  double mean[NP_BAND_COUNT], squares[NP_BAND_COUNT]; /* Σ(x − mean)² */
} np_spread;

/* Values of a pixel as a whole. */
typedef struct np_pixel_facts {
  double distance, depth; /* distance along the ray, and depth along the camera's axis, at which the transmittance falls
                             below one half */
  np_spread spread;
} np_pixel_facts;

/* The rule that fills a channel. */
typedef struct np_channel_kind {
  /* Value that one sample adds to the channel's sum; NULL: the channel has no sum of its own. */
  float (*read)(const np_channels *channels, const np_channel *channel, const np_camera_ray *ray,
                const np_integrator_sample *sample);
  /* A pixel's value from the sums of all channels. */
  double (*finish)(const np_channels *channels, const np_channel *channel, const double *sums,
                   const np_pixel_facts *facts);
  unsigned components;  /* bit c: component c is part of it */
  bool is_over_opacity; /* a mean weighted by opacity, whose sum is needed too */
  unsigned group;       /* number of a group of lights */
  unsigned alpha;       /* neph_alpha; read_alpha reads it */
} np_channel_kind;

struct np_channel {
  char name[NP_CHANNEL_NAME_MAX];
  np_channel_kind kind;
  unsigned part, index; /* band or axis; number among the sums */
};

struct np_channels {
  unsigned count;     /* channels of the picture */
  unsigned sum_count; /* number of `channel` entries: the picture's, then sums without a channel that some channels are
                         divided by */
  unsigned opaque;    /* number of the sum of the opacity; NP_CHANNEL_NONE: no channel needs it */
  unsigned mattes, matte_count;          /* number of the first matte's sum; count of all, the ground's last; 0: none */
  float matte_ids[NP_INSTANCES_MAX + 1]; /* identifiers of a Cryptomatte */
  bool is_ground_held_out;
  np_channel channel[NP_CHANNELS_MAX];
  unsigned beauty; /* components of the picture */
  float scale;     /* factor of radiances */
};

/* A sum; a channel of the picture too where it has a name. */
void np_channels_add(np_channels *channels, const char *name, np_channel_kind kind, unsigned part);

/* Sum of one band of a sample over the components in a bit mask. */
float np_channels_sum_components(const np_channels *channels, unsigned components, unsigned band,
                                 const np_integrator_sample *sample);

/* The mean over the samples, as a channel's `finish`. */
double np_channel_finish_mean(const np_channels *channels, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts);

/* Adds one sample to the sum of each channel. */
void np_channels_read(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                      float out_values[NP_CHANNELS_MAX]);

/* A pixel's values, from the sums over its samples. */
void np_channels_finish(const np_channels *channels, const double *sums, const np_pixel_facts *facts,
                        float out_values[NP_CHANNELS_MAX]);

/* Values of one sample for the film: as many as np_channels_count_numbers, but for the squares. */
void np_channels_read_numbers(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                              float out_values[NP_PIXEL_NUMBERS_MAX]);

static inline unsigned np_channels_count_numbers(const np_channels *channels) {
  return channels->sum_count + NP_PIXEL_SUMS_OWN + 2 * NP_BAND_COUNT;
}

/* The sums of the light that is lost, among a pixel's numbers. */
static inline const double *np_channels_get_lost(const np_channels *channels, const double *numbers) {
  return numbers + channels->sum_count;
}

static inline double np_channels_get_opacity(const np_channels *channels, const double *numbers) {
  return numbers[channels->sum_count + NP_BAND_COUNT];
}

/* Paths that met the limit on scatterings, and the number of followed ones among them. */
static inline const double *np_channels_get_cuts(const np_channels *channels, const double *numbers) {
  return numbers + channels->sum_count + NP_BAND_COUNT + 1;
}

/* The spread of `count` samples, by a pixel's numbers. */
np_spread np_channels_get_spread(const np_channels *channels, const double *numbers, unsigned count);

/* Squared standard error of the mean as of independent samples: the spread of their points over the pixel makes it
 * less, never more. 0 for a single sample, which has no spread. */
double np_spread_variance(const np_spread *spread, unsigned band);

#endif
