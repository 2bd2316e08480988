/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_fail.h"

#include <stdarg.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"

/* Whether a position comes before a problem's; problems without a position come last. */
static bool is_before(unsigned line, unsigned column, const np_scene_problem *other) {
  if (!line || !other->line) return line && !other->line;
  return line < other->line || (line == other->line && column < other->column);
}

bool np_scene_would_list(const np_scene_problems *problems, const np_node *node) {
  return problems->count < NP_SCENE_PROBLEMS_MAX ||
         is_before(node->key_line, node->key_column, &problems->listed[NP_SCENE_PROBLEMS_MAX - 1]);
}

/* Slot for an error in file order, after errors at the same line and column; NULL: the list is full of earlier ones. */
static np_scene_problem *insert(np_scene_problems *problems, unsigned line, unsigned column) {
  unsigned count = problems->count++;
  if (count > NP_SCENE_PROBLEMS_MAX) count = NP_SCENE_PROBLEMS_MAX;
  unsigned place = count;
  while (place && is_before(line, column, &problems->listed[place - 1])) place--;
  if (place == NP_SCENE_PROBLEMS_MAX) return NULL;
  np_scene_problem *problem = &problems->listed[place];
  if (count == NP_SCENE_PROBLEMS_MAX) np_alloc_free(problems->context, problems->listed[--count].text);
  memmove(problem + 1, problem, (count - place) * sizeof *problem);
  return problem;
}

static neph_result add(np_scene_problems *problems, const np_node *node, unsigned line, unsigned column,
                       const char *format, va_list arguments) {
  np_text text = {.context = problems->context};
  char *characters;
  np_text_add_list(&text, format, arguments);
  const neph_result result = np_text_finish(&text, &characters);
  if (result) return problems->failure = result;
  np_scene_problem *problem = insert(problems, line, column);
  if (problem)
    *problem = (np_scene_problem){node, line, column, characters};
  else
    np_alloc_free(problems->context, characters);
  return NEPH_ERROR_BAD_SCENE;
}

neph_result np_scene_fail_at(np_scene_problems *problems, const np_node *node, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  neph_result result = add(problems, node, node ? node->line : 0, node ? node->column : 0, format, arguments);
  va_end(arguments);
  return result;
}

neph_result np_scene_fail_key(np_scene_problems *problems, const np_node *node, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  neph_result result = add(problems, node, node->key_line, node->key_column, format, arguments);
  va_end(arguments);
  return result;
}

bool np_scene_goes_on(const np_scene_problems *problems, neph_result part, neph_result *all) {
  if (part) *all = part;
  return !part || (part == NEPH_ERROR_BAD_SCENE && !problems->is_first_only);
}

static unsigned count_listed(const np_scene_problems *problems) {
  return problems->count < NP_SCENE_PROBLEMS_MAX ? problems->count : NP_SCENE_PROBLEMS_MAX;
}

bool np_scene_has_problem_in(const np_scene_problems *problems, const np_node *node) {
  if (!node) return false;
  for (unsigned i = 0; i < count_listed(problems); i++)
    if (problems->listed[i].node == node) return true;
  for (const np_node *child = node->first; child; child = child->next)
    if (np_scene_has_problem_in(problems, child)) return true;
  return false;
}

static const char *get_file_name(const char *file) { return file ? file : "scene"; }

static void free_texts(np_scene_problems *problems) {
  for (unsigned i = 0; i < count_listed(problems); i++) np_alloc_free(problems->context, problems->listed[i].text);
  problems->count = 0;
}

static void report_one(const np_scene_problems *problems, const np_scene_problem *problem) {
  if (problem->line)
    np_fail(problems->context, NEPH_ERROR_BAD_SCENE, "%s:%u:%u: %s", get_file_name(problems->file), problem->line,
            problem->column, problem->text);
  else
    np_fail(problems->context, NEPH_ERROR_BAD_SCENE, "%s", problem->text);
}

static neph_result report_all(const np_scene_problems *problems, neph_result result) {
  const unsigned listed = count_listed(problems);
  const neph_result bad = listed ? NEPH_ERROR_BAD_SCENE : result;
  const char *file = get_file_name(problems->file);
  for (unsigned i = 0; i < listed; i++) report_one(problems, &problems->listed[i]);
  if (problems->count > listed)
    return np_fail(problems->context, bad, "%s has %u errors, of which these are the first %u", file, problems->count,
                   listed);
  return listed > 1 ? np_fail(problems->context, bad, "%s has %u errors", file, listed) : bad;
}

neph_result np_scene_report(np_scene_problems *problems, neph_result result) {
  if (problems->failure) result = problems->failure;
  if (!result || result == NEPH_ERROR_BAD_SCENE) result = report_all(problems, result);
  free_texts(problems);
  return result;
}

void np_scene_warn_key(const neph_scene *scene, const np_node *node, const char *format, ...) {
  np_text text = {.context = scene->context};
  va_list arguments;
  va_start(arguments, format);
  np_text_add_list(&text, format, arguments);
  va_end(arguments);
  const bool has_place = node->key_line;
  if (!text.has_failed && has_place)
    np_log(scene->context, NEPH_LOG_WARNING, "%s:%u:%u: %s", get_file_name(scene->file), node->key_line,
           node->key_column, np_text_get(&text));
  else if (!text.has_failed)
    np_log(scene->context, NEPH_LOG_WARNING, "%s", np_text_get(&text));
  (void)np_text_end(&text, NEPH_OK);
}
