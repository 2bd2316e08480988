/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of clouds: one row for each neph_cloud_model, in the file of its name. Nothing else depends on the model. */
#ifndef NP_CLOUD_CLOUD_KINDS_H
#define NP_CLOUD_CLOUD_KINDS_H

#include <nephos/cloud.h>

#include "cloud/cloud_wind.h"
#include "core/parallel.h"

typedef struct np_cloud_model np_cloud_model;
typedef struct np_cloud_points np_cloud_points;
typedef struct np_cloud_box np_cloud_box;

/* Form of a landscape. */
typedef enum np_landscape_form {
  NP_LANDSCAPE_CELLS, /* rounded islands */
  NP_LANDSCAPE_SHEET, /* noise alone, longer along the wind */
  NP_LANDSCAPE_HERO   /* one large cell with lesser ones around it */
} np_landscape_form;

/* The landscape under a weather map. */
typedef struct np_landscape_rule {
  np_landscape_form form;
  float swirl_size;               /* of the eddies that bend outlines, in cells */
  float group_height, group_gain; /* noise that gathers cells in groups: its height, and the gain of an octave */
  unsigned group_octaves;
  bool has_anvils;         /* on the largest cells */
  bool has_patterns;       /* streets and mesoscale cells */
  bool has_mountain_waves; /* in place of the landscape */
  bool has_ground;         /* the ground shapes the cloud, whatever the description says of lift and cover */
} np_landscape_rule;

typedef struct np_cloud_kind {
  const char *name; /* in scenes and files */
  np_landscape_rule landscape;
  np_cloud_skew skew;
  const char *more_cover, *less_cover; /* reason why a field covers less or more than it should, and what helps */
  const char *repeat_obstacle;         /* reason why fields of it cannot repeat; NULL: they can */
  bool has_thermals;                   /* stacks of balls, to which a shape may be given */
  bool is_single;                      /* one cloud in the middle of the field */
  bool has_pannus;                     /* ragged clouds in the rain */
  bool is_thin_at_border;              /* so much that no voxel may reach the coverage */
  bool is_line;                        /* does not fill a picture's shapes */
  bool has_thin_rims;                  /* as thin as any voxel: a census evaluates the heights of all voxels */
  double billow_grains;                /* size of detail, in grains across the largest billows */
  double census_per_billow; /* heights that a census evaluates over a billow, where these are more than usual */
  int census_passes;        /* a census evaluates the heights of a column in so many portions, until it finds cloud */

  /* Sets noises, by description and grain alone. */
  void (*prepare)(np_cloud_model *model);

  /* Sets what follows from the slope at outlines, once there is a waterline; NULL: nothing does. */
  void (*set_edges)(np_cloud_model *model);

  /* Sets the waterline of the map at which the wanted share of the sky is covered. */
  neph_result (*search_waterline)(np_cloud_model *model, np_monitor *monitor);

  /* Makes what stands on the map; NULL: nothing does. What is left on failure is cleared as after success. */
  neph_result (*build)(np_cloud_model *model, np_monitor *monitor);
  void (*clear)(np_cloud_model *model); /* NULL: `build` is */

  /* Writes extinction where it is above 0, rain aside; all values are 0 before, or that of rain. */
  void (*eval)(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m);

  /* True only if there is no cloud anywhere in the box, rain aside; costs no noise. */
  bool (*is_empty)(const np_cloud_model *model, const np_cloud_box *box);
} np_cloud_kind;

/* Advice on coverage, for kinds of separate clouds and for kinds that fill the sky. */
#define NP_GAPS_STAY_CLEAR "its edges and the gaps between clouds stay clear; enlarge extent, or take a stratus"
#define NP_EDGES_STAY_CLEAR "its edges stay clear; enlarge extent"
#define NP_CLOUDS_COVER_NO_LESS "clouds of this size cover no less; enlarge extent, or lessen cell"

/* NULL: there is none of this number. */
const np_cloud_kind *np_cloud_kind_get(neph_cloud_model model);

extern const np_cloud_kind np_cells_kind, np_slab_kind, np_hero_kind, np_thermals_kind, np_fog_kind, np_lenses_kind,
    np_trails_kind, np_deck_kind, np_streaks_kind;

#endif
