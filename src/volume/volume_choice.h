/* SPDX-License-Identifier: Apache-2.0 */
/* Choice of the grids of a file that hold the density, and the role of each grid by its name. Inside the volume module
 * only. */
#ifndef NP_VOLUME_VOLUME_CHOICE_H
#define NP_VOLUME_VOLUME_CHOICE_H

#include "volume/volume_file.h"

/* Request for a grid. */
typedef struct np_grid_query {
  const char *grid;        /* a name, "name[i]", or several joined by "+"; NULL: the default choice */
  double level_set_voxels; /* 0: level sets are refused */
  bool is_field;           /* not a density: any numbers are valid */
  const char *key;         /* scene key that names a field, for messages; NULL: none */
  const char *sequence;    /* pattern of a sequence, in which a file may lack the density; NULL: a single file */
} np_grid_query;

/* Chooses the grids to read. A name matches exactly, else without case. Without a name the choice is "density", else
 * the only scalar grid that is a fog volume, else the only scalar of another class, else the only grid of integers or
 * masks; a grid named like a velocity or a field is never a density by default. In a sequence one name holds for all
 * files, and a file that lacks the grid yields an empty choice: fluid programs leave out empty grids. `*out_refusal`,
 * to be freed, says why no grid can be chosen; NULL: success. */
neph_result np_volume_choose(const np_volume_file *file, const np_grid_query *query, np_volume_choice *out_choice,
                             char **out_refusal);

/* Message, to be freed, about a file of a sequence that lacks the density, with a list of its grids; NULL: out of
 * memory. */
char *np_volume_describe_absence(const np_volume_file *file, const np_grid_query *query);

/* Whether a file has a grid of that name, ignoring case. */
bool np_volume_has_grid(const np_volume_file *file, const char *name);

/* Role of a grid by its name and kind, without a scene. */
np_grid_role np_volume_get_role(const np_volume_file *file, const np_vdb_grid_info *info);

#endif
