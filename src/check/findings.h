/* SPDX-License-Identifier: Apache-2.0 */
/* The list of a check's findings, and the log callback that fills it. */
#ifndef NP_CHECK_FINDINGS_H
#define NP_CHECK_FINDINGS_H

#include <stdatomic.h>

#include <nephos/check.h>

#include "core/parallel.h"

enum { NP_FINDINGS_MAX = 200 };

typedef struct np_finding {
  neph_severity severity;
  const char *rule;             /* rule of a table */
  const char *file, *last_file; /* files in the check's list with its first and last occurrence */
  char grid[64], place[160];
  char *cause;          /* owned by the list */
  const char *remedy;   /* remedy of a table, or NULL */
  unsigned frame_count; /* 0: no sequence */
  unsigned sequence;    /* index of the sequence, 1 for the first; 0: none */
} np_finding;

struct neph_check {
  neph_context *context; /* retained */
  neph_log_fn log;       /* log callback of the context before the check */
  void *log_user;
  neph_log_level log_level_max;
  neph_progress_fn progress;
  void *progress_user;
  atomic_flag is_listing; /* lock: one thread at a time */
  char **files;           /* names of checked files; owned */
  size_t file_count, file_capacity;
  const char *file, *grid;           /* current file and grid; NULL: none */
  unsigned sequence, sequence_count; /* current sequence, and number of sequences so far */
  bool are_warnings_muted;           /* warnings of other modules are ignored where a finding covers them already */
  size_t counts[3], listed;
  np_finding *findings;
};

/* A row of a table of rules: its name and its remedy. */
typedef struct np_rule {
  const char *name;
  neph_severity severity;
  const char *remedy; /* NULL: none */
} np_rule;

/* Place and cause, filled by the function of a rule. */
typedef struct np_finding_draft {
  char place[160], cause[700];
} np_finding_draft;

/* Sets the cause, and the place where there is one. Returns true: the rule is broken. */
bool np_draft_set(np_finding_draft *draft, const char *format, ...) __attribute__((format(printf, 2, 3)));
void np_draft_set_place(np_finding_draft *draft, const char *format, ...) __attribute__((format(printf, 2, 3)));

void np_check_add(neph_check *check, const np_rule *rule, const np_finding_draft *draft);

/* Converts a failure that is a finding already to success; lack of memory and cancelling remain failures. */
neph_result np_check_pass(neph_result result);

/* Starts a call's monitor. */
void np_check_start_monitor(const neph_check *check, np_monitor *monitor);

#endif
