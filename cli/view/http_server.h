/* SPDX-License-Identifier: Apache-2.0 */
/* A small HTTP/1.1 server: one thread, one poll loop, no thread for a client. Each state of a connection has a deadline
 * for the whole of it, so that a client that sends or reads a byte now and then is cut like a silent one. When all
 * places are taken, a new connection takes the place of the one whose deadline comes first. */
#ifndef NEPHOS_CLI_HTTP_SERVER_H
#define NEPHOS_CLI_HTTP_SERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "http_reply.h"
#include "http_request.h"
#include "options.h"

enum { CLI_HTTP_CONNECTIONS_MAX = 128, CLI_HTTP_HOST_SIZE = 64 };

typedef struct cli_http_server cli_http_server;

/* The program behind a server. `host` is the address and port that the client reached, as "127.0.0.1:8080". */
typedef struct cli_http_program {
  void *user;

  /* Judges a request by its head, before any of its body is read. Returns true, or fills the refusal. */
  bool (*admit)(void *user, const cli_http_request *request, const char *host, cli_http_reply *out_refusal);

  /* Answers a complete request. `is_due`: the answer must not be postponed further. */
  void (*answer)(void *user, const cli_http_request *request, bool is_due, cli_http_reply *out_reply);
} cli_http_program;

/* Listens at a numeric address, IPv4 or IPv6, and a port; 0: a free one. Fails after a message. */
cli_exit cli_http_server_create(const char *address, uint16_t port, const cli_http_program *program,
                                cli_http_server **out_server);

/* Closes all connections. NULL is allowed. */
void cli_http_server_destroy(cli_http_server *server);

/* Address and port as they stand in a URL: "127.0.0.1:8080", "[::1]:8080". */
const char *cli_http_server_get_host(const cli_http_server *server);

/* Serves until something has been done, or `wait_s` have passed. Returns whether the descriptor `other`, which may be
 * -1, can be read. */
bool cli_http_server_serve(cli_http_server *server, double wait_s, int other);

/* Has requests that wait answered anew. Any thread may call it. */
void cli_http_server_wake(cli_http_server *server);

#endif
