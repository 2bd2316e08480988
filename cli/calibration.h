/* SPDX-License-Identifier: Apache-2.0 */
/* The file that `nephos report --calibrate` writes, and that renders read. */
#ifndef NEPHOS_CLI_CALIBRATION_H
#define NEPHOS_CLI_CALIBRATION_H

#include "session.h"

/* $XDG_CACHE_HOME/nephos/machine.json, by default in ~/.cache; the caller frees it. NULL: no such folder, or no
 * memory. */
char *cli_calibration_get_path(void);

/* Loads the calibration file of --machine, or the file at cli_calibration_get_path if it exists. */
neph_result cli_calibration_load(cli_session *session, neph_machine *out_machine);

/* Measures this machine and writes the calibration to --output, or else to cli_calibration_get_path. */
cli_exit cli_calibration_run(cli_session *session);

#endif
