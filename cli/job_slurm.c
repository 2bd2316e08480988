/* SPDX-License-Identifier: Apache-2.0 */
/* Slurm: a script that submits an array of tasks, and a merge that depends on it. A task requests its predicted memory
 * and time. The working folder is an option of sbatch and not a line of the task, where quotes are read otherwise than
 * by a shell. */
#include "job.h"

static void print_argument(const farm_job *job, const char *argument, bool is_template) {
  putc(' ', job->out);
  if (is_template)
    fputs(argument, job->out);
  else
    farm_text_put_word(job->out, NULL, argument);
}

static void print_header(const farm_job *job, const char *step, const char *log) {
  fprintf(job->out,
          "#SBATCH --job-name=%s-%s\n#SBATCH --array=0-%zu\n#SBATCH --output=%s-%s\n#SBATCH --open-mode=append\n",
          job->name, step, farm_job_count_chunks(job) * (*step == 'r' ? job->tile_count : 1) - 1, job->name, log);
  if (job->thread_count) fprintf(job->out, "#SBATCH --cpus-per-task=%u\n", job->thread_count);
}

static void print_demand(const farm_job *job, const farm_demand *demand) {
  fprintf(job->out, "#SBATCH --mem=%lluM\n#SBATCH --time=%llu\n", demand->memory_mib, demand->minutes);
}

static void print_chunks(const farm_job *job) {
  fprintf(job->out, "set --");
  for (size_t i = 0; i < farm_job_count_chunks(job); i++) {
    putc(' ', job->out);
    farm_job_print_chunk(job, i);
  }
  putc('\n', job->out);
}

static void print_submission(const farm_job *job, const char *step, const char *options) {
  fprintf(job->out, "%s=$(sbatch --parsable%s --chdir=", step, options);
  farm_text_put_word(job->out, NULL, job->folder);
  fprintf(job->out, " \"$@\" <<'TASK'\n#!/bin/sh\n");
}

/* Prints the command of a task. The shell passes SIGTERM on, and waits for the checkpoint. Failures that may succeed
 * another time are requeued up to three times. */
static void print_render(const farm_job *job) {
  print_submission(job, "render", "");
  print_header(job, "render", "%A_%a.log");
  fprintf(job->out, "# %.3g MB and %.3g s are predicted for a task\n", 1e-6 * job->render.predicted_bytes,
          job->render.predicted_s);
  print_demand(job, &job->render);
  fprintf(job->out, "#SBATCH --requeue\n#SBATCH --signal=B:TERM@60\n# The frames of each chunk\n");
  print_chunks(job);
  fprintf(job->out, "tiles=%u\nshift $((SLURM_ARRAY_TASK_ID / tiles))\n", job->tile_count);
  fprintf(job->out, "nephos");
  farm_job_print_render(job, "\"$1\"", "\"$((SLURM_ARRAY_TASK_ID % tiles + 1))/$tiles\"", "lines", print_argument);
  fputs(" &\n"
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
        "echo \"render: job $render\"\n",
        job->out);
}

static void print_merge(const farm_job *job) {
  print_submission(job, "merge", " --dependency=\"afterok:${render%%;*}\" --kill-on-invalid-dep=yes");
  print_header(job, "merge", "%A_%a.merge.log");
  print_demand(job, &job->merge);
  print_chunks(job);
  fprintf(job->out, "shift \"$SLURM_ARRAY_TASK_ID\"\nexec nephos");
  farm_job_print_merge(job, "\"$1\"", print_argument);
  fprintf(job->out, "\nTASK\n)\necho \"merge: job $merge\"\n");
}

static void print_job(const farm_job *job) {
  fprintf(job->out, "#!/bin/sh\n");
  farm_job_print_origin(job, "#", &farm_slurm);
  fprintf(job->out, "\n# Submits the job: sh THIS_FILE [options of sbatch]\nset -eu\n\n");
  print_render(job);
  if (job->tile_count < 2) return;
  fprintf(job->out, "\n");
  print_merge(job);
}

const farm farm_slurm = {.name = "slurm", .has_demands = true, .text = {.has_tabs = true}, .print = print_job};
