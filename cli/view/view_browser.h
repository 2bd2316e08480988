/* SPDX-License-Identifier: Apache-2.0 */
/* Starts a browser. Its command line, which other users can read, holds no token: it names a file of this user alone
 * that leads to the address. */
#ifndef NEPHOS_CLI_VIEW_BROWSER_H
#define NEPHOS_CLI_VIEW_BROWSER_H

#include "options.h"

typedef struct cli_view_browser {
  char *folder, *file; /* NULL: none */
} cli_view_browser;

/* Opens `url` with xdg-open. Fails after a message. */
cli_exit cli_view_browser_open(cli_view_browser *browser, const char *url);

/* Removes the file. */
void cli_view_browser_close(cli_view_browser *browser);

#endif
