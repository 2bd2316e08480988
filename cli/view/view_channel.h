/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of a picture as pictures to look at. */
#ifndef NEPHOS_CLI_VIEW_CHANNEL_H
#define NEPHOS_CLI_VIEW_CHANNEL_H

#include <stdio.h>

#include <nephos/nephos.h>

/* Name under which the luminance is shown, by its logarithm. */
extern const char cli_view_luminance[];

/* Name under which the luminance of the standard error is shown, as a share of the pixel's luminance. */
extern const char cli_view_relative_error[];

typedef struct cli_view_channel {
  neph_image *image; /* R, G and B; owned by the caller */
  bool is_scalar;    /* a number as a colour, between `least`, dark blue, and `greatest`, yellow; infinite ones black */
  double least, greatest;
} cli_view_channel;

/* Makes a picture of a channel: colours, "sun", of its channels sun.R, sun.G and sun.B; a number, "Z"; the stops of
 * luminance below the brightest, at most 12; or the relative error, up to 1, black where there is no luminance.
 * A number has the colours of `range`; NULL: those of its own range. NEPH_ERROR_NOT_FOUND: the picture has no such
 * channel. */
neph_result cli_view_channel_create(neph_context *context, const neph_image *image, const char *name,
                                    const cli_view_channel *range, cli_view_channel *out_channel);

/* Writes the names of all channels as a JSON list; colours once. */
void cli_view_channel_write_names(const neph_image *image, FILE *out);

#endif
