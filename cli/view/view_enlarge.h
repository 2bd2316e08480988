/* SPDX-License-Identifier: Apache-2.0 */
/* Enlargement of pixels of four bytes. */
#ifndef NEPHOS_CLI_VIEW_ENLARGE_H
#define NEPHOS_CLI_VIEW_ENLARGE_H

#include <stdint.h>

/* Enlarges a picture to another size, linear between the centres of its pixels. */
void cli_view_enlarge(const uint8_t *from, unsigned from_width, unsigned from_height, uint8_t *to, unsigned to_width,
                      unsigned to_height);

#endif
