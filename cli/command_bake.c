/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bake_map.h"
#include "cloud_target.h"
#include "command_files.h"
#include "failures.h"
#include "print.h"
#include "verbs.h"

static unsigned count_baked(const neph_scene *scene) {
  unsigned count = 0;
  for (unsigned i = 0; i < neph_scene_get_cloud_count(scene); i++) count += neph_scene_is_cloud_baked(scene, i);
  return count;
}

static cli_exit check_output(const cli_options *options, unsigned baked_count) {
  if (!baked_count) {
    cli_complain("%s bakes no cloud", options->files[0]);
    return CLI_BAD_SCENE;
  }
  if (!options->output_count) return CLI_DONE;
  const char *output = options->outputs[0];
  if (options->output_count == 1 && (cli_is_folder(output) || (baked_count == 1 && cli_get_grid_ending(output))))
    return CLI_DONE;
  cli_complain("--output of nephos bake must be %s",
               baked_count == 1 ? "a .vdb, a .nvdb or a folder" : "a folder, for several clouds");
  return CLI_USAGE;
}

typedef struct cloud_job {
  cli_session *session;
  neph_scene *scene;
  unsigned cloud;
  int frame;
  neph_files *files; /* table to which the file is added; NULL: the cloud is baked */
  bool *is_stopped;  /* set where files cannot be written, so that no later frame can be baked either */
} cloud_job;

/* One cause of loss in a bake; `key` is its name in JSON. */
typedef struct loss_row {
  const char *key, *meaning;
  const neph_bake_loss *loss;
} loss_row;

enum { LOSS_COUNT = 6 };

static void list_losses(const neph_bake_error *error, loss_row out_rows[LOSS_COUNT]) {
  const loss_row rows[LOSS_COUNT] = {
      {"voxel", "by voxel size", &error->voxel},    {"detail", "  detail left out", &error->detail},
      {"sampling", "  sampling", &error->sampling}, {"half", "by half floats", &error->half},
      {"pruning", "by pruning", &error->pruning},   {"total", "together", &error->total}};
  memcpy(out_rows, rows, sizeof rows);
}

static void print_loss(const char *meaning, const neph_bake_loss *loss) {
  printf("%-20s%14.3g%11.3g%12.3g%10.3g\n", meaning, loss->density_rms_per_m, loss->density_max_per_m, loss->depth_rms,
         loss->depth_max);
}

static void print_lods(const neph_bake_error *error) {
  for (size_t k = 0; k < error->lod_count; k++) {
    char meaning[40];
    cli_print(meaning, sizeof meaning, "  in voxels of %g m", error->lods[k].voxel_m);
    print_loss(meaning, &error->lods[k].total);
  }
}

static void print_error(const neph_bake_error *error) {
  loss_row rows[LOSS_COUNT];
  list_losses(error, rows);
  printf("%-20s%25s%22s\n%-20s%14s%11s%12s%10s\n", "lost", "density, 1/m", "optical depth", "", "rms", "max", "rms",
         "max");
  for (int i = 0; i < LOSS_COUNT; i++) print_loss(rows[i].meaning, rows[i].loss);
  print_lods(error);
  printf("%-20s%14.3g%23.3g\n", "of the model's", error->density_rms_per_m, error->depth_rms);
  printf("at %llu points in the cloud, along the %llu of %d rays that meet it\n",
         (unsigned long long)error->point_count, (unsigned long long)error->ray_count, (int)NEPH_BAKE_ERROR_RAYS);
}

static void print_json_loss(const char *key, const neph_bake_loss *loss) {
  printf(", \"%s\": {\"density_rms_per_m\": %.6g, \"density_max_per_m\": %.6g, \"depth_rms\": %.6g, "
         "\"depth_max\": %.6g}",
         key, loss->density_rms_per_m, loss->density_max_per_m, loss->depth_rms, loss->depth_max);
}

static void print_json_lods(const neph_bake_error *error) {
  for (size_t k = 0; k < error->lod_count; k++) {
    const neph_bake_lod_error *lod = &error->lods[k];
    printf("%s{\"voxel_m\": %.6g, \"rays\": %llu, \"points\": %llu, \"density_rms_per_m\": %.6g, \"depth_rms\": %.6g",
           k ? ", " : ", \"levels\": [", lod->voxel_m, (unsigned long long)lod->ray_count,
           (unsigned long long)lod->point_count, lod->density_rms_per_m, lod->depth_rms);
    print_json_loss("total", &lod->total);
    printf("}%s", k + 1 == error->lod_count ? "]" : "");
  }
}

static void print_json_error(const neph_bake_error *error) {
  loss_row rows[LOSS_COUNT];
  list_losses(error, rows);
  printf(", \"error\": {\"rays\": %llu, \"points\": %llu, \"density_rms_per_m\": %.6g, \"depth_rms\": %.6g",
         (unsigned long long)error->ray_count, (unsigned long long)error->point_count, error->density_rms_per_m,
         error->depth_rms);
  for (int i = 0; i < LOSS_COUNT; i++) print_json_loss(rows[i].key, rows[i].loss);
  print_json_lods(error);
  printf("}");
}

/* Prints the line of a finished file. `error` NULL: the error was not measured. */
static void print_done(const cli_session *session, const char *name, const char *path, double seconds,
                       const neph_bake_error *error) {
  if (!session->options->is_json) {
    cli_say("%s: %s, %.2f s", name, path, seconds);
    if (error) print_error(error);
    return;
  }
  printf("{\"cloud\": ");
  cli_print_json_text(name);
  printf(", \"file\": ");
  cli_print_json_text(path);
  printf(", \"seconds\": %.3f", seconds);
  if (error) print_json_error(error);
  printf("}\n");
}

static double get_time_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static neph_bake_desc make_desc(cli_session *session) {
  const cli_options *options = session->options;
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.file_precision = options->is_half ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT;
  desc.prune_per_m = options->prune_per_m;
  if (options->level_count) desc.level_count = options->level_count;
  desc.has_velocity = options->wants_velocity;
  desc.has_region = options->has_region;
  memcpy(desc.region_min_m, options->region_m, sizeof desc.region_min_m);
  memcpy(desc.region_max_m, options->region_m + 3, sizeof desc.region_max_m);
  if (options->has_memory_max) desc.memory_max_bytes = options->memory_max_bytes;
  desc.progress = cli_progress_report;
  desc.progress_user = &session->progress;
  return desc;
}

/* Prints the name of the file that a bake would write. */
static cli_exit rehearse(const cloud_job *job, const char *path) {
  neph_result result = neph_scene_check_files(job->scene);
  if (!result) cli_say("%s", path);
  return cli_exit_of(result);
}

static cli_exit bake_to(const cloud_job *job, const char *path) {
  cli_session *session = job->session;
  cli_exit exit = cli_check_target(session, path);
  if (exit) return exit;
  if (session->options->is_dry_run) return rehearse(job, path);
  const double start_s = get_time_s();
  neph_bake_desc desc = make_desc(session);
  neph_bake_error error = NEPH_BAKE_ERROR_DEFAULT;
  if (session->options->wants_error) desc.error = &error;
  neph_result result = neph_scene_bake_file(job->scene, job->cloud, job->frame, &desc, path);
  cli_progress_finish(&session->progress);
  *job->is_stopped = result == NEPH_ERROR_IO;
  if (!result)
    print_done(session, neph_scene_get_cloud_name(job->scene, job->cloud), path, get_time_s() - start_s, desc.error);
  fflush(stdout);
  return cli_exit_of(result);
}

/* Bakes to a path, or adds the path to the table of files. */
static cli_exit take_path(const cloud_job *job, const char *path) {
  if (!job->files) return bake_to(job, path);
  char role[32];
  cli_print(role, sizeof role, "clouds[%u].vdb", job->cloud);
  if (job->session->options->output_count) cli_print(role, sizeof role, "--output");
  return cli_exit_of(neph_files_add_bake(job->files, NEPH_FILE_WRITTEN, role, job->scene, job->cloud, path));
}

static cli_exit bake_frame(const cloud_job *job, const char *pattern) {
  if (!neph_frame_is_numbered(pattern) && !cli_is_single_frame(job->session->options)) {
    cli_complain("%s would be written for every frame: put # where the number goes", pattern);
    return CLI_USAGE;
  }
  char *path;
  neph_result result = neph_frame_get_path(job->session->context, pattern, job->frame, &path);
  if (result) return cli_exit_of(result);
  cli_exit exit = take_path(job, path);
  neph_text_destroy(job->session->context, path);
  return exit;
}

static cli_exit bake_cloud(const cloud_job *job) {
  if (!neph_scene_is_cloud_baked(job->scene, job->cloud)) return CLI_DONE;
  char *pattern = cli_get_cloud_target(job->session->options, job->scene, job->cloud, true);
  cli_exit exit = pattern ? bake_frame(job, pattern) : CLI_INTERNAL;
  free(pattern);
  return exit;
}

/* Bakes all clouds of a frame, or adds their files to the table. */
static cli_exit walk_frame(cli_session *session, neph_scene *scene, neph_files *files, int frame, bool *is_stopped) {
  cli_exit exit = CLI_DONE;
  for (unsigned i = 0; !exit && i < neph_scene_get_cloud_count(scene); i++) {
    const cloud_job job = {session, scene, i, frame, files, is_stopped};
    exit = bake_cloud(&job);
  }
  return exit;
}

static cli_exit check_frames(cli_session *session, neph_scene *scene, neph_files *files) {
  cli_frame_walk walk = {0};
  cli_exit exit = CLI_DONE;
  for (int frame; !exit && cli_next_frame(session->options, &walk, &frame);)
    exit = walk_frame(session, scene, files, frame, NULL);
  return exit;
}

static void note_failure(const cli_session *session, cli_failures *failures, int frame, cli_exit exit) {
  cli_failures_add(failures, frame);
  if (session->options->is_json) printf("{\"frame\": %d, \"exit\": %d}\n", frame, (int)exit);
  fflush(stdout);
}

/* Bakes all frames. A frame that fails does not end a batch, unless files cannot be written. */
static cli_exit bake_frames(cli_session *session, neph_scene *scene) {
  cli_frame_walk walk = {0};
  cli_failures failures = {0};
  unsigned count = 0;
  bool is_stopped = false;
  cli_exit exit = CLI_DONE;
  for (int frame; !exit && cli_next_frame(session->options, &walk, &frame); count++) {
    exit = walk_frame(session, scene, NULL, frame, &is_stopped);
    if (!exit || is_stopped || exit == CLI_INTERRUPTED || cli_is_single_frame(session->options)) continue;
    note_failure(session, &failures, frame, exit);
    exit = CLI_DONE;
  }
  if (!exit && failures.count) exit = CLI_SOME_FAILED;
  cli_failures_complain(&failures, &session->progress, count, "");
  return exit;
}

static cli_exit bake_clouds(cli_session *session, neph_scene *scene) {
  neph_files *files;
  cli_exit exit = check_output(session->options, count_baked(scene));
  if (!exit) exit = cli_maps_check(session, scene);
  if (exit) return exit;
  exit = cli_files_begin(session, &files);
  if (!exit) exit = check_frames(session, scene, files);
  if (!exit) exit = cli_maps_add_files(session, scene, files);
  exit = cli_files_end(files, scene, exit);
  if (!exit) exit = cli_maps_save(session, scene);
  return exit ? exit : bake_frames(session, scene);
}

static cli_exit verify_file(cli_session *session) {
  const char *path = session->options->files[0];
  bool is_same;
  neph_result result =
      neph_cloud_verify_file(session->context, path, cli_progress_report, &session->progress, &is_same);
  cli_progress_finish(&session->progress);
  if (result) return cli_exit_of(result);
  if (session->options->is_json)
    printf("{\"same\": %s}\n", is_same ? "true" : "false");
  else
    cli_say("%s: %s", path, is_same ? "the same when rebaked" : "differs when rebaked");
  return is_same ? CLI_DONE : CLI_DIFFERENT;
}

static cli_exit run_bake(cli_session *session) {
  neph_scene *scene;
  cli_catch_interrupts();
  if (session->options->is_verifying) return verify_file(session);
  cli_exit exit = cli_load_scene(session, session->options->files[0], &scene);
  if (exit) return exit;
  exit = bake_clouds(session, scene);
  neph_scene_destroy(scene);
  return exit;
}

const cli_verb cli_verb_bake = {
    .name = "bake",
    .arguments = "SCENE|FILE",
    .summary = "bake the procedural clouds of a scene to .vdb or .nvdb",
    .argument_min = 1,
    .argument_max = 1,
    .run = run_bake,
    .files = "yaml yml vdb",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_LIMIT) | CLI_MAY(CLI_DIFFERENT) |
             CLI_MAY(CLI_SOME_FAILED),
    .description = "Bakes each procedural cloud of a scene: to the cloud's `vdb` if it has one, else to its name and "
                   ".vdb in the current folder.",
    .options = {{"--output", "write to FILE, a .vdb or .nvdb, where the scene bakes one cloud, or into the folder FILE",
                 .files = "vdb"},
                {"--set"},
                {"--path-mapping"},
                {"--frames", "bake a file for each frame, its number in place of #; the others continue if one fails"},
                {"--half"},
                {"--prune"},
                {"--levels"},
                {"--region"},
                {"--max-memory",
                 "refuse, with exit code 6, a bake that may need more, as one that may need more than the machine has"},
                {"--velocity"},
                {"--error"},
                {"--preview-map",
                 "write the weather map of the scene's cloud from above, north up, to FILE, a .png, before anything is "
                 "baked; of several clouds with a map, into the folder FILE, as NAME.map.png",
                 .files = "png /"},
                {"--verify",
                 "rebake a file from the parameters in it, and fail, with exit code 7, when a grid differs"},
                {"--dry-run"},
                {"--progress"}},
    .examples = {{"nephos bake clouds.yaml -o low.vdb", "bake the only cloud of a scene"},
                 {"nephos bake clouds.yaml -o . --half --levels 2", "bake into a folder, with a coarser grid"},
                 {"nephos bake painted.yaml --preview-map map.png", "show how a painted map lies on the field"},
                 {"nephos bake --verify low.vdb", "bake the file again, and compare"}},
};
