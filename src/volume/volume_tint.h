/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a cloud. Parts overlap and add up: the colours of a cloud with varying albedo, its sizes of droplets
 * (volume_sizes.h), or levels of detail that never overlap (cloud/bake_lod.c). Alternatively they are coarser versions
 * of the whole cloud, of which each copy uses one (volume_coarser.c).
 *
 * The colours of a cloud lie in a box of red, green and blue. Each is a mixture of at most four corners of the box, by
 * tetrahedral interpolation (Kasson, Nin, Plouffe and Hafner 1995, "Performing color space conversions with
 * three-dimensional linear interpolation"), and the density of a voxel is split among them. The parts sum to the
 * density, and to the colour at each point. Each part is a volume with one albedo, so that renderers, solvers and
 * caches need no colours. Between voxels colours are mixed by density, which avoids fringes at the edge of a cloud. */
#ifndef NP_VOLUME_VOLUME_TINT_H
#define NP_VOLUME_VOLUME_TINT_H

#include "volume/volume_private.h"

enum { NP_TINT_PARTS_MAX = 8 };

typedef enum np_volume_parts {
  NP_PARTS_OF_COLORS,
  NP_PARTS_OF_CELLS,  /* white levels of detail, which do not overlap; the first may be empty */
  NP_PARTS_OF_COPIES, /* white coarser versions of the whole cloud: they do not add up */
  NP_PARTS_OF_SIZES   /* white, each with the phase function of droplets of one size, or of crystals */
} np_volume_parts;

typedef struct np_tint_part {
  neph_volume *volume; /* NULL: the cloud itself, which has one colour */
  double color[3];     /* in [0, 1] */
  double diameter_m;   /* size of the droplets whose phase function it has; 0: the cloud's own phase function */
  bool is_ice;         /* it has the phase function of crystals */
} np_tint_part;

typedef struct np_tint {
  neph_context *context; /* borrowed */
  unsigned count;
  np_volume_parts kind;
  np_tint_part parts[NP_TINT_PARTS_MAX];
} np_tint;

typedef struct np_tint_source {
  const char *path;
  const char *color;                 /* name of the grid; NULL: one of the conventional names, optional */
  const neph_volume_load_desc *load; /* settings of the density */
  const neph_volume *density;        /* loaded density */
} np_tint_source;

/* Splits a density among the colours of its file; NULL if the file has no colours. */
neph_result np_tint_create(neph_context *context, const np_tint_source *source, np_monitor *monitor,
                           np_tint **out_tint);
/* Creates the parts of a cloud with levels of detail. The cloud itself is the finest; np_volume_add_level adds the
 * others. */
neph_result np_tint_create_levels(neph_context *context, np_volume_parts kind, np_tint **out_tint);
void np_tint_add_level(np_tint *tint, neph_volume *level);

void np_tint_destroy(np_tint *tint); /* NULL is allowed */

static inline bool np_volume_has_parts(const neph_volume *volume, np_volume_parts kind) {
  return volume->tint && volume->tint->kind == kind;
}

/* Whether the parts add up voxel by voxel: they have the cloud's lattice and place. */
static inline bool np_volume_has_shares(const neph_volume *volume) {
  return np_volume_has_parts(volume, NP_PARTS_OF_COLORS) || np_volume_has_parts(volume, NP_PARTS_OF_SIZES);
}

/* Number of volumes of a cloud: 1, unless it has colours or levels of detail. */
static inline unsigned np_volume_count_parts(const neph_volume *volume) {
  return volume->tint ? volume->tint->count : 1;
}

static inline const neph_volume *np_volume_get_part(const neph_volume *volume, unsigned part) {
  const neph_volume *own = volume->tint ? volume->tint->parts[part].volume : NULL;
  return own ? own : volume;
}

#endif
