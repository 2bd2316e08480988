/* SPDX-License-Identifier: Apache-2.0 */
/* Statistics of the grids of a .vdb file, for `check` and `info`. */
#ifndef NP_VOLUME_VOLUME_FACTS_H
#define NP_VOLUME_VOLUME_FACTS_H

#include "core/parallel.h"
#include "volume/frustum.h"
#include "volume/value_tally.h"
#include "volume/volume_private.h"

/* Count of invalid values of one kind. */
typedef struct np_value_count {
  uint64_t count;
  double first_value;
  np_value_place first;
} np_value_count;

enum { NP_DIAGNOSES_MAX = 6 };

/* Texts are owned by the struct. */
typedef struct np_grid_facts {
  char *name, *value_type, *grid_class, *creator;
  np_grid_role role;
  bool is_unread; /* the grid has no use: only its header is read */
  bool is_scalar, is_count, is_vector, is_level_set, is_half_on_disk, is_instance;
  bool is_affine;  /* false: a frustum, or a transform that cannot be inverted */
  bool is_frustum; /* measured for densities alone */
  np_frustum_facts frustum;
  bool is_invertible; /* set for affine transforms */
  double index_to_world[3][4];
  double voxel_m[3]; /* edge lengths of a voxel, in the file's units */
  uint64_t active_count;
  int32_t active_min[3], active_max[3]; /* index box of the active samples, both ends inclusive */
  double world_min[3], world_max[3];    /* world box of the active samples, in the file's units */
  np_value_count kinds[NP_VALUE_KINDS]; /* counts of invalid values; for vectors, over all components */
  float background;                     /* background; for a vector, one of its components that is not finite, or 0 */
  /* Scalars alone: */
  bool has_values;
  float value_min, value_max; /* range of the active samples */
  double sum;                 /* sum of the finite active samples */
  double sum_of_others;       /* the sum without one of the largest values */
  np_value_place largest;
  np_value_count beyond_half; /* finite values above the largest half (65504) */
  double stray_ratio;         /* size of the active box over the size of the box of 99.9 % of its voxels */
  np_value_place stray;       /* block of active voxels that is farthest from the smallest box around 99.9 % of them */
  char *diagnoses[NP_DIAGNOSES_MAX]; /* messages of OpenVDB's own checks */
  unsigned diagnosis_count;
} np_grid_facts;

typedef struct np_file_facts {
  neph_context *context; /* borrowed */
  np_grid_facts *grids;
  size_t count;
  char *refusal; /* owned; reason why no density can be read; NULL: one can */
  char *absence; /* owned; message about a sequence file without its density; NULL: it has one */
} np_file_facts;

/* Grids of a file that a scene reads. */
typedef struct np_file_use {
  neph_volume_load_desc load; /* settings for its density */
  const char *sequence;       /* pattern of a sequence, in which a file may lack the density; NULL: a single file */
  bool has_up;                /* the scene states the up axis */
  const char *fields[3];      /* names of further scalars; NULL: none */
  np_vector_request vectors[3];
  unsigned vector_count;
} np_file_use;

/* Reads and measures all grids of a file, densities as loading would read them. Without `use`, the names of grids give
 * their roles; with it, grids that it does not name have none. Failures are reported as in loading; grids measured
 * before them stay. The caller clears the facts, whatever the outcome. `monitor` may be NULL. */
neph_result np_file_facts_measure(neph_context *context, const char *path, const np_file_use *use, np_monitor *monitor,
                                  np_file_facts *out_facts);
void np_file_facts_clear(np_file_facts *facts);

/* Writes a repaired copy of a file with all its grids and metadata. Values of scalar grids become finite and not
 * negative, densities become fog volumes with a background of 0, grids with values above 65504 are stored as floats,
 * and vectors become finite. Files of points are refused, because they cannot be copied. `out_path` must differ from
 * the file, end as it does, and appears complete or not at all. `*out_text`, to be freed, lists the changes, one line
 * for each grid. */
neph_result np_volume_mend_file(neph_context *context, const char *path, const char *out_path, np_monitor *monitor,
                                char **out_text);

#endif
