/* SPDX-License-Identifier: Apache-2.0 */
#include "view_guard.h"

#include <string.h>
#include <sys/random.h>

#include "print.h"

bool cli_view_token_create(char out_token[CLI_VIEW_TOKEN_SIZE]) {
  unsigned char bytes[(CLI_VIEW_TOKEN_SIZE - 1) / 2];
  if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes) return false;
  for (size_t i = 0; i < sizeof bytes; i++) cli_print(out_token + 2 * i, 3, "%02x", bytes[i]);
  return true;
}

/* Compares in a time that does not depend on where the texts differ. */
static bool is_token(const char *given, const char *token) {
  const size_t length = strlen(token);
  unsigned char difference = 0;
  if (!given || strlen(given) != length) return false;
  for (size_t i = 0; i < length; i++) difference = (unsigned char)(difference | (given[i] ^ token[i]));
  return !difference;
}

/* Whether `text` is a name and the port of `host`, which browsers leave out where it is 80. */
static bool is_name(const char *text, const char *name, const char *host) {
  const size_t length = strlen(name);
  const char *port = strrchr(host, ':');
  if (strncmp(text, name, length)) return false;
  return !strcmp(text + length, port) || (!text[length] && !strcmp(port, ":80"));
}

/* Whether `text` is the address `host`; localhost, of a loopback one; or the address of any interface, by which a
 * browser comes to its own machine. A name that resolves to this machine, of a page that rebinds it, is none of these.
 */
static bool is_host(const char *text, const char *host) {
  char address[CLI_HTTP_HOST_SIZE];
  cli_print(address, sizeof address, "%.*s", (int)(strrchr(host, ':') - host), host);
  const bool is_loopback = !strncmp(host, "127.", 4) || !strncmp(host, "[::1]", 5);
  return is_name(text, address, host) || (is_loopback && is_name(text, "localhost", host)) ||
         is_name(text, "0.0.0.0", host) || is_name(text, "[::]", host);
}

static bool is_origin(const char *text, const char *host) {
  static const char scheme[] = "http://";
  return !strncmp(text, scheme, sizeof scheme - 1) && is_host(text + sizeof scheme - 1, host);
}

static bool is_own_site(const char *site) { return !strcmp(site, "same-origin") || !strcmp(site, "none"); }

bool cli_view_guard_admit(const char *token, const cli_http_request *request, const char *host,
                          cli_http_reply *refusal) {
  const char *named = cli_http_request_get(request, "Host"), *origin = cli_http_request_get(request, "Origin");
  const char *site = cli_http_request_get(request, "Sec-Fetch-Site");
  const bool is_api = !strncmp(request->path, "/api/", 5), is_post = !strcmp(request->method, "POST");
  /* A link to the page may lie anywhere: the page alone is no secret. */
  const bool is_visit = !strcmp(request->path, "/") && !is_post;
  unsigned status = 0;
  const char *text = NULL;
  if (!named || !is_host(named, host))
    status = 421, text = "this server answers to its own address alone\n";
  else if (origin && !is_origin(origin, host))
    status = 403, text = "the request comes from a page of another origin\n";
  else if (site && !is_visit && !is_own_site(site))
    status = 403, text = "the request comes from a page of another site\n";
  else if (!is_post && strcmp(request->method, "GET"))
    status = 405, text = "the method must be GET or POST\n";
  else if (is_api && !is_token(cli_http_request_get(request, "X-Nephos-Token"), token))
    status = 401, text = "the token is missing or wrong: open the address that nephos view has printed\n";
  if (status) *refusal = cli_http_reply_text(status, text);
  return !status;
}
