/* SPDX-License-Identifier: Apache-2.0 */
#include "session.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "print.h"
#include "process.h"

cli_exit cli_exit_of(neph_result result) {
  switch (result) {
  case NEPH_OK:
    return CLI_DONE;
  case NEPH_ERROR_INTERNAL:
  case NEPH_ERROR_OUT_OF_MEMORY:
    return CLI_INTERNAL;
  case NEPH_ERROR_INVALID_ARGUMENT:
    return CLI_USAGE;
  case NEPH_ERROR_BAD_SCENE:
    return CLI_BAD_SCENE;
  case NEPH_ERROR_NOT_FOUND:
    return CLI_NOT_FOUND;
  case NEPH_ERROR_IO:
  case NEPH_ERROR_BAD_FILE:
  case NEPH_ERROR_UNSUPPORTED:
    return CLI_IO;
  case NEPH_ERROR_LIMIT:
    return CLI_LIMIT;
  case NEPH_ERROR_CANCELLED:
    return CLI_INTERRUPTED;
  }
  return CLI_INTERNAL;
}

/* Checks whether a log can be opened, in a context of its own, since the session's context writes to the log. */
static cli_exit check_log_place(cli_session *session, const char *path) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  neph_files *files = NULL;
  desc.thread_count = 1;
  desc.log = cli_progress_log;
  desc.log_user = &session->progress;
  neph_result result = neph_context_create(&desc, &context);
  if (!result) result = neph_files_create(context, &files);
  if (!result) result = neph_files_add(files, NEPH_FILE_WRITTEN, "--log", path);
  neph_files_destroy(files);
  neph_context_destroy(context);
  return cli_exit_of(result);
}

static cli_exit open_log(cli_session *session, const char *path) {
  if (!path) return CLI_DONE;
  const cli_exit exit = check_log_place(session, path);
  return exit ? exit : cli_progress_open_log(&session->progress, path);
}

static bool is_interrupted(void *user) {
  (void)user;
  return cli_is_interrupted();
}

cli_exit cli_session_start(const cli_options *options, cli_session *session) {
  *session = (cli_session){.options = options};
  cli_progress_start(&session->progress, options);
  const cli_exit exit = open_log(session, options->log_path);
  if (exit) return exit;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = options->thread_count;
  desc.isa_max = options->isa;
  desc.log = cli_progress_log;
  desc.log_user = &session->progress;
  desc.log_level_max = options->log_path && options->log_level < NEPH_LOG_INFO ? NEPH_LOG_INFO : options->log_level;
  desc.cache_dir = options->cache_dir;
  desc.path_mapping = options->path_mapping;
  desc.cache_size_max_bytes = options->cache_size_max_bytes;
  desc.is_interrupted = is_interrupted;
  desc.loop_log = options->loop_log;
  neph_result result = neph_context_create(&desc, &session->context);
  neph_names_desc names = NEPH_NAMES_DESC_DEFAULT;
  names.variables = (const char *const *)environ;
  names.time_zone_dir = getenv("TZDIR");
  if (!result) result = neph_context_set_names(session->context, &names);
  return cli_exit_of(result);
}

void cli_session_end(cli_session *session) {
  neph_context_destroy(session->context);
  cli_progress_end(&session->progress);
}

static neph_result apply_settings(const cli_options *options, neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < options->setting_count; i++) {
    const cli_setting *setting = &options->settings[i];
    result = neph_scene_set(scene, setting->key, setting->value);
    /* A wrong value of an option that sets a key is an error of the command line, not of the scene. */
    if (result == NEPH_ERROR_BAD_SCENE && setting->option) result = NEPH_ERROR_INVALID_ARGUMENT;
  }
  return result;
}

neph_result cli_set_scene(const cli_session *session, neph_scene *scene) {
  const neph_result result = apply_settings(session->options, scene);
  return result || !session->options->has_frame ? result : neph_scene_set_frame(scene, session->options->frame);
}

neph_result cli_read_scene(cli_session *session, const char *path, neph_scene **out_scene) {
  neph_result result = neph_scene_open(session->context, path, out_scene);
  if (result) return result;
  result = cli_set_scene(session, *out_scene);
  if (!result) result = neph_scene_check(*out_scene);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

cli_exit cli_load_scene(cli_session *session, const char *path, neph_scene **out_scene) {
  return cli_exit_of(cli_read_scene(session, path, out_scene));
}

cli_exit cli_check_target(const cli_session *session, const char *path) {
  return cli_exit_of(neph_target_check(session->context, path));
}

void cli_print_text(cli_session *session, char *text) {
  size_t length = strlen(text);
  cli_clean_lines(text);
  fputs(text, stdout);
  if (length && text[length - 1] != '\n') putchar('\n');
  neph_text_destroy(session->context, text);
}

neph_text_format cli_text_format(const cli_session *session) {
  return session->options->is_json ? NEPH_TEXT_JSON : NEPH_TEXT_PLAIN;
}

bool cli_has_extension(const char *path, const char *extension) {
  size_t length = strlen(path), tail = strlen(extension);
  return length > tail && !strcasecmp(path + length - tail, extension);
}

bool cli_is_scene(const char *path) {
  return cli_has_extension(path, ".yaml") || cli_has_extension(path, ".yml") || (path[0] == '-' && !path[1]);
}

bool cli_place_output(const char *path, const char *extension, const char **image, const char **preview) {
  const bool is_preview = cli_has_extension(path, ".png");
  const char **place = is_preview ? preview : image;
  if (*place || (!is_preview && !cli_has_extension(path, extension))) return false;
  *place = path;
  return true;
}

bool cli_is_single_frame(const cli_options *options) {
  cli_frame_walk walk = {0};
  int frame;
  return cli_next_frame(options, &walk, &frame) && !cli_next_frame(options, &walk, &frame);
}
