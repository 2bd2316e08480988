/* SPDX-License-Identifier: Apache-2.0 */
/* One frame: camera rays through an assembled scene to the channels of an image.
 *
 * The room of sampling. It calls plan, stages, the integrators and image. np_render_image builds the assembly and calls
 * np_frame_render, which sets up an np_frame (frame_state.h), samples its tiles (sampling.c, pixel_samples.c), develops
 * pixels to channels (channel_table.c), estimates the picture's error and writes the header. A caller that keeps the
 * numbers of pixels in files gives an np_film_sink (film_sink.h); src/parts has one, and no file of this room names it.
 */
#ifndef NP_FRAME_FRAME_H
#define NP_FRAME_FRAME_H

#include "frame/film_sink.h"
#include "stages/assembly.h"

/* Surroundings of a picture. */
typedef struct np_render_job {
  np_build_job build;
  struct np_tile_feed *feed;    /* borrowed: queue of finished tiles; NULL: tiles are not shown */
  const np_film_sink *sink;     /* keeps parts and checkpoints; NULL: of a plan that has none */
  struct np_kept_samples *kept; /* borrowed: samples of the picture before, to go on with; NULL: none are kept */
  const double *focus; /* borrowed: place in the picture, as shares, whose tiles come first; NULL: those at the top */
} np_render_job;

/* Renders the crop of the plan into a new image with R, G, B, A, Z and the scene's AOVs. The job has times. The same
 * bits for any number of threads and any division into crops. */
neph_result np_frame_render(const neph_scene *scene, const np_plan *plan, const np_render_job *job,
                            const np_assembly *assembly, np_monitor *monitor, neph_image **out_image);

/* neph_render_image by a plan, under a monitor that was started: the plan's time limit counts from then. */
neph_result np_render_image(const neph_scene *scene, np_plan *plan, const np_render_job *job, np_monitor *monitor,
                            neph_image **out_image);

#endif
