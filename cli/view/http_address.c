/* SPDX-License-Identifier: Apache-2.0 */
#include "http_address.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "http_server.h"
#include "print.h"

bool cli_http_address_is_loopback(const char *address) {
  return !strncmp(address, "127.", 4) || !strcmp(address, "::1");
}

static struct addrinfo *resolve(const char *address, uint16_t port) {
  char service[8];
  struct addrinfo hints = {.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE, .ai_socktype = SOCK_STREAM};
  struct addrinfo *list = NULL;
  cli_print(service, sizeof service, "%u", port);
  if (!getaddrinfo(address, service, &hints, &list)) return list;
  cli_complain("--listen is %s, must be a numeric address of this machine, such as 127.0.0.1 or ::1", address);
  return NULL;
}

cli_exit cli_http_address_listen(const char *address, uint16_t port, int *out_socket) {
  *out_socket = -1;
  struct addrinfo *place = resolve(address, port);
  if (!place) return CLI_USAGE;
  const int one = 1;
  const int listener = socket(place->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  bool is_open = listener >= 0 && !setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) &&
                 !bind(listener, place->ai_addr, place->ai_addrlen) && !listen(listener, CLI_HTTP_CONNECTIONS_MAX);
  freeaddrinfo(place);
  if (is_open) {
    *out_socket = listener;
    return CLI_DONE;
  }
  cli_complain("%s, port %u cannot be listened at: %s", address, port, strerror(errno));
  if (listener >= 0) close(listener);
  return CLI_IO;
}

bool cli_http_address_print(int socket, char *out) {
  union {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
  } own;
  socklen_t size = sizeof own;
  char text[INET6_ADDRSTRLEN];
  if (getsockname(socket, &own.any, &size)) return false;
  const bool is_v6 = own.any.sa_family == AF_INET6;
  const void *address = is_v6 ? (const void *)&own.v6.sin6_addr : (const void *)&own.v4.sin_addr;
  if (!inet_ntop(own.any.sa_family, address, text, sizeof text)) return false;
  const unsigned port = ntohs(is_v6 ? own.v6.sin6_port : own.v4.sin_port);
  cli_print(out, CLI_HTTP_HOST_SIZE, is_v6 ? "[%s]:%u" : "%s:%u", text, port);
  return true;
}
