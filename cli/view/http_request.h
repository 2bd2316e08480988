/* SPDX-License-Identifier: Apache-2.0 */
/* An HTTP/1.1 request, parsed in place. The parser is strict: a browser sends nothing that it refuses. */
#ifndef NEPHOS_CLI_HTTP_REQUEST_H
#define NEPHOS_CLI_HTTP_REQUEST_H

#include <stddef.h>

enum {
  CLI_HTTP_HEAD_MAX = 32768, /* bytes of request line and headers */
  CLI_HTTP_BODY_MAX = 65536, /* bytes of a body */
  CLI_HTTP_HEADERS_MAX = 64
};

typedef struct cli_http_header {
  const char *name, *value;
} cli_http_header;

typedef struct cli_http_request {
  const char *method, *path;
  const char *query; /* text behind the '?'; "" where there is none */
  cli_http_header headers[CLI_HTTP_HEADERS_MAX];
  size_t header_count;
  size_t head_bytes; /* bytes of request line and headers, the empty line included */
  size_t body_bytes; /* announced bytes of the body */
  char *body;        /* body, ended by a zero; set once it is complete */
} cli_http_request;

/* Parses request line and headers, all of which lie in the `size` bytes at `text`, and ends each part by a zero.
 * Returns 0, or the status of a refusal: 400, 411, 413, 431, 505. */
unsigned cli_http_request_parse(char *text, size_t size, cli_http_request *out_request);

/* Length of request line and headers, the empty line included; 0: the empty line has not come. */
size_t cli_http_request_measure(const char *text, size_t size);

/* Value of a header, whose name is compared without regard to case; NULL: it is not there. */
const char *cli_http_request_get(const cli_http_request *request, const char *name);

/* Number of a parameter `name=NUMBER` of the query; `fallback` where it is missing or no whole number. */
unsigned long long cli_http_request_get_number(const cli_http_request *request, const char *name,
                                               unsigned long long fallback);

#endif
