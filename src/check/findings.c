/* SPDX-License-Identifier: Apache-2.0 */
#include "check/findings.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/text.h"

/* ---- Findings ---- */

bool np_draft_set(np_finding_draft *draft, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  np_print_list(draft->cause, sizeof draft->cause, format, arguments);
  va_end(arguments);
  return true;
}

void np_draft_set_place(np_finding_draft *draft, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  np_print_list(draft->place, sizeof draft->place, format, arguments);
  va_end(arguments);
}

static bool is_same_text(const char *a, const char *b) { return a == b || (a && b && !strcmp(a, b)); }

/* Whether a message ends with another, apart from the name of its file. */
static bool has_message(const np_finding *longer, const np_finding *shorter) {
  const size_t length = strlen(longer->cause), tail = strlen(shorter->cause);
  if (length < tail || strcmp(longer->cause + length - tail, shorter->cause) != 0) return false;
  return length == tail ? is_same_text(longer->file, shorter->file) : longer->cause[length - tail - 1] == ' ';
}

static bool is_message(const np_finding *finding) { return !strcmp(finding->rule, "read"); }

static bool is_same_message(const np_finding *a, const np_finding *b) {
  return (is_message(a) && has_message(a, b)) || (is_message(b) && has_message(b, a));
}

/* Searches for an equal finding: the same in another frame of a sequence, or a message of the reader of a scene's
 * file. */
static np_finding *search_same(neph_check *check, const np_finding *wanted) {
  for (size_t i = 0; i < check->listed; i++) {
    np_finding *f = &check->findings[i];
    if (is_same_message(f, wanted)) return f;
    if (strcmp(f->rule, wanted->rule) != 0 || strcmp(f->grid, wanted->grid) != 0) continue;
    if (f->sequence && f->sequence == wanted->sequence && f->file != wanted->file && !is_message(f)) return f;
    if (is_same_text(f->file, wanted->file) && !strcmp(f->cause, wanted->cause) && !strcmp(f->place, wanted->place))
      return f;
  }
  return NULL;
}

/* Lists a finding; a rule replaces a mere message. Returns a cause that the list does not store, or NULL. */
static char *list(neph_check *check, const np_finding *finding) {
  np_finding *same = search_same(check, finding);
  if (same && is_message(same) && !is_message(finding)) {
    char *replaced = same->cause;
    check->counts[same->severity]--;
    check->counts[finding->severity]++;
    *same = *finding;
    return replaced;
  }
  if (same) {
    same->frame_count += same->sequence && same->last_file != finding->file;
    same->last_file = finding->file;
    return finding->cause;
  }
  check->counts[finding->severity]++;
  if (check->listed == NP_FINDINGS_MAX) return finding->cause;
  check->findings[check->listed++] = *finding;
  return NULL;
}

/* Adds a finding and takes ownership of its cause. A finding without a cause, for lack of memory, is dropped. */
static void add(neph_check *check, const np_finding *finding) {
  if (!finding->cause) return;
  while (atomic_flag_test_and_set_explicit(&check->is_listing, memory_order_acquire)) {}
  char *left = list(check, finding);
  atomic_flag_clear_explicit(&check->is_listing, memory_order_release);
  np_alloc_free(check->context, left);
}

/* Copies a cause without np_fail, whose message would become a finding too. */
static char *copy_cause(const neph_check *check, const char *cause) {
  const size_t size = strlen(cause) + 1;
  char *copy = np_alloc_quietly(check->context, size, 1);
  return copy ? memcpy(copy, cause, size) : NULL;
}

static np_finding start_finding(const neph_check *check, const np_rule *rule) {
  np_finding finding = {.severity = rule->severity,
                        .rule = rule->name,
                        .file = check->file,
                        .last_file = check->file,
                        .remedy = rule->remedy,
                        .sequence = check->sequence,
                        .frame_count = check->sequence > 0};
  if (check->grid) np_print_short(finding.grid, sizeof finding.grid, check->grid);
  return finding;
}

void np_check_add(neph_check *check, const np_rule *rule, const np_finding_draft *draft) {
  np_finding finding = start_finding(check, rule);
  memcpy(finding.place, draft->place, sizeof finding.place);
  finding.cause = copy_cause(check, draft->cause);
  add(check, &finding);
}

/* ---- The log ---- */

/* Splits a message at the file's name, with "12:3" for a scene, into place and rest. */
static const char *split_place(const char *file, const char *message, char *out_place, size_t size) {
  const size_t length = file ? strlen(file) : 0;
  if (!length || strncmp(message, file, length) != 0 || message[length] != ':') return message;
  unsigned line, column;
  int end = 0;
  if (sscanf(message + length, ":%u:%u:%n", &line, &column, &end) == 2 && end > 0)
    np_print(out_place, size, "%u:%u", line, column);
  else
    end = 1;
  message += length + (size_t)end;
  return message + (*message == ' ');
}

/* Whether a message is the number of a scene's errors, which this list counts itself. */
static bool is_count(const char *message) {
  const char *count = strstr(message, " has ");
  unsigned errors;
  int end = 0;
  return count && sscanf(count, " has %u errors%n", &errors, &end) == 1 && end > 0 && count[end] == '\0';
}

static void take_message(void *user, neph_log_level level, const char *message) {
  static const np_rule complaints[] = {[NEPH_LOG_ERROR] = {"read", NEPH_SEVERITY_ERROR, NULL},
                                       [NEPH_LOG_WARNING] = {"read", NEPH_SEVERITY_WARNING, NULL}};
  neph_check *check = user;
  if (level > NEPH_LOG_WARNING) {
    if (check->log_level_max > NEPH_LOG_INFO) check->log(check->log_user, level, message);
    return;
  }
  if (is_count(message) || (check->are_warnings_muted && level == NEPH_LOG_WARNING)) return;
  np_finding finding = start_finding(check, &complaints[level]);
  const char *cause = split_place(check->file, message, finding.place, sizeof finding.place);
  finding.cause = copy_cause(check, cause);
  add(check, &finding);
}

static void take_log(neph_check *check) {
  neph_context *context = check->context;
  check->log = context->log;
  check->log_user = context->log_user;
  check->log_level_max = context->log_level_max;
  context->log = take_message;
  context->log_user = check;
  if (context->log_level_max < NEPH_LOG_WARNING) context->log_level_max = NEPH_LOG_WARNING;
}

static void give_log_back(const neph_check *check) {
  check->context->log = check->log;
  check->context->log_user = check->log_user;
  check->context->log_level_max = check->log_level_max;
}

/* ---- The check ---- */

neph_result neph_check_create(neph_context *context, neph_check **out_check) {
  if (NP_LACKS_OUT(context, out_check)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_check = NULL;
  neph_check *check = np_alloc(context, 1, sizeof *check);
  if (!check) return NEPH_ERROR_OUT_OF_MEMORY;
  check->context = context;
  check->findings = np_alloc(context, NP_FINDINGS_MAX, sizeof *check->findings);
  if (!check->findings) {
    np_alloc_free(context, check);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_context_retain(context);
  atomic_flag_clear(&check->is_listing);
  take_log(check);
  *out_check = check;
  return NEPH_OK;
}

void neph_check_destroy(neph_check *check) {
  if (!check) return;
  neph_context *context = check->context;
  give_log_back(check);
  for (size_t i = 0; i < check->file_count; i++) np_alloc_free(context, check->files[i]);
  np_alloc_free(context, check->files);
  for (size_t i = 0; i < check->listed; i++) np_alloc_free(context, check->findings[i].cause);
  np_alloc_free(context, check->findings);
  np_alloc_free(context, check);
  np_context_release(context);
}

void neph_check_set_progress(neph_check *check, neph_progress_fn progress, void *user) {
  if (!check) return;
  check->progress = progress;
  check->progress_user = user;
}

neph_result neph_check_set_file(neph_check *check, const char *path) {
  if (!check) return NEPH_ERROR_INVALID_ARGUMENT;
  check->file = check->grid = NULL;
  if (!path) return NEPH_OK;
  if (check->file_count == check->file_capacity) {
    const size_t capacity = 2 * check->file_capacity + 8;
    char **files = np_alloc_resize(check->context, check->files, capacity, sizeof *files);
    if (!files) return NEPH_ERROR_OUT_OF_MEMORY;
    check->files = files;
    check->file_capacity = capacity;
  }
  char *copy = np_alloc_text(check->context, path);
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  check->file = check->files[check->file_count++] = copy;
  return NEPH_OK;
}

neph_result np_check_pass(neph_result result) {
  return result == NEPH_ERROR_OUT_OF_MEMORY || result == NEPH_ERROR_CANCELLED || result == NEPH_ERROR_INTERNAL
             ? result
             : NEPH_OK;
}

void np_check_start_monitor(const neph_check *check, np_monitor *monitor) {
  np_monitor_start(monitor, check->context, check->progress, check->progress_user);
}

size_t neph_check_count(const neph_check *check, neph_severity severity) {
  return check && (unsigned)severity <= NEPH_SEVERITY_ERROR ? check->counts[severity] : 0;
}

size_t neph_check_get_finding_count(const neph_check *check) { return check ? check->listed : 0; }

neph_result neph_check_get_finding(const neph_check *check, size_t index, neph_finding *out_finding) {
  if (NP_LACKS(NP_CONTEXT_OF(check), out_finding)) return NEPH_ERROR_INVALID_ARGUMENT;
  if (index >= check->listed)
    return np_fail(check->context, NEPH_ERROR_INVALID_ARGUMENT, "neph_check_get_finding: index %zu, must be below %zu",
                   index, check->listed);
  const np_finding *f = &check->findings[index];
  const neph_finding finding = {.struct_size = sizeof finding,
                                .severity = f->severity,
                                .rule = f->rule,
                                .file = f->file ? f->file : "",
                                .grid = f->grid[0] ? f->grid : NULL,
                                .place = f->place[0] ? f->place : NULL,
                                .cause = f->cause,
                                .remedy = f->remedy,
                                .frame_count = f->frame_count};
  return np_desc_write(check->context, "neph_finding", &finding, sizeof finding, out_finding);
}
