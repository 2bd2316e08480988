/* SPDX-License-Identifier: Apache-2.0 */
#include "http_request.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

size_t cli_http_request_measure(const char *text, size_t size) {
  const char *end = memmem(text, size, "\r\n\r\n", 4);
  return end ? (size_t)(end - text) + 4 : 0;
}

/* Ends the line at `text` by a zero and returns the next one; NULL: a bare CR, a bare LF or a control character. */
static char *end_line(char *text) {
  char *c = text;
  for (; *c != '\r'; c++)
    if ((unsigned char)*c < 32 && *c != '\t') return NULL;
  if (c[1] != '\n') return NULL;
  *c = '\0';
  return c + 2;
}

/* Splits "METHOD /path?query HTTP/1.x". */
static unsigned parse_request_line(char *line, cli_http_request *out) {
  char *path = strchr(line, ' '), *version = path ? strchr(path + 1, ' ') : NULL;
  if (!version || path == line || path[1] != '/') return 400;
  *path++ = '\0';
  *version++ = '\0';
  if (strcmp(version, "HTTP/1.1")) return strncmp(version, "HTTP/", 5) ? 400 : 505;
  char *mark = strchr(path, '?');
  if (mark) *mark++ = '\0';
  out->method = line;
  out->path = path;
  out->query = mark ? mark : "";
  return 0;
}

static bool is_token(const char *name) {
  for (const char *c = name; *c; c++)
    if (!isalnum((unsigned char)*c) && !strchr("!#$%&'*+-.^_`|~", *c)) return false;
  return *name;
}

/* Splits "Name: value". A name that occurs twice is refused: two readers might take different ones. */
static unsigned parse_header(char *line, cli_http_request *out) {
  char *colon = strchr(line, ':');
  if (!colon) return 400;
  *colon = '\0';
  if (!is_token(line) || cli_http_request_get(out, line)) return 400;
  if (out->header_count == CLI_HTTP_HEADERS_MAX) return 431;
  char *value = colon + 1, *end = value + strlen(value);
  value += strspn(value, " \t");
  while (end > value && (end[-1] == ' ' || end[-1] == '\t')) *--end = '\0';
  out->headers[out->header_count++] = (cli_http_header){line, value};
  return 0;
}

static bool read_number(const char *text, unsigned long long *out) {
  char *end;
  if (!isdigit((unsigned char)*text)) return false;
  errno = 0;
  *out = strtoull(text, &end, 10);
  return !errno && (!*end || *end == '&');
}

/* Sets the length of the body. A body without a length, in chunks, is refused. */
static unsigned parse_length(cli_http_request *out) {
  unsigned long long bytes = 0;
  const char *length = cli_http_request_get(out, "Content-Length");
  if (cli_http_request_get(out, "Transfer-Encoding")) return 411;
  if (!length) return strcmp(out->method, "POST") ? 0 : 411;
  if (!read_number(length, &bytes) || strchr(length, '&')) return errno == ERANGE ? 413 : 400;
  if (bytes > CLI_HTTP_BODY_MAX) return 413;
  out->body_bytes = (size_t)bytes;
  return 0;
}

unsigned cli_http_request_parse(char *text, size_t size, cli_http_request *out) {
  *out = (cli_http_request){.head_bytes = cli_http_request_measure(text, size)};
  if (!out->head_bytes) return 400;
  char *next = end_line(text);
  unsigned status = next ? parse_request_line(text, out) : 400;
  while (!status && *next != '\r') {
    char *line = next;
    next = end_line(line);
    status = next ? parse_header(line, out) : 400;
  }
  return status ? status : parse_length(out);
}

const char *cli_http_request_get(const cli_http_request *request, const char *name) {
  for (size_t i = 0; i < request->header_count; i++)
    if (!strcasecmp(request->headers[i].name, name)) return request->headers[i].value;
  return NULL;
}

unsigned long long cli_http_request_get_number(const cli_http_request *request, const char *name,
                                               unsigned long long fallback) {
  const size_t length = strlen(name);
  for (const char *item = request->query; item; item = strchr(item, '&') ? strchr(item, '&') + 1 : NULL) {
    unsigned long long number;
    if (!strncmp(item, name, length) && item[length] == '=')
      return read_number(item + length + 1, &number) ? number : fallback;
  }
  return fallback;
}
