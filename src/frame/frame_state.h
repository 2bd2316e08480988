/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a frame while it is rendered: frame.c sets it up and describes it, sampling.c fills it. */
#ifndef NP_FRAME_FRAME_STATE_H
#define NP_FRAME_FRAME_STATE_H

#include "frame/channels.h"
#include "frame/deep_pixels.h"
#include "frame/film_sink.h"
#include "frame/history.h"
#include "frame/sample_counts.h"
#include "frame/tile_feed.h"
#include "stages/assembly.h"
#include "stages/motion.h"

/* Sums over a tile's pixels, of their means and of the squared standard errors of the means. */
typedef struct np_tile_total {
  double sum[NP_BAND_COUNT], variance[NP_BAND_COUNT];
  double lost[NP_BAND_COUNT];         /* sum of the means that a limit on scatterings took away */
  uint64_t cut_count, followed_count; /* paths that met the limit on scatterings, and the followed ones of them */
  uint64_t samples;
  double squares; /* sum over the pixels of their squared relative errors */
} np_tile_total;

/* Indices of a pixel's samples: [begin, next) are done, [next, end) are still to be taken. */
typedef struct np_pixel_state {
  uint32_t begin, next, end;
  np_deep_stored deep; /* segments along the rays of its samples, for deep pixels */
  double *record;      /* record of the kept film, to be filled; NULL: none is kept */
  double *kept;        /* record of the samples that the renderer keeps; NULL: none are kept */
} np_pixel_state;

/* Luminance of a pixel, and the variance of it by its samples as of independent ones. */
typedef struct np_pixel_luminance {
  float value, variance, count;
  float opacity; /* opacity of the clouds */
} np_pixel_luminance;

/* Rows of pixels in progress, and a border of one pixel whose pilots measure the noise: slots of a grid. */
typedef struct np_pixel_rows {
  unsigned begin, count; /* rows of the frame, without the border */
  size_t stride;         /* slots in a row: the frame's width + 2 */
  np_pixel_state *states;
  np_pilot *pilots; /* NULL without a target error */
  double *numbers;  /* np_channels_count_numbers for each slot */
} np_pixel_rows;

typedef struct np_frame {
  const np_assembly *assembly;
  const neph_render_desc *desc;
  np_monitor *monitor;
  np_tile_feed *feed;
  const np_film_sink *sink;                 /* NULL: no film is kept */
  np_kept_film *film;                       /* NULL: none is kept */
  const double *focus;                      /* shares of the window, whose tiles come first; NULL: those at the top */
  struct np_kept_samples *kept;             /* samples of the picture so far, of a renderer; NULL: none are kept */
  struct np_reconstruction *reconstruction; /* fills pixels that are not rendered; NULL: all are */
  np_integrator_settings settings;
  np_integrator_fn integrate;
  np_half_distance_fn half_distance;
  np_view_depth_fn view_depth;
  float spread_rad;          /* angle between the middle pixel and the next; 0: rays are parallel */
  const np_motion *exposure; /* motion of camera and clouds while the shutter is open; NULL: nothing moves */
  const np_motion *vectors;  /* motion between frames for the motion vectors; NULL: no such channel */
  unsigned aovs;             /* bits of np_aov */
  bool has_light_groups;     /* their light is summed apart */
  bool has_layers;           /* its samples have np_integrator_layers */
  unsigned depth_components; /* bits of the components whose light deep pixels have; 0: there are no deep pixels */
  neph_image *image;
  np_channels channels;
  float *planes[NP_CHANNELS_MAX];
  np_tile_total *totals;
  np_pixel_luminance *luminances;          /* one for each pixel, for the estimate of its error; NULL: there is none */
  double luminance_weights[NP_BAND_COUNT]; /* weights of the picture's R, G and B */
  double dim[NP_BAND_COUNT];               /* radiances below this need not be as exact, relatively */
  double noise_target;                     /* noise that the target error leaves; infinite: there is no target */
  np_sample_rule rule;                     /* void without a target error */
  np_prediction *prediction;               /* borrowed: completed by pilots */
  np_pixel_rows rows;                      /* all rows with a time limit; some with a target error alone */
  bool is_first_pass;
  bool is_cut;                  /* the time limit came before all samples were taken */
  int min[2];                   /* first pixel that is rendered */
  int view_min[2], view_max[2]; /* the whole picture with its overscan */
  unsigned width, height;       /* size of the rendered window */
} np_frame;

static inline bool np_frame_has_target(const np_frame *f) { return isfinite(f->desc->target_error); }

/* Edge of a tile in pixels. */
enum { NP_TILE_EDGE = 8 };

size_t np_frame_count_tiles(const np_frame *f);

/* Takes a pixel's samples up to index `end`, and adds them to `numbers`, of np_channels_count_numbers elements. Fewer
 * are taken if the monitor stops the call, which drops the sample in progress. A first leaf of the film's tree that is
 * already begun is continued. */
neph_result np_frame_sample_pixel(const np_frame *f, const int at[2], uint32_t end, np_pixel_state *p, double *numbers);

/* Fills a pixel's values by its samples, and adds it to its tile. */
neph_result np_frame_finish_pixel(const np_frame *f, const int at[2], const np_pixel_state *p, const double *numbers,
                                  np_tile_total *total);

/* Depths along the ray of a pixel's centre, and a depth of the picture by a distance along it. */
np_pixel_guide np_frame_compute_guide(const np_frame *f, const int at[2]);
double np_frame_get_depth(const np_frame *f, const int at[2], double distance_m);

bool np_frame_is_in_view(const np_frame *f, const int at[2]);

/* Pilot of a pixel from its own first `count` samples. np_frame_fly_pilot draws it from separate samples, which are
 * then dropped. */
np_pilot np_frame_get_pilot(const np_frame *f, const double *numbers, uint32_t count);
neph_result np_frame_fly_pilot(const np_frame *f, const int at[2], uint32_t count, np_pilot *out);

/* A number of the pixel's own that its samples do not use, in [0, 1). */
double np_frame_draw_rounding(const np_frame *f, const int at[2]);

/* A copy that samples the luminance alone, with `desc` as its description; NULL: there is no memory. Freed by
 * np_alloc_free. */
np_frame *np_frame_copy_for_luminance(const np_frame *f, neph_render_desc *desc);

np_pixel_luminance np_frame_get_luminance(const np_frame *f, const np_spread *spread);

/* Samples every pixel and fills planes and totals, which has room for all tiles. */
neph_result np_frame_sample(np_frame *f);

/* Fills a pixel's values by its numbers, and adds it to its tile. */
void np_frame_develop_pixel(const np_frame *f, size_t index, const np_pixel_facts *facts, const double *numbers,
                            np_tile_total *total);

/* Writes the number of samples and the standard error of the pixels into the header. */
neph_result np_frame_describe(const np_frame *f, neph_image *image);

#endif
