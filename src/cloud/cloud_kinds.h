/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of clouds: one row for each neph_cloud_model, in a file named after it. Nothing else depends on the model. */
#ifndef NP_CLOUD_CLOUD_KINDS_H
#define NP_CLOUD_CLOUD_KINDS_H

#include <nephos/cloud.h>

#include "cloud/cloud_wind.h"
#include "core/parallel.h"

typedef struct np_cloud_model np_cloud_model;
typedef struct np_cloud_points np_cloud_points;
typedef struct np_cloud_box np_cloud_box;

/* Shape of a landscape. */
typedef enum np_landscape_form {
  NP_LANDSCAPE_CELLS, /* rounded islands */
  NP_LANDSCAPE_SHEET, /* noise alone, stretched along the wind */
  NP_LANDSCAPE_HERO   /* one large cell with smaller ones around it */
} np_landscape_form;

/* Parameters of the landscape under a weather map. */
typedef struct np_landscape_rule {
  np_landscape_form form;
  float swirl_size;               /* size of the eddies that deform outlines, in cells */
  float group_height, group_gain; /* noise that groups cells: its height, and the gain of an octave */
  unsigned group_octaves;
  bool has_anvils;         /* the largest cells have anvils */
  bool has_patterns;       /* streets and mesoscale cells are available */
  bool has_mountain_waves; /* mountain waves replace the landscape */
  bool has_ground;         /* the ground always shapes the cloud, independent of lift and cover */
} np_landscape_rule;

typedef struct np_cloud_kind {
  const char *name; /* name in scenes and files */
  np_landscape_rule landscape;
  np_cloud_skew skew;
  const char *more_cover, *less_cover; /* advice if a field covers less or more than requested */
  const char *repeat_obstacle;         /* reason why fields of this kind cannot repeat; NULL: they can */
  bool has_thermals;                   /* consists of thermals, stacks of balls, or of a shape that replaces them */
  bool is_single;                      /* a single cloud in the middle of the field */
  bool has_pannus;                     /* ragged clouds in the rain */
  bool is_thin_at_border;   /* so thin at the border that the coverage may be out of reach for any voxel size */
  bool is_line;             /* does not fill a picture's shapes */
  bool has_thin_rims;       /* rims thinner than a voxel: a census evaluates the heights of all voxels */
  double billow_grains;     /* size of detail, in grains across the largest billows */
  double census_per_billow; /* heights per billow in a census, if more than usual */
  int census_passes; /* number of passes in which a census evaluates the heights of a column, until one has cloud */

  /* Sets up noises, from description and grain alone. */
  void (*prepare)(np_cloud_model *model);

  /* Sets values that depend on the slope at outlines, once the waterline is set; NULL: none. */
  void (*set_edges)(np_cloud_model *model);

  /* Searches the waterline of the map for the requested cloud cover. */
  neph_result (*search_waterline)(np_cloud_model *model, np_monitor *monitor);

  /* Builds the objects on the map; NULL: none. `clear` also frees the rest of a failed build. */
  neph_result (*build)(np_cloud_model *model, np_monitor *monitor);
  void (*clear)(np_cloud_model *model); /* NULL if `build` is NULL */

  /* Writes extinction where it is positive, apart from rain; values are 0, or the extinction of rain, before. */
  void (*eval)(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

  /* True only if the box is free of cloud, apart from rain; needs no noise. */
  bool (*is_empty)(const np_cloud_model *model, const np_cloud_box *box);
} np_cloud_kind;

/* Advice on coverage, for separate clouds and for kinds that fill the sky. */
#define NP_GAPS_STAY_CLEAR "its edges and the gaps between clouds stay clear; enlarge extent, or take a stratus"
#define NP_EDGES_STAY_CLEAR "its edges stay clear; enlarge extent"
#define NP_CLOUDS_COVER_NO_LESS "clouds of this size cover no less; enlarge extent, or reduce cell"

/* NULL: unknown model. */
const np_cloud_kind *np_cloud_kind_get(neph_cloud_model model);

extern const np_cloud_kind np_cells_kind, np_slab_kind, np_hero_kind, np_thermals_kind, np_fog_kind, np_lenses_kind,
    np_trails_kind, np_deck_kind, np_streaks_kind;

#endif
