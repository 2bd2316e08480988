/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "job_forecast.h"
#include "print.h"
#include "verbs.h"

#define ADDRESS(name) &farm_##name,
static const farm *const farms[] = {CLI_FARMS(ADDRESS)};
#undef ADDRESS

enum { FARM_COUNT = sizeof farms / sizeof *farms };

/* ---- Farm and frames ---- */

static const farm *choose_farm(const char *name) {
  for (size_t i = 0; i < FARM_COUNT; i++)
    if (!strcmp(farms[i]->name, name)) return farms[i];
  cli_complain("%s is not a farm, must be slurm, openjd, opencue or parallel", name);
  return NULL;
}

static int compare_frames(const void *a, const void *b) {
  const int left = *(const int *)a, right = *(const int *)b;
  return (left > right) - (left < right);
}

/* Lists all frames in order, each once. */
static cli_exit list_frames(const cli_options *options, farm_job *job) {
  size_t count = 0;
  int frame;
  for (cli_frame_walk walk = {0}; cli_next_frame(options, &walk, &frame);) count++;
  job->frames = calloc(count, sizeof *job->frames);
  if (!job->frames) return CLI_INTERNAL;
  for (cli_frame_walk walk = {0}; cli_next_frame(options, &walk, &frame);) job->frames[job->frame_count++] = frame;
  qsort(job->frames, count, sizeof *job->frames, compare_frames);
  return CLI_DONE;
}

/* Path of the scene for tasks, which may start in any folder. Links in the path are kept, since names in the scene
 * start from its folder.
 */
static cli_exit place_scene(const farm *chosen, farm_job *job, char **out_folder, char **out_scene) {
  const char *folder = "", *slash = "";
  if (!strcmp(job->given, "-")) {
    cli_complain("a job reads its scene in each task: give a file, not standard input");
    return CLI_USAGE;
  }
  *out_folder = getcwd(NULL, 0);
  if (!*out_folder) {
    cli_complain("the working folder has no name any more: start from another");
    return CLI_IO;
  }
  if (!chosen->maps_scene && *job->given != '/') folder = *out_folder, slash = strcmp(folder, "/") ? "/" : "";
  if (chosen->maps_scene && *job->given == '-') folder = ".", slash = "/";
  if (asprintf(out_scene, "%s%s%s", folder, slash, job->given) < 0) *out_scene = NULL;
  job->folder = *out_folder;
  job->scene = *out_scene;
  return *out_scene ? CLI_DONE : CLI_INTERNAL;
}

/* ---- Check of a task ---- */

/* Parses the command line of a task, without its tile, with the parser of nephos render. */
static cli_exit read_task(const cli_session *session, const farm_job *job, cli_options *out) {
  const cli_options *options = session->options;
  const char **words = calloc(job->argument_count + 4, sizeof *words);
  size_t count = 0;
  if (!words) return CLI_INTERNAL;
  words[count++] = "nephos";
  words[count++] = "render";
  words[count++] = job->scene;
  for (size_t i = 0; i < job->argument_count; i++) words[count++] = job->arguments[i];
  cli_exit exit = cli_options_read((int)count, (char **)(uintptr_t)words, out);
  free(words);
  if (exit) return exit;
  out->frames = calloc(options->frame_range_count + 1, sizeof *out->frames);
  if (!out->frames) return CLI_INTERNAL;
  for (out->frame_range_count = 0; out->frame_range_count < options->frame_range_count; out->frame_range_count++)
    out->frames[out->frame_range_count] = options->frames[out->frame_range_count];
  return CLI_DONE;
}

static cli_exit check_options(const cli_options *task) {
  if (task->given[cli_option_get("--frames", strlen("--frames")) - cli_option_at(0)] || task->output_count ||
      task->tile_count || task->has_sample_range || task->is_dry_run || task->wants_plan || task->has_time_limit) {
    cli_complain("behind -- may not be --frames, --output, --tile, --sample-range, --time-limit, --explain or "
                 "--dry-run: frames and tiles are the job's, names the scene's");
    return CLI_USAGE;
  }
  if (!task->has_ended) return CLI_DONE;
  cli_complain("behind -- may not be another --: the task's own options follow");
  return CLI_USAGE;
}

static cli_exit check_outputs(const farm_job *job, render_job *render) {
  cli_exit exit = cli_exit_of(neph_scene_get_output(render->scene, &render->output));
  if (!exit) exit = render_job_choose_outputs(render);
  if (!exit && job->tile_count > 1 && !render->output.image) {
    cli_complain("%s has no output.image: tiles are merged by it", job->given);
    exit = CLI_USAGE;
  }
  if (!exit && job->frame_count > job->chunk_size) neph_scene_warn_of_tasks(render->scene);
  return exit;
}

/* Fails where every task would fail: scene, names. Predicts the task's demands, where its farm requires them. */
static cli_exit try_task(cli_session *session, const farm *chosen, farm_job *job) {
  render_job render = {.session = session,
                       .desc = NEPH_RENDER_DESC_DEFAULT,
                       .machine = NEPH_MACHINE_DEFAULT,
                       .output = NEPH_OUTPUT_DEFAULT};
  cli_exit exit = cli_load_scene(session, job->given, &render.scene);
  if (exit) return exit;
  exit = check_outputs(job, &render);
  if (!exit && chosen->has_demands) exit = render_job_choose_settings(&render);
  if (!exit && chosen->has_demands) exit = farm_job_forecast(job, &render);
  neph_scene_destroy(render.scene);
  return exit;
}

/* Checks a task; during the call the session has the task's options. */
static cli_exit check_task(cli_session *session, const farm *chosen, farm_job *job, const cli_options *task) {
  const cli_options *own = session->options;
  cli_exit exit = check_options(task);
  if (exit) return exit;
  session->options = task;
  exit = try_task(session, chosen, job);
  session->options = own;
  return exit;
}

static cli_exit collect_settings(const cli_options *task, farm_job *job) {
  job->settings = calloc(task->setting_count + 1, sizeof *job->settings);
  for (size_t i = 0; job->settings && i < task->setting_count; i++) {
    char *text;
    if (task->settings[i].option) continue;
    if (asprintf(&text, "%s=%s", task->settings[i].key, task->settings[i].value) < 0) return CLI_INTERNAL;
    job->settings[job->setting_count++] = text;
  }
  return job->settings ? CLI_DONE : CLI_INTERNAL;
}

/* ---- The verb ---- */

static cli_exit prepare_job(cli_session *session, const farm *chosen, farm_job *job) {
  cli_options task;
  cli_exit exit = list_frames(session->options, job);
  if (exit) return exit;
  farm_job_set_name(job);
  exit = read_task(session, job, &task);
  if (!exit) exit = check_task(session, chosen, job, &task);
  if (!exit) exit = collect_settings(&task, job);
  cli_options_clear(&task);
  return exit;
}

static cli_exit check_chunks(const farm *chosen, const farm_job *job) {
  const size_t count = farm_job_count_chunks(job);
  if (!chosen->chunk_max || job->chunk_size == 1 || count <= chosen->chunk_max) return CLI_DONE;
  cli_complain("%zu chunks of %u frames, must be at most %zu for %s: raise --chunk, or leave it at 1", count,
               job->chunk_size, chosen->chunk_max, chosen->name);
  return CLI_USAGE;
}

static void clear_job(farm_job *job) {
  for (size_t i = 0; i < job->setting_count; i++) free((char *)(uintptr_t)job->settings[i]);
  free(job->settings);
  free(job->frames);
}

static cli_exit print_job(cli_session *session, const farm *chosen, farm_job *job) {
  char *folder = NULL, *scene = NULL;
  cli_exit exit = place_scene(chosen, job, &folder, &scene);
  if (!exit && !farm_job_check_texts(job, chosen)) exit = CLI_USAGE;
  if (!exit) exit = prepare_job(session, chosen, job);
  if (!exit) exit = check_chunks(chosen, job);
  if (!exit) chosen->print(job);
  free(folder);
  free(scene);
  return exit;
}

static cli_exit run_job(cli_session *session) {
  const cli_options *options = session->options;
  const farm *chosen = choose_farm(options->files[0]);
  if (!chosen) return CLI_USAGE;
  const bool has_threads = options->given[cli_option_get("--threads", strlen("--threads")) - cli_option_at(0)];
  farm_job job = {.out = stdout,
                  .given = options->files[1],
                  .chunk_size = options->chunk_size ? options->chunk_size : 1,
                  .tile_count = options->shard_count ? options->shard_count : 1,
                  .thread_count = has_threads ? options->thread_count : 0,
                  .checkpoint = options->checkpoint ? options->checkpoint : "60s",
                  .arguments = options->files + 2,
                  .argument_count = options->file_count - 2};
  const cli_exit exit = print_job(session, chosen, &job);
  clear_job(&job);
  return exit;
}

const cli_verb cli_verb_job = {
    .name = "job",
    .arguments = "FARM SCENE [-- RENDER OPTION...]",
    .summary = "print a job for a render farm",
    .argument_min = 2,
    .argument_max = (size_t)-1,
    .run = run_job,
    .words = "slurm openjd opencue parallel",
    .files = "yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND),
    .description =
        "Prints a job that renders frames of a scene on a farm: a script for Slurm (slurm) or GNU parallel (parallel), "
        "a template of Open Job Description (openjd), or a specification of OpenCue (opencue). Each task renders a "
        "chunk of frames, or a tile of them, with --checkpoint, --resume and --skip-existing, so that it goes on where "
        "it was when it is started again. Where there are tiles, each chunk is merged once all of its tiles are done. "
        "Tasks of Slurm ask for 1.5 times the memory that is predicted and 256 MB, and for 4 times the time and 10 "
        "minutes. Names and options that a farm cannot hold, such as a line break, are refused. "
        "Options behind -- are those of nephos render for every task. Scene and options are checked.",
    .options = {{"--frames", "frames to render"},
                {"--tiles", "tiles of each frame, which are merged"},
                {"--chunk", "frames that one task renders, one after the other, with one solution of the light"},
                {"--checkpoint", .fallback = "60s"}},
    .examples = {{"nephos job slurm scene.yaml --frames 1-100 --chunk 10 -t 8 > job.sh",
                  "ten tasks of ten frames, each on eight CPUs"},
                 {"nephos job parallel scene.yaml --frames 1-4 --tiles 8 -- --samples 64", "tiles, with 64 samples"}},
};
