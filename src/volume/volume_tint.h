/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a cloud, which overlap and add up: clouds of one colour each of which a cloud of many colours is made, or
 * levels of detail: those that never hold the same place twice (cloud/bake_lod.c), or the whole cloud in larger voxels
 * again, of which each copy of the cloud takes one (volume_coarser.c).
 *
 * The colours that occur are in a box of red, green and blue. Each is a mixture of at most four of the box's eight
 * corners, those of the tetrahedron of its order, and the density of a voxel is shared among them (Kasson, Nin, Plouffe
 * and Hafner 1995, "Performing color space conversions with three-dimensional linear interpolation"). Overlapping
 * clouds add up, so that together they have the density, and at each place the colour. Each is a volume of one albedo:
 * whoever renders, solves or caches knows of no colours. Between voxels colours are mixed by density, so that there is
 * no fringe where a cloud ends.
 */
#ifndef NP_VOLUME_VOLUME_TINT_H
#define NP_VOLUME_VOLUME_TINT_H

#include "volume/volume_private.h"

enum { NP_TINT_PARTS_MAX = 8 };

typedef enum np_volume_parts {
  NP_PARTS_OF_COLORS,
  NP_PARTS_OF_CELLS, /* white levels of detail, each with voxels of its own; the first may be empty */
  NP_PARTS_OF_COPIES /* the same, each of the whole cloud: they do not add up */
} np_volume_parts;

typedef struct np_tint_part {
  neph_volume *volume; /* NULL: the cloud itself, where it has one colour alone */
  double color[3];     /* in [0, 1] */
} np_tint_part;

typedef struct np_tint {
  neph_context *context; /* borrowed */
  unsigned count;
  np_volume_parts kind;
  np_tint_part parts[NP_TINT_PARTS_MAX];
} np_tint;

typedef struct np_tint_source {
  const char *path;
  const char *color;                 /* name of the grid; NULL: the usual ones, where one is there */
  const neph_volume_load_desc *load; /* of the density */
  const neph_volume *density;        /* as it was loaded */
} np_tint_source;

/* Shares a density among the colours that its file has; NULL where there are none. */
neph_result np_tint_create(neph_context *context, const np_tint_source *source, np_monitor *monitor,
                           np_tint **out_tint);
/* Parts of a cloud in levels of detail of a kind, of which it is the finest itself; the others, which hold something,
 * are given away to it. */
neph_result np_tint_create_levels(neph_context *context, np_volume_parts kind, np_tint **out_tint);
void np_tint_add_level(np_tint *tint, neph_volume *level);

void np_tint_destroy(np_tint *tint); /* NULL is allowed */

static inline bool np_volume_has_parts(const neph_volume *volume, np_volume_parts kind) {
  return volume->tint && volume->tint->kind == kind;
}

/* Volumes that a cloud is made of: itself, unless it has colours or levels of detail. */
static inline unsigned np_volume_count_parts(const neph_volume *volume) {
  return volume->tint ? volume->tint->count : 1;
}

static inline const neph_volume *np_volume_get_part(const neph_volume *volume, unsigned part) {
  const neph_volume *own = volume->tint ? volume->tint->parts[part].volume : NULL;
  return own ? own : volume;
}

#endif
