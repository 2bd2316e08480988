/* SPDX-License-Identifier: Apache-2.0 */
/* A row of the key table, and tables of them. */
#ifndef NP_SCENE_SCENE_KEY_H
#define NP_SCENE_SCENE_KEY_H

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
  NP_KEY_TEXT,    /* char *, owned by the scene; FILE and PRESET too */
  NP_KEY_FILE,    /* seen from the folder of the scene */
  NP_KEY_PRESET,  /* names a description that fills its whole section before any other key does */
  NP_KEY_TIME,    /* np_scene_moment, ISO 8601; its text is owned by the scene */
  NP_KEY_ROWS,    /* np_scene_rows: a list of pairs */
  NP_KEY_POINTS,  /* neph_cloud_points: a list of points with radii */
  NP_KEY_CURVES,  /* the same: a list of such lists */
  NP_KEY_TRACKS   /* animate: read before any other key (animation.h) */
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
  bool is_numbered;     /* of an input: its name may hold the number of the frame */
  const char *shorthand; /* of SECTION: the key of it that one text stands for; NULL: none */
  bool is_air_preset;   /* of CHOICE and SECTION: an air that fills the section before any other key does */
  bool is_quality;      /* of CHOICE: its value chooses those of keys (quality.h) before any other key does */
  bool is_grey_allowed; /* one number may stand for the whole list */
  unsigned group;       /* keys of one section and one group, not 0, exclude each other … */
  unsigned alternative; /* … unless they are of the same alternative */
  np_field tag;         /* bool or enumeration that takes `tag_value` when the key is given … */
  unsigned tag_value;
  const char *word;  /* given in place of a number, … */
  double word_value; /* … it stands for this one */
} np_key;

/* Rows of one file, in their order. */
typedef struct np_key_table {
  const np_key *keys;
  size_t count;
} np_key_table;

#endif
