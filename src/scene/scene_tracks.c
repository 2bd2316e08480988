/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_tracks.h"

#include <math.h>

#include "scene/animation.h"

/* Struct with a track's field: the scene, or an element of one of its lists. */
static char *get_base(neph_scene *scene, const np_track *track) {
  if (!track->list) return (char *)scene;
  const bool is_cloud = track->list->field.offset == offsetof(neph_scene, clouds);
  return is_cloud ? (char *)&scene->clouds[track->element] : (char *)&scene->air.layers[track->element];
}

/* Writes a time, rounded to milliseconds. */
static void write_time(np_scene_moment *moment, double unix_s) {
  moment->is_given = true;
  moment->at = (np_time){.unix_s = round(1e3 * unix_s) / 1e3, .has_zone = true};
}

static void write_track(neph_scene *scene, const np_track *track, double frame) {
  void *field = get_base(scene, track) + track->key->field.offset;
  const unsigned first = track->component == NP_TRACK_ALL ? 0 : (unsigned)track->component;
  for (unsigned i = 0; i < track->value_count; i++) {
    const double value = np_track_eval(track, i, frame);
    if (track->key->type == NP_KEY_TIME)
      write_time(field, value);
    else if (track->key->type == NP_KEY_INTEGER)
      ((unsigned *)field)[first + i] = (unsigned)round(value);
    else
      ((double *)field)[first + i] = value;
  }
}

void np_scene_write_tracks(neph_scene *scene, double frame, double step_frame) {
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++) {
    const np_track *track = &scene->animation->tracks[i];
    if (!track->is_excluded)
      write_track(scene, track, track->interpolation == NP_INTERPOLATION_STEP ? step_frame : frame);
  }
}

void np_scene_write_section(neph_scene *scene, const char *path, double frame) {
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++) {
    const np_track *track = &scene->animation->tracks[i];
    if (!track->is_excluded && !track->list && np_track_is_in(track, path)) write_track(scene, track, frame);
  }
}
