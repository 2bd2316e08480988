/* SPDX-License-Identifier: Apache-2.0 */
/* The view: a scene under edit, the thread that renders it, and the server of its page. */
#ifndef NEPHOS_CLI_VIEW_PROGRAM_H
#define NEPHOS_CLI_VIEW_PROGRAM_H

#include <stdint.h>

#include "session.h"

typedef struct cli_view_settings {
  const char *path;    /* scene */
  const char *address; /* numeric address to listen at */
  uint16_t port;       /* 0: a free one */
  bool allows_files;   /* the page may set keys that name files */
  bool opens;          /* a browser is started */
} cli_view_settings;

/* Serves the view until the process is interrupted. */
cli_exit cli_view_run(cli_session *session, const cli_view_settings *settings);

#endif
