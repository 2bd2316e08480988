/* SPDX-License-Identifier: Apache-2.0 */
/* Streams of random numbers derived from a description's seed. */
#ifndef NP_CLOUD_CLOUD_STREAMS_H
#define NP_CLOUD_CLOUD_STREAMS_H

#include <nephos/cloud.h>

#include "noise/noise.h"

/* The order of streams is part of the meaning of a seed. */
typedef enum np_cloud_stream {
  NP_CLOUD_STREAM_CELLS,
  NP_CLOUD_STREAM_SMALL_CELLS,
  NP_CLOUD_STREAM_SWIRL,
  NP_CLOUD_STREAM_GROUPS,
  NP_CLOUD_STREAM_BASE,
  NP_CLOUD_STREAM_CURL,
  NP_CLOUD_STREAM_DETAIL, /* one for each octave */
  NP_CLOUD_STREAM_SHEET = 32,
  NP_CLOUD_STREAM_RAIN,
  NP_CLOUD_STREAM_THERMALS,
  NP_CLOUD_STREAM_FILLERS,
  NP_CLOUD_STREAM_SCRAPS,
  NP_CLOUD_STREAM_FLOOR,
  NP_CLOUD_STREAM_WISPS,
  NP_CLOUD_STREAM_STREETS = 24,
  NP_CLOUD_STREAM_MESOSCALE,
  NP_CLOUD_STREAM_MESOSCALE_X,
  NP_CLOUD_STREAM_MESOSCALE_Y,
  NP_CLOUD_STREAM_ANVIL_LOBES,
  NP_CLOUD_STREAM_ANVIL_EDDIES,
  NP_CLOUD_STREAM_ANVIL_GROUPS,
  NP_CLOUD_STREAM_SHELVES,
  NP_CLOUD_STREAM_BILLOWS = 40, /* one for each level */
  NP_CLOUD_STREAM_PATCHES = 48, /* one for each level */
  NP_CLOUD_STREAM_WARP = 56     /* one for each octave */
} np_cloud_stream;

/* A lattice of a stream, without a period. */
static inline np_noise_lattice np_cloud_make_lattice(const neph_cloud_desc *desc, unsigned stream) {
  return (np_noise_lattice){np_noise_derive_seed(desc->seed, stream),
                            {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
}

#endif
