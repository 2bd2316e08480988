/* SPDX-License-Identifier: Apache-2.0 */
/* Messages of scenes: errors, collected until all are known, and warnings. */
#ifndef NP_SCENE_SCENE_FAIL_H
#define NP_SCENE_SCENE_FAIL_H

#include "scene/scene_node.h"
#include "scene/scene_private.h"

enum { NP_SCENE_PROBLEMS_MAX = 20 };

typedef struct np_scene_problem {
  const np_node *node;   /* NULL: the error concerns the whole scene */
  unsigned line, column; /* 0: no position */
  char *text;
} np_scene_problem;

/* The errors of one scene: the first NP_SCENE_PROBLEMS_MAX in file order. */
typedef struct np_scene_problems {
  neph_context *context;
  const char *file;   /* NULL: none */
  bool is_first_only; /* reading stops at the first error */
  unsigned count;     /* number of all errors */
  np_scene_problem listed[NP_SCENE_PROBLEMS_MAX];
  neph_result failure; /* failure to record a problem; NEPH_OK: none */
} np_scene_problems;

/* Whether an error at a node's key would be listed. Otherwise its text need not be formatted: a file may have thousands
 * of errors. */
bool np_scene_would_list(const np_scene_problems *problems, const np_node *node);

/* Adds an error at a node's value; without a position if the node has none or is NULL. Returns NEPH_ERROR_BAD_SCENE, or
 * NEPH_ERROR_OUT_OF_MEMORY if there is no memory for the text. */
neph_result np_scene_fail_at(np_scene_problems *problems, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Adds an error at a node's key; otherwise like np_scene_fail_at. */
neph_result np_scene_fail_key(np_scene_problems *problems, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Merges the result of a part into the total. Returns whether reading continues: after an error of the scene, unless
 * only the first matters, but not when out of memory. */
bool np_scene_goes_on(const np_scene_problems *problems, neph_result part, neph_result *all);

/* Whether a node or one of its descendants has an error; false for NULL. */
bool np_scene_has_problem_in(const np_scene_problems *problems, const np_node *node);

/* Logs all errors as "file:line:column: text", with their number if there are several, and frees them. Returns
 * NEPH_ERROR_BAD_SCENE if there is any; but a `result` that ended the reading early, which has its own message, is
 * returned unchanged. */
neph_result np_scene_report(np_scene_problems *problems, neph_result result);

/* Logs a warning at a node's key. */
void np_scene_warn_key(const neph_scene *scene, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
