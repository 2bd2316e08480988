/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_odd_density.h"

#include "core/alloc.h"
#include "volume/volume_choice.h"

static neph_result warn(const np_volume_file *file, const np_grid_wish *wish) {
  np_volume_choice choice;
  char *refusal;
  const neph_result result = np_volume_choose(file, wish, &choice, &refusal);
  const bool is_chosen = !result && !refusal; /* else loading says why not */
  np_alloc_free(file->context, refusal);
  if (!is_chosen) return result;
  const np_vdb_grid_info info = np_volume_file_describe(file, choice.indices[0]);
  if (np_volume_is_odd_density(file, wish, &info))
    np_log(file->context, NEPH_LOG_WARNING,
           "%s: its density is grid '%s', the only one that is a scalar: clouds[].grid names it, where it is meant",
           file->path, info.name);
  return NEPH_OK;
}

neph_result np_volume_warn_of_odd_density(neph_context *context, const char *path, const neph_volume_load_desc *desc) {
  np_volume_file file;
  if (desc->grid) return NEPH_OK;
  neph_result result = np_volume_file_open(context, path, NULL, &file);
  if (result) return result;
  result = warn(&file, &(np_grid_wish){.level_set_voxels = desc->level_set_voxels});
  np_volume_file_close(&file);
  return result;
}
