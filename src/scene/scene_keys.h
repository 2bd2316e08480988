/* SPDX-License-Identifier: Apache-2.0 */
/* The key table: every key of a scene once, with its place in struct neph_scene, type, unit, range, default and
 * meaning. Parsing, defaults, --set, the schema, the documentation and the hints in messages all read it. */
#ifndef NP_SCENE_SCENE_KEYS_H
#define NP_SCENE_SCENE_KEYS_H

#include "core/text.h"
#include "scene/scene_key.h"

/* A key that had another name, in the same section. */
typedef struct np_key_rename {
  const char *old_path, *path;
} np_key_rename;

#define NP_RENAME_WARNING "%s is the old name of %s: use the new one"

size_t np_key_rename_count(void);
const np_key_rename *np_key_rename_at(size_t index);

/* The rename of a key whose old name in a section (NULL: at the top) is `name`; NULL: none. */
const np_key_rename *np_key_get_rename(const np_key *section, const char *name);

size_t np_key_count(void);
const np_key *np_key_get(size_t index);

/* The last part of a path. */
const char *np_path_get_name(const char *path);
const char *np_key_get_name(const np_key *key);

/* The section that a key lies in; NULL for those at the top. */
const np_key *np_key_get_parent(const np_key *key);

/* Whether a text in place of the key's section stands for the key. */
bool np_key_is_shorthand(const np_key *key);

/* The key of a name in a section (NULL: at the top), or NULL. */
const np_key *np_key_search(const np_key *section, const char *name);

/* The key of a path that the table has. */
const np_key *np_key_search_path(const char *path);

/* The list whose elements a key is a part of; NULL: none. */
const np_key *np_key_get_list(const np_key *key);
bool np_key_is_points(const np_key *key); /* POINTS or CURVES: its field owns what it points to */
bool np_key_is_text(const np_key *key);   /* TEXT, FILE or PRESET: its field owns a text */
/* The moment of a key of type TIME in the struct that has its field. */
static inline np_scene_moment *np_scene_moment_get(const np_key *key, void *base) {
  return (np_scene_moment *)(void *)((char *)base + key->field.offset);
}

bool np_key_excludes(const np_key *a, const np_key *b);

/* Numbers that a key takes: 1, or the length of its list. */
unsigned np_key_count_values(const np_key *key);

/* The key that an unknown name most likely meant: among those of its section, then among all of that name. NULL: none.
 */
const np_key *np_key_guess(const np_key *section, const char *name);

/* The values that a key takes: "a length in [1, 1e+07] m", "march or path". */
void np_key_describe_values(const np_key *key, np_text *out);

/* The values that one item of a list takes. */
void np_key_describe_item(const np_key *key, np_text *out);

/* The text behind "NAME is not a key": ", did you mean camera.fov? camera has position, look_at, …". */
void np_key_describe_hint(const np_key *section, const char *name, np_text *out);

#endif
