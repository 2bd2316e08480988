/* SPDX-License-Identifier: Apache-2.0 */
/* Open Job Description, version 2023-09: a job template in YAML. Values are JSON, which YAML includes.
 * https://github.com/OpenJobDescription/openjd-specifications/blob/mainline/wiki/2023-09-Template-Schemas.md */
#include "job.h"
#include "print.h"

enum { CHUNKS_MAX = 1024 }; /* greatest number of elements in a list of values */

static void print_argument(const farm_job *job, const char *argument, bool is_template) {
  (void)is_template;
  fprintf(job->out, "            - ");
  farm_text_put_json(job->out, argument);
  putc('\n', job->out);
}

/* Prints the frames of tasks: chunks of one frame as ranges of numbers, others as a list of texts. */
static void print_frames(const farm_job *job) {
  if (job->chunk_size == 1) {
    fprintf(job->out, "        - {name: Frames, type: INT, range: \"");
    farm_job_print_frames(job, 0, job->frame_count, ':');
    fprintf(job->out, "\"}\n");
    return;
  }
  fprintf(job->out, "        - name: Frames\n          type: STRING\n          range: [");
  for (size_t i = 0; i < farm_job_count_chunks(job); i++) {
    fputs(i ? ", \"" : "\"", job->out);
    farm_job_print_chunk(job, i);
    putc('"', job->out);
  }
  fprintf(job->out, "]\n");
}

static void print_action(const farm_job *job) {
  fprintf(job->out, "    script:\n      actions:\n        onRun:\n          command: nephos\n          args:\n");
}

/* Prints the mapping of names within the scene, by the same rules as parameters. */
static void print_mapping(const farm_job *job) {
  print_argument(job, "--path-mapping", false);
  print_argument(job, "{{Session.PathMappingRulesFile}}", true);
}

static void print_step(const farm_job *job, const char *name, const char *needs) {
  fprintf(job->out, "  - name: %s\n", name);
  if (needs) fprintf(job->out, "    dependencies: [{dependsOn: %s}]\n", needs);
  if (job->thread_count && !needs)
    fprintf(job->out, "    hostRequirements: {amounts: [{name: amount.worker.vcpu, min: %u}]}\n", job->thread_count);
  fprintf(job->out, "    parameterSpace:\n      taskParameterDefinitions:\n");
  print_frames(job);
}

static void print_render(const farm_job *job) {
  char tile[48];
  cli_print(tile, sizeof tile, "{{Task.Param.Tile}}/%u", job->tile_count);
  print_step(job, "render", NULL);
  if (job->tile_count > 1) fprintf(job->out, "        - {name: Tile, type: INT, range: \"1-%u\"}\n", job->tile_count);
  print_action(job);
  farm_job_print_render(job, "{{Task.Param.Frames}}", tile, "openjd", print_argument);
  farm_job_print_threads(job, print_argument);
  print_mapping(job);
  fprintf(job->out, "          cancelation: {mode: NOTIFY_THEN_TERMINATE, notifyPeriodInSeconds: 60}\n");
}

static void print_merge(const farm_job *job) {
  print_step(job, "merge", "render");
  print_action(job);
  farm_job_print_merge(job, "{{Task.Param.Frames}}", print_argument);
  print_mapping(job);
}

static void print_job(const farm_job *job) {
  farm_job mapped = *job;
  mapped.scene = "{{Param.Scene}}";
  farm_job_print_origin(job, "#", &farm_openjd);
  fprintf(job->out, "\nspecificationVersion: jobtemplate-2023-09\nname: ");
  farm_text_put_json(job->out, job->name);
  fprintf(job->out, "\nparameterDefinitions:\n"
                    "  - name: Scene\n    type: PATH\n    objectType: FILE\n    dataFlow: IN\n    default: ");
  farm_text_put_json(job->out, job->scene);
  fprintf(job->out, "\nsteps:\n");
  print_render(&mapped);
  if (job->tile_count > 1) print_merge(&mapped);
}

const farm farm_openjd = {.name = "openjd",
                          .chunk_max = CHUNKS_MAX,
                          .maps_scene = true,
                          .text = {.is_unicode = true, .reserved = "{{"},
                          .print = print_job};
