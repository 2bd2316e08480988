/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_fail.h"

#include <stdarg.h>
#include <stdio.h>

neph_result np_scene_fail_text(const neph_scene *scene, unsigned line, unsigned column, const char *text) {
  if (!line) return np_fail(scene->context, NEPH_ERROR_BAD_SCENE, "%s", text);
  return np_fail(scene->context, NEPH_ERROR_BAD_SCENE, "%s:%u:%u: %s", scene->file ? scene->file : "scene", line,
                 column, text);
}

neph_result np_scene_fail_at(const neph_scene *scene, const np_node *node, const char *format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return np_scene_fail_text(scene, node ? node->line : 0, node ? node->column : 0, text);
}
