/* SPDX-License-Identifier: Apache-2.0 */
/* Parsers of options' arguments: numbers, lists, names. Each returns false when the text is not valid. */
#ifndef NEPHOS_CLI_OPTION_VALUES_H
#define NEPHOS_CLI_OPTION_VALUES_H

#include "options.h"

/* Reads digits and nothing else. */
bool cli_read_whole(const char *text, unsigned *out_value);

/* Reads `count` whole numbers separated by `mark`. */
bool cli_read_list(const char *text, char mark, unsigned count, unsigned *out_values);

/* Reads a duration: a number above 0, followed by s, m or h, or by nothing for seconds. */
bool cli_read_duration(const char *text, double *out_s);

/* Reads a number ≥ 0. */
bool cli_read_real(const char *text, double *out_value);

/* Reads N, N-N or N-NxN, each N with a sign where it is below 0, at the start of `*text`, and moves `*text` past it. */
bool cli_read_frame_range(const char **text, cli_frame_range *out_range);

/* Reads X0,Y0,Z0,X1,Y1,Z1, each of the first three below its counterpart. */
bool cli_read_region(const char *text, double out[6]);

#endif
