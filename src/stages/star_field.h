/* SPDX-License-Identifier: Apache-2.0 */
/* The stars of one picture: points of light, put on the film.
 *
 * A star's irradiance is shared among the four pixels about it by the tent that the film reconstructs with, and divided
 * by the solid angle of each: radiance times solid angle adds up to its irradiance at any resolution, wherever in a
 * pixel it falls. Out of focus it is the picture of the aperture.
 */
#ifndef NP_STAGES_STAR_FIELD_H
#define NP_STAGES_STAR_FIELD_H

#include "atmosphere/magnitudes.h"
#include "atmosphere/stars.h"
#include "scene/camera.h"
#include "world/world.h"

/* Radiance that stars add to one pixel. */
typedef struct np_star_pixel {
  int x, y;
  np_spectrum radiance;
} np_star_pixel;

typedef struct np_star_field {
  neph_context *context;
  size_t count;
  np_star_pixel *pixels; /* one for each lit pixel, in order of rows */
  unsigned width;        /* width with the overscan on both sides */
  int overscan;
  int bokeh_reach;      /* pixels from the middle of a star out of focus to the edge of … */
  float *bokeh;         /* … its light's shares */
  np_spectrum *blurred; /* radiance of every pixel, where stars are out of focus; NULL: `pixels` are all */
} np_star_field;

typedef struct np_star_field_desc {
  const np_star_catalogue *catalogue;
  const np_world *world;   /* world whose air, planet and moon attenuate and hide stars, and whose night rotates them */
  const np_camera *camera; /* NULL: a latitude-longitude picture … */
  unsigned width, height;  /* … of this size … */
  int overscan;            /* pixels around the camera's picture */
  double center_rad;       /* … about this azimuth … */
  np_dvec3 origin;         /* observer's position in the world */
  const double *wavelength_nm; /* wavelengths of the bands */
  double twinkling;
  uint64_t seed;
  int frame;
} np_star_field_desc;

/* Projects the stars of a catalogue onto the film. On failure nothing needs to be freed. */
neph_result np_star_field_build(neph_context *context, const np_star_field_desc *desc, np_star_field *out_field);
void np_star_field_clear(np_star_field *field);

np_spectrum np_star_field_get(const np_star_field *field, int x, int y);

#endif
