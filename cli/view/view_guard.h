/* SPDX-License-Identifier: Apache-2.0 */
/* Access control of the view's server: only requests by its own page are accepted. */
#ifndef NEPHOS_CLI_VIEW_GUARD_H
#define NEPHOS_CLI_VIEW_GUARD_H

#include "http_server.h"

enum { CLI_VIEW_TOKEN_SIZE = 33 }; /* 128 bits in hexadecimal digits, and a zero */

/* Draws a token from the system's random numbers; false: there are none. */
bool cli_view_token_create(char out_token[CLI_VIEW_TOKEN_SIZE]);

/* Judges a request by its head: its Host is the address that was reached, or localhost; its Origin, where it has one,
 * is that host; no page of another site sent it; below /api/ its header X-Nephos-Token is the token. */
bool cli_view_guard_admit(const char *token, const cli_http_request *request, const char *host,
                          cli_http_reply *out_refusal);

#endif
