/* SPDX-License-Identifier: Apache-2.0 */
/* The key table: every key of a scene once, with its field in struct neph_scene, type, unit, range, default and
 * meaning. Parsing, defaults, --set, the schema, the documentation and hints in messages all use it. */
#ifndef NP_SCENE_SCENE_KEYS_H
#define NP_SCENE_SCENE_KEYS_H

#include "core/text.h"
#include "scene/scene_key.h"

/* A renamed key, in the same section. */
typedef struct np_key_rename {
  const char *old_path, *path;
} np_key_rename;

#define NP_RENAME_WARNING "%s is the old name of %s: use the new one"

size_t np_key_rename_count(void);
const np_key_rename *np_key_rename_at(size_t index);

/* Rename entry for a deprecated name in a section (NULL: top level); NULL: none. */
const np_key_rename *np_key_get_rename(const np_key *section, const char *name);

size_t np_key_count(void);
const np_key *np_key_get(size_t index);

/* The last part of a path. */
const char *np_path_get_name(const char *path);
const char *np_key_get_name(const np_key *key);

/* Section that contains a key; NULL at top level. */
const np_key *np_key_get_parent(const np_key *key);

/* Whether a plain text in place of the key's section sets this key. */
bool np_key_is_shorthand(const np_key *key);

/* Key with a name in a section (NULL: top level); NULL: none. */
const np_key *np_key_search(const np_key *section, const char *name);

/* Key of a path in the table. */
const np_key *np_key_search_path(const char *path);

/* List whose elements contain a key; NULL: none. */
const np_key *np_key_get_list(const np_key *key);
bool np_key_is_points(const np_key *key); /* POINTS or CURVES: its field owns an array */
bool np_key_is_text(const np_key *key);   /* TEXT, FILE or PRESET: its field owns a text */
/* Moment of a key of type TIME in the struct `base` with its field. */
static inline np_scene_moment *np_scene_moment_get(const np_key *key, void *base) {
  return (np_scene_moment *)(void *)((char *)base + key->field.offset);
}

bool np_key_excludes(const np_key *a, const np_key *b);

/* Number of values: 1, or the length of the list. */
unsigned np_key_count_values(const np_key *key);

/* Most similar key to an unknown name: in its section, else in the whole table; NULL: none. */
const np_key *np_key_guess(const np_key *section, const char *name);

/* Describes the values of a key: "a length in [1, 1e+07] m", "march or path". */
void np_key_describe_values(const np_key *key, np_text *out);

/* Describes the values of one list item. */
void np_key_describe_item(const np_key *key, np_text *out);

/* End of a message after "NAME is not a key": ", did you mean camera.fov? camera has position, look_at, …". */
void np_key_describe_hint(const np_key *section, const char *name, np_text *out);

#endif
