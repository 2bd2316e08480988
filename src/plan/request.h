/* SPDX-License-Identifier: Apache-2.0 */
/* The first part of a plan: the picture that is requested. It follows from the scene and the caller's description
 * alone; request.c writes it. */
#ifndef NP_PLAN_REQUEST_H
#define NP_PLAN_REQUEST_H

#include "scene/scene_private.h"

/* A picture of the sky alone, without clouds and terrain. */
typedef struct np_sky_request {
  bool is_of_bands;  /* its channels are bands at 680, 550 and 440 nm, whatever the scene's pictures are */
  unsigned size[2];  /* size of a latitude-longitude picture; 0: the camera's picture */
  double center_rad; /* azimuth of the panorama's centre */
} np_sky_request;

typedef struct np_request {
  neph_context *context;            /* borrowed */
  neph_render_desc desc;            /* checked description: the caller's values, else the scene's */
  int view_min[2], view_max[2];     /* pixels of the picture and its overscan; view_max is one past the last */
  int window_min[2], window_max[2]; /* the rendered pixels: the data window */
  int whole_min[2], whole_max[2];   /* the window that is divided into tiles */
  bool is_sky_alone;                /* `sky` is requested */
  bool takes_near; /* results of earlier pictures that are near its own serve it: one of more pixels or samples follows
                    */
  np_sky_request sky;
  bool has_beauty;
  unsigned aovs;                       /* bits of np_aov */
  bool has_light_groups;               /* each light is rendered in a world without the others, and summed separately */
  uint64_t ray_count;                  /* rays of the camera: pixels of the window times samples */
  uint64_t film_bytes;                 /* the film's channels in float */
  double light_bytes;                  /* memory for multiple scattering while it is solved for */
  double work_factor[NEPH_WORK_COUNT]; /* time of each kind of work over its time on the machine of the constants */
} np_request;

/* Whether the picture is a first one, by the detail of another height, which a finer picture follows. */
static inline bool np_request_is_coarse(const np_request *request) {
  return request->desc.detail_height && request->desc.detail_height != request->desc.height;
}

/* Whether the clouds of a picture are sketches: of a first one whose light is an approximation in any case. */
static inline bool np_request_has_sketches(const np_request *request) {
  return np_request_is_coarse(request) && request->desc.multiple_scattering != NEPH_MULTIPLE_SCATTERING_ORDINATES;
}

/* Checks scene and description. `desc` NULL: the scene's own. */
neph_result np_request_make(const neph_scene *scene, const neph_render_desc *desc, np_request *out_request);

neph_result np_request_make_sky(const neph_scene *scene, const np_sky_request *sky, np_request *out_request);

/* The caller's description over the scene's, checked. */
neph_result np_request_read_desc(const neph_scene *scene, const neph_render_desc *desc, neph_render_desc *out_desc);

/* The request by which detail is chosen: this one, or one with the height that the caller sets for detail. */
np_request np_request_get_detail(const np_request *request, const neph_scene *scene);

static inline uint64_t np_request_count_pixels(const np_request *request) {
  const int *min = request->window_min, *max = request->window_max;
  return (uint64_t)(max[0] - min[0]) * (uint64_t)(max[1] - min[1]);
}

static inline bool np_request_is_path(const np_request *request) {
  return request->desc.integrator == NEPH_INTEGRATOR_PATH;
}

/* Whether paths continue through the air and from the ground. */
static inline bool np_request_traces_air(const np_request *request) {
  return np_request_is_path(request) && request->desc.atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED;
}

#endif
