/* SPDX-License-Identifier: Apache-2.0 */
/* Weather maps of baked clouds from above, for --preview-map. Without that option each function does nothing. */
#ifndef NEPHOS_CLI_BAKE_MAP_H
#define NEPHOS_CLI_BAKE_MAP_H

#include "session.h"

/* Refuses a scene without a map, and a name that does not fit. */
cli_exit cli_maps_check(const cli_session *session, const neph_scene *scene);

/* Adds the pictures to a table of files. */
cli_exit cli_maps_add_files(cli_session *session, neph_scene *scene, neph_files *files);

/* Writes and describes the pictures; a dry run reads the maps and prints the names. */
cli_exit cli_maps_save(cli_session *session, neph_scene *scene);

#endif
