/* SPDX-License-Identifier: Apache-2.0 */
/* Texts that are shown: names and header values come from anywhere, and a terminal obeys some of their bytes. */
#ifndef NEPHOS_TEXT_H
#define NEPHOS_TEXT_H

#include <nephos/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Puts '?' in the place of each byte of a control character, the line break among them, and of each byte that is not
 * UTF-8. The messages of the library are so already. NULL is allowed. */
NEPH_API void neph_text_clean(char *text);

#ifdef __cplusplus
}
#endif

#endif
