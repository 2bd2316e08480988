/* SPDX-License-Identifier: Apache-2.0 */
/* The files of the page, which the build puts into the program. */
#ifndef NEPHOS_CLI_VIEW_PAGES_H
#define NEPHOS_CLI_VIEW_PAGES_H

#include <stddef.h>

typedef struct cli_view_page {
  const char *path, *type;
  const unsigned char *bytes;
  size_t size;
} cli_view_page;

/* Pages in any order; the last has no path. */
extern const cli_view_page cli_view_pages[];

#endif
