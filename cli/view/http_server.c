/* SPDX-License-Identifier: Apache-2.0 */
#include "http_server.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "http_address.h"
#include "http_connection.h"
#include "print.h"
#include "view_clock.h"

struct cli_http_server {
  cli_http_program program;
  int listener, waker; /* the waker is an eventfd */
  char host[CLI_HTTP_HOST_SIZE];
  cli_http_connection connections[CLI_HTTP_CONNECTIONS_MAX];
};

cli_exit cli_http_server_create(const char *address, uint16_t port, const cli_http_program *program,
                                cli_http_server **out_server) {
  cli_http_server *server = *out_server = calloc(1, sizeof *server);
  if (!server) return cli_complain("out of memory"), CLI_INTERNAL;
  server->program = *program;
  server->waker = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  cli_exit exit = cli_http_address_listen(address, port, &server->listener);
  if (!exit && (server->waker < 0 || !cli_http_address_print(server->listener, server->host))) exit = CLI_INTERNAL;
  if (!exit) return CLI_DONE;
  cli_http_server_destroy(server);
  *out_server = NULL;
  return exit;
}

void cli_http_server_destroy(cli_http_server *server) {
  if (!server) return;
  for (size_t i = 0; i < CLI_HTTP_CONNECTIONS_MAX; i++)
    if (server->connections[i].state) cli_http_connection_close(&server->connections[i]);
  if (server->listener >= 0) close(server->listener);
  if (server->waker >= 0) close(server->waker);
  free(server);
}

const char *cli_http_server_get_host(const cli_http_server *server) { return server->host; }

void cli_http_server_wake(cli_http_server *server) {
  const uint64_t one = 1;
  while (write(server->waker, &one, sizeof one) < 0 && errno == EINTR) continue;
}

/* A free place, or the place of the connection whose deadline comes first. */
static cli_http_connection *choose_place(cli_http_server *server) {
  cli_http_connection *first = server->connections;
  for (size_t i = 0; i < CLI_HTTP_CONNECTIONS_MAX; i++) {
    cli_http_connection *connection = &server->connections[i];
    if (!connection->state) return connection;
    if (connection->state != CLI_HTTP_WAITING && connection->deadline_s < first->deadline_s) first = connection;
  }
  cli_http_connection_close(first);
  return first;
}

static void accept_clients(cli_http_server *server) {
  for (;;) {
    const int socket = accept4(server->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    cli_http_connection *connection = choose_place(server);
    if (cli_http_connection_open(connection, socket)) cli_http_connection_advance(connection, &server->program);
  }
}

/* Seconds until the first deadline, at most `wait_s`. */
static double get_wait_s(const cli_http_server *server, double wait_s) {
  const double now_s = cli_view_clock_get_s();
  for (size_t i = 0; i < CLI_HTTP_CONNECTIONS_MAX; i++) {
    const cli_http_connection *connection = &server->connections[i];
    const double left_s = connection->deadline_s - now_s;
    if (connection->state && left_s < wait_s) wait_s = left_s > 0.0 ? left_s : 0.0;
  }
  return wait_s;
}

static bool take_wake(const cli_http_server *server) {
  uint64_t count;
  return read(server->waker, &count, sizeof count) == sizeof count;
}

bool cli_http_server_serve(cli_http_server *server, double wait_s, int other) {
  enum { OWN_COUNT = 3 };
  struct pollfd polls[OWN_COUNT + CLI_HTTP_CONNECTIONS_MAX] = {{.fd = server->listener, .events = POLLIN},
                                                               {.fd = server->waker, .events = POLLIN},
                                                               {.fd = other, .events = POLLIN}};
  for (size_t i = 0; i < CLI_HTTP_CONNECTIONS_MAX; i++) {
    const cli_http_connection *connection = &server->connections[i];
    polls[OWN_COUNT + i] = (struct pollfd){.fd = connection->state ? connection->socket : -1,
                                           .events = cli_http_connection_get_events(connection)};
  }
  const int count = poll(polls, OWN_COUNT + CLI_HTTP_CONNECTIONS_MAX, (int)(1e3 * get_wait_s(server, wait_s) + 0.999));
  const bool is_woken = take_wake(server);
  for (size_t i = 0; i < CLI_HTTP_CONNECTIONS_MAX; i++) {
    cli_http_connection *connection = &server->connections[i];
    const short events = count > 0 ? polls[OWN_COUNT + i].revents : 0;
    if (connection->state == CLI_HTTP_WAITING && events & (POLLHUP | POLLERR))
      cli_http_connection_close(connection);
    else if (connection->state && events)
      cli_http_connection_advance(connection, &server->program);
    cli_http_connection_check(connection, &server->program, is_woken);
    if (connection->state == CLI_HTTP_WRITING) cli_http_connection_advance(connection, &server->program);
  }
  if (count > 0 && polls[0].revents) accept_clients(server);
  return count > 0 && polls[2].revents;
}
