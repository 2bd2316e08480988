/* SPDX-License-Identifier: Apache-2.0 */
/* Measures of a .vdb file's grids, for who judges them. */
#ifndef NP_VOLUME_VOLUME_FACTS_H
#define NP_VOLUME_VOLUME_FACTS_H

#include "core/parallel.h"
#include "volume/frustum.h"
#include "volume/value_tally.h"
#include "volume/volume_private.h"

/* Values of a kind. */
typedef struct np_value_count {
  uint64_t count;
  double first_value;
  np_value_place first;
} np_value_count;

enum { NP_DIAGNOSES_MAX = 6 };

/* Texts are owned. */
typedef struct np_grid_facts {
  char *name, *value_type, *grid_class, *creator;
  np_grid_role role;
  bool is_unread; /* of no use: its header alone is known */
  bool is_scalar, is_count, is_vector, is_level_set, is_half_on_disk, is_instance;
  bool is_affine;  /* else a frustum, or a transform that cannot be inverted */
  bool is_frustum; /* whose facts are known of densities alone */
  np_frustum_facts frustum;
  bool is_invertible; /* of those that are affine */
  double index_to_world[3][4];
  double voxel_m[3]; /* lengths of its edges, in the file's units */
  uint64_t active_count;
  int32_t active_min[3], active_max[3]; /* index box of the active samples, both ends inside it */
  double world_min[3], world_max[3];    /* the same, in the file's units */
  np_value_count kinds[NP_VALUE_KINDS]; /* of vectors, over all components */
  float background;                     /* of a vector's components one that is not finite, or 0 */
  /* Scalars alone: */
  bool has_values;
  float value_min, value_max; /* the range of the active samples */
  double sum;                 /* of the finite active samples */
  double sum_of_others;       /* of all of them but one of the largest value */
  np_value_place largest;
  np_value_count beyond_half;        /* finite, and above the largest half */
  double stray_ratio;                /* size of the box over that of all but a thousandth of its voxels */
  np_value_place stray;              /* the block farthest from those */
  char *diagnoses[NP_DIAGNOSES_MAX]; /* OpenVDB's own complaints */
  unsigned diagnosis_count;
} np_grid_facts;

typedef struct np_file_facts {
  neph_context *context; /* borrowed */
  np_grid_facts *grids;
  size_t count;
  char *refusal; /* owned; why no density can be read from it; NULL: one can */
  char *absence; /* owned; of a file of a sequence that lacks its density; NULL: it does not */
} np_file_facts;

/* Grids of a file that a scene uses. */
typedef struct np_file_use {
  neph_volume_load_desc load; /* of its density */
  const char *sequence;       /* pattern of the files, of which some may lack a density; NULL: a file by itself */
  bool has_up;                /* the scene says which axis points up */
  const char *fields[2];      /* names of further scalars; NULL: none */
  np_vector_request vectors[3];
  unsigned vector_count;
} np_file_use;

/* Reads all grids of a file, as densities those that would be loaded as such. Without a use, the purpose of the others
 * is that of their names; with one, grids that it does not name have none. What fails is reported, as loading reports
 * it; grids measured before it stay. The caller clears the facts, whatever the outcome. `monitor` may be NULL. */
neph_result np_file_facts_measure(neph_context *context, const char *path, const np_file_use *use, np_monitor *monitor,
                                  np_file_facts *out_facts);
void np_file_facts_clear(np_file_facts *facts);

/* Writes a copy of a file in which scalar grids hold a cloud's values, finite and not negative, densities end in a
 * background of 0 and are called fog volumes, those beyond halves are stored as floats, and vectors are finite; with
 * all other grids, and all metadata. Refuses files of points, which cannot be copied. `out_path` appears complete or
 * not at all, and must not be the file itself. `*out_text`, to be freed, says what has changed, a line for each grid.
 */
neph_result np_volume_mend_file(neph_context *context, const char *path, const char *out_path, np_monitor *monitor,
                                char **out_text);

#endif
