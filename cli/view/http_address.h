/* SPDX-License-Identifier: Apache-2.0 */
/* Numeric addresses of sockets. */
#ifndef NEPHOS_CLI_HTTP_ADDRESS_H
#define NEPHOS_CLI_HTTP_ADDRESS_H

#include <stdbool.h>
#include <stdint.h>

#include "options.h"

/* Opens a socket that listens at a numeric address and a port, 0: a free one. Fails after a message; the socket is then
 * -1. */
cli_exit cli_http_address_listen(const char *address, uint16_t port, int *out_socket);

/* Prints a socket's own address and port as in a URL, at most CLI_HTTP_HOST_SIZE characters; false: it has none. */
bool cli_http_address_print(int socket, char *out_host);

/* Whether an address is of the loopback interface, which other machines do not reach. */
bool cli_http_address_is_loopback(const char *address);

#endif
