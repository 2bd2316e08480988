/* SPDX-License-Identifier: Apache-2.0 */
/* The key table: every key of a scene once, with its place in struct neph_scene, type, unit, range, default and
 * meaning. Parsing, defaults, --set, the schema, the documentation and the hints in messages all read it. */
#ifndef NP_SCENE_SCENE_KEYS_H
#define NP_SCENE_SCENE_KEYS_H

#include "scene/scene_private.h"
#include "scene/scene_values.h"

typedef enum np_key_type {
  NP_KEY_SECTION, /* a mapping of further keys */
  NP_KEY_LIST,    /* a list of such mappings */
  NP_KEY_REAL,    /* double, or an array of them */
  NP_KEY_INTEGER, /* unsigned, or an array of them */
  NP_KEY_SEED,    /* uint64_t, any */
  NP_KEY_CHOICE,  /* bool or an enumeration */
  NP_KEY_FLAGS,   /* unsigned, a bit for each word in a list */
  NP_KEY_TEXT,    /* char *, owned by the scene; so are the next three */
  NP_KEY_FILE,    /* seen from the folder of the scene */
  NP_KEY_TIME,    /* ISO 8601 */
  NP_KEY_PRESET,  /* names a description that fills its whole section before any other key does */
  NP_KEY_ROWS     /* np_scene_rows: a list of pairs */
} np_key_type;

/* Least and greatest value, in the key's own unit. */
typedef struct np_range {
  double min, max;
} np_range;

/* Words a key takes; the last has no name. */
typedef struct np_choice {
  const char *name;
  unsigned value;
} np_choice;

/* A member of neph_scene, or, for keys of a list's elements, of an element. Size 0: none. */
typedef struct np_field {
  size_t offset, size;
} np_field;

typedef struct np_key {
  const char *path; /* "clouds[].bake.voxel" */
  const char *meaning;
  const char *fallback;     /* the default as a file would say it, list items parted by ", "; NULL: not set */
  const np_choice *choices; /* of CHOICE and FLAGS; also words that a section takes in place of a mapping, and a tagged
                               number in place of it: its tag takes their value */
  np_key_type type;
  np_unit unit;
  np_range range; /* of REAL and INTEGER */
  np_field field;
  bool is_input;        /* of FILE: the same in every frame, and read */
  bool is_air_preset;   /* of CHOICE and SECTION: an air that fills the section before any other key does */
  bool is_grey_allowed; /* one number may stand for the whole list */
  unsigned group;       /* keys of one section and one group, not 0, exclude each other … */
  unsigned alternative; /* … unless they are of the same alternative */
  np_field tag;         /* bool or enumeration that takes `tag_value` when the key is given … */
  unsigned tag_value;
  const char *word;  /* given in place of a number, … */
  double word_value; /* … it stands for this one */
} np_key;

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

/* The key of a name in a section (NULL: at the top), or NULL. */
const np_key *np_key_search(const np_key *section, const char *name);

/* The list whose elements a key is a part of; NULL: none. */
const np_key *np_key_get_list(const np_key *key);
bool np_key_is_text(const np_key *key); /* TEXT, FILE, TIME or PRESET: its field owns a text */
bool np_key_excludes(const np_key *a, const np_key *b);

/* Numbers that a key takes: 1, or the length of its list. */
unsigned np_key_count_values(const np_key *key);

/* The key that an unknown name most likely meant: among those of its section, then among all of that name. NULL: none.
 */
const np_key *np_key_guess(const np_key *section, const char *name);

/* The values that a key takes: "a length in [1, 1e+07] m", "march or path". */
void np_key_describe_values(const np_key *key, char *out, size_t size);

/* The values that one item of a list takes. */
void np_key_describe_item(const np_key *key, char *out, size_t size);

/* The text behind "NAME is not a key": ", did you mean camera.fov? camera has position, look_at, …". */
void np_key_describe_hint(const np_key *section, const char *name, char *out, size_t size);

#endif
