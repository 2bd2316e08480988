/* SPDX-License-Identifier: Apache-2.0 */
/* The grid of a bake. */
#ifndef NP_CLOUD_BAKE_GRID_H
#define NP_CLOUD_BAKE_GRID_H

#include "cloud/bake.h"

/* Evaluates the grid; pruned unless its error is measured too. On failure the grid is cleared. */
neph_result np_bake_make_grid(np_bake *bake, const char *name, np_sparse_grid *out_grid);

/* Removes values up to the bake's prune_per_m, and inactive ones. */
void np_bake_prune(const np_bake *bake, np_sparse_grid *grid);

/* Evaluates the model on a grid named `name`. On failure the grid is cleared. */
neph_result np_cloud_bake_grid(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               const char *name, np_monitor *monitor, np_sparse_grid *out_grid);

#endif
