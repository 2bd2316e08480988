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
} np_grid_wish;

/* Chooses the grids to be read: by exact name, else by its letters in either case; without a name "density", else the
 * only grid of numbers that is a fog volume, else the only one of another class, else the only one of whole numbers or
 * marks; those that are called as velocities and fields are come last. `*out_refusal` says why none can be, to be
 * freed; NULL: they are chosen. */
neph_result np_volume_choose(const np_volume_file *file, const np_grid_wish *wish, np_volume_choice *out_choice,
                             char **out_refusal);

/* Whether a file has a grid of that name, in letters of either case. */
bool np_volume_has_grid(const np_volume_file *file, const char *name);

/* Purposes by names and kinds alone, where no scene says them. */
np_grid_role np_volume_get_role(const np_volume_file *file, const np_vdb_grid_info *info);

/* Whether a grid chosen as a density is called as a field or a velocity, and the wish does not name it; and a warning
 * of that. */
bool np_volume_is_odd_density(const np_volume_file *file, const np_grid_wish *wish, const np_vdb_grid_info *info);
void np_volume_warn_of_odd_density(neph_context *context, const char *path, const char *name);

#endif
