/* SPDX-License-Identifier: Apache-2.0 */
/* A scene as a tree of values, sequences and mappings, each with its position in the file. */
#ifndef NP_SCENE_SCENE_NODE_H
#define NP_SCENE_SCENE_NODE_H

#include <nephos/atmosphere.h>
#include <nephos/terrain.h>
#include <nephos/volume.h>

#include "core/context_private.h"

typedef enum np_node_kind {
  NP_NODE_SCALAR, /* text, as in files */
  NP_NODE_SEQUENCE,
  NP_NODE_MAPPING,
  NP_NODE_NUMBER,  /* number in SI units, from API calls */
  NP_NODE_ANIMATED /* no value: a track provides it */
} np_node_kind;

/* Objects that a mapping holds in addition to its keys or instead of them. They are set by calls of the API, never by
 * files. NULL: none. */
typedef struct np_node_assets {
  neph_volume *volume;         /* volume of a cloud */
  neph_terrain *terrain;       /* terrain of the section `terrain` */
  neph_atmosphere *atmosphere; /* atmosphere of the section `atmosphere` */
} np_node_assets;

typedef struct np_node np_node;

struct np_node {
  np_node_kind kind;
  bool is_quoted;        /* quoted or block scalar: never null */
  unsigned line, column; /* 1 for the first; 0: not from a file */
  char *text;            /* scalar text */
  double number;         /* value of NP_NODE_NUMBER */
  char *key;             /* key of a mapping's entry */
  unsigned key_line, key_column;
  bool is_flow;                 /* a sequence or mapping in brackets */
  size_t begin, end, key_begin; /* bytes of value and key in the file, a block up to the end of its last child */
  np_node_assets assets;        /* objects of a mapping; retained */
  np_node *first, *next;        /* children of a sequence or mapping, and siblings */
};

/* Retains the assets and returns them. */
np_node_assets np_node_assets_retain(np_node_assets assets);

/* NULL: out of memory. `text` and `key` may be NULL. */
np_node *np_node_create(neph_context *context, np_node_kind kind, const char *text, const char *key);

/* Creates a node of numbers in SI: a sequence if there are several. NULL: out of memory. */
np_node *np_node_create_numbers(neph_context *context, const double *numbers, unsigned count);

/* Creates a node from text: a sequence if it has several items separated by ", ", else a scalar. NULL: out of memory.
 */
np_node *np_node_create_value(neph_context *context, const char *text);

/* Destroys a node and its descendants, not its siblings. NULL is allowed. */
void np_node_destroy(neph_context *context, np_node *node);

/* Copies a node and its descendants; NULL: out of memory. */
np_node *np_node_copy(neph_context *context, const np_node *node);

/* Whether a node is a single value, not a sequence or mapping. */
static inline bool np_node_is_value(const np_node *node) {
  return node->kind != NP_NODE_SEQUENCE && node->kind != NP_NODE_MAPPING;
}

/* Appends a child. */
void np_node_append(np_node *parent, np_node *child);

/* Inserts a child before the child `next`. */
void np_node_insert(np_node *parent, const np_node *next, np_node *child);

/* Removes a child from its parent without destroying it. */
void np_node_remove(np_node *parent, np_node *child);

/* Replaces `child` by `node`, which takes its key, and destroys the child. */
void np_node_replace(neph_context *context, np_node *parent, np_node *child, np_node *node);

/* Child of a mapping with a key; NULL: there is none. */
np_node *np_node_search(const np_node *mapping, const char *key);
np_node *np_node_get(const np_node *sequence, size_t index);

size_t np_node_count(const np_node *node);

/* Parses one YAML document. Aliases, anchors, tags, merge keys, keys that are not scalars, second documents and deep
 * nesting are refused.
 *
 * name begins each message: a file name, followed by line and column, or, with `is_value`, a key. NULL: no message.
 *
 * out_node destroyed by np_node_destroy; NULL on failure. Nodes of a value have no line. */
neph_result np_scene_parse(neph_context *context, const char *text, size_t size, const char *name, bool is_value,
                           np_node **out_node);

#endif
