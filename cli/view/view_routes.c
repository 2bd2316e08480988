/* SPDX-License-Identifier: Apache-2.0 */
#include "view_routes.h"

#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "view_keys.h"
#include "view_pages.h"

static const char json_type[] = "application/json";

/* ---- Bodies ---- */

/* A body that is written as to a file. */
typedef struct view_body {
  char *bytes;
  size_t size;
  FILE *out;
} view_body;

static bool begin_body(view_body *body) {
  *body = (view_body){0};
  body->out = open_memstream(&body->bytes, &body->size);
  return body->out;
}

/* Ends a body, which passes to the reply. */
static void end_body(view_body *body, unsigned status, const char *type, cli_http_reply *out) {
  const bool is_lost = !body->out || fclose(body->out);
  *out = (cli_http_reply){status, type, body->bytes, body->size, body->bytes, false};
  if (!is_lost) return;
  free(body->bytes);
  *out = cli_http_reply_text(500, "out of memory\n");
}

/* Replies with a text of the library, which is freed. */
static void reply_text(cli_view *view, neph_result result, char *text, cli_http_reply *out) {
  view_body body;
  if (begin_body(&body) && !result) fputs(text, body.out);
  neph_text_destroy(view->session->context, text);
  end_body(&body, result ? 500 : 200, json_type, out);
}

/* ---- Reading ---- */

static void write_state(cli_view *view, FILE *out) {
  fputc('{', out);
  cli_view_picture_write_state(view->picture, out);
  fputc(',', out);
  cli_view_variants_write_state(view->variants, out);
  fputc(',', out);
  cli_view_document_write_state(view->document, out);
  fputs("}\n", out);
}

/* State, and behind its line the pixels, once they differ from those that the page has. */
static void answer_picture(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  const unsigned long long number = cli_view_picture_get_number(view->picture);
  const bool has_news = number != cli_http_request_get_number(request, "after", 0);
  out->is_later = !has_news && !is_due;
  view_body body;
  if (out->is_later) return;
  if (begin_body(&body)) write_state(view, body.out);
  if (body.out && has_news) cli_view_picture_write_pixels(view->picture, body.out);
  end_body(&body, 200, "application/octet-stream", out);
}

static void answer_schema(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  char *text = NULL;
  (void)request, (void)is_due;
  const neph_result result = neph_schema_describe(view->session->context, NULL, NEPH_TEXT_JSON, &text);
  reply_text(view, result, text, out);
}

static void answer_values(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  char *text = NULL;
  (void)request, (void)is_due;
  const neph_result result = cli_view_document_describe(view->document, &text);
  reply_text(view, result, text, out);
}

static void answer_edits(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  char *text = NULL;
  (void)request, (void)is_due;
  const neph_result result = cli_view_document_describe_edits(view->document, &text);
  reply_text(view, result, text, out);
}

static void answer_channels(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  view_body body;
  (void)request, (void)is_due;
  if (begin_body(&body)) cli_view_picture_write_channels(view->picture, body.out);
  end_body(&body, 200, json_type, out);
}

static void answer_pixel(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  const unsigned x = (unsigned)cli_http_request_get_number(request, "x", UINT32_MAX);
  const unsigned y = (unsigned)cli_http_request_get_number(request, "y", UINT32_MAX);
  view_body body;
  (void)is_due;
  if (begin_body(&body)) cli_view_picture_write_values(view->picture, x, y, body.out);
  end_body(&body, 200, json_type, out);
}

/* ---- Editing ---- */

/* Watches the files that the scene reads now. */
static void watch_files(cli_view *view) {
  char *text = NULL;
  if (cli_view_document_describe(view->document, &text)) return;
  cli_view_watch_set_files(view->watch, cli_view_document_get_schema(view->document), text,
                           cli_view_document_get_frame(view->document));
  neph_text_destroy(view->session->context, text);
}

void cli_view_refresh(cli_view *view) {
  neph_output output = NEPH_OUTPUT_DEFAULT;
  cli_view_order order = {.generation = cli_view_document_get_generation(view->document),
                          .bake = cli_view_document_get_bake(view->document),
                          .samples_min = cli_view_document_get_samples_min(view->document),
                          .frame = cli_view_document_get_frame(view->document)};
  const neph_result result = neph_scene_get_output(cli_view_document_get_scene(view->document), &output);
  if (!result) cli_view_picture_set_preview(view->picture, &output.preview_desc);
  if (order.generation != cli_view_document_get_number(view->document)) return;
  if (order.bake == order.generation) watch_files(view);
  if (cli_view_document_copy_scene(view->document, &order.scene)) return;
  order.key = cli_view_document_create_key(view->document, order.scene);
  cli_view_worker_submit(view->worker, &order);
}

/* Replies to an edit with the state of the document, and the reason of a refusal. */
static void reply_edit(cli_view *view, unsigned status, cli_http_reply *out) {
  view_body body;
  if (status == 200) cli_view_refresh(view);
  if (begin_body(&body)) {
    fputs("{\"refusal\":", body.out);
    cli_put_json_text(body.out, status == 200 ? "" : cli_view_document_get_refusal(view->document));
    fputs(",\"notice\":", body.out);
    cli_put_json_text(body.out, cli_text_get(&view->messages.notice));
    fputc(',', body.out);
    cli_view_document_write_state(view->document, body.out);
    fputc('}', body.out);
  }
  end_body(&body, status, json_type, out);
}

/* Replies with the name of the file that was written, or the reason why none was. */
static void reply_file(cli_view *view, unsigned status, const char *path, cli_http_reply *out) {
  view_body body;
  if (begin_body(&body)) {
    fputs("{\"refusal\":", body.out);
    cli_put_json_text(body.out, status == 200 ? "" : cli_view_document_get_refusal(view->document));
    fputs(",\"file\":", body.out);
    cli_put_json_text(body.out, status == 200 ? path : "");
    fputc('}', body.out);
  }
  end_body(&body, status, json_type, out);
}

static void answer_set(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  const unsigned long long gesture = cli_http_request_get_number(request, "gesture", 0);
  reply_edit(view, cli_view_document_set(view->document, request->body, gesture), out);
}

static void answer_undo(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)request, (void)is_due;
  reply_edit(view, cli_view_document_undo(view->document), out);
}

static void answer_redo(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)request, (void)is_due;
  reply_edit(view, cli_view_document_redo(view->document), out);
}

static void answer_unset(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  reply_edit(view, cli_view_document_unset(view->document, request->body), out);
}

static void answer_add_cloud(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  reply_edit(view, cli_view_document_add_cloud(view->document, request->body), out);
}

static void answer_toggle_cloud(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  const unsigned long long cloud = cli_http_request_get_number(request, "cloud", UINT32_MAX);
  reply_edit(view, cli_view_document_toggle_cloud(view->document, (unsigned)cloud), out);
}

/* Begins a set of variants: the body has a line for each. */
static void answer_vary(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  neph_scene *scenes[CLI_VIEW_VARIANTS_MAX];
  unsigned count = 0;
  (void)is_due;
  const unsigned status = cli_view_document_vary(view->document, request->body, CLI_VIEW_VARIANTS_MAX, scenes, &count);
  if (status == 200) {
    cli_view_variants_begin(view->variants, scenes, count);
    cli_view_worker_awake(view->worker);
  }
  reply_file(view, status, "", out);
}

static void answer_variants(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  view_body body;
  (void)request, (void)is_due;
  if (begin_body(&body)) cli_view_variants_write_pixels(view->variants, body.out);
  end_body(&body, 200, "application/octet-stream", out);
}

static void answer_show(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  const neph_result result = cli_view_picture_set_channel(view->picture, request->body);
  *out = result ? cli_http_reply_text(422, "the channel cannot be shown\n") : cli_http_reply_text(200, "");
}

static void answer_reload(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  const bool keeps_edits = cli_http_request_get_number(request, "keep", 0);
  reply_edit(view, cli_view_document_reload(view->document, keeps_edits), out);
}

/* ---- Frames, regions, maps ---- */

/* The frames of the command line, in their order. */
static void answer_frames(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  cli_frame_walk walk = {0};
  view_body body;
  int frame;
  (void)request, (void)is_due;
  if (begin_body(&body)) {
    fputc('[', body.out);
    const cli_options *options = view->session->options;
    if (options->has_frame) fprintf(body.out, "%d", options->frame);
    for (bool is_first = true; !options->has_frame && cli_next_frame(options, &walk, &frame); is_first = false)
      fprintf(body.out, is_first ? "%d" : ",%d", frame);
    fputc(']', body.out);
  }
  end_body(&body, 200, json_type, out);
}

static void answer_frame(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  char *end;
  const long frame = strtol(request->body, &end, 10);
  (void)is_due;
  const bool is_number = end != request->body && !*end && frame >= -1000000000 && frame <= 1000000000;
  const unsigned status = is_number ? cli_view_document_set_frame(view->document, (int)frame)
                                    : cli_view_document_refuse(view->document, 400, "a frame must be a whole number");
  reply_edit(view, status, out);
}

/* Reads shares from 0 to 1, which fill the body; false: they do not. */
static bool read_shares(const char *body, size_t count, double *out) {
  if (!cli_view_read_numbers(body, count, out)) return false;
  for (size_t i = 0; i < count; i++)
    if (!(out[i] >= 0.0 && out[i] <= 1.0)) return false;
  return true;
}

/* Takes "LEFT TOP RIGHT BOTTOM", shares of the picture; an empty body: the whole. */
static void answer_region(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  double region[4] = {0.0};
  (void)is_due;
  const bool is_good = !*request->body || read_shares(request->body, 4, region);
  if (is_good) cli_view_worker_set_region(view->worker, region);
  *out =
      is_good ? cli_http_reply_text(200, "") : cli_http_reply_text(400, "a region must be four shares from 0 to 1\n");
}

/* Takes "X Y", the place of the pointer as shares of the picture. */
static void answer_focus(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  double focus[2];
  (void)is_due;
  const bool is_good = read_shares(request->body, 2, focus);
  if (is_good) cli_view_worker_set_focus(view->worker, focus[0], focus[1]);
  *out = is_good ? cli_http_reply_text(200, "") : cli_http_reply_text(400, "a focus must be two shares from 0 to 1\n");
}

static unsigned get_cloud(const cli_http_request *request) {
  return (unsigned)cli_http_request_get_number(request, "cloud", UINT32_MAX);
}

static void answer_map(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  view_body body;
  unsigned status = 500;
  (void)is_due;
  if (begin_body(&body)) status = cli_view_paint_write_pixels(&view->paint, get_cloud(request), body.out);
  if (status != 200 && body.out) fputs(cli_view_document_get_refusal(view->document), body.out);
  end_body(&body, status, status == 200 ? "application/octet-stream" : "text/plain; charset=utf-8", out);
}

static void answer_paint(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  const unsigned long long stroke = cli_http_request_get_number(request, "gesture", 0);
  reply_edit(view, cli_view_paint_dabs(&view->paint, get_cloud(request), request->body, stroke), out);
}

static void answer_unpaint(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)is_due;
  reply_edit(view, cli_view_paint_swap(&view->paint, get_cloud(request)), out);
}

/* ---- Saving ---- */

static void answer_save(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  (void)request, (void)is_due;
  reply_file(view, cli_view_document_save(view->document), cli_view_document_get_path(view->document), out);
}

static void answer_save_copy(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  cli_text name = {0};
  (void)request, (void)is_due;
  const unsigned status = cli_view_document_save_copy(view->document, &name);
  reply_file(view, status, cli_text_get(&name), out);
  cli_text_clear(&name);
}

/* Saves the picture beside the scene, under a name that is free. */
static void answer_save_picture(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  cli_text name = {0};
  (void)is_due;
  const bool is_exr = !strcmp(request->body, "exr");
  unsigned status = cli_view_document_choose_name(view->document, is_exr ? ".exr" : ".png", &name);
  cli_view_messages_judge(&view->messages, true);
  if (status == 200 && cli_view_picture_save(view->picture, cli_text_get(&name), is_exr)) status = 422;
  cli_view_messages_judge(&view->messages, false);
  reply_file(view, status, cli_text_get(&name), out);
  cli_text_clear(&name);
}

/* ---- The table ---- */

static const struct {
  const char *method, *path;
  void (*answer)(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out_reply);
} routes[] = {
    {"GET", "/api/picture", answer_picture},
    {"GET", "/api/schema", answer_schema},
    {"GET", "/api/values", answer_values},
    {"GET", "/api/edits", answer_edits},
    {"GET", "/api/pixel", answer_pixel},
    {"GET", "/api/channels", answer_channels},
    {"GET", "/api/variants", answer_variants},
    {"POST", "/api/set", answer_set},
    {"POST", "/api/unset", answer_unset},
    {"POST", "/api/add_cloud", answer_add_cloud},
    {"POST", "/api/undo", answer_undo},
    {"POST", "/api/redo", answer_redo},
    {"POST", "/api/reload", answer_reload},
    {"POST", "/api/show", answer_show},
    {"POST", "/api/vary", answer_vary},
    {"POST", "/api/save", answer_save},
    {"GET", "/api/frames", answer_frames},
    {"POST", "/api/frame", answer_frame},
    {"POST", "/api/region", answer_region},
    {"POST", "/api/focus", answer_focus},
    {"GET", "/api/map", answer_map},
    {"POST", "/api/paint", answer_paint},
    {"POST", "/api/unpaint", answer_unpaint},
    {"POST", "/api/toggle_cloud", answer_toggle_cloud},
    {"POST", "/api/save_copy", answer_save_copy},
    {"POST", "/api/save_picture", answer_save_picture},
};

void cli_view_answer(cli_view *view, const cli_http_request *request, bool is_due, cli_http_reply *out) {
  for (size_t i = 0; i < sizeof routes / sizeof *routes; i++)
    if (!strcmp(request->path, routes[i].path) && !strcmp(request->method, routes[i].method)) {
      routes[i].answer(view, request, is_due, out);
      return;
    }
  for (const cli_view_page *page = cli_view_pages; page->path; page++)
    if (!strcmp(request->path, page->path) && !strcmp(request->method, "GET")) {
      *out = (cli_http_reply){200, page->type, (const char *)page->bytes, page->size, NULL, false};
      return;
    }
  *out = cli_http_reply_text(404, "there is no such page\n");
}
