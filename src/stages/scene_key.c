/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/text.h"
#include "scene/scene_flow.h"
#include "stages/stage_part.h"

bool np_stage_add_scene_key(const np_stage_part *in, np_hash *hash) {
  const neph_scene *scene = in->scene;
  np_text text = {.context = in->context};
  bool is_known = !scene->air.given;
  for (unsigned i = 0; i < scene->cloud_count; i++) is_known = is_known && !scene->clouds[i].volume;
  for (const np_node *section = np_scene_get_source(scene)->first; section; section = section->next) {
    if (!strcmp(section->key, "camera") || !strcmp(section->key, "output")) continue;
    np_text_add(&text, "%s: ", section->key);
    np_flow_add(&text, np_key_search(NULL, section->key), section);
    np_text_add(&text, "\n");
  }
  np_hash_add_text(hash, np_text_get(&text));
  return np_text_end(&text, NEPH_OK) == NEPH_OK && is_known;
}
