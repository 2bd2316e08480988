/* SPDX-License-Identifier: Apache-2.0 */
/* The answers of the view's server. */
#ifndef NEPHOS_CLI_VIEW_ROUTES_H
#define NEPHOS_CLI_VIEW_ROUTES_H

#include "http_server.h"
#include "view_document.h"
#include "view_guard.h"
#include "view_paint.h"
#include "view_watch.h"
#include "view_worker.h"

/* The parts of a view, with which requests are answered. */
typedef struct cli_view {
  cli_session *session;
  cli_view_messages messages;
  cli_view_document *document;
  cli_view_picture *picture;
  cli_view_variants *variants;
  cli_view_worker *worker;
  cli_view_paint paint;
  cli_view_watch *watch; /* NULL: nothing is followed */
  cli_http_server *server;
  char token[CLI_VIEW_TOKEN_SIZE];
} cli_view;

/* Answers a request that the guard has admitted. */
void cli_view_answer(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out_reply);

/* Updates the picture after a change of the document: by a render, or by developing it again. */
void cli_view_refresh(cli_view *view);

#endif
