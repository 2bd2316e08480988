/* SPDX-License-Identifier: Apache-2.0 */
/* Slurm: a script that submits an array of tasks, and a merging that depends on it. */
#include "job.h"

/* Lets go of the shell's quotes where an argument is a variable of the task. */
static void print_argument(const char *argument) {
  if (argument[0] == '"')
    printf(" %s", argument);
  else
    farm_print_shell_argument(argument);
}

static void print_header(const farm_job *job, const char *step, const char *log) {
  printf("#SBATCH --job-name=%s-%s\n#SBATCH --array=0-%zu\n#SBATCH --output=%s-%s\n#SBATCH --open-mode=append\n",
         job->name, step, farm_job_count_chunks(job) * (*step == 'r' ? job->tile_count : 1) - 1, job->name, log);
  if (job->thread_count) printf("#SBATCH --cpus-per-task=%u\n", job->thread_count);
}

static void print_chunks(const farm_job *job) {
  printf("set --");
  for (size_t i = 0; i < farm_job_count_chunks(job); i++) {
    putchar(' ');
    farm_job_print_chunk(job, i);
  }
  putchar('\n');
}

/* The shell passes SIGTERM on, and waits for the checkpoint. What may succeed another time is queued again, thrice. */
static void print_render(const farm_job *job) {
  printf("render=$(sbatch --parsable \"$@\" <<'TASK'\n#!/bin/sh\n");
  print_header(job, "render", "%A_%a.log");
  printf("#SBATCH --requeue\n#SBATCH --signal=B:TERM@60\n# The frames of each chunk\n");
  print_chunks(job);
  printf("tiles=%u\nshift $((SLURM_ARRAY_TASK_ID / tiles))\n", job->tile_count);
  printf("nephos");
  farm_job_print_render(job, "\"$1\"", "\"$((SLURM_ARRAY_TASK_ID % tiles + 1))/$tiles\"", "lines", print_argument);
  printf(
      " &\n"
      "task=$!\n"
      "trap 'kill -TERM $task 2>/dev/null' TERM\n"
      "while :; do\n"
      "  code=0\n"
      "  wait $task || code=$?\n"
      "  kill -0 $task 2>/dev/null || break\n"
      "done\n"
      "# A wrong command line, 2, or scene, 3, stays wrong; all else may succeed another time, from its checkpoint.\n"
      "case $code in 0 | 2 | 3) exit $code ;; esac\n"
      "[ \"${SLURM_RESTART_COUNT:-0}\" -lt 3 ] || exit $code\n"
      "scontrol requeue \"${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\" || exit $code\n"
      "sleep 60\n"
      "TASK\n)\n"
      "echo \"render: job $render\"\n");
}

static void print_merge(const farm_job *job) {
  printf(
      "merge=$(sbatch --parsable --dependency=\"afterok:${render%%%%;*}\" --kill-on-invalid-dep=yes \"$@\" <<'TASK'\n"
      "#!/bin/sh\n");
  print_header(job, "merge", "%A_%a.merge.log");
  print_chunks(job);
  printf("shift \"$SLURM_ARRAY_TASK_ID\"\nexec nephos");
  farm_job_print_merge(job, "\"$1\"", print_argument);
  printf("\nTASK\n)\necho \"merge: job $merge\"\n");
}

static void print_job(const farm_job *job) {
  printf("#!/bin/sh\n");
  farm_job_print_origin(job, "#", &farm_slurm);
  printf("\n# Submits the job: sh THIS_FILE [options of sbatch]\nset -eu\n\n");
  print_render(job);
  if (job->tile_count < 2) return;
  printf("\n");
  print_merge(job);
}

const farm farm_slurm = {.name = "slurm", .print = print_job};
