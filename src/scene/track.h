/* SPDX-License-Identifier: Apache-2.0 */
/* Values of a key at key frames, and their interpolation. */
#ifndef NP_SCENE_TRACK_H
#define NP_SCENE_TRACK_H

#include "scene/scene_key.h"

enum { NP_TRACK_PATH_SIZE = 120, NP_TRACK_ALL = -1 };

/* Interpolation between two key frames. The value is constant before the first and after the last one. */
typedef enum np_interpolation {
  NP_INTERPOLATION_STEP,
  NP_INTERPOLATION_LINEAR,
  NP_INTERPOLATION_SMOOTH,
  NP_INTERPOLATION_COUNT
} np_interpolation;

typedef struct np_track {
  char path[NP_TRACK_PATH_SIZE]; /* path of the key as in --set: "clouds[0].position" */
  const np_key *key;
  const np_key *list;   /* list whose element has the key's field; NULL: a field of the scene */
  unsigned element;     /* index of the element */
  bool is_excluded;     /* a later track of a key that excludes this one overrides it */
  int component;        /* index of the only animated number of a list; or NP_TRACK_ALL */
  unsigned value_count; /* numbers per key frame */
  np_interpolation interpolation;
  unsigned key_count;
  double *frames;        /* ascending */
  double *values;        /* [key_count][value_count], in SI; times are seconds since 1970 */
  bool lacks_zone;       /* a time has no zone, and counts as UTC */
  unsigned line, column; /* in the scene's file; 0: not from a file */
} np_track;

/* Name such as "step"; the second parses it and returns false for an unknown name. */
const char *np_interpolation_get_name(np_interpolation interpolation);
bool np_interpolation_get(const char *name, np_interpolation *out);

/* One number of a track in a frame, which may be fractional. */
double np_track_eval(const np_track *track, unsigned index, double frame);

/* Allocates key frames and values; np_track_clear frees them. */
neph_result np_track_alloc(neph_context *context, np_track *track, unsigned key_count);
void np_track_clear(neph_context *context, np_track *track);

#endif
