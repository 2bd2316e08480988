/* SPDX-License-Identifier: Apache-2.0 */
/* A scene as a tree: values, sequences and mappings, each with its place in the scene's file. */
#ifndef NP_SCENE_SCENE_NODE_H
#define NP_SCENE_SCENE_NODE_H

#include <nephos/atmosphere.h>
#include <nephos/terrain.h>
#include <nephos/volume.h>

#include "core/context_private.h"

typedef enum np_node_kind {
  NP_NODE_SCALAR, /* a text, as files have it */
  NP_NODE_SEQUENCE,
  NP_NODE_MAPPING,
  NP_NODE_NUMBER,  /* a number in SI, as calls give it */
  NP_NODE_ANIMATED /* no value: a track has its key's values */
} np_node_kind;

/* Objects that a mapping stands for, beside or in place of its keys: given to a scene by calls, never by a file. NULL:
 * none. */
typedef struct np_node_assets {
  neph_volume *volume;         /* of a cloud */
  neph_terrain *terrain;       /* of the section of that name */
  neph_atmosphere *atmosphere; /* of the section of that name */
} np_node_assets;

typedef struct np_node np_node;

struct np_node {
  np_node_kind kind;
  bool is_quoted;        /* a scalar in quotes or a block: never null */
  unsigned line, column; /* from 1; 0: not from a file */
  char *text;            /* of a scalar */
  double number;         /* of that kind */
  char *key;             /* of an entry of a mapping */
  unsigned key_line, key_column;
  np_node_assets assets; /* of a mapping; retained */
  np_node *first, *next; /* children of a sequence or mapping, and siblings */
};

/* The same assets, each retained once more. */
np_node_assets np_node_assets_retain(np_node_assets assets);

/* NULL: no memory. `text` and `key` may be NULL. */
np_node *np_node_create(neph_context *context, np_node_kind kind, const char *text, const char *key);

/* The node of numbers in SI: a sequence where there are several. NULL: no memory. */
np_node *np_node_create_numbers(neph_context *context, const double *numbers, unsigned count);

/* The node that `text` stands for: a sequence where it has several items, parted by ", ", else a scalar. NULL: no
 * memory. */
np_node *np_node_create_value(neph_context *context, const char *text);

/* Destroys a node and everything below it, but not its siblings. NULL is allowed. */
void np_node_destroy(neph_context *context, np_node *node);

/* A copy of a node and everything below it; NULL: no memory. */
np_node *np_node_copy(neph_context *context, const np_node *node);

/* Whether a node is one value: no sequence, no mapping. */
static inline bool np_node_is_value(const np_node *node) {
  return node->kind != NP_NODE_SEQUENCE && node->kind != NP_NODE_MAPPING;
}

/* Appends a child. */
void np_node_append(np_node *parent, np_node *child);

/* Takes a child out of its parent, without destroying it. */
void np_node_remove(np_node *parent, np_node *child);

/* Puts `node` where `child` is, with the child's key, and destroys the child. */
void np_node_replace(neph_context *context, np_node *parent, np_node *child, np_node *node);

/* NULL when there is none. */
np_node *np_node_search(const np_node *mapping, const char *key);
np_node *np_node_get(const np_node *sequence, size_t index);

size_t np_node_count(const np_node *node);

/* Parses one YAML document. Aliases, anchors, tags, merge keys, keys that are not scalars, second documents and deep
 * nesting are refused.
 *
 * name      begins each message: a file, whose line and column follow, or, when `is_value`, a key.
 * out_node  to be destroyed with np_node_destroy; NULL on failure. Nodes of a value have no line.
 */
neph_result np_scene_parse(neph_context *context, const char *text, size_t size, const char *name, bool is_value,
                           np_node **out_node);

#endif
