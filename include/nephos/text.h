/* SPDX-License-Identifier: Apache-2.0 */
/* Cleaning of texts for display: names and header values may contain bytes that a terminal obeys. */
#ifndef NEPHOS_TEXT_H
#define NEPHOS_TEXT_H

#include <nephos/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Replaces each byte of a control character, the line break included, and each byte that is not UTF-8 by '?'. Messages
 * of the library are clean already. NULL is allowed. */
NEPH_API void neph_text_clean(char *text);

#ifdef __cplusplus
}
#endif

#endif
