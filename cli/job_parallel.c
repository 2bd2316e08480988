/* SPDX-License-Identifier: Apache-2.0 */
/* GNU parallel: a script that runs the tasks on one machine, or on several by ssh, and merges. */
#include "job.h"

/* Parallel replaces {1} and {2} in a command that it quotes for a shell of its own. */
static void print_argument(const char *argument) {
  if (argument[0] == '{')
    printf(" %s", argument);
  else
    farm_print_shell_argument(argument);
}

static void print_chunks(const farm_job *job) {
  printf(" :::");
  for (size_t i = 0; i < farm_job_count_chunks(job); i++) {
    putchar(' ');
    farm_job_print_chunk(job, i);
  }
}

static void print_start(const farm_job *job) {
  printf("parallel --quote --jobs ");
  if (job->thread_count)
    printf("\"$((cpus > %u ? cpus / %u : 1))\"", job->thread_count, job->thread_count);
  else
    printf("1");
  printf(" \"$@\"");
}

static void print_job(const farm_job *job) {
  char tile[32];
  snprintf(tile, sizeof tile, "{2}/%u", job->tile_count);
  printf("#!/bin/sh\n");
  farm_job_print_origin(job, "#", &farm_parallel);
  printf("\n# Runs the job: sh THIS_FILE [options of parallel]\nset -eu\n");
  if (job->thread_count) printf("cpus=$(nproc)\n");
  printf("\n");
  print_start(job);
  printf(" --retries 3 --termseq TERM,60000,KILL,25 \\\n  nephos");
  farm_job_print_render(job, "{1}", tile, "none", print_argument);
  farm_job_print_threads(job, print_argument);
  printf(" \\\n ");
  print_chunks(job);
  if (job->tile_count > 1) printf(" :::");
  for (unsigned i = 1; job->tile_count > 1 && i <= job->tile_count; i++) printf(" %u", i);
  printf("\n");
  if (job->tile_count < 2) return;
  print_start(job);
  printf(" \\\n  nephos");
  farm_job_print_merge(job, "{1}", print_argument);
  printf(" \\\n ");
  print_chunks(job);
  printf("\n");
}

const farm farm_parallel = {.name = "parallel", .print = print_job};
