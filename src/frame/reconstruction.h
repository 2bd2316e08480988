/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of which a part of the pixels is rendered: the others come from the frame before (render.history), or from
 * their neighbours (render.upsample).
 *
 * The picture is divided into squares, of which a frame renders one pixel each, in an order that goes over the whole
 * square in as many frames as it has pixels. Pixels without history are rendered too, or, of an upsampled picture, one
 * of each smaller square of them, and the rest is interpolated from those nearby that are as far away (Kopf et al.
 * 2007, "Joint Bilateral Upsampling"); a pixel without such neighbours is rendered. History is clipped to the mean and
 * the deviation of rendered pixels nearby (Salvi 2016, "An Excursion in Temporal Supersampling"), and a pixel that is
 * rendered is averaged with its history exponentially. */
#ifndef NP_FRAME_RECONSTRUCTION_H
#define NP_FRAME_RECONSTRUCTION_H

#include "frame/frame_state.h"
#include "frame/reprojection.h"

enum { NP_HISTORY_AXES = 4 }; /* axes along which history is clipped: luma, two colour differences, coverage */

typedef enum np_pixel_source { NP_PIXEL_INTERPOLATED, NP_PIXEL_REPROJECTED, NP_PIXEL_RENDERED } np_pixel_source;

/* A lattice of pixels: the pixel `at` of each square of `edge` × `edge` pixels. */
typedef struct np_pixel_lattice {
  unsigned edge;
  unsigned at[2];
} np_pixel_lattice;

static inline bool np_pixel_lattice_has(const np_pixel_lattice *lattice, unsigned x, unsigned y) {
  return x % lattice->edge == lattice->at[0] && y % lattice->edge == lattice->at[1];
}

typedef struct np_reconstruction {
  neph_context *context;
  unsigned width, height;
  int min[2];
  const np_history_frame *before; /* NULL: none */
  bool has_history;               /* the picture is stored as history for the next frame */
  bool is_cut;                    /* a cut: too few pixels of the previous picture can be reprojected */
  bool has_still_light;           /* the camera alone moves */
  bool has_beauty;                /* the first channels are R, G, B */
  double weight_min;
  np_pixel_lattice update;     /* rendered in any case */
  np_pixel_lattice resolution; /* rendered where there is no history */
  np_reprojected *places;      /* the place of each pixel in the frame before; NULL: none */
  uint8_t *sources;            /* np_pixel_source of each pixel */
  float *changes; /* [channel][pixel]: rendered value less history; unset for pixels that are not rendered */
  uint64_t source_counts[NP_PIXEL_RENDERED + 1];
  np_history_frame next; /* the picture, for the next frame */
} np_reconstruction;

/* NULL where all pixels of the plan's picture are rendered. */
neph_result np_reconstruction_create(const neph_scene *scene, const np_plan *plan, const np_frame *f,
                                     np_reconstruction **out);
void np_reconstruction_destroy(np_reconstruction *r);

/* Projects pixels into the frame before, and chooses the pixels that are rendered. */
neph_result np_reconstruction_prepare(np_frame *f);

static inline bool np_reconstruction_is_rendered(const np_reconstruction *r, size_t index) {
  return r->sources[index] == NP_PIXEL_RENDERED;
}

/* Fills the planes of the frame, which have the pixels that were rendered. */
neph_result np_reconstruction_resolve(np_frame *f);

/* Writes the shares of rendered, reprojected and interpolated pixels into the header and the log. */
neph_result np_reconstruction_describe(const np_frame *f, neph_image *image);

/* Puts the frame into the stores as history for the next frame. */
neph_result np_reconstruction_store(np_reconstruction *r, const np_plan *plan, np_stores *stores);

/* Whether a pixel has neighbours on the resolution's lattice that it may be interpolated from. */
bool np_reconstruction_has_alike(const np_reconstruction *r, unsigned x, unsigned y);

/* Passes over the rows: compare rendered pixels with their history, blend both, and interpolate the other pixels. */
void np_reconstruction_compare_row(const np_frame *f, unsigned y);
void np_reconstruction_blend_row(const np_frame *f, unsigned y);
void np_reconstruction_interpolate_row(const np_frame *f, unsigned y);

#endif
