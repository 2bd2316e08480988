/* SPDX-License-Identifier: Apache-2.0 */
/* Reads `animate`: tracks by the paths of their keys. */
#include "scene/animation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "core/time_text.h"
#include "scene/scene_keys.h"

typedef struct track_reader {
  neph_context *context;
  np_scene_problems *problems;
  const np_node *document;
  const np_node *entry; /* entry of `animate` */
  np_track *track;
} track_reader;

/* ---- Keys ---- */

/* Whether a key must be the same in all frames of a sequence, for files of one size and format. */
static bool is_of_sequence(const np_key *key) {
  static const char *const paths[] = {"version",
                                      "frame_rate",
                                      "camera.resolution",
                                      "camera.overscan",
                                      "render.wavelengths",
                                      "render.samples",
                                      "render.max_samples",
                                      "render.target_error",
                                      "render.time_limit",
                                      "render.max_scatterings",
                                      "render.history_frames",
                                      "output.scale",
                                      "output.exposure"};
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
    if (!strcmp(key->path, paths[i])) return true;
  return false;
}

static bool is_numeric(const np_key *key) {
  return key->type == NP_KEY_REAL || key->type == NP_KEY_INTEGER || key->type == NP_KEY_TIME;
}

static neph_result fail_unknown(const track_reader *r, const np_key *section, const char *name) {
  np_text hint = {.context = r->context};
  if (np_scene_would_list(r->problems, r->entry)) np_key_describe_hint(section, name, &hint);
  return np_text_end(
      &hint, np_scene_fail_key(r->problems, r->entry, "animate: %s is not a key%s", r->entry->key, np_text_get(&hint)));
}

static neph_result fail_kind(const track_reader *r, const np_key *key) {
  const char *why = is_numeric(key) ? "must be the same in all frames" : "is no number: numbers and times change";
  return np_scene_fail_key(r->problems, r->entry, "animate: %s %s", r->entry->key, why);
}

/* One part of a path: "clouds[0]". */
typedef struct path_part {
  char name[48];
  bool has_index;
  unsigned long index;
} path_part;

/* Removes the first part of a path, with its dot. */
static bool read_part(const char **path, path_part *out) {
  const size_t length = strcspn(*path, ".[");
  if (length == 0 || length >= sizeof out->name) return false;
  np_print(out->name, sizeof out->name, "%.*s", (int)length, *path);
  *path += length;
  out->has_index = **path == '[';
  if (out->has_index) {
    char *end;
    out->index = strtoul(*path + 1, &end, 10);
    if (end == *path + 1 || *end != ']') return false;
    *path = end + 1;
  }
  if (**path == '.') ++*path;
  return true;
}

/* Checks that the scene has the element of a list. */
static neph_result check_element(const track_reader *r, const path_part *p, const np_node **at) {
  const np_node *list = *at ? np_node_search(*at, p->name) : NULL;
  const size_t count = list && list->kind == NP_NODE_SEQUENCE ? np_node_count(list) : 0;
  if (p->index >= count)
    return np_scene_fail_key(r->problems, r->entry, "animate: %s is of %s[%lu], but the scene has %zu of them",
                             r->entry->key, p->name, p->index, count);
  *at = np_node_get(list, p->index);
  if ((*at)->kind != NP_NODE_MAPPING) *at = NULL;
  return NEPH_OK;
}

/* Reads the index of a list item at the end of a path: "camera.position.0". */
static neph_result read_component(const track_reader *r, const char *text) {
  np_track *t = r->track;
  const unsigned count = np_key_count_values(t->key);
  char *end;
  const unsigned long component = strtoul(text, &end, 10);
  if (*end || text[0] < '0' || text[0] > '9' || component >= count || count == 1)
    return np_scene_fail_key(r->problems, r->entry, "animate: %s: %s is no number of %s, which has %u", r->entry->key,
                             text, t->key->path, count);
  t->component = (int)component;
  return NEPH_OK;
}

/* Reads the key of an entry, with the index of a list item. */
static neph_result read_path(const track_reader *r) {
  np_track *t = r->track;
  const char *path = r->entry->key, *begin = path;
  const np_node *at = r->document;
  path_part p = {.has_index = false};
  neph_result result = NEPH_OK;
  while (!result && *path && !(t->key && is_numeric(t->key))) {
    const np_key *section = t->key;
    t->key = read_part(&path, &p) ? np_key_search(section, p.name) : NULL;
    if (!t->key || p.has_index != (t->key->type == NP_KEY_LIST)) return fail_unknown(r, section, p.name);
    if (p.has_index) {
      t->list = t->key;
      t->element = (unsigned)p.index;
      result = check_element(r, &p, &at);
    }
    if (!p.has_index && at) at = np_node_search(at, p.name);
    if (at && at->kind != NP_NODE_MAPPING) at = NULL;
  }
  if (result) return result;
  if (!t->key || !is_numeric(t->key) || is_of_sequence(t->key))
    return t->key ? fail_kind(r, t->key) : fail_unknown(r, NULL, "");
  t->component = NP_TRACK_ALL;
  const size_t length = (size_t)(path - begin) - (*path ? 1 : 0);
  if (length >= sizeof t->path)
    return np_scene_fail_key(r->problems, r->entry, "animate: %s is too long", r->entry->key);
  np_print(t->path, sizeof t->path, "%.*s", (int)length, begin);
  if (*path) result = read_component(r, path);
  t->value_count = t->component == NP_TRACK_ALL ? np_key_count_values(t->key) : 1;
  return result;
}

/* ---- Values ---- */

static const char *show(const np_node *node) { return node->kind == NP_NODE_SCALAR ? node->text : "a list"; }

static neph_result fail_value(const track_reader *r, const np_node *node, bool is_one) {
  np_text values = {.context = r->context};
  (is_one ? np_key_describe_item : np_key_describe_values)(r->track->key, &values);
  return np_text_end(&values, np_scene_fail_at(r->problems, node, "animate: %s is %s, must be %s", r->entry->key,
                                               show(node), np_text_get(&values)));
}

static neph_result fail_time(const track_reader *r, const np_node *node, const char *problem) {
  np_text values = {.context = r->context};
  np_key_describe_values(r->track->key, &values);
  return np_text_end(&values, np_scene_fail_at(r->problems, node, "animate: %s is %s, must be %s: %s", r->entry->key,
                                               show(node), np_text_get(&values), problem));
}

static neph_result read_time(const track_reader *r, const np_node *node, double *out) {
  char *problem;
  np_time time;
  if (node->kind != NP_NODE_SCALAR) return fail_value(r, node, false);
  neph_result result = np_time_parse(r->context, node->text, &time, &problem);
  if (problem) result = fail_time(r, node, problem);
  np_alloc_free(r->context, problem);
  if (result) return result;
  r->track->lacks_zone = r->track->lacks_zone || !time.has_zone;
  *out = time.unix_s;
  return NEPH_OK;
}

static neph_result read_number(const track_reader *r, const np_node *node, double *out) {
  const np_key *key = r->track->key;
  if (key->type == NP_KEY_TIME) return read_time(r, node, out);
  const bool is_read = node->kind == NP_NODE_SCALAR && np_value_parse_real(node->text, key->unit, out);
  const double low = np_unit_to_si(key->unit, key->range.min), high = np_unit_to_si(key->unit, key->range.max);
  return is_read && *out >= low && *out <= high ? NEPH_OK : fail_value(r, node, true);
}

/* Reads a number, or a list with as many numbers as the key. */
static neph_result read_values(const track_reader *r, const np_node *node, double *out) {
  const np_track *t = r->track;
  const bool is_one = t->value_count == 1 || (t->key->is_grey_allowed && node->kind == NP_NODE_SCALAR);
  neph_result result = NEPH_OK;
  if (!is_one && (node->kind != NP_NODE_SEQUENCE || np_node_count(node) != t->value_count))
    return fail_value(r, node, false);
  const np_node *item = is_one ? node : node->first;
  for (unsigned i = 0; i < t->value_count && !result; i++) {
    result = read_number(r, item, &out[i]);
    if (!is_one) item = item->next;
  }
  return result;
}

/* ---- Key frames ---- */

static neph_result read_key(const track_reader *r, const np_node *pair, unsigned at) {
  np_track *t = r->track;
  double *frame = &t->frames[at];
  if (pair->kind != NP_NODE_SEQUENCE || np_node_count(pair) != 2)
    return np_scene_fail_at(r->problems, pair, "animate: %s: a key is not a pair, must be [frame, value]",
                            r->entry->key);
  const np_node *first = pair->first;
  if (first->kind != NP_NODE_SCALAR || !np_value_parse_real(first->text, NP_UNIT_NONE, frame) || fabs(*frame) > 1e9)
    return np_scene_fail_at(r->problems, first, "animate: %s: a frame is %s, must be a number in [-1e9, 1e9]",
                            r->entry->key, show(first));
  if (at > 0 && !(*frame > t->frames[at - 1]))
    return np_scene_fail_at(r->problems, first, "animate: %s: frame %.9g stands behind frame %.9g: frames must rise",
                            r->entry->key, *frame, t->frames[at - 1]);
  return read_values(r, first->next, &t->values[at * t->value_count]);
}

static neph_result read_keys(const track_reader *r, const np_node *list) {
  if (!list || list->kind != NP_NODE_SEQUENCE || !list->first)
    return np_scene_fail_key(r->problems, r->entry, "animate: %s has no keys, must have a list of [frame, value]",
                             r->entry->key);
  neph_result result = np_track_alloc(r->context, r->track, (unsigned)np_node_count(list));
  unsigned at = 0;
  for (const np_node *pair = list->first; pair && !result; pair = pair->next) result = read_key(r, pair, at++);
  return result;
}

static neph_result read_interpolation(const track_reader *r, const np_node *node) {
  if (node->kind == NP_NODE_SCALAR && np_interpolation_get(node->text, &r->track->interpolation)) return NEPH_OK;
  return np_scene_fail_at(r->problems, node, "animate: %s: interpolation is %s, must be step, linear or smooth",
                          r->entry->key, show(node));
}

/* Reads a track: either its keys, or a mapping of interpolation and keys. */
static neph_result read_track(const track_reader *r) {
  const np_node *keys = r->entry;
  r->track->interpolation = NP_INTERPOLATION_LINEAR;
  r->track->line = r->entry->line;
  r->track->column = r->entry->column;
  neph_result result = read_path(r);
  if (result || keys->kind != NP_NODE_MAPPING) return result ? result : read_keys(r, keys);
  for (const np_node *child = r->entry->first; child && !result; child = child->next) {
    if (!strcmp(child->key, "interpolation"))
      result = read_interpolation(r, child);
    else if (strcmp(child->key, "keys") != 0)
      result = np_scene_fail_key(r->problems, child, "animate: %s.%s is not a key; it has interpolation and keys",
                                 r->entry->key, child->key);
  }
  return result ? result : read_keys(r, np_node_search(r->entry, "keys"));
}

static neph_result check_twice(const track_reader *r, const np_node *animate) {
  for (const np_node *other = animate->first; other != r->entry; other = other->next)
    if (!strcmp(other->key, r->entry->key))
      return np_scene_fail_key(r->problems, r->entry, "animate: %s is given twice, first on line %u", r->entry->key,
                               other->key_line);
  return NEPH_OK;
}

static neph_result read_tracks(neph_context *context, const np_node *document, const np_node *animate,
                               np_scene_problems *problems, np_animation *out) {
  out->tracks = np_alloc(context, np_node_count(animate), sizeof *out->tracks);
  if (!out->tracks) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (const np_node *entry = animate->first; entry; entry = entry->next) {
    track_reader r = {.context = context,
                      .problems = problems,
                      .document = document,
                      .entry = entry,
                      .track = &out->tracks[out->count++]};
    neph_result one = check_twice(&r, animate);
    if (!one) one = read_track(&r);
    if (!np_scene_goes_on(problems, one, &result)) break;
  }
  return result;
}

neph_result np_animation_read(neph_context *context, const np_node *document, np_scene_problems *problems,
                              np_animation **out) {
  *out = NULL;
  const np_node *animate = document->kind == NP_NODE_MAPPING ? np_node_search(document, "animate") : NULL;
  if (!animate) return NEPH_OK;
  if (animate->kind != NP_NODE_MAPPING)
    return np_scene_fail_at(problems, animate, "animate must be a mapping from keys to lists of [frame, value]");
  *out = np_alloc(context, 1, sizeof **out);
  return *out ? read_tracks(context, document, animate, problems, *out) : NEPH_ERROR_OUT_OF_MEMORY;
}

void np_animation_destroy(neph_context *context, np_animation *animation) {
  if (!animation) return;
  for (unsigned i = 0; i < animation->count; i++) np_track_clear(context, &animation->tracks[i]);
  np_alloc_free(context, animation->tracks);
  np_alloc_free(context, animation);
}
