/* SPDX-License-Identifier: Apache-2.0 */
/* Rows of the key table. */
#ifndef NP_SCENE_SCENE_KEY_H
#define NP_SCENE_SCENE_KEY_H

#include "scene/scene_private.h"
#include "scene/scene_values.h"

typedef enum np_key_type {
  NP_KEY_SECTION, /* a mapping of nested keys */
  NP_KEY_LIST,    /* a list of mappings of nested keys */
  NP_KEY_REAL,    /* double, or an array of doubles */
  NP_KEY_INTEGER, /* unsigned, or an array of unsigned */
  NP_KEY_SEED,    /* uint64_t, any value */
  NP_KEY_CHOICE,  /* bool or an enumeration */
  NP_KEY_FLAGS,   /* unsigned, one bit for each word of a list */
  NP_KEY_TEXT,    /* char *, owned by the scene, like FILE and PRESET */
  NP_KEY_FILE,    /* path relative to the folder of the scene */
  NP_KEY_PRESET,  /* names a preset that fills its whole section before other keys apply */
  NP_KEY_TIME,    /* np_scene_moment, ISO 8601; its text is owned by the scene */
  NP_KEY_ROWS,    /* np_scene_rows: a list of pairs */
  NP_KEY_POINTS,  /* neph_cloud_points: a list of points with radii */
  NP_KEY_CURVES,  /* neph_cloud_points: a list of lists of points */
  NP_KEY_TRACKS   /* animate: read before any other key (animation.h) */
} np_key_type;

/* Least and greatest value, in the key's unit. */
typedef struct np_range {
  double min, max;
} np_range;

/* Words of a key; the last one has no name. */
typedef struct np_choice {
  const char *name;
  unsigned value;
} np_choice;

/* Member of neph_scene, or, for keys in a list, of the list's element. Size 0: none. */
typedef struct np_field {
  size_t offset, size;
} np_field;

typedef struct np_key {
  const char *path; /* "clouds[].bake.voxel" */
  const char *meaning;
  const char *fallback;     /* default in scene syntax, list items separated by ", "; NULL: not set */
  const np_choice *choices; /* CHOICE and FLAGS: the words. SECTION: words accepted in place of a mapping, or in place
                               of a tagged number: the tag takes their value */
  np_key_type type;
  np_unit unit;
  np_range range; /* REAL and INTEGER: allowed range */
  np_field field;
  bool is_input;         /* FILE: an input that is the same in every frame */
  bool is_numbered;      /* input: its name may contain the frame number */
  const char *shorthand; /* SECTION: key that a plain text represents; NULL: none */
  bool is_air_preset;    /* CHOICE and SECTION: an air preset that fills the section before other keys apply */
  bool is_quality;       /* CHOICE: a quality, which sets the keys of quality.h before other keys apply */
  bool is_grey_allowed;  /* one number may replace the whole list */
  unsigned group;        /* keys of one section with the same group, not 0, exclude each other … */
  unsigned alternative;  /* … unless they have the same alternative */
  np_field tag;          /* bool or enumeration that is set to `tag_value` when the key is set */
  unsigned tag_value;
  const char *word;  /* word accepted in place of a number */
  double word_value; /* number that the word represents */
} np_key;

/* Rows of one file in schema order. */
typedef struct np_key_table {
  const np_key *keys;
  size_t count;
} np_key_table;

#endif
