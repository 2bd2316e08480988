/* SPDX-License-Identifier: Apache-2.0 */
/* A first program against the installed library: bakes a small cloud to the file it is told, and says what is in it.
 * The second argument, if any, is the folder of the modules. */
#include <stdio.h>

#include <nephos/nephos.h>

static void print_message(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level;
  fprintf(stderr, "%s\n", message);
}

static neph_result bake_small_cloud(neph_context *context, const char *path) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  cloud.extent_m[0] = cloud.extent_m[1] = 1500.0;
  cloud.voxel_m = 50.0;
  return neph_cloud_bake_file(context, &cloud, NULL, "density", path);
}

int main(int argument_count, char **arguments) {
  if (argument_count < 2) return 2;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.log = print_message;
  desc.module_dir = argument_count > 2 ? arguments[2] : NULL;
  neph_context *context = NULL;
  char *text = NULL;

  neph_result result = neph_context_create(&desc, &context);
  if (!result) result = bake_small_cloud(context, arguments[1]);
  if (!result) result = neph_volume_describe_file(context, arguments[1], NEPH_TEXT_PLAIN, &text);
  if (!result) fputs(text, stdout);

  neph_text_destroy(context, text);
  neph_context_destroy(context);
  printf("nephos %s: %s\n", neph_version_get_text(), neph_result_get_text(result));
  return result != NEPH_OK;
}
