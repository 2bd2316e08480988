/* SPDX-License-Identifier: Apache-2.0 */
/* Names of files of a sequence, one for each frame.
 *
 * A pattern holds the place of the number: "####", "%04d", "%04i" or "$F4", padded with zeros to 4 digits, "%d", "%i"
 * or "$F", not padded, "$FF", with the decimals of frames between two. Of several the last counts. "$#" and "$$" stand
 * for a literal # and $, in names that are no pattern too. */
#ifndef NP_CORE_FRAME_NAME_H
#define NP_CORE_FRAME_NAME_H

#include "core/context_private.h"

/* Numbers of existing files, ascending. */
typedef struct np_frame_numbers {
  double *numbers; /* owned */
  size_t count;
} np_frame_numbers;

bool np_frame_name_is_pattern(const char *text);

/* Length of "$F", "$FF" or "$F4" at the start of a text; 0: there is none. */
size_t np_frame_name_count_dollar(const char *text);

/* The number that a name can hold: rounded down to an integer, or with "$FF" to three decimals. */
double np_frame_name_round(const char *pattern, double number);

/* Name for a number, rounded as by np_frame_name_round; a text that is no pattern is copied with its literal signs. The
 * caller frees it. NULL: no memory. */
char *np_frame_name_make(neph_context *context, const char *pattern, double number);

/* Replaces the escapes of literal signs in a text, as if it were no pattern. */
void np_frame_name_unescape(char *text);

/* Numbers of the existing files of a pattern. A name belongs to the pattern if its number has this name: a.####.vdb
 * includes a.0007.vdb and a.12345.vdb, not a.7.vdb or a.-old.vdb. There are none where the number is in the name of a
 * folder. */
neph_result np_frame_name_list(neph_context *context, const char *pattern, np_frame_numbers *out_numbers);

#endif
