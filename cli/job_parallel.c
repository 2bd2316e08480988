/* SPDX-License-Identifier: Apache-2.0 */
/* GNU parallel: a script that runs the tasks on one machine, or on several by ssh, and merges. A task is one argument,
 * a command of a shell in which parallel replaces {1} and {2}. Quotes behind every other { keep it from being replaced,
 * and a ::: within the argument begins no list. */
#include "job.h"
#include "print.h"

#include <stdlib.h>

/* Prints an argument of the command. */
static void print_argument(const farm_job *job, const char *argument, bool is_template) {
  putc(' ', job->out);
  if (is_template)
    fputs(argument, job->out);
  else
    farm_text_put_word(job->out, &farm_parallel.text, argument);
}

static void print_chunks(const farm_job *job) {
  fprintf(job->out, " :::");
  for (size_t i = 0; i < farm_job_count_chunks(job); i++) {
    putc(' ', job->out);
    farm_job_print_chunk(job, i);
  }
}

/* Prints as one argument the command that `print` prints. */
static void print_command(const farm_job *job, void (*print)(const farm_job *job)) {
  farm_job inner = *job;
  char *command = NULL;
  size_t size;
  inner.out = open_memstream(&command, &size);
  if (!inner.out) abort();
  fprintf(inner.out, "nephos");
  print(&inner);
  if (fclose(inner.out)) abort();
  farm_text_put_word(job->out, NULL, command);
  free(command);
}

static void print_render(const farm_job *job) {
  char tile[32];
  cli_print(tile, sizeof tile, "{2}/%u", job->tile_count);
  farm_job_print_render(job, "{1}", tile, "none", print_argument);
  farm_job_print_threads(job, print_argument);
}

static void print_merge(const farm_job *job) { farm_job_print_merge(job, "{1}", print_argument); }

static void print_start(const farm_job *job) {
  fprintf(job->out, "parallel --workdir . --jobs ");
  if (job->thread_count)
    fprintf(job->out, "\"$((cpus > %u ? cpus / %u : 1))\"", job->thread_count, job->thread_count);
  else
    fprintf(job->out, "1");
  fprintf(job->out, " \"$@\"");
}

static void print_head(const farm_job *job) {
  fprintf(job->out, "#!/bin/sh\n");
  farm_job_print_origin(job, "#", &farm_parallel);
  fprintf(job->out, "\n# Runs the job: sh THIS_FILE [options of parallel]\nset -eu\ncd ");
  farm_text_put_word(job->out, NULL, job->folder);
  fprintf(job->out, "\nexport PARALLEL_SHELL=/bin/sh\n");
  if (job->thread_count) fprintf(job->out, "cpus=$(nproc)\n");
  fprintf(job->out, "\n");
}

static void print_job(const farm_job *job) {
  print_head(job);
  print_start(job);
  fprintf(job->out, " --retries 3 --termseq TERM,60000,KILL,25 \\\n  ");
  print_command(job, print_render);
  fprintf(job->out, " \\\n ");
  print_chunks(job);
  if (job->tile_count > 1) fprintf(job->out, " :::");
  for (unsigned i = 1; job->tile_count > 1 && i <= job->tile_count; i++) fprintf(job->out, " %u", i);
  fprintf(job->out, "\n");
  if (job->tile_count < 2) return;
  print_start(job);
  fprintf(job->out, " \\\n  ");
  print_command(job, print_merge);
  fprintf(job->out, " \\\n ");
  print_chunks(job);
  fprintf(job->out, "\n");
}

const farm farm_parallel = {.name = "parallel", .text = {.has_tabs = true, .split = '{'}, .print = print_job};
