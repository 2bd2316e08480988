/* SPDX-License-Identifier: Apache-2.0 */
/* Differences of two documents, as replacements in the text of the first.
 *
 * Children are paired: entries of a mapping by their key, elements of a sequence by their place in the file, the rest
 * of a gap between such elements in order. Pairs are compared; a child without a partner is cut with its line, and a
 * new one gets a line of its own, in flow style. Comments stay but within what is cut or replaced.
 */
#include "scene/scene_diff.h"

#include <string.h>

#include "core/alloc.h"
#include "scene/scene_flow.h"
#include "scene/scene_splice.h"

typedef struct differ {
  const char *text;
  size_t size, first; /* `first` is behind a byte-order mark */
  const char *line_break;
  np_splices splices;
} differ;

static void diff(differ *d, const np_key *key, const np_node *old, const np_node *now);

static np_text begin_text(const differ *d) { return (np_text){.context = d->splices.context}; }

/* ---- Places in the text ---- */

static bool is_break(char c) { return c == '\n' || c == '\r'; }

static size_t get_line_begin(const differ *d, size_t at) {
  while (at > d->first && !is_break(d->text[at - 1])) at--;
  return at;
}

static size_t get_line_end(const differ *d, size_t at) {
  while (at < d->size && !is_break(d->text[at])) at++;
  return at;
}

static size_t skip_break(const differ *d, size_t at) {
  if (at + 1 < d->size && d->text[at] == '\r' && d->text[at + 1] == '\n') return at + 2;
  return at < d->size ? at + 1 : at;
}

static size_t get_break_before(const differ *d, size_t line) {
  return line >= 2 && d->text[line - 2] == '\r' && d->text[line - 1] == '\n' ? line - 2 : line - 1;
}

static bool is_blank(const differ *d, size_t begin, size_t end) {
  while (begin < end && d->text[begin] == ' ') begin++;
  return begin == end;
}

static bool has_comment(const differ *d, size_t begin, size_t end) {
  return begin < end && memchr(d->text + begin, '#', end - begin);
}

static const np_node *get_previous(const np_node *parent, const np_node *child) {
  const np_node *previous = NULL;
  for (const np_node *at = parent->first; at != child; at = at->next) previous = at;
  return previous;
}

/* The dash of an element of a block sequence, behind comments. */
static size_t search_dash(const differ *d, size_t begin, size_t end) {
  size_t at = begin;
  while (at < end && d->text[at] != '-') at = d->text[at] == '#' ? get_line_end(d, at) : at + 1;
  return at;
}

/* Beginning of a child with its key or dash. */
static size_t get_begin(const differ *d, const np_node *parent, const np_node *child) {
  if (parent->kind == NP_NODE_SEQUENCE) {
    const np_node *previous = get_previous(parent, child);
    return parent->is_flow ? child->begin : search_dash(d, previous ? previous->end : parent->begin, child->begin);
  }
  size_t at = child->key_begin;
  while (at > d->first && d->text[at - 1] == ' ') at--;
  const bool is_explicit = at > d->first && at < child->key_begin && d->text[at - 1] == '?';
  return is_explicit ? at - 1 : child->key_begin;
}

/* ---- Values ---- */

static void replace(differ *d, size_t begin, size_t end, np_text *text) {
  np_splices_add(&d->splices, begin, end, text);
}

static void cut(differ *d, size_t begin, size_t end) {
  np_text nothing = begin_text(d);
  replace(d, begin, end, &nothing);
}

/* Text before a value that replaces an empty one. */
static const char *get_separator(const differ *d, size_t at) {
  if (at == d->first || strchr(" \t\n\r,[{", d->text[at - 1])) return "";
  return d->text[at - 1] == ':' || d->text[at - 1] == '-' ? " " : ": ";
}

static void replace_value(differ *d, const np_key *key, const np_node *old, const np_node *now) {
  const bool is_block = !np_node_is_value(old) && !old->is_flow;
  np_text text = begin_text(d);
  size_t begin = old->begin;
  while (is_block && begin > d->first && strchr(" \n\r", d->text[begin - 1])) begin--;
  if (is_block && begin > d->first && !strchr(":-", d->text[begin - 1])) begin = old->begin;
  np_text_add(&text, "%s", begin < old->begin ? " " : begin == old->end ? get_separator(d, begin) : "");
  np_flow_add(&text, key, now);
  replace(d, begin, old->end, &text);
}

/* ---- Children ---- */

/* The children of two collections. */
typedef struct pairing {
  const np_key *key;
  const np_node *old, *now;
  size_t count;            /* number of old children */
  const np_node **partner; /* partner of each old child; NULL: it is cut */
  size_t *place;           /* old child that each new one follows; `count`: none; PAIRED: it has a partner */
} pairing;

static const size_t PAIRED = SIZE_MAX;

static const np_key *get_child_key(const pairing *p, const np_node *child) {
  return p->old->kind == NP_NODE_MAPPING ? np_key_search(p->key, child->key) : p->key;
}

static void add_entry(np_text *out, const pairing *p, const np_node *child) {
  if (p->old->kind == NP_NODE_MAPPING) {
    np_flow_add_scalar(out, child->key, false);
    np_text_add(out, ": ");
  } else if (!p->old->is_flow) {
    np_text_add(out, "- ");
  }
  np_flow_add(out, get_child_key(p, child), child);
}

static void cut_in_flow(differ *d, const pairing *p, const np_node *child, const np_node *previous, bool has_kept) {
  const size_t begin = get_begin(d, p->old, child);
  if (has_kept && !has_comment(d, previous->end, begin))
    cut(d, previous->end, child->end);
  else if (child->next)
    cut(d, begin, get_begin(d, p->old, child->next));
  else
    cut(d, begin, child->end);
}

/* Cuts a child with its line and the break before it; one that shares its line with a dash, up to a next that stays. */
static void cut_in_block(differ *d, const pairing *p, const np_node *child, bool has_next) {
  const size_t begin = get_begin(d, p->old, child), line = get_line_begin(d, begin), stop = get_line_end(d, child->end);
  const size_t next = has_next ? get_begin(d, p->old, child->next) : begin;
  if (!is_blank(d, line, begin))
    cut(d, begin, has_next && !has_comment(d, child->end, next) ? next : child->end);
  else if (line > d->first)
    cut(d, get_break_before(d, line), stop);
  else
    cut(d, line, has_next ? skip_break(d, stop) : stop);
}

static void cut_children(differ *d, const pairing *p) {
  const np_node *previous = NULL;
  bool has_kept = false;
  size_t i = 0;
  for (const np_node *child = p->old->first; child; previous = child, child = child->next, i++) {
    if (p->partner[i])
      has_kept = true;
    else if (p->old->is_flow)
      cut_in_flow(d, p, child, previous, has_kept);
    else
      cut_in_block(d, p, child, child->next && p->partner[i + 1]);
  }
}

/* Adds the new children of a place, each behind a separator, or, at the front, before one. */
static void add_children_at(np_text *out, const differ *d, const pairing *p, size_t place) {
  const size_t begin = get_begin(d, p->old, p->old->first);
  const bool is_front = place == p->count;
  size_t i = 0;
  for (const np_node *now = p->now->first; now; now = now->next, i++) {
    if (p->place[i] != place) continue;
    if (is_front) add_entry(out, p, now);
    np_text_add(out, "%s", p->old->is_flow ? ", " : d->line_break);
    if (!p->old->is_flow) np_text_add(out, "%*s", (int)(begin - get_line_begin(d, begin)), "");
    if (!is_front) add_entry(out, p, now);
  }
}

static void add_children(differ *d, const pairing *p) {
  const np_node *child = p->old->first;
  for (size_t i = 0; i <= p->count; i++) {
    np_text text = begin_text(d);
    size_t at = get_begin(d, p->old, p->old->first);
    if (i < p->count) at = p->old->is_flow ? child->end : get_line_end(d, child->end);
    add_children_at(&text, d, p, i);
    if (text.length) replace(d, at, at, &text);
    if (child) child = child->next;
  }
}

/* Writes a block mapping of which no entry stays: the first place gets the first new entry, or none. */
static void renew_block(differ *d, const pairing *p) {
  const np_node *first = p->old->first, *added = p->now->first;
  const size_t begin = get_begin(d, p->old, first);
  np_text text = begin_text(d);
  if (!added) np_text_add(&text, "{}");
  for (; added; added = added->next) {
    if (added != p->now->first) np_text_add(&text, "%s%*s", d->line_break, (int)(begin - get_line_begin(d, begin)), "");
    add_entry(&text, p, added);
  }
  replace(d, begin, p->now->first ? first->end : get_line_end(d, first->end), &text);
  for (const np_node *child = first->next; child; child = child->next) cut_in_block(d, p, child, false);
}

static void write_pairs(differ *d, const pairing *p) {
  size_t i = 0, kept = 0;
  for (const np_node *child = p->old->first; child; child = child->next, i++) {
    if (!p->partner[i]) continue;
    diff(d, get_child_key(p, p->partner[i]), child, p->partner[i]);
    kept++;
  }
  if (!kept && p->count && p->old->kind == NP_NODE_MAPPING && !p->old->is_flow) {
    renew_block(d, p);
  } else if (!kept) {
    replace_value(d, p->key, p->old, p->now);
  } else {
    cut_children(d, p);
    add_children(d, p);
  }
}

/* ---- Pairs ---- */

/* Entry of the key that the file has by its new or its old name. */
static const np_node *search_entry(const np_key *section, const np_node *now, const np_node *old) {
  const np_key_rename *rename = np_key_get_rename(section, old->key);
  const np_node *entry = np_node_search(now, old->key);
  return entry || !rename ? entry : np_node_search(now, np_path_get_name(rename->path));
}

static bool has_partner(const pairing *p, const np_node *now) {
  for (size_t i = 0; i < p->count; i++)
    if (p->partner[i] == now) return true;
  return false;
}

static bool is_from(const np_node *now, const np_node *old) {
  return now->line && now->line == old->line && now->column == old->column;
}

static void pair_by_place(const pairing *p) {
  const np_node *now = p->now->first;
  size_t i = 0;
  for (const np_node *old = p->old->first; old; old = old->next, i++) {
    const np_node *at = now;
    while (at && !is_from(at, old)) at = at->next;
    if (at) p->partner[i] = at, now = at->next;
  }
}

/* Pairs what is left between elements of known place, in order. */
static void pair_gaps(const pairing *p) {
  const np_node *now = p->now->first;
  for (size_t i = 0; i < p->count; i++) {
    if (p->partner[i]) {
      now = p->partner[i]->next;
    } else if (now && !has_partner(p, now)) {
      p->partner[i] = now;
      now = now->next;
    }
  }
}

static void pair_by_key(const pairing *p) {
  size_t i = 0;
  for (const np_node *old = p->old->first; old; old = old->next) p->partner[i++] = search_entry(p->key, p->now, old);
}

/* Notes where new children go: in a mapping at its end, in a sequence behind the partner before them. */
static void note_places(const pairing *p) {
  size_t place = p->old->kind == NP_NODE_MAPPING ? p->count - 1 : p->count, k = 0;
  for (const np_node *now = p->now->first; now; now = now->next, k++) {
    size_t i = 0;
    while (i < p->count && p->partner[i] != now) i++;
    p->place[k] = i < p->count ? PAIRED : place;
    if (i < p->count && p->old->kind == NP_NODE_SEQUENCE) place = i;
  }
}

static void pair(const pairing *p) {
  if (p->old->kind == NP_NODE_MAPPING) {
    pair_by_key(p);
  } else {
    pair_by_place(p);
    pair_gaps(p);
  }
  note_places(p);
}

static void diff_children(differ *d, const np_key *key, const np_node *old, const np_node *now) {
  neph_context *context = d->splices.context;
  pairing p = {.key = key, .old = old, .now = now, .count = np_node_count(old)};
  p.partner = np_alloc(context, p.count + 1, sizeof *p.partner);
  p.place = np_alloc(context, np_node_count(now) + 1, sizeof *p.place);
  if (p.partner && p.place) {
    pair(&p);
    write_pairs(d, &p);
  } else {
    d->splices.result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_alloc_free(context, p.partner);
  np_alloc_free(context, p.place);
}

static void diff(differ *d, const np_key *key, const np_node *old, const np_node *now) {
  if (np_flow_is_same(key, old, now)) return;
  if (old->kind == now->kind && !np_node_is_value(old))
    diff_children(d, key, old, now);
  else
    replace_value(d, key, old, now);
}

static const char *choose_line_break(const char *text, size_t size) {
  const char *feed = memchr(text, '\n', size), *carriage = memchr(text, '\r', size);
  if (carriage && feed == carriage + 1) return "\r\n";
  return feed || !carriage ? "\n" : "\r";
}

neph_result np_scene_splice(neph_context *context, const char *text, size_t size, const np_node *old,
                            const np_node *now, char **out_text) {
  const bool has_mark = size >= 3 && !memcmp(text, "\xef\xbb\xbf", 3);
  differ d = {.text = text,
              .size = size,
              .first = has_mark ? 3 : 0,
              .line_break = choose_line_break(text, size),
              .splices = {.context = context}};
  *out_text = NULL;
  diff(&d, NULL, old, now);
  const neph_result result = np_splices_apply(&d.splices, text, size, out_text);
  np_splices_clear(&d.splices);
  return result;
}
