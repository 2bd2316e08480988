/* SPDX-License-Identifier: Apache-2.0 */
/* Densities whose name is that of another purpose, such as a temperature's. */
#ifndef NP_VOLUME_VOLUME_ODD_DENSITY_H
#define NP_VOLUME_VOLUME_ODD_DENSITY_H

#include <nephos/volume.h>

/* Warns where the density of a file is a temperature or the like, taken for being the only scalar grid, and `desc` does
 * not name it. Reads no values. */
neph_result np_volume_warn_of_odd_density(neph_context *context, const char *path, const neph_volume_load_desc *desc);

#endif
