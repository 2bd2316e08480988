/* SPDX-License-Identifier: Apache-2.0 */
#include "view_document.h"

#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "view_edits.h"
#include "view_keys.h"

struct cli_view_document {
  cli_session *session;
  const char *path; /* borrowed */
  bool allows_files;
  char *schema;      /* JSON of the library */
  char *text;        /* text of the file, at its last good reading */
  neph_scene *scene; /* scene of the file, the command line, and the edits in force */
  cli_view_edits edits;
  size_t saved;     /* edits in force at the last save */
  bool has_news;    /* the file has changed on disk, and there are edits */
  char *file_fault; /* messages of the file's last reading; NULL: it was read */
  unsigned long long generation, number;
  cli_view_messages *messages; /* borrowed; they hold the refusal */
};

/* ---- Refusals ---- */

static unsigned refuse(cli_view_document *document, unsigned status, const char *key, const char *reason) {
  cli_text_clear(&document->messages->refusal);
  cli_text_add(&document->messages->refusal, "%s%s%s", key, *key ? ": " : "", reason);
  return status;
}

const char *cli_view_document_get_refusal(const cli_view_document *document) {
  return cli_text_get(&document->messages->refusal);
}

/* ---- Scenes ---- */

/* Makes a scene of a text, the settings of the command line, and edits. Fails after messages. */
static neph_result build(const cli_view_document *document, const char *text, const cli_view_edits *edits,
                         neph_scene **out_scene) {
  neph_result result = neph_scene_load_text(document->session->context, text, document->path, out_scene);
  if (result) return result;
  result = cli_set_scene(document->session, *out_scene);
  if (!result) result = cli_view_edits_apply(edits, *out_scene);
  if (!result) result = neph_scene_check(*out_scene);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

/* Makes another list of edits that in force, where the scene has no fault with it. Takes the list in any case. */
static unsigned accept_edits(cli_view_document *document, const char *text, cli_view_edits edits, bool is_view_alone) {
  neph_scene *scene = NULL;
  cli_view_messages_judge(document->messages, true);
  const neph_result result = build(document, text, &edits, &scene);
  cli_view_messages_judge(document->messages, false);
  if (result) {
    cli_view_edits_clear(&edits);
    return 422;
  }
  cli_view_edits_clear(&document->edits);
  document->edits = edits;
  neph_scene_destroy(document->scene);
  document->scene = scene;
  document->number++;
  if (!is_view_alone) document->generation = document->number;
  return 200;
}

const neph_scene *cli_view_document_get_scene(const cli_view_document *document) { return document->scene; }

neph_result cli_view_document_copy_scene(cli_view_document *document, neph_scene **out_scene) {
  return build(document, document->text, &document->edits, out_scene);
}

unsigned long long cli_view_document_get_generation(const cli_view_document *document) { return document->generation; }

unsigned long long cli_view_document_get_number(const cli_view_document *document) { return document->number; }

const char *cli_view_document_get_path(const cli_view_document *document) { return document->path; }

/* ---- Edits ---- */

static unsigned judge(cli_view_document *document, const char *key, const char *value) {
  const cli_view_key_use use = cli_view_key_get_use(document->schema, key);
  if (use == CLI_VIEW_KEY_FILE && !document->allows_files)
    return refuse(document, 403, key, "the page sets keys that name files with --allow-files alone");
  if (use == CLI_VIEW_KEY_MAPPING && !cli_view_value_is_word(value))
    return refuse(document, 403, key, "the page sets single keys of `nephos schema` alone");
  return 200;
}

/* Adds the edits of the lines to a list. */
static unsigned add_lines(cli_view_document *document, cli_view_edits *edits, char *lines, bool *out_is_view_alone) {
  char *rest = NULL;
  *out_is_view_alone = true;
  for (char *line = strtok_r(lines, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
    char *mark = strchr(line, '=');
    if (!mark || mark == line) return refuse(document, 400, line, "a line must be KEY=VALUE");
    *mark = '\0';
    const unsigned status = judge(document, line, mark + 1);
    if (status != 200) return status;
    if (!cli_view_edits_add(edits, line, mark + 1)) return refuse(document, 500, "", "out of memory");
    *out_is_view_alone = *out_is_view_alone && cli_view_key_is_view(line);
  }
  return 200;
}

unsigned cli_view_document_set(cli_view_document *document, char *lines, unsigned long long gesture) {
  cli_view_edits edits;
  bool is_view_alone;
  if (!cli_view_edits_copy(&document->edits, &edits)) return refuse(document, 500, "", "out of memory");
  cli_view_edits_begin(&edits, gesture);
  const unsigned status = add_lines(document, &edits, lines, &is_view_alone);
  if (status == 200) return accept_edits(document, document->text, edits, is_view_alone);
  cli_view_edits_clear(&edits);
  return status;
}

static unsigned step(cli_view_document *document, bool (*move)(cli_view_edits *edits), const char *reason) {
  cli_view_edits edits;
  if (!cli_view_edits_copy(&document->edits, &edits)) return refuse(document, 500, "", "out of memory");
  if (move(&edits)) return accept_edits(document, document->text, edits, false);
  cli_view_edits_clear(&edits);
  return refuse(document, 409, "", reason);
}

unsigned cli_view_document_undo(cli_view_document *document) {
  return step(document, cli_view_edits_undo, "there is nothing to undo");
}

unsigned cli_view_document_redo(cli_view_document *document) {
  return step(document, cli_view_edits_redo, "there is nothing to redo");
}

/* ---- The file ---- */

/* Reads the file's text. Fails after a message. */
static char *read_text(const char *path) {
  cli_text text = {0};
  char part[4097];
  FILE *file = fopen(path, "re");
  for (size_t count; file && (count = fread(part, 1, sizeof part - 1, file)) > 0;) {
    part[count] = '\0';
    cli_text_add(&text, "%s", part);
  }
  const bool is_read = file && !ferror(file) && !text.has_failed;
  if (file) fclose(file);
  if (is_read && text.length) return text.characters;
  cli_text_clear(&text);
  return is_read ? strdup("") : NULL;
}

/* Notes what is wrong with the file, the reason of the last refusal. */
static void note_fault(cli_view_document *document, bool is_faulty) {
  free(document->file_fault);
  document->file_fault = is_faulty ? strdup(cli_view_document_get_refusal(document)) : NULL;
}

unsigned cli_view_document_reload(cli_view_document *document, bool keeps_edits) {
  cli_view_edits edits = {0};
  char *text = read_text(document->path);
  unsigned status = text ? 200 : refuse(document, 422, document->path, "the file cannot be read");
  if (status == 200 && keeps_edits && !cli_view_edits_copy(&document->edits, &edits))
    status = refuse(document, 500, "", "out of memory");
  if (status == 200) status = accept_edits(document, text, edits, false);
  note_fault(document, status != 200);
  if (status != 200) {
    free(text);
    return status;
  }
  free(document->text);
  document->text = text;
  document->saved = 0;
  document->has_news = false;
  return status;
}

static bool is_edited(const cli_view_document *document) { return document->edits.in_force != document->saved; }

bool cli_view_document_follow(cli_view_document *document) {
  document->has_news = is_edited(document);
  return !document->has_news && cli_view_document_reload(document, false) == 200;
}

/* ---- State ---- */

void cli_view_document_write_state(const cli_view_document *document, FILE *out) {
  const cli_view_edits *edits = &document->edits;
  fprintf(out, "\"wanted\":%llu,\"edit\":%llu,\"undo\":%s,\"redo\":%s,\"edited\":%s,\"news\":%s,\"file_fault\":",
          document->generation, document->number, edits->in_force ? "true" : "false",
          edits->in_force < edits->count ? "true" : "false", is_edited(document) ? "true" : "false",
          document->has_news ? "true" : "false");
  cli_put_json_text(out, document->file_fault ? document->file_fault : "");
}

/* Whether an edit in force behind that of `index` sets the same key. */
static bool is_overruled(const cli_view_edits *edits, size_t index) {
  for (size_t i = index + 1; i < edits->in_force; i++)
    if (!strcmp(edits->list[i].key, edits->list[index].key)) return true;
  return false;
}

void cli_view_document_write_edits(const cli_view_document *document, FILE *out) {
  const cli_view_edits *edits = &document->edits;
  for (size_t i = 0; i < edits->in_force; i++)
    if (!is_overruled(edits, i)) fprintf(out, "%s=%s\n", edits->list[i].key, edits->list[i].value);
}

/* ---- Lifetime ---- */

cli_exit cli_view_document_open(cli_session *session, cli_view_messages *messages, const char *path, bool allows_files,
                                cli_view_document **out_document) {
  cli_view_document *document = *out_document = calloc(1, sizeof *document);
  if (!document) return cli_complain("out of memory"), CLI_INTERNAL;
  *document = (cli_view_document){.session = session,
                                  .messages = messages,
                                  .path = path,
                                  .allows_files = allows_files,
                                  .number = 1,
                                  .generation = 1};
  neph_result result = neph_schema_describe(session->context, NULL, NEPH_TEXT_JSON, &document->schema);
  if (!result) result = cli_read_scene(session, path, &document->scene);
  if (!result && !(document->text = read_text(path))) result = NEPH_ERROR_IO;
  if (!result) return CLI_DONE;
  cli_view_document_close(document);
  *out_document = NULL;
  return cli_exit_of(result);
}

void cli_view_document_close(cli_view_document *document) {
  if (!document) return;
  neph_text_destroy(document->session->context, document->schema);
  free(document->text);
  neph_scene_destroy(document->scene);
  cli_view_edits_clear(&document->edits);
  free(document->file_fault);
  free(document);
}
