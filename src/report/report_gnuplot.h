/* SPDX-License-Identifier: Apache-2.0 */
/* The door to gnuplot, a program that may be missing. */
#ifndef NP_REPORT_REPORT_GNUPLOT_H
#define NP_REPORT_REPORT_GNUPLOT_H

#include "core/context_private.h"

/* Draws a script that prints one SVG, to be freed with np_alloc_free: an element to stand in a page, whose ink is the
 * text's colour, and whose ids begin with `name`. NULL where gnuplot is not installed, or refuses the script. */
neph_result np_gnuplot_draw(neph_context *context, const char *script, const char *name, char **out_svg);

#endif
