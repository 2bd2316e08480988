/* SPDX-License-Identifier: Apache-2.0 */
#include "fuzz_support.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static neph_context *context;
static unsigned error_count;
static char folder[] = "/tmp/nephos-fuzz-XXXXXX", path[64];

static void count_error(void *user, neph_log_level level, const char *message) {
  (void)user;
  error_count += level == NEPH_LOG_ERROR;
  if (strchr(message, '\n')) abort();
}

static void end(void) {
  neph_context_destroy(context);
  if (!path[0]) return;
  unlink(path);
  rmdir(folder);
}

neph_context *fuzz_get_context(void) {
  if (context) return context;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = 1;
  desc.log = count_error;
  desc.module_dir = NEPHOS_FUZZ_MODULE_DIR;
  if (neph_context_create(&desc, &context)) abort();
  atexit(end);
  return context;
}

const char *fuzz_write_file(const char *name, const uint8_t *data, size_t size) {
  if (!path[0] && !mkdtemp(folder)) abort();
  if (path[0]) unlink(path); /* its name may differ */
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(data, 1, size, file) != size || fclose(file)) abort();
  return path;
}

static void check_result(neph_result result) {
  if (result != NEPH_OK && result != NEPH_ERROR_BAD_FILE && result != NEPH_ERROR_BAD_SCENE &&
      result != NEPH_ERROR_UNSUPPORTED && result != NEPH_ERROR_INVALID_ARGUMENT && result != NEPH_ERROR_LIMIT &&
      result != NEPH_ERROR_NOT_FOUND)
    abort();
}

void fuzz_expect(neph_result result) {
  const unsigned errors = error_count;
  error_count = 0;
  /* A scene's errors are logged together, followed by their number: at most 20 and 1. */
  const bool is_several = result == NEPH_ERROR_BAD_SCENE && errors > 2 && errors <= 21;
  if (errors != (result != NEPH_OK) && !is_several) abort();
  check_result(result);
}

void fuzz_expect_any(neph_result result) {
  const unsigned errors = error_count;
  error_count = 0;
  if ((errors > 0) != (result != NEPH_OK)) abort();
  check_result(result);
}

void fuzz_read_volume(const char *name, const uint8_t *data, size_t size, const neph_volume_load_desc *desc) {
  neph_context *own = fuzz_get_context();
  const char *file = fuzz_write_file(name, data, size);
  neph_volume *volume;
  char *text;
  fuzz_expect(neph_volume_describe_file(own, file, NEPH_TEXT_JSON, &text));
  neph_text_destroy(own, text);
  fuzz_expect(neph_volume_load(own, file, desc, &volume));
  neph_volume_release(volume);
  fuzz_expect(neph_volume_load_memory(own, data, size, desc, &volume));
  neph_volume_release(volume);
}
