/* SPDX-License-Identifier: Apache-2.0 */
/* Open Job Description, version 2023-09: a job template in YAML. Values are JSON, which YAML includes.
 * https://github.com/OpenJobDescription/openjd-specifications/blob/mainline/wiki/2023-09-Template-Schemas.md */
#include "job.h"

#include "session.h"

enum { CHUNKS_MAX = 1024 }; /* elements of a list of values */

static void print_argument(const char *argument) {
  printf("            - ");
  cli_print_json_text(argument);
  putchar('\n');
}

/* Chunks of one frame are numbers, by ranges; others are texts, one by one. */
static void print_frames(const farm_job *job) {
  if (job->chunk_size == 1) {
    printf("        - {name: Frames, type: INT, range: \"");
    farm_job_print_frames(job, 0, job->frame_count, ':');
    printf("\"}\n");
    return;
  }
  printf("        - name: Frames\n          type: STRING\n          range: [");
  for (size_t i = 0; i < farm_job_count_chunks(job); i++) {
    printf(i ? ", \"" : "\"");
    farm_job_print_chunk(job, i);
    putchar('"');
  }
  printf("]\n");
}

static void print_action(void) {
  printf("    script:\n      actions:\n        onRun:\n          command: nephos\n          args:\n");
}

/* Names within the scene are mapped by the rules that those of parameters are. */
static void print_mapping(void) {
  print_argument("--path-mapping");
  print_argument("{{Session.PathMappingRulesFile}}");
}

static void print_step(const farm_job *job, const char *name, const char *needs) {
  printf("  - name: %s\n", name);
  if (needs) printf("    dependencies: [{dependsOn: %s}]\n", needs);
  if (job->thread_count && !needs)
    printf("    hostRequirements: {amounts: [{name: amount.worker.vcpu, min: %u}]}\n", job->thread_count);
  printf("    parameterSpace:\n      taskParameterDefinitions:\n");
  print_frames(job);
}

static void print_render(const farm_job *job) {
  char tile[48];
  snprintf(tile, sizeof tile, "{{Task.Param.Tile}}/%u", job->tile_count);
  print_step(job, "render", NULL);
  if (job->tile_count > 1) printf("        - {name: Tile, type: INT, range: \"1-%u\"}\n", job->tile_count);
  print_action();
  farm_job_print_render(job, "{{Task.Param.Frames}}", tile, "openjd", print_argument);
  farm_job_print_threads(job, print_argument);
  print_mapping();
  printf("          cancelation: {mode: NOTIFY_THEN_TERMINATE, notifyPeriodInSeconds: 60}\n");
}

static void print_merge(const farm_job *job) {
  print_step(job, "merge", "render");
  print_action();
  farm_job_print_merge(job, "{{Task.Param.Frames}}", print_argument);
  print_mapping();
}

static void print_job(const farm_job *job) {
  farm_job mapped = *job;
  mapped.scene = "{{Param.Scene}}";
  farm_job_print_origin(job, "#", &farm_openjd);
  printf("\nspecificationVersion: jobtemplate-2023-09\nname: ");
  cli_print_json_text(job->name);
  printf("\nparameterDefinitions:\n"
         "  - name: Scene\n    type: PATH\n    objectType: FILE\n    dataFlow: IN\n    default: ");
  cli_print_json_text(job->scene);
  printf("\nsteps:\n");
  print_render(&mapped);
  if (job->tile_count > 1) print_merge(&mapped);
}

const farm farm_openjd = {.name = "openjd", .chunk_max = CHUNKS_MAX, .reserved = "{{", .print = print_job};
