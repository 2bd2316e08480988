/* SPDX-License-Identifier: Apache-2.0 */
/* Arguments of options, read as numbers, lists, names. Each is false when the text is not one. */
#ifndef NEPHOS_CLI_OPTION_VALUES_H
#define NEPHOS_CLI_OPTION_VALUES_H

#include "options.h"

/* Digits and nothing else. */
bool cli_read_whole(const char *text, unsigned *out_value);

/* `count` whole numbers parted by `mark`. */
bool cli_read_list(const char *text, char mark, unsigned count, unsigned *out_values);

/* Seconds: a number above 0, with s, m or h behind it, or nothing for seconds. */
bool cli_read_duration(const char *text, double *out_s);

/* A number of at least 0. */
bool cli_read_real(const char *text, double *out_value);

/* Each N with a sign where it is below 0: N, N-N or N-NxN at the start of `*text`, which moves behind it. */
bool cli_read_frame_range(const char **text, cli_frame_range *out_range);

/* X0,Y0,Z0,X1,Y1,Z1, the first three below the last. */
bool cli_read_region(const char *text, double out[6]);

#endif
