/* SPDX-License-Identifier: Apache-2.0 */
/* A first program against the installed library. */
#include <stdio.h>

#include <nephos/nephos.h>

static void print_message(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level;
  fprintf(stderr, "%s\n", message);
}

int main(void) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.log = print_message;
  desc.thread_count = 2;
  neph_context *context = NULL;
  neph_result result = neph_context_create(&desc, &context);
  if (!result && neph_context_get_thread_count(context) != 2) result = NEPH_ERROR_INTERNAL;
  neph_context_destroy(context);
  printf("nephos %s: %s\n", neph_version_get_text(), neph_result_get_text(result));
  return result != NEPH_OK;
}
