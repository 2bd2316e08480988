/* SPDX-License-Identifier: Apache-2.0 */
#include "view_document.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "view_edits.h"
#include "view_keys.h"
#include "view_past.h"

struct cli_view_document {
  cli_session *session;
  const char *path; /* borrowed */
  bool allows_files;
  char *schema;           /* JSON of the library */
  neph_scene *file_scene; /* scene of the file, at its last good reading, and of the command line */
  neph_scene *scene;      /* the same with the edits in force */
  cli_view_edits edits;
  size_t saved;                                /* edits in force at the last save */
  struct stat on_disk;                         /* the file as it was read or saved last */
  bool has_news;                               /* the file has changed on disk, and there are edits */
  bool is_unread;                              /* the file's last reading failed: the scene is not the file's */
  char *file_fault;                            /* messages of the file's last reading; NULL: it was read */
  unsigned long long number, generation, bake; /* last edit; the last that renders, and that bakes */
  unsigned samples_min;                        /* least number of samples a pixel for the scene's channels */
  unsigned long long files;                    /* state of the files that the scene reads */
  int frame;                                   /* frame that is shown */
  char *hidden;                                /* names of the clouds that are off, a line each; NULL: none */
  cli_view_messages *messages;                 /* borrowed; they hold the refusal */
};

/* ---- Refusals ---- */

static unsigned refuse(cli_view_document *document, unsigned status, const char *key, const char *reason) {
  cli_text_clear(&document->messages->refusal);
  cli_text_add(&document->messages->refusal, "%s%s%s", key, *key ? ": " : "", reason);
  return status;
}

unsigned cli_view_document_refuse(cli_view_document *document, unsigned status, const char *reason) {
  return refuse(document, status, "", reason);
}

const char *cli_view_document_get_refusal(const cli_view_document *document) {
  return cli_text_get(&document->messages->refusal);
}

/* ---- Scenes ---- */

/* Makes a scene of another and edits, which is described in a frame. Fails after messages. */
static neph_result build(const neph_scene *file_scene, const cli_view_edits *edits, int frame, neph_scene **out_scene) {
  neph_result result = neph_scene_clone(file_scene, out_scene);
  if (result) return result;
  result = cli_view_edits_apply(edits, *out_scene);
  if (!result) result = neph_scene_set_frame(*out_scene, frame);
  if (!result) result = neph_scene_check(*out_scene);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

/* Whether an edit may change the channels of the picture. */
static bool has_output(const cli_view_edits *edits) {
  static const char section[] = "output";
  for (size_t i = 0; i < edits->in_force; i++)
    if (!strncmp(edits->list[i].key, section, strlen(section))) return true;
  return false;
}

/* Notes the samples that the scene's channels need. */
static void note_samples_min(cli_view_document *document) {
  char *text = NULL;
  if (neph_scene_describe(document->scene, NEPH_TEXT_JSON, &text)) return;
  document->samples_min = cli_view_get_samples_min(text);
  neph_text_destroy(document->session->context, text);
}

/* Makes another list of edits that in force, where the scene has no fault with it: `base` with the edits `applied`.
 * Takes the list in any case. */
static unsigned accept_edits(cli_view_document *document, const neph_scene *base, const cli_view_edits *applied,
                             cli_view_edits edits, cli_view_cost cost) {
  const bool has_new_output = base != document->scene || has_output(applied);
  neph_scene *scene = NULL;
  cli_view_messages_judge(document->messages, true);
  const neph_result result = build(base, applied, document->frame, &scene);
  cli_view_messages_judge(document->messages, false);
  if (result) {
    cli_view_edits_clear(&edits);
    return 422;
  }
  cli_view_edits_clear(&document->edits);
  document->edits = edits;
  neph_scene_destroy(document->scene);
  document->scene = scene;
  if (has_new_output) note_samples_min(document);
  document->number++;
  if (cost >= CLI_VIEW_COST_RENDER) document->generation = document->number;
  if (cost >= CLI_VIEW_COST_BAKE) document->bake = document->number;
  return 200;
}

const neph_scene *cli_view_document_get_scene(const cli_view_document *document) { return document->scene; }

/* Has clouds that are baked to a file baked in memory: a view writes no bakes. */
static neph_result bake_in_memory(neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < neph_scene_get_cloud_count(scene); i++) {
    cli_text key = {0};
    if (!neph_scene_is_cloud_baked(scene, i) || !neph_scene_get_cloud_file(scene, i)) continue;
    cli_text_add(&key, "clouds[%u].vdb", i);
    result = key.has_failed ? NEPH_ERROR_OUT_OF_MEMORY : neph_scene_unset(scene, cli_text_get(&key));
    cli_text_clear(&key);
  }
  return result;
}

/* Whether a cloud is off. */
static bool is_hidden(const cli_view_document *document, const char *name) {
  const size_t length = strlen(name);
  for (const char *at = document->hidden; at && *at; at = strchr(at, '\n') + 1)
    if (!strncmp(at, name, length) && at[length] == '\n') return true;
  return false;
}

/* Takes the clouds that are off out of a copy of the scene, the last first. */
static neph_result remove_hidden(const cli_view_document *document, neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (unsigned i = neph_scene_get_cloud_count(scene); i-- > 0 && !result;) {
    cli_text key = {0};
    if (!is_hidden(document, neph_scene_get_cloud_name(scene, i))) continue;
    cli_text_add(&key, "clouds[%u]", i);
    result = key.has_failed ? NEPH_ERROR_OUT_OF_MEMORY : neph_scene_unset(scene, cli_text_get(&key));
    cli_text_clear(&key);
  }
  return result;
}

/* Makes a scene ready for a renderer; one that fails is destroyed. */
static neph_result prepare(const cli_view_document *document, neph_scene **scene) {
  neph_result result = remove_hidden(document, *scene);
  if (!result) result = bake_in_memory(*scene);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*scene);
  *scene = NULL;
  return result;
}

neph_result cli_view_document_copy_scene(cli_view_document *document, neph_scene **out_scene) {
  const neph_result result = neph_scene_clone(document->scene, out_scene);
  return result ? result : prepare(document, out_scene);
}

unsigned long long cli_view_document_get_generation(const cli_view_document *document) { return document->generation; }

char *cli_view_document_create_key(const cli_view_document *document, const neph_scene *scene) {
  return cli_view_past_create_key(document->session->context, document->schema, scene, document->frame,
                                  document->files);
}

unsigned cli_view_document_get_samples_min(const cli_view_document *document) { return document->samples_min; }

unsigned long long cli_view_document_get_bake(const cli_view_document *document) { return document->bake; }

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

/* Adds the sets of the lines to a list, and returns the greatest of their costs. */
static unsigned add_sets(cli_view_document *document, cli_view_edits *edits, char *lines, cli_view_cost *out_cost) {
  char *rest = NULL;
  *out_cost = CLI_VIEW_COST_DISPLAY;
  for (char *line = strtok_r(lines, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
    char *mark = strchr(line, '=');
    if (!mark || mark == line) return refuse(document, 400, line, "a line must be KEY=VALUE");
    *mark = '\0';
    const unsigned status = judge(document, line, mark + 1);
    if (status != 200) return status;
    if (!cli_view_edits_add(edits, CLI_VIEW_SET, line, mark + 1)) return refuse(document, 500, "", "out of memory");
    const cli_view_cost cost = cli_view_key_get_cost(document->schema, line);
    if (cost > *out_cost) *out_cost = cost;
  }
  return 200;
}

/* Makes a scene with the line's key set, and keeps messages as a refusal. */
static unsigned vary(cli_view_document *document, char *line, neph_scene **out_scene) {
  cli_view_edits edits = {0};
  cli_view_cost cost;
  unsigned status = add_sets(document, &edits, line, &cost);
  if (status == 200) cli_view_messages_judge(document->messages, true);
  if (status == 200 && (build(document->scene, &edits, document->frame, out_scene) || prepare(document, out_scene)))
    status = 422;
  cli_view_messages_judge(document->messages, false);
  cli_view_edits_clear(&edits);
  return status;
}

unsigned cli_view_document_vary(cli_view_document *document, char *lines, unsigned max, neph_scene **out_scenes,
                                unsigned *out_count) {
  char *rest = NULL;
  unsigned status = 200;
  *out_count = 0;
  for (char *line = strtok_r(lines, "\n", &rest); line && status == 200; line = strtok_r(NULL, "\n", &rest)) {
    status = *out_count < max ? vary(document, line, &out_scenes[*out_count]) : refuse(document, 400, "", "too many");
    if (status == 200) ++*out_count;
  }
  while (status != 200 && *out_count) neph_scene_destroy(out_scenes[--*out_count]);
  return status;
}

/* Copies the edits, for a change of the copy. */
static unsigned begin_change(cli_view_document *document, cli_view_edits *out_edits) {
  return cli_view_edits_copy(&document->edits, out_edits) ? 200 : refuse(document, 500, "", "out of memory");
}

/* Adds new edits behind those in force. They alone are applied, to the scene as it is. */
static unsigned append(cli_view_document *document, const cli_view_edits *fresh, unsigned long long gesture,
                       cli_view_cost cost) {
  cli_view_edits edits;
  const unsigned status = begin_change(document, &edits);
  if (status != 200) return status;
  cli_view_edits_begin(&edits, gesture);
  bool is_complete = true;
  for (size_t i = 0; is_complete && i < fresh->count; i++)
    is_complete = cli_view_edits_add(&edits, fresh->list[i].kind, fresh->list[i].key, fresh->list[i].value);
  if (is_complete) return accept_edits(document, document->scene, fresh, edits, cost);
  cli_view_edits_clear(&edits);
  return refuse(document, 500, "", "out of memory");
}

unsigned cli_view_document_set(cli_view_document *document, char *lines, unsigned long long gesture) {
  cli_view_edits fresh = {0};
  cli_view_cost cost;
  unsigned status = add_sets(document, &fresh, lines, &cost);
  if (status == 200) status = append(document, &fresh, gesture, cost);
  cli_view_edits_clear(&fresh);
  return status;
}

/* Makes one edit that is no set. */
static unsigned change(cli_view_document *document, cli_view_edit_kind kind, const char *key, const char *value) {
  cli_view_edits fresh = {0};
  unsigned status = cli_view_edits_add(&fresh, kind, key, value) ? 200 : refuse(document, 500, "", "out of memory");
  const cli_view_cost cost = kind == CLI_VIEW_UNSET ? cli_view_key_get_cost(document->schema, key) : CLI_VIEW_COST_BAKE;
  if (status == 200) status = append(document, &fresh, 0, cost);
  cli_view_edits_clear(&fresh);
  return status;
}

unsigned cli_view_document_unset(cli_view_document *document, const char *key) {
  return change(document, CLI_VIEW_UNSET, key, NULL);
}

/* Whether a cloud has a name. */
static bool has_cloud(const neph_scene *scene, const char *name) {
  for (unsigned i = 0; i < neph_scene_get_cloud_count(scene); i++)
    if (!strcmp(neph_scene_get_cloud_name(scene, i), name)) return true;
  return false;
}

unsigned cli_view_document_add_cloud(cli_view_document *document, const char *preset) {
  cli_text name = {0}, key = {0}, value = {0};
  if (!cli_view_value_is_word(preset)) return refuse(document, 400, preset, "this is no name of a preset");
  cli_text_add(&name, "%s", preset);
  for (unsigned i = 2; has_cloud(document->scene, cli_text_get(&name)); i++) {
    cli_text_clear(&name);
    cli_text_add(&name, "%s %u", preset, i);
  }
  cli_text_add(&key, "clouds[%u]", neph_scene_get_cloud_count(document->scene));
  cli_text_add(&value, "{name: %s, bake: {preset: %s}}", cli_text_get(&name), preset);
  const unsigned status = change(document, CLI_VIEW_INSERT, cli_text_get(&key), cli_text_get(&value));
  cli_text_clear(&name);
  cli_text_clear(&key);
  cli_text_clear(&value);
  return status;
}

/* ---- Maps, frames and files ---- */

/* Counts an edit that the scene does not have. */
static void count_edit(cli_view_document *document) { document->bake = document->generation = ++document->number; }

void cli_view_document_touch(cli_view_document *document) {
  document->files++;
  count_edit(document);
}

unsigned cli_view_document_set_frame(cli_view_document *document, int frame) {
  if (frame == document->frame) return 200;
  cli_view_messages_judge(document->messages, true);
  const neph_result result = neph_scene_set_frame(document->scene, frame);
  cli_view_messages_judge(document->messages, false);
  if (result) return 422;
  document->frame = frame;
  count_edit(document);
  return 200;
}

/* Names of the clouds that are off, with or without one more. */
static char *list_hidden(const cli_view_document *document, const char *name) {
  const bool was_hidden = is_hidden(document, name);
  cli_text text = {0};
  for (const char *at = document->hidden; at && *at; at = strchr(at, '\n') + 1) {
    const size_t length = strcspn(at, "\n");
    if (strlen(name) != length || strncmp(at, name, length)) cli_text_add(&text, "%.*s\n", (int)length, at);
  }
  if (!was_hidden) cli_text_add(&text, "%s\n", name);
  return text.characters;
}

unsigned cli_view_document_toggle_cloud(cli_view_document *document, unsigned cloud) {
  if (cloud >= neph_scene_get_cloud_count(document->scene)) return refuse(document, 422, "", "there is no such cloud");
  char *hidden = list_hidden(document, neph_scene_get_cloud_name(document->scene, cloud));
  free(document->hidden);
  document->hidden = hidden;
  count_edit(document);
  return 200;
}

/* Indices of the clouds that are off, as a JSON list. */
static void write_hidden(const cli_view_document *document, FILE *out) {
  bool is_first = true;
  fputs("\"hidden\":[", out);
  for (unsigned i = 0; i < neph_scene_get_cloud_count(document->scene); i++) {
    if (!is_hidden(document, neph_scene_get_cloud_name(document->scene, i))) continue;
    fprintf(out, is_first ? "%u" : ",%u", i);
    is_first = false;
  }
  fputs("],", out);
}

int cli_view_document_get_frame(const cli_view_document *document) { return document->frame; }

const char *cli_view_document_get_schema(const cli_view_document *document) { return document->schema; }

neph_result cli_view_document_describe(const cli_view_document *document, char **out_text) {
  return neph_scene_describe(document->scene, NEPH_TEXT_JSON, out_text);
}

/* The text of a key's value in the scene's JSON, as it goes on; NULL: the key is not in force. */
static const char *search_value(const char *described, unsigned cloud, const char *key) {
  cli_text name = {0};
  cli_text_add(&name, "\"clouds[%u].%s\": \"", cloud, key);
  const char *found = name.has_failed ? NULL : strstr(described, cli_text_get(&name));
  if (found) found += name.length;
  cli_text_clear(&name);
  return found;
}

unsigned cli_view_document_get_map(cli_view_document *document, unsigned cloud, char **out_path) {
  char *text = NULL;
  *out_path = NULL;
  if (cloud >= neph_scene_get_cloud_count(document->scene) || !neph_scene_is_cloud_baked(document->scene, cloud))
    return refuse(document, 422, "", "the cloud is not baked here: it has no map");
  if (cli_view_document_describe(document, &text)) return refuse(document, 500, "", "out of memory");
  const char *value = search_value(text, cloud, "bake.map.image");
  if (value && !strncmp(value, "\\\"", 2)) *out_path = strndup(value + 2, strcspn(value + 2, "\\"));
  neph_text_destroy(document->session->context, text);
  return 200;
}

double cli_view_document_get_coverage(const cli_view_document *document, unsigned cloud) {
  char *text = NULL;
  if (cli_view_document_describe(document, &text)) return 0.0;
  const char *value = search_value(text, cloud, "bake.coverage");
  const double coverage = value ? strtod(value, NULL) : 0.0;
  neph_text_destroy(document->session->context, text);
  return coverage;
}

bool cli_view_is_same_name(const char *a, const char *b) {
  const char *slash_a = strrchr(a, '/'), *slash_b = strrchr(b, '/');
  return !strcmp(slash_a ? slash_a + 1 : a, slash_b ? slash_b + 1 : b);
}

/* The scene names it as beside its own file. */
unsigned cli_view_document_set_map(cli_view_document *document, unsigned cloud, const char *path) {
  char *now = NULL;
  cli_text key = {0}, value = {0};
  unsigned status = cli_view_document_get_map(document, cloud, &now);
  const bool is_set = now && cli_view_is_same_name(now, path);
  const char *slash = strrchr(path, '/');
  cli_text_add(&key, "clouds[%u].bake.map", cloud);
  cli_text_add(&value, "\"%s\"", slash ? slash + 1 : path);
  if (status == 200 && is_set) cli_view_document_touch(document);
  if (status == 200 && !is_set) status = change(document, CLI_VIEW_SET, cli_text_get(&key), cli_text_get(&value));
  cli_text_clear(&key);
  cli_text_clear(&value);
  free(now);
  return status;
}

static unsigned step(cli_view_document *document, bool (*move)(cli_view_edits *edits), const char *reason) {
  cli_view_edits edits;
  const unsigned status = begin_change(document, &edits);
  if (status != 200) return status;
  if (move(&edits)) return accept_edits(document, document->file_scene, &edits, edits, CLI_VIEW_COST_BAKE);
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

/* Notes what is wrong with the file, the reason of the last refusal. */
static void note_fault(cli_view_document *document, bool is_faulty) {
  free(document->file_fault);
  document->file_fault = is_faulty ? strdup(cli_view_document_get_refusal(document)) : NULL;
}

/* Notes the file as it is on disk. */
static void note_file(cli_view_document *document) {
  if (stat(document->path, &document->on_disk)) document->on_disk = (struct stat){0};
}

/* Whether the file on disk is not the one that was read or saved last. One that was removed is none to read, and
 * nothing that a save would lose. */
static bool has_changed(const cli_view_document *document) {
  const struct stat *known = &document->on_disk;
  struct stat now;
  if (stat(document->path, &now)) return false;
  return now.st_ino != known->st_ino || now.st_dev != known->st_dev || now.st_size != known->st_size ||
         now.st_mtim.tv_sec != known->st_mtim.tv_sec || now.st_mtim.tv_nsec != known->st_mtim.tv_nsec;
}

/* Reads the file and the settings of the command line. */
static unsigned read_file(cli_view_document *document, neph_scene **out_scene) {
  note_file(document);
  cli_view_messages_judge(document->messages, true);
  const neph_result result = cli_read_scene(document->session, document->path, out_scene);
  cli_view_messages_judge(document->messages, false);
  return result ? 422 : 200;
}

unsigned cli_view_document_reload(cli_view_document *document, bool keeps_edits) {
  cli_view_edits edits = {0};
  neph_scene *file_scene = NULL;
  unsigned status = read_file(document, &file_scene);
  if (status == 200 && keeps_edits) status = begin_change(document, &edits);
  if (edits.in_force >= document->saved) cli_view_edits_drop(&edits, document->saved);
  if (status == 200) status = accept_edits(document, file_scene, &edits, edits, CLI_VIEW_COST_BAKE);
  note_fault(document, status != 200);
  document->is_unread = status != 200;
  if (status == 200) {
    neph_scene *before = document->file_scene;
    document->file_scene = file_scene;
    file_scene = before;
    document->saved = 0;
    document->files++;
    document->has_news = false;
  }
  neph_scene_destroy(file_scene);
  return status;
}

/* Writes the scene, and keeps messages as a refusal. */
static unsigned save(cli_view_document *document, const char *path) {
  cli_view_messages_judge(document->messages, true);
  const neph_result result = neph_scene_save(document->scene, path);
  cli_view_messages_judge(document->messages, false);
  return result ? 422 : 200;
}

unsigned cli_view_document_save(cli_view_document *document) {
  if (has_changed(document))
    return refuse(document, 409, document->path, "the file has changed on disk: read it first");
  if (document->is_unread)
    return refuse(document, 409, document->path,
                  "the file on disk could not be read, and is kept: mend it, or save a copy");
  const unsigned status = save(document, document->path);
  if (status != 200) return status;
  document->saved = document->edits.in_force;
  note_file(document);
  return status;
}

/* A name beside the scene's that no file has: "scene-2.yaml". */
static bool choose_name(const cli_view_document *document, const char *ending, cli_text *out_name) {
  const char *path = document->path, *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
  const size_t length = dot && (!slash || dot > slash) ? (size_t)(dot - path) : strlen(path);
  struct stat taken; /* a link that leads nowhere takes a name, too */
  for (unsigned i = 2; i < 10000; i++) {
    cli_text_clear(out_name);
    cli_text_add(out_name, "%.*s-%u%s", (int)length, path, i, ending);
    if (out_name->has_failed) return false;
    if (lstat(cli_text_get(out_name), &taken)) return true;
  }
  return false;
}

unsigned cli_view_document_choose_name(cli_view_document *document, const char *ending, cli_text *out_name) {
  return choose_name(document, ending, out_name) ? 200 : refuse(document, 422, "", "no name is free beside the scene");
}

unsigned cli_view_document_save_copy(cli_view_document *document, cli_text *out_name) {
  const unsigned status = cli_view_document_choose_name(document, ".yaml", out_name);
  return status == 200 ? save(document, cli_text_get(out_name)) : status;
}

static bool is_edited(const cli_view_document *document) { return document->edits.in_force != document->saved; }

bool cli_view_document_follow(cli_view_document *document) {
  if (!has_changed(document)) return false;
  document->has_news = is_edited(document);
  return !document->has_news && cli_view_document_reload(document, false) == 200;
}

/* ---- State ---- */

void cli_view_document_write_state(const cli_view_document *document, FILE *out) {
  const cli_view_edits *edits = &document->edits;
  write_hidden(document, out);
  fprintf(
      out,
      "\"frame\":%d,\"wanted\":%llu,\"edit\":%llu,\"undo\":%s,\"redo\":%s,\"edited\":%s,\"news\":%s,\"file_fault\":",
      document->frame, document->generation, document->number, edits->in_force ? "true" : "false",
      edits->in_force < edits->count ? "true" : "false", is_edited(document) ? "true" : "false",
      document->has_news ? "true" : "false");
  cli_put_json_text(out, document->file_fault ? document->file_fault : "");
}

neph_result cli_view_document_describe_edits(const cli_view_document *document, char **out_text) {
  return neph_scene_describe_edits(document->scene, NEPH_TEXT_JSON, out_text);
}

/* ---- Lifetime ---- */

/* The first frame of the command line; frame 1 where none is given. */
static int choose_first_frame(const cli_options *options) {
  cli_frame_walk walk = {0};
  int frame = 1;
  if (options->has_frame) return options->frame;
  return cli_next_frame(options, &walk, &frame) ? frame : 1;
}

cli_exit cli_view_document_open(cli_session *session, cli_view_messages *messages, const char *path, bool allows_files,
                                cli_view_document **out_document) {
  cli_view_document *document = *out_document = calloc(1, sizeof *document);
  if (!document) return cli_complain("out of memory"), CLI_INTERNAL;
  *document = (cli_view_document){.session = session,
                                  .messages = messages,
                                  .path = path,
                                  .allows_files = allows_files,
                                  .frame = choose_first_frame(session->options),
                                  .samples_min = 1,
                                  .number = 1,
                                  .generation = 1,
                                  .bake = 1};
  neph_result result = neph_schema_describe(session->context, NULL, NEPH_TEXT_JSON, &document->schema);
  note_file(document);
  if (!result) result = cli_read_scene(session, path, &document->file_scene);
  if (!result) result = neph_scene_clone(document->file_scene, &document->scene);
  if (!result) result = neph_scene_set_frame(document->scene, document->frame);
  if (!result) note_samples_min(document);
  if (!result) return CLI_DONE;
  cli_view_document_close(document);
  *out_document = NULL;
  return cli_exit_of(result);
}

void cli_view_document_close(cli_view_document *document) {
  if (!document) return;
  neph_text_destroy(document->session->context, document->schema);
  neph_scene_destroy(document->file_scene);
  neph_scene_destroy(document->scene);
  cli_view_edits_clear(&document->edits);
  free(document->file_fault);
  free(document->hidden);
  free(document);
}
