/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_node.h"

#include <string.h>
#include <yaml.h>

#include "core/alloc.h"
#include "core/text.h"

enum { DEPTH_MAX = 16 };

typedef struct document_reader {
  neph_context *context;
  yaml_parser_t parser;
  const char *name;
  bool is_value;
  int depth;
  const char *text;
  size_t size;
  size_t at, at_index; /* a byte of the text, and the number of characters before it */
} document_reader;

static neph_result read_node(document_reader *reader, const yaml_event_t *event, np_node **out_node);

/* ---- Messages ---- */

static neph_result fail_at(document_reader *reader, yaml_mark_t mark, const char *what) {
  if (!reader->name) return NEPH_ERROR_BAD_SCENE;
  if (reader->is_value) return np_fail(reader->context, NEPH_ERROR_BAD_SCENE, "%s: %s", reader->name, what);
  return np_fail(reader->context, NEPH_ERROR_BAD_SCENE, "%s:%zu:%zu: %s", reader->name, mark.line + 1, mark.column + 1,
                 what);
}

static neph_result fail_syntax(document_reader *reader) {
  const yaml_parser_t *parser = &reader->parser;
  if (!reader->name) return NEPH_ERROR_BAD_SCENE;
  if (parser->error == YAML_MEMORY_ERROR)
    return np_fail(reader->context, NEPH_ERROR_OUT_OF_MEMORY, "%s: out of memory while parsing", reader->name);
  char what[240], begun[120] = "";
  if (parser->context)
    np_print(begun, sizeof begun, " %s begun on line %zu", parser->context, parser->context_mark.line + 1);
  np_print(what, sizeof what, "not valid YAML: %s%s", parser->problem ? parser->problem : "unknown problem", begun);
  /* The mark of an encoding error is the parser's. */
  return fail_at(reader, parser->error == YAML_READER_ERROR ? parser->mark : parser->problem_mark, what);
}

/* ---- Events ---- */

static neph_result next_event(document_reader *reader, yaml_event_t *event) {
  return yaml_parser_parse(&reader->parser, event) ? NEPH_OK : fail_syntax(reader);
}

static neph_result check_decoration(document_reader *reader, const yaml_event_t *event, const yaml_char_t *anchor,
                                    const yaml_char_t *tag) {
  if (anchor) return fail_at(reader, event->start_mark, "anchors (&) are not allowed in a scene");
  if (tag) return fail_at(reader, event->start_mark, "tags (!) are not allowed in a scene");
  return NEPH_OK;
}

static neph_result check_event(document_reader *reader, const yaml_event_t *event) {
  switch ((int)event->type) {
  case YAML_ALIAS_EVENT:
    return fail_at(reader, event->start_mark, "aliases (*) are not allowed in a scene");
  case YAML_SCALAR_EVENT:
    return check_decoration(reader, event, event->data.scalar.anchor, event->data.scalar.tag);
  case YAML_SEQUENCE_START_EVENT:
    return check_decoration(reader, event, event->data.sequence_start.anchor, event->data.sequence_start.tag);
  case YAML_MAPPING_START_EVENT:
    return check_decoration(reader, event, event->data.mapping_start.anchor, event->data.mapping_start.tag);
  default:
    return NEPH_OK;
  }
}

/* ---- Places ---- */

static bool is_inside_character(char byte) { return ((unsigned char)byte & 0xc0) == 0x80; }

/* Byte of a mark, which counts characters, those of a byte-order mark apart. */
static size_t get_offset(document_reader *r, yaml_mark_t mark) {
  for (; r->at_index < mark.index && r->at < r->size; r->at_index++) do
      r->at++;
    while (r->at < r->size && is_inside_character(r->text[r->at]));
  for (; r->at_index > mark.index; r->at_index--) do
      r->at--;
    while (is_inside_character(r->text[r->at]));
  return r->at;
}

/* Sets the bytes of a value. The end of a scalar is without the breaks behind it, which belong to a block scalar. */
static void set_place(document_reader *reader, const yaml_event_t *event, np_node *node) {
  node->begin = get_offset(reader, event->start_mark);
  node->end = get_offset(reader, event->end_mark);
  while (node->end > node->begin && strchr(" \t\r\n", reader->text[node->end - 1])) node->end--;
}

/* ---- Nodes ---- */

static np_node *make_node(document_reader *reader, const yaml_event_t *event, np_node_kind kind, const char *text) {
  np_node *node = np_node_create(reader->context, kind, text, NULL);
  if (node && !reader->is_value) {
    node->line = (unsigned)event->start_mark.line + 1;
    node->column = (unsigned)event->start_mark.column + 1;
    set_place(reader, event, node);
  }
  return node;
}

static neph_result read_scalar(document_reader *reader, const yaml_event_t *event, np_node **out_node) {
  const char *text = (const char *)event->data.scalar.value;
  if (strlen(text) != event->data.scalar.length)
    return fail_at(reader, event->start_mark, "a zero character is not allowed");
  *out_node = make_node(reader, event, NP_NODE_SCALAR, text);
  if (!*out_node) return NEPH_ERROR_OUT_OF_MEMORY;
  (*out_node)->is_quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
  return NEPH_OK;
}

static neph_result check_key(document_reader *reader, const yaml_event_t *event) {
  if (event->type == YAML_ALIAS_EVENT) return check_event(reader, event);
  if (event->type != YAML_SCALAR_EVENT)
    return fail_at(reader, event->start_mark, "a key must be a word, not a list or a mapping");
  neph_result result = check_event(reader, event);
  if (result) return result;
  const char *text = (const char *)event->data.scalar.value;
  if (strlen(text) != event->data.scalar.length)
    return fail_at(reader, event->start_mark, "a zero character is not allowed");
  if (!strcmp(text, "<<")) return fail_at(reader, event->start_mark, "merge keys (<<) are not allowed in a scene");
  return NEPH_OK;
}

/* Reads an entry: the key in `event`, and the value after it. */
static neph_result read_entry(document_reader *reader, const yaml_event_t *key, np_node **out_node) {
  neph_result result = check_key(reader, key);
  if (result) return result;
  yaml_event_t value;
  result = next_event(reader, &value);
  if (result) return result;
  result = read_node(reader, &value, out_node);
  yaml_event_delete(&value);
  if (result) return result;
  (*out_node)->key = np_alloc_text(reader->context, (const char *)key->data.scalar.value);
  if (!(*out_node)->key) return NEPH_ERROR_OUT_OF_MEMORY;
  if (!reader->is_value) {
    (*out_node)->key_line = (unsigned)key->start_mark.line + 1;
    (*out_node)->key_column = (unsigned)key->start_mark.column + 1;
    (*out_node)->key_begin = get_offset(reader, key->start_mark);
  }
  return NEPH_OK;
}

/* Sets the end of a sequence or mapping. */
static void end_node(document_reader *reader, const yaml_event_t *event, np_node *node, const np_node *last) {
  if (node->is_flow)
    node->end = get_offset(reader, event->end_mark);
  else if (last)
    node->end = last->end;
}

/* Reads the children of `parent` up to its end event. Children read before a failure stay in the tree. */
static neph_result read_children(document_reader *reader, np_node *parent) {
  np_node **link = &parent->first, *last = NULL;
  for (;;) {
    yaml_event_t event;
    neph_result result = next_event(reader, &event);
    if (result) return result;
    bool is_end = event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT;
    if (!is_end)
      result = parent->kind == NP_NODE_MAPPING ? read_entry(reader, &event, link) : read_node(reader, &event, link);
    if (is_end && !reader->is_value) end_node(reader, &event, parent, last);
    yaml_event_delete(&event);
    if (result || is_end) return result;
    last = *link;
    link = &last->next;
  }
}

static neph_result read_collection(document_reader *reader, const yaml_event_t *event, np_node **out_node) {
  if (reader->depth == DEPTH_MAX) return fail_at(reader, event->start_mark, "nested more than 16 levels deep");
  bool is_mapping = event->type == YAML_MAPPING_START_EVENT;
  *out_node = make_node(reader, event, is_mapping ? NP_NODE_MAPPING : NP_NODE_SEQUENCE, NULL);
  if (!*out_node) return NEPH_ERROR_OUT_OF_MEMORY;
  (*out_node)->is_flow = is_mapping ? event->data.mapping_start.style == YAML_FLOW_MAPPING_STYLE
                                    : event->data.sequence_start.style == YAML_FLOW_SEQUENCE_STYLE;
  reader->depth++;
  neph_result result = read_children(reader, *out_node);
  reader->depth--;
  return result;
}

/* Reads a node. On failure `*out_node` may hold a partial node, which belongs to the tree. */
static neph_result read_node(document_reader *reader, const yaml_event_t *event, np_node **out_node) {
  neph_result result = check_event(reader, event);
  if (result) return result;
  return event->type == YAML_SCALAR_EVENT ? read_scalar(reader, event, out_node)
                                          : read_collection(reader, event, out_node);
}

/* ---- Documents ---- */

/* Skips the start of the stream and of its first document. `*event` is then the root's event, or the end of the stream.
 */
static neph_result read_root(document_reader *reader, yaml_event_t *event) {
  for (;;) {
    neph_result result = next_event(reader, event);
    if (result) return result;
    if (event->type != YAML_STREAM_START_EVENT && event->type != YAML_DOCUMENT_START_EVENT) return NEPH_OK;
    yaml_event_delete(event);
  }
}

static neph_result check_end(document_reader *reader) {
  for (;;) {
    yaml_event_t event;
    neph_result result = next_event(reader, &event);
    if (result) return result;
    bool is_end = event.type == YAML_STREAM_END_EVENT;
    if (event.type == YAML_DOCUMENT_START_EVENT)
      result = fail_at(reader, event.start_mark, "a second document begins here, a scene is one");
    yaml_event_delete(&event);
    if (result || is_end) return result;
  }
}

static neph_result read_document(document_reader *reader, np_node **out_node) {
  yaml_event_t event;
  neph_result result = read_root(reader, &event);
  if (result) return result;
  if (event.type == YAML_STREAM_END_EVENT)
    result = fail_at(reader, event.start_mark,
                     reader->is_value ? "the value is empty, must be YAML such as 5 or [1, 2]; an empty text is ''"
                                      : "nothing is here, must be a mapping of keys");
  else
    result = read_node(reader, &event, out_node);
  yaml_event_delete(&event);
  return result ? result : check_end(reader);
}

neph_result np_scene_parse(neph_context *context, const char *text, size_t size, const char *name, bool is_value,
                           np_node **out_node) {
  document_reader reader = {.context = context, .name = name, .is_value = is_value, .text = text, .size = size};
  if (size >= 3 && !memcmp(text, "\xef\xbb\xbf", 3)) reader.at = 3;
  *out_node = NULL;
  if (!yaml_parser_initialize(&reader.parser))
    return np_fail(context, NEPH_ERROR_OUT_OF_MEMORY, "%s: out of memory while parsing", name);
  yaml_parser_set_input_string(&reader.parser, (const unsigned char *)text, size);
  neph_result result = read_document(&reader, out_node);
  yaml_parser_delete(&reader.parser);
  if (!result) return NEPH_OK;
  np_node_destroy(context, *out_node);
  *out_node = NULL;
  return result;
}
