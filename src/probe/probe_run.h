/* SPDX-License-Identifier: Apache-2.0 */
/* The frame of a probe: a table of cases is read, answered, and written with its answers as one text.
 *
 * The module stands above render, whose assembly gives a probe its clouds, air and light; nothing of the library calls
 * it. A kind of probe is a file with an np_probe_kind; pictures and checks of the sky's tables are beside them.
 */
#ifndef NP_PROBE_PROBE_RUN_H
#define NP_PROBE_PROBE_RUN_H

#include <stdio.h>

#include "core/context_private.h"
#include "core/csv.h"

/* Functions of a kind of probe; `probe` is the kind's struct. */
typedef struct np_probe_kind {
  neph_result (*read)(void *probe); /* all cases of the table */
  neph_result (*answer)(void *probe);
  void (*print)(FILE *out, const void *probe);
} np_probe_kind;

/* Loads the table at `path`, "-" being standard input, and does all three; the text is to be freed with
 * neph_text_destroy. The table is cleared at the end. */
neph_result np_probe_run(neph_context *context, const char *path, const np_probe_kind *kind, void *probe, np_csv *csv,
                         char **out_text);

/* Collects what `print` writes, to be freed with neph_text_destroy. */
neph_result np_probe_write_text(neph_context *context, void (*print)(FILE *out, const void *user), const void *user,
                                char **out_text);

#endif
