/* SPDX-License-Identifier: Apache-2.0 */
/* One connection of the server, a machine of few states. */
#ifndef NEPHOS_CLI_HTTP_CONNECTION_H
#define NEPHOS_CLI_HTTP_CONNECTION_H

#include "http_server.h"

typedef enum cli_http_state {
  CLI_HTTP_FREE,
  CLI_HTTP_READING,  /* a request is being received, or none has begun */
  CLI_HTTP_WAITING,  /* a request is complete, and its answer is postponed */
  CLI_HTTP_WRITING,  /* an answer is being sent */
  CLI_HTTP_DRAINING, /* an answer is sent, and the rest of a refused request is discarded before the end */
  CLI_HTTP_STATE_COUNT
} cli_http_state;

typedef struct cli_http_connection {
  int socket;
  cli_http_state state;
  double deadline_s; /* end of the state, by cli_view_clock_get_s */
  char host[CLI_HTTP_HOST_SIZE];
  char *in; /* bytes read so far, at most CLI_HTTP_HEAD_MAX + CLI_HTTP_BODY_MAX, and a zero */
  size_t in_bytes;
  bool has_head; /* the head of the request is parsed and admitted */
  cli_http_request request;
  bool is_last; /* the connection ends with this answer */
  char head[768];
  size_t head_bytes;
  cli_http_reply reply;
  size_t sent_bytes; /* sent bytes of head and body */
} cli_http_connection;

/* Begins a connection on an accepted socket, which it owns. False, after closing the socket: no memory. */
bool cli_http_connection_open(cli_http_connection *connection, int socket);
void cli_http_connection_close(cli_http_connection *connection);

/* Events of poll() that the state is after. */
short cli_http_connection_get_events(const cli_http_connection *connection);

/* Advances reading and writing as far as possible without blocking. */
void cli_http_connection_advance(cli_http_connection *connection, const cli_http_program *program);

/* Answers a request that waits, or ends a state whose deadline has passed. */
void cli_http_connection_check(cli_http_connection *connection, const cli_http_program *program, bool is_woken);

#endif
