/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_flow.h"

#include <string.h>

#include "scene/scene_values.h"

/* ---- Scalars ---- */

/* Whether a text is a plain scalar in every place of a scene, and reads as itself there. */
static bool is_plain(const char *text) {
  static const char indicators[] = "!&*|>'\"%@`#?,[]{}";
  const size_t length = strlen(text);
  if (!length || strspn(text, indicators) || text[0] == ' ' || text[length - 1] == ' ') return false;
  if (strchr("-:=", text[0]) && (!text[1] || strchr(" -", text[1]))) return false;
  for (const char *c = text; *c; c++) {
    if (*c < ' ' || *c > '~' || strchr("?,[]{}\"'", *c)) return false;
    if (*c == ':' && (!c[1] || c[1] == ' ')) return false;
    if (*c == '#' && c[-1] == ' ') return false;
  }
  return true;
}

static bool is_null(const char *text) {
  static const char *const words[] = {"", "~", "null", "Null", "NULL"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (!strcmp(text, words[i])) return true;
  return false;
}

/* The code point at `*text`, in valid UTF-8, which advances behind it. */
static unsigned read_code(const char **text) {
  const unsigned char *c = (const unsigned char *)*text;
  const unsigned length = *c < 0x80 ? 1 : *c < 0xe0 ? 2 : *c < 0xf0 ? 3 : 4;
  unsigned code = length == 1 ? *c : *c & (0x7fu >> length);
  for (unsigned i = 1; i < length && c[i]; i++) code = code << 6 | (c[i] & 0x3fu);
  for (unsigned i = 0; i < length && **text; i++) ++*text;
  return code;
}

/* Code points that must be escaped: controls, breaks of lines, the byte-order mark. */
static bool needs_escape(unsigned code) {
  if (code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x2028 || code == 0x2029) return true;
  return code == 0xfeff || code == 0xfffe || code == 0xffff;
}

static void add_quoted(np_text *out, const char *text) {
  np_text_add(out, "\"");
  while (*text) {
    const char *begin = text;
    const unsigned code = read_code(&text);
    if (needs_escape(code))
      np_text_add(out, code < 0x100 ? "\\x%02x" : "\\u%04x", code);
    else
      np_text_add(out, code == '"' || code == '\\' ? "\\%.*s" : "%.*s", (int)(text - begin), begin);
  }
  np_text_add(out, "\"");
}

void np_flow_add_scalar(np_text *out, const char *text, bool is_quoted) {
  if (!is_quoted && is_plain(text))
    np_text_add(out, "%s", text);
  else
    add_quoted(out, text);
}

/* ---- Nodes ---- */

static void print_number(const np_key *key, double number, char *out, size_t size) {
  if (key && key->type == NP_KEY_REAL)
    np_value_format_real(number, key->unit, out, size);
  else
    np_print(out, size, "%.17g", number);
}

static void add_children(np_text *out, const np_key *key, const np_node *node) {
  const bool is_mapping = node->kind == NP_NODE_MAPPING;
  np_text_add(out, is_mapping ? "{" : "[");
  for (const np_node *child = node->first; child; child = child->next) {
    if (child != node->first) np_text_add(out, ", ");
    if (is_mapping) {
      np_flow_add_scalar(out, child->key, false);
      np_text_add(out, ": ");
    }
    np_flow_add(out, is_mapping ? np_key_search(key, child->key) : key, child);
  }
  np_text_add(out, is_mapping ? "}" : "]");
}

void np_flow_add(np_text *out, const np_key *key, const np_node *node) {
  char number[64];
  switch (node->kind) {
  case NP_NODE_SCALAR:
    np_flow_add_scalar(out, node->text, node->is_quoted);
    return;
  case NP_NODE_NUMBER:
    print_number(key, node->number, number, sizeof number);
    np_text_add(out, "%s", number);
    return;
  case NP_NODE_SEQUENCE:
  case NP_NODE_MAPPING:
    add_children(out, key, node);
    return;
  case NP_NODE_ANIMATED:
    return;
  }
}

/* ---- Comparison ---- */

/* Text of a value; `buffer` has that of a number. */
static const char *get_text(const np_key *key, const np_node *node, char buffer[64]) {
  if (node->kind != NP_NODE_NUMBER) return node->text ? node->text : "";
  print_number(key, node->number, buffer, 64);
  return buffer;
}

static bool is_same_value(const np_key *key, const np_node *a, const np_node *b) {
  char of_a[64], of_b[64];
  const char *text = get_text(key, a, of_a);
  return !strcmp(text, get_text(key, b, of_b)) && (a->is_quoted == b->is_quoted || !is_null(text));
}

static bool is_same_sequence(const np_key *key, const np_node *a, const np_node *b) {
  const np_node *of_a = a->first, *of_b = b->first;
  for (; of_a && of_b; of_a = of_a->next, of_b = of_b->next)
    if (!np_flow_is_same(key, of_a, of_b)) return false;
  return !of_a && !of_b;
}

static bool is_same_mapping(const np_key *key, const np_node *a, const np_node *b) {
  if (np_node_count(a) != np_node_count(b)) return false;
  for (const np_node *child = a->first; child; child = child->next) {
    const np_key_rename *rename = np_key_get_rename(key, child->key);
    const np_node *other = np_node_search(b, child->key);
    if (!other && rename) other = np_node_search(b, np_path_get_name(rename->path));
    if (!other || !np_flow_is_same(np_key_search(key, other->key), child, other)) return false;
  }
  return true;
}

bool np_flow_is_same(const np_key *key, const np_node *a, const np_node *b) {
  if (np_node_is_value(a) && np_node_is_value(b)) return is_same_value(key, a, b);
  if (a->kind != b->kind) return false;
  return a->kind == NP_NODE_SEQUENCE ? is_same_sequence(key, a, b) : is_same_mapping(key, a, b);
}
