/* SPDX-License-Identifier: Apache-2.0 */
/* Textures of a scene. */
#ifndef NEPHOS_CLI_EXPORT_TEXTURES_H
#define NEPHOS_CLI_EXPORT_TEXTURES_H

#include "session.h"

/* Writes the textures of each frame into the folder of --output, which is created. */
cli_exit cli_export_textures(cli_session *session, const neph_scene *scene);

#endif
