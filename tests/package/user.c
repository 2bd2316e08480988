/* SPDX-License-Identifier: Apache-2.0 */
/* A first program with the installed library: bakes a small cloud to a given file, and prints its content. The optional
 * second argument is the folder of the modules. Exits with 3 if the library states beforehand that it cannot write .vdb
 * files, and then fails. */
#include <stdio.h>

#include <nephos/nephos.h>

static neph_result bake_small_cloud(neph_context *context, const char *path) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  cloud.extent_m[0] = cloud.extent_m[1] = 1500.0;
  cloud.voxel_m = 50.0;
  return neph_cloud_bake_file(context, &cloud, NULL, "density", path);
}

int main(int argument_count, char **arguments) {
  if (argument_count < 2) return 2;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.module_dir = argument_count > 2 ? arguments[2] : NULL;
  neph_context *context = NULL;
  char *text = NULL;

  neph_result result = neph_context_create(&desc, &context);
  const bool has_vdb = !result && neph_feature_is_present(context, NEPH_FEATURE_VDB);
  if (!result) result = bake_small_cloud(context, arguments[1]);
  if (!result) result = neph_volume_describe_file(context, arguments[1], NEPH_TEXT_PLAIN, &text);
  if (!result) fputs(text, stdout);

  neph_text_destroy(context, text);
  neph_context_destroy(context);
  printf("nephos %s: %s\n", neph_version_get_text(), neph_result_get_text(result));
  if (has_vdb == (result == NEPH_ERROR_UNSUPPORTED) || neph_version_get_number() != NEPHOS_VERSION_NUMBER) return 1;
  return has_vdb ? result != NEPH_OK : 3;
}
