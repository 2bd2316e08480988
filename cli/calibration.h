/* SPDX-License-Identifier: Apache-2.0 */
/* The file that `nephos report --calibrate` writes, and that renders read. */
#ifndef NEPHOS_CLI_CALIBRATION_H
#define NEPHOS_CLI_CALIBRATION_H

#include "session.h"

/* $XDG_CACHE_HOME/nephos/machine.json, by default in ~/.cache; to be freed. NULL: there is no such folder, or no
 * memory.
 */
char *cli_calibration_get_path(void);

/* By --machine, else by the file at that path where there is one. */
neph_result cli_calibration_load(cli_session *session, neph_machine *out_machine);

/* Measures this machine and writes the file, to --output or to that path. */
cli_exit cli_calibration_run(cli_session *session);

#endif
