/* SPDX-License-Identifier: Apache-2.0 */
/* Answers of the HTTP server. */
#ifndef NEPHOS_CLI_HTTP_REPLY_H
#define NEPHOS_CLI_HTTP_REPLY_H

#include <stdbool.h>
#include <stddef.h>

/* The answer to a request. */
typedef struct cli_http_reply {
  unsigned status;
  const char *type; /* type of the body */
  const char *body;
  size_t bytes;
  char *owned;   /* memory of the body, freed after sending; NULL: the body is borrowed */
  bool is_later; /* nothing is sent yet; the request is answered at the next wake or at its deadline */
} cli_http_reply;

/* Headers that every answer has, each with its line end: no page of another origin may frame, embed or read it, and the
 * page loads nothing from elsewhere. */
extern const char cli_http_safe_headers[];

/* Reason of a status, as it stands behind it. */
const char *cli_http_reply_get_reason(unsigned status);

/* A reply that is a fixed text. */
cli_http_reply cli_http_reply_text(unsigned status, const char *text);

#endif
