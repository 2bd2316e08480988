/* SPDX-License-Identifier: Apache-2.0 */
/* The pieces that a stretch of a ray is cut into, in order: all alike, or, where they are shorter than a voxel, alike
 * from one face of the lattice of samples to the next: between faces the field is smooth. */
#ifndef NP_INTEGRATE_CUTS_H
#define NP_INTEGRATE_CUTS_H

#include "integrate/stretch.h"

typedef struct np_cuts {
  float at, end; /* m from the stretch's begin: of the next piece, of all */
  float length;  /* of the next `left` pieces */
  int left;
  float least;              /* m; what then is left is rounding */
  float per_m;              /* pieces between faces, at least */
  float next[3], stride[3]; /* along each axis: the next face, and from one to another */
} np_cuts;

/* `count` pieces, which end at faces of `medium`, the one with the finest voxels, where there are as many of those. */
static inline void np_cuts_start(np_cuts *c, const np_stretch *s, const np_medium *medium, int count) {
  const float extent = (float)(s->end - s->begin);
  *c = (np_cuts){.end = extent, .length = extent / (float)count, .per_m = (float)count / extent};
  if (c->per_m < medium->voxels_per_m) {
    c->left = count;
    c->least = extent;
    return;
  }
  c->least = 1e-5f / medium->voxels_per_m;
  const np_vec3 begin = np_brick_walk_local(&medium->walk, &medium->span, s->begin), d = np_medium_direction(medium);
  const float place[3] = {begin.x, begin.y, begin.z}, along[3] = {d.x, d.y, d.z};
  for (int a = 0; a < 3; a++) {
    const bool is_level = fabsf(along[a]) < 1e-6f * medium->voxels_per_m;
    const float face = along[a] > 0.0f ? floorf(place[a]) + 1.0f : ceilf(place[a]) - 1.0f;
    c->next[a] = is_level ? INFINITY : (face - place[a]) / along[a];
    c->stride[a] = is_level ? 0.0f : fabsf(1.0f / along[a]);
  }
}

/* Goes on to the next face; false at the end. */
static inline bool np_cuts_pass_face(np_cuts *c) {
  float face = c->at;
  while (face - c->at <= c->least) {
    if (c->end - c->at <= c->least) return false;
    const int axis = c->next[0] <= c->next[1] ? (c->next[0] <= c->next[2] ? 0 : 2) : (c->next[1] <= c->next[2] ? 1 : 2);
    face = c->next[axis] < c->end ? c->next[axis] : c->end;
    c->next[axis] += c->stride[axis];
  }
  c->left = (int)ceilf((face - c->at) * c->per_m);
  c->length = (face - c->at) / (float)c->left;
  return true;
}

/* The next pieces, their middles and lengths; returns how many. */
static inline int np_cuts_take(np_cuts *c, float middle[NP_BRICK_LINE], float length[NP_BRICK_LINE]) {
  int count = 0;
  for (; count < NP_BRICK_LINE && (c->left > 0 || np_cuts_pass_face(c)); count++, c->left--) {
    middle[count] = c->at + 0.5f * c->length;
    length[count] = c->length;
    c->at += c->length;
  }
  for (int k = count; k < NP_BRICK_LINE; k++) middle[k] = 0.0f;
  return count;
}

#endif
