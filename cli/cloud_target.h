/* SPDX-License-Identifier: Apache-2.0 */
/* Files to which the clouds of a scene are written. */
#ifndef NEPHOS_CLI_CLOUD_TARGET_H
#define NEPHOS_CLI_CLOUD_TARGET_H

#include "session.h"

bool cli_is_folder(const char *path);

/* Path for a cloud, with # for the number where there are several frames; the caller frees it: --output, else, if
 * `is_own_file` allows it, the cloud's own file, else NAME.vdb. NULL: no memory. */
char *cli_get_cloud_target(const cli_options *options, const neph_scene *scene, unsigned cloud, bool is_own_file);

/* ".vdb" or ".nvdb", as a path ends; NULL: it ends otherwise. */
const char *cli_get_grid_ending(const char *path);

#endif
