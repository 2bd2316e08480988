/* SPDX-License-Identifier: Apache-2.0 */
#include "view_program.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "http_address.h"
#include "print.h"
#include "view_browser.h"
#include "view_routes.h"

/* Longest time until an interrupt is noticed, seconds. */
static const double patience_s = 0.2;

static void wake(void *user) {
  cli_view *view = user;
  if (view->server) cli_http_server_wake(view->server);
}

static bool admit(void *user, const cli_http_request *request, const char *host, cli_http_reply *out_refusal) {
  const cli_view *view = user;
  return cli_view_guard_admit(view->token, request, host, out_refusal);
}

static void answer(void *user, const cli_http_request *request, bool is_due, cli_http_reply *out_reply) {
  cli_view_answer(user, request, is_due, out_reply);
}

/* Prints the address with the token in its fragment, which no browser sends. */
static cli_exit announce(const cli_view *view, const cli_view_settings *settings, cli_view_browser *browser) {
  cli_text url = {0};
  cli_text_add(&url, "http://%s/#%s", cli_http_server_get_host(view->server), view->token);
  cli_say("%s", cli_text_get(&url));
  fflush(stdout);
  if (!cli_http_address_is_loopback(settings->address))
    cli_complain("warning: other machines reach this address, and the token crosses the network unencrypted: a tunnel "
                 "of ssh to the loopback interface is safer");
  const cli_exit exit = settings->opens ? cli_view_browser_open(browser, cli_text_get(&url)) : CLI_DONE;
  cli_text_clear(&url);
  return exit;
}

/* Follows the scene's file, and the files that it reads. */
static void follow(cli_view *view) {
  const cli_view_changes changes = cli_view_watch_take(view->watch);
  if (changes.is_file) cli_view_document_touch(view->document);
  const bool is_read = changes.is_scene && cli_view_document_follow(view->document);
  if (is_read || changes.is_file) cli_view_refresh(view);
  if (changes.is_scene || changes.is_file) cli_http_server_wake(view->server);
}

/* Serves the page until an interrupt. */
static void serve(cli_view *view, const cli_view_settings *settings) {
  view->watch = cli_view_watch_create(settings->path);
  cli_view_refresh(view);
  while (!cli_is_interrupted())
    if (cli_http_server_serve(view->server, patience_s, cli_view_watch_get(view->watch))) follow(view);
  cli_view_watch_destroy(view->watch);
}

static cli_exit start(cli_view *view, const cli_view_settings *settings) {
  const cli_http_program program = {view, admit, answer};
  if (!cli_view_token_create(view->token)) return cli_complain("the system has no random numbers"), CLI_INTERNAL;
  view->picture = cli_view_picture_create(view->session->context, wake, view);
  view->variants = cli_view_variants_create();
  if (!view->picture || !view->variants) return cli_complain("out of memory"), CLI_INTERNAL;
  cli_view_messages_begin(&view->messages, view->session, view->picture);
  cli_exit exit =
      cli_view_document_open(view->session, &view->messages, settings->path, settings->allows_files, &view->document);
  if (!exit) exit = cli_http_server_create(settings->address, settings->port, &program, &view->server);
  view->paint = (cli_view_paint){.document = view->document, .context = view->session->context};
  return exit ? exit : cli_view_worker_create(view->session, view->picture, view->variants, &view->worker);
}

cli_exit cli_view_run(cli_session *session, const cli_view_settings *settings) {
  cli_view view = {.session = session};
  cli_view_browser browser = {0};
  cli_catch_interrupts();
  cli_exit exit = start(&view, settings);
  if (!exit) exit = announce(&view, settings, &browser);
  if (!exit) serve(&view, settings);
  cli_view_worker_destroy(view.worker);
  cli_view_browser_close(&browser);
  cli_http_server_destroy(view.server);
  cli_view_paint_clear(&view.paint);
  cli_view_document_close(view.document);
  cli_view_messages_end(&view.messages);
  cli_view_picture_destroy(view.picture);
  cli_view_variants_destroy(view.variants);
  return exit;
}
