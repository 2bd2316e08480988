/* SPDX-License-Identifier: Apache-2.0 */
/* Values of a key at key frames, and between them. */
#ifndef NP_SCENE_TRACK_H
#define NP_SCENE_TRACK_H

#include "scene/scene_key.h"

enum { NP_TRACK_PATH_SIZE = 120, NP_TRACK_ALL = -1 };

/* Between two key frames. Before the first and behind the last its value is held. */
typedef enum np_interpolation {
  NP_INTERPOLATION_STEP,
  NP_INTERPOLATION_LINEAR,
  NP_INTERPOLATION_SMOOTH,
  NP_INTERPOLATION_COUNT
} np_interpolation;

typedef struct np_track {
  char path[NP_TRACK_PATH_SIZE]; /* of the key, as --set takes it: "clouds[0].position" */
  const np_key *key;
  const np_key *list;   /* the list whose element has the key's field; NULL: the scene has it */
  unsigned element;     /* of that list */
  bool is_excluded;     /* by a later track, of a key that excludes this one */
  int component;        /* of a list, the only one that is animated; or NP_TRACK_ALL */
  unsigned value_count; /* numbers at each key frame */
  np_interpolation interpolation;
  unsigned key_count;
  double *frames;        /* rising */
  double *values;        /* [key_count][value_count], in SI; of a time, seconds since 1970 */
  bool lacks_zone;       /* a time was given without its zone, and taken as UTC */
  unsigned line, column; /* in the scene's file; 0: not from there */
} np_track;

/* "step"; by its name, or false. */
const char *np_interpolation_get_name(np_interpolation interpolation);
bool np_interpolation_get(const char *name, np_interpolation *out);

/* One number of a track in a frame, which may lie between two. */
double np_track_eval(const np_track *track, unsigned index, double frame);

/* Makes room for key frames and values, which np_track_clear frees. */
neph_result np_track_alloc(neph_context *context, np_track *track, unsigned key_count);
void np_track_clear(neph_context *context, np_track *track);

#endif
