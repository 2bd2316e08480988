/* SPDX-License-Identifier: Apache-2.0 */
/* Grids by their names: which of a file a density is read from, and the purpose of each. Inside the volume module only.
 */
#ifndef NP_VOLUME_VOLUME_CHOICE_H
#define NP_VOLUME_VOLUME_CHOICE_H

#include "volume/volume_file.h"

/* A grid as it is asked for. */
typedef struct np_grid_wish {
  const char *grid;        /* a name, "name[i]", or several with "+" between them; NULL: the usual */
  double level_set_voxels; /* 0: level sets are refused */
  bool is_field;           /* of no density: its values may be any numbers */
  const char *key;         /* of the scene, by which a field is named, for messages; NULL: none */
  const char *sequence;    /* pattern of the files, of which some may lack a density; NULL: a file by itself */
} np_grid_wish;

/* Chooses the grids to be read: by exact name, else by its letters in either case; without a name "density", else the
 * only grid of numbers that is a fog volume, else the only one of another class, else the only one of whole numbers or
 * marks; a grid that is called as velocities and fields are is never a density by itself. In a file of a sequence the
 * name is that of the whole sequence, and a file that lacks the grid has a choice of no grids: fluid programs leave out
 * grids that are empty. `*out_refusal` says why none can be, to be freed; NULL: they are chosen. */
neph_result np_volume_choose(const np_volume_file *file, const np_grid_wish *wish, np_volume_choice *out_choice,
                             char **out_refusal);

/* Text, to be freed, about a file of a sequence that lacks the density, with the grids that it has; NULL: no memory. */
char *np_volume_describe_absence(const np_volume_file *file, const np_grid_wish *wish);

/* Whether a file has a grid of that name, in letters of either case. */
bool np_volume_has_grid(const np_volume_file *file, const char *name);

/* Purposes by names and kinds alone, where no scene says them. */
np_grid_role np_volume_get_role(const np_volume_file *file, const np_vdb_grid_info *info);

#endif
