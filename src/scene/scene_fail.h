/* SPDX-License-Identifier: Apache-2.0 */
/* Messages of scenes: errors, kept until all are known, and warnings. */
#ifndef NP_SCENE_SCENE_FAIL_H
#define NP_SCENE_SCENE_FAIL_H

#include "scene/scene_node.h"
#include "scene/scene_private.h"

enum { NP_SCENE_PROBLEMS_MAX = 20 };

typedef struct np_scene_problem {
  const np_node *node;   /* NULL: of the scene as a whole */
  unsigned line, column; /* 0: without a place */
  char *text;
} np_scene_problem;

/* The errors of one scene: the first NP_SCENE_PROBLEMS_MAX in the order of its file. */
typedef struct np_scene_problems {
  neph_context *context;
  const char *file;   /* NULL: none */
  bool is_first_only; /* the first error that is met ends the reading */
  unsigned count;     /* of all errors */
  np_scene_problem listed[NP_SCENE_PROBLEMS_MAX];
  neph_result failure; /* of a problem that could not be noted; NEPH_OK: none */
} np_scene_problems;

/* Whether an error at a node's key would be listed: no text need be made of others, of which a file may have thousands.
 */
bool np_scene_would_list(const np_scene_problems *problems, const np_node *node);

/* Adds an error at a node's value; without a place where the node has none or is NULL. Returns NEPH_ERROR_BAD_SCENE;
 * without memory for the text NEPH_ERROR_OUT_OF_MEMORY. */
neph_result np_scene_fail_at(np_scene_problems *problems, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same at a node's key. */
neph_result np_scene_fail_key(np_scene_problems *problems, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Takes the result of a part into that of all. Whether reading goes on: behind an error of the scene, unless the first
 * is enough, but not without memory. */
bool np_scene_goes_on(const np_scene_problems *problems, neph_result part, neph_result *all);

/* Whether a node, or a node below it, has an error. NULL has none. */
bool np_scene_has_problem_in(const np_scene_problems *problems, const np_node *node);

/* Logs all errors and frees them: "file:line:column: text" each, and their number where there are several, and returns
 * NEPH_ERROR_BAD_SCENE where there is any; but a `result` that ended the reading before its time is passed on: it has
 * its own message. */
neph_result np_scene_report(np_scene_problems *problems, neph_result result);

/* Logs a warning at a node's key. */
void np_scene_warn_key(const neph_scene *scene, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
