/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/scene_hash.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "core/hash.h"
#include "core/json.h"
#include "core/path_map.h"
#include "scene/animation.h"
#include "scene/cloud_file.h"
#include "scene/scene_keys.h"
#include "scene/sequence.h"

typedef struct hash_writer {
  const neph_scene *scene;
  int first, frame; /* frames whose files the picture follows from */
  np_hash *hash;
  neph_result result;
} hash_writer;

/* ---- Files ---- */

/* Adds a file's size and contents, but not its name: copies have equal hashes. The size separates consecutive files. */
static neph_result add_contents(neph_context *context, np_hash *hash, const char *path) {
  enum { BLOCK = 1 << 18 };
  const uint64_t size = np_file_get_size(path);
  NP_HASH_ADD(hash, size);
  FILE *file = np_file_open_stream(path);
  char *block = file ? np_alloc(context, 1, BLOCK) : NULL;
  size_t count = 0;
  while (block && (count = fread(block, 1, BLOCK, file)) > 0) np_hash_add(hash, block, count);
  const neph_result result = file && !block ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_OK;
  np_alloc_free(context, block);
  if (file) fclose(file);
  return result;
}

/* Adds a file to the list, and takes ownership of its path. */
static void add_path(hash_writer *w, char *path) {
  if (!path)
    w->result = NEPH_ERROR_OUT_OF_MEMORY;
  else if (!w->result)
    w->result = add_contents(w->scene->context, w->hash, path);
  np_alloc_free(w->scene->context, path);
}

/* Replaces %20 and the like by their characters; false: there is none. */
static bool decode_uri(char *uri) {
  char *to = uri;
  bool has_any = false;
  for (const char *from = uri; *from; to++) {
    unsigned code;
    const bool is_code = *from == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2]) &&
                         sscanf(from + 1, "%2x", &code) == 1;
    *to = is_code ? (char)code : *from;
    has_any = has_any || is_code;
    from += is_code ? 3 : 1;
  }
  *to = '\0';
  return has_any;
}

/* A buffer beside a .gltf file, by its name as it stands there, and as a URI: readers differ. */
static void add_buffer(hash_writer *w, const char *gltf, const char *uri) {
  neph_context *context = w->scene->context;
  char *name = np_alloc_text(context, uri);
  if (!strncmp(uri, "data:", 5) || !name) {
    if (!name) w->result = NEPH_ERROR_OUT_OF_MEMORY;
    np_alloc_free(context, name);
    return;
  }
  add_path(w, np_file_resolve(context, gltf, name));
  if (decode_uri(name)) add_path(w, np_file_resolve(context, gltf, name));
  np_alloc_free(context, name);
}

/* Keys and vertices of a .gltf file may stand in others. One that cannot be read has none: the render says so. */
static void add_buffers(hash_writer *w, const char *path) {
  const char *dot = strrchr(path, '.');
  void *text = NULL;
  size_t size;
  const char *reason;
  if (!dot || strcasecmp(dot, ".gltf") != 0 || w->result || np_file_probe(path, &reason)) return;
  w->result = np_file_read(w->scene->context, path, &text, &size);
  np_json_value *json = text ? np_json_read(text) : NULL;
  const np_json_value *buffer = json ? np_json_get_element(json, "buffers", 0) : NULL;
  for (size_t i = 1; buffer && !w->result; buffer = np_json_get_element(json, "buffers", i++)) {
    const char *uri = np_json_get_text(buffer, "uri");
    if (uri) add_buffer(w, path, uri);
  }
  np_json_value_destroy(json);
  np_alloc_free(w->scene->context, text);
}

/* A file that is missing has no contents: the render says so. */
static void add_file(hash_writer *w, const np_key *key, const char *text) {
  neph_context *context = w->scene->context;
  char *path = np_path_map_resolve_again(context, w->scene->file, text), *named = path;
  if (path && (!key->is_input || key->is_numbered)) {
    named = np_frame_name_make(context, path, w->frame);
    np_alloc_free(context, path);
  }
  if (named && key->is_input && !key->is_numbered) np_frame_name_unescape(named);
  if (named) add_buffers(w, named);
  add_path(w, named);
}

/* All files of a sequence. */
static void add_all(hash_writer *w, const np_scene_cloud *cloud) {
  np_frame_numbers there;
  w->result = np_frame_name_list(w->scene->context, cloud->vdb, &there);
  for (size_t i = 0; !w->result && i < there.count; i++)
    add_path(w, np_frame_name_make(w->scene->context, cloud->vdb, there.numbers[i]));
  np_alloc_free(w->scene->context, there.numbers);
}

/* A sequence has the files of the frame and of the frames that lead up to it, and its reference file. */
static void add_cloud(hash_writer *w, const np_scene_cloud *cloud) {
  np_cloud_file file;
  if (!cloud->vdb || cloud->is_baked) return;
  for (int frame = np_scene_cloud_is_sequence(cloud) ? w->first : w->frame; frame <= w->frame && !w->result; frame++) {
    w->result = np_cloud_file_get(w->scene->context, cloud, frame, &file);
    if (!w->result && file.path) add_path(w, file.path);
  }
  if (w->result) return;
  if (!np_scene_cloud_is_sequence(cloud)) return;
  if (np_scene_cloud_goes_by_all(cloud))
    add_all(w, cloud);
  else if (cloud->has_reference_frame)
    add_path(w, np_frame_name_make(w->scene->context, cloud->vdb, cloud->reference_frame));
}

/* ---- The document ---- */

/* Keys that no value of a picture follows from. */
static bool is_left_out(const char *path) {
  static const char *const paths[] = {"output.image", "output.preview",      "output.deep", "output.exposure",
                                      "output.view",  "output.preview_bits", "output.glare"};
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
    if (!strcmp(paths[i], path)) return true;
  return false;
}

static const np_node *search_next(const np_node *mapping, const np_node *before) {
  const np_node *best = NULL;
  for (const np_node *child = mapping->first; child; child = child->next)
    if ((!before || strcmp(child->key, before->key) > 0) && (!best || strcmp(child->key, best->key) < 0)) best = child;
  return best;
}

static void add_node(hash_writer *w, const np_node *node, const np_key *key);

/* Files of clouds are added frame by frame. */
static bool is_cloud_file(const np_key *key) {
  return !strcmp(key->path, "clouds[].vdb") || !strcmp(key->path, "clouds[].netcdf.file");
}

/* A file that a cloud is baked to is no input. */
static bool is_bake_target(const np_node *mapping, const np_key *key) {
  return !strcmp(key->path, "clouds[].vdb") && np_node_search(mapping, "bake");
}

/* Adds keys sorted by name, whatever their order in the scene. */
static void add_mapping(hash_writer *w, const np_node *mapping, const np_key *section) {
  for (const np_node *child = search_next(mapping, NULL); child; child = search_next(mapping, child)) {
    const np_key *key = np_key_search(section, child->key);
    if (key && (is_left_out(key->path) || is_bake_target(mapping, key))) continue;
    np_hash_add_text(w->hash, child->key);
    add_node(w, child, key);
  }
}

static void add_node(hash_writer *w, const np_node *node, const np_key *key) {
  const unsigned kind = node->kind;
  NP_HASH_ADD(w->hash, kind);
  if (node->kind == NP_NODE_MAPPING) add_mapping(w, node, key);
  for (const np_node *item = node->first; item && node->kind == NP_NODE_SEQUENCE; item = item->next)
    add_node(w, item, key);
  if (node->kind == NP_NODE_NUMBER) NP_HASH_ADD(w->hash, node->number);
  if (node->kind != NP_NODE_SCALAR) return;
  const bool is_file = key && key->type == NP_KEY_FILE && node->text;
  const char *slash = is_file ? strrchr(node->text, '/') : NULL;
  np_hash_add_text(w->hash, slash ? slash + 1 : node->text);
  if (is_file && !is_cloud_file(key)) add_file(w, key, node->text);
}

static bool has_given_assets(const neph_scene *scene) {
  bool has = scene->air.given || scene->terrain.given;
  for (unsigned i = 0; i < scene->cloud_count; i++) has = has || scene->clouds[i].volume;
  return has;
}

/* ---- Settings ---- */

static void add_settings(np_hash *hash, const neph_scene *scene, const neph_render_desc *d, const char *savings) {
  const unsigned words[] = {d->integrator,
                            d->width,
                            d->height,
                            d->crop_min[0],
                            d->crop_min[1],
                            d->crop_max[0],
                            d->crop_max[1],
                            d->sample_count,
                            d->multiple_scattering,
                            d->sample_count_max,
                            d->atmosphere,
                            d->path_guiding,
                            d->scattering_max,
                            d->eye,
                            (unsigned)d->frame,
                            neph_context_get_isa(scene->context)};
  const double reals[] = {d->target_error, d->time_limit_s};
  NP_HASH_ADD(hash, words);
  NP_HASH_ADD(hash, reals);
  NP_HASH_ADD(hash, d->seed);
  if (d->detail_height) NP_HASH_ADD(hash, d->detail_height);
  np_hash_add_text(hash, neph_version_get_text());
  np_hash_add_text(hash, savings);
  /* A sequence may have other caches than a still (plan_sun_optical_depth.c). */
  const bool is_sequence = scene->output.image && np_frame_name_is_pattern(scene->output.image);
  NP_HASH_ADD(hash, is_sequence);
}

neph_result np_scene_hash_compute(const neph_scene *scene, const neph_render_desc *desc, const char *savings,
                                  char out_hex[33]) {
  out_hex[0] = '\0';
  if (has_given_assets(scene)) return NEPH_OK;
  const int frame = desc->frame, first = np_scene_has_history(scene) ? np_scene_get_history_first(scene, frame) : frame;
  hash_writer w = {.scene = scene, .first = first, .frame = frame, .hash = np_hash_create(scene->context)};
  if (!w.hash) return NEPH_ERROR_OUT_OF_MEMORY;
  if (scene->document) add_node(&w, np_scene_get_source(scene), NULL);
  if (scene->animation) np_animation_add_to_hash(scene->animation, w.hash);
  for (unsigned i = 0; i < scene->cloud_count; i++) add_cloud(&w, &scene->clouds[i]);
  add_settings(w.hash, scene, desc, savings);
  neph_result result = np_hash_finish(w.hash, out_hex);
  if (w.result) out_hex[0] = '\0';
  return w.result ? w.result : result;
}
