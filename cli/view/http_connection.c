/* SPDX-License-Identifier: Apache-2.0 */
#include "http_connection.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "http_address.h"
#include "print.h"
#include "view_clock.h"

/* Longest time in each state, seconds. */
static const double limits_s[CLI_HTTP_STATE_COUNT] = {
    [CLI_HTTP_READING] = 5.0, [CLI_HTTP_WAITING] = 0.25, [CLI_HTTP_WRITING] = 15.0, [CLI_HTTP_DRAINING] = 1.0};

enum { IN_MAX = CLI_HTTP_HEAD_MAX + CLI_HTTP_BODY_MAX };

static void enter(cli_http_connection *connection, cli_http_state state) {
  connection->state = state;
  connection->deadline_s = cli_view_clock_get_s() + limits_s[state];
}

bool cli_http_connection_open(cli_http_connection *connection, int socket) {
  *connection = (cli_http_connection){.socket = socket, .in = malloc(IN_MAX + 1)};
  if (!connection->in || !cli_http_address_print(socket, connection->host)) {
    cli_http_connection_close(connection);
    return false;
  }
  enter(connection, CLI_HTTP_READING);
  return true;
}

void cli_http_connection_close(cli_http_connection *connection) {
  close(connection->socket);
  free(connection->in);
  free(connection->reply.owned);
  *connection = (cli_http_connection){.socket = -1};
}

short cli_http_connection_get_events(const cli_http_connection *connection) {
  return connection->state == CLI_HTTP_WRITING ? POLLOUT : connection->state == CLI_HTTP_WAITING ? 0 : POLLIN;
}

/* ---- Writing ---- */

static void begin_reply(cli_http_connection *connection) {
  const cli_http_reply *reply = &connection->reply;
  connection->head_bytes = cli_print(connection->head, sizeof connection->head,
                                     "HTTP/1.1 %u %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n%s%s\r\n",
                                     reply->status, cli_http_reply_get_reason(reply->status), reply->type, reply->bytes,
                                     cli_http_safe_headers, connection->is_last ? "Connection: close\r\n" : "");
  connection->sent_bytes = 0;
  enter(connection, CLI_HTTP_WRITING);
}

static void refuse(cli_http_connection *connection, cli_http_reply refusal) {
  connection->reply = refusal;
  connection->is_last = true;
  begin_reply(connection);
}

/* Makes room for the next request, whose first bytes may have come already. */
static void end_reply(cli_http_connection *connection) {
  free(connection->reply.owned);
  connection->reply = (cli_http_reply){0};
  if (connection->is_last) {
    shutdown(connection->socket, SHUT_WR);
    enter(connection, CLI_HTTP_DRAINING);
    return;
  }
  const size_t taken = connection->request.head_bytes + connection->request.body_bytes;
  connection->in_bytes -= taken;
  memmove(connection->in, connection->in + taken, connection->in_bytes);
  connection->has_head = false;
  enter(connection, CLI_HTTP_READING);
}

/* Sends as much as the socket takes; false: the client is gone. */
static bool write_some(cli_http_connection *connection) {
  const cli_http_reply *reply = &connection->reply;
  const size_t all = connection->head_bytes + reply->bytes;
  while (connection->sent_bytes < all) {
    const bool is_head = connection->sent_bytes < connection->head_bytes;
    const size_t body_sent = is_head ? 0 : connection->sent_bytes - connection->head_bytes;
    const char *from = is_head ? connection->head + connection->sent_bytes : reply->body + body_sent;
    const size_t count = is_head ? connection->head_bytes - connection->sent_bytes : reply->bytes - body_sent;
    const ssize_t sent = send(connection->socket, from, count, MSG_NOSIGNAL | (is_head && reply->bytes ? MSG_MORE : 0));
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
    connection->sent_bytes += (size_t)sent;
  }
  end_reply(connection);
  return true;
}

/* ---- Reading ---- */

static void answer(cli_http_connection *connection, const cli_http_program *program, bool is_due) {
  cli_http_reply reply = {0};
  program->answer(program->user, &connection->request, is_due, &reply);
  if (reply.is_later && !is_due) {
    if (connection->state != CLI_HTTP_WAITING) enter(connection, CLI_HTTP_WAITING);
    return;
  }
  connection->reply = reply;
  begin_reply(connection);
}

/* Parses and judges the head, once it is there; the body, which may never come, is not awaited for a refusal. */
static void take_head(cli_http_connection *connection, const cli_http_program *program) {
  const size_t bytes = cli_http_request_measure(connection->in, connection->in_bytes);
  if (!bytes && connection->in_bytes < CLI_HTTP_HEAD_MAX) return;
  const unsigned status = bytes > CLI_HTTP_HEAD_MAX || !bytes
                              ? 431
                              : cli_http_request_parse(connection->in, connection->in_bytes, &connection->request);
  cli_http_reply refusal = {0};
  if (status)
    refuse(connection, cli_http_reply_text(status, "the request is malformed or too long\n"));
  else if (program->admit(program->user, &connection->request, connection->host, &refusal))
    connection->has_head = true;
  else
    refuse(connection, refusal);
}

/* Answers the request, once its body is complete. */
static void take_body(cli_http_connection *connection, const cli_http_program *program) {
  cli_http_request *request = &connection->request;
  const size_t end = request->head_bytes + request->body_bytes;
  if (connection->in_bytes < end) return;
  const char next = connection->in[end];
  request->body = connection->in + request->head_bytes;
  connection->in[end] = '\0';
  answer(connection, program, false);
  connection->in[end] = next;
}

/* Reads the available bytes; false: the client has closed the connection. */
static bool read_some(cli_http_connection *connection) {
  char scrap[4096];
  const bool is_kept = connection->state == CLI_HTTP_READING;
  char *into = is_kept ? connection->in + connection->in_bytes : scrap;
  const ssize_t count = recv(connection->socket, into, is_kept ? IN_MAX - connection->in_bytes : sizeof scrap, 0);
  if (count <= 0) return count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
  if (is_kept) connection->in_bytes += (size_t)count;
  return true;
}

/* Consumes the bytes read so far, as the state allows. */
static void take_input(cli_http_connection *connection, const cli_http_program *program) {
  if (connection->state == CLI_HTTP_READING && !connection->has_head) take_head(connection, program);
  if (connection->state == CLI_HTTP_READING && connection->has_head) take_body(connection, program);
}

void cli_http_connection_advance(cli_http_connection *connection, const cli_http_program *program) {
  bool is_open = connection->state == CLI_HTTP_WRITING || read_some(connection);
  take_input(connection, program);
  while (is_open && connection->state == CLI_HTTP_WRITING) {
    const size_t sent_before = connection->sent_bytes;
    is_open = write_some(connection);
    if (connection->state == CLI_HTTP_WRITING && connection->sent_bytes == sent_before) break;
    take_input(connection, program);
  }
  if (!is_open) cli_http_connection_close(connection);
}

void cli_http_connection_check(cli_http_connection *connection, const cli_http_program *program, bool is_woken) {
  const bool is_due = cli_view_clock_get_s() >= connection->deadline_s;
  if (connection->state == CLI_HTTP_FREE || (!is_due && !is_woken)) return;
  if (connection->state == CLI_HTTP_WAITING)
    answer(connection, program, is_due);
  else if (is_due)
    cli_http_connection_close(connection);
}
