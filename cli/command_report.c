/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "calibration.h"
#include "command_files.h"
#include "make_folder.h"
#include "print.h"
#include "verbs.h"

static const double budget_s = 600.0, quick_budget_s = 60.0;

typedef struct report_job {
  cli_session *session;
  char *folder; /* folder of the report; owned */
  bool is_made; /* whether this run created the folder */
  bool are_files_checked;
  neph_report *report;
} report_job;

/* ---- The folder ---- */

/* Folder of the report: "scene.report" in the current folder for "dir/scene.yaml". */
static char *name_folder(const cli_options *options) {
  if (options->output_count) return strdup(options->outputs[0]);
  const char *path = options->files[0], *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  const char *dot = strrchr(name, '.');
  char *folder;
  const int printed = asprintf(&folder, "%.*s.report", dot ? (int)(dot - name) : (int)strlen(name), name);
  return printed < 0 ? NULL : folder;
}

static cli_exit make_folder(report_job *job) { return cli_folder_make(job->folder, &job->is_made) ? CLI_DONE : CLI_IO; }

static cli_exit check_page(const report_job *job, neph_files *files, const char *name) {
  char *page;
  if (asprintf(&page, "%s/%s", job->folder, name) < 0) return CLI_INTERNAL;
  cli_exit exit = cli_check_target(job->session, page);
  if (!exit) exit = cli_files_add_output(job->session, files, name, page);
  free(page);
  return exit;
}

static cli_exit check_files(const report_job *job, const neph_scene *scene) {
  static const char *const names[] = {"report.html", "report.csv", "report.json"};
  neph_files *files;
  cli_exit exit = cli_files_begin(job->session, &files);
  for (size_t i = 0; !exit && i < sizeof names / sizeof *names; i++) exit = check_page(job, files, names[i]);
  return cli_files_end(files, scene, exit);
}

/* ---- The report ---- */

/* Loads a scene of the report, and checks the files of the first, before anything is rendered. */
static neph_result load_scene(void *user, neph_scene **out_scene) {
  report_job *job = user;
  neph_result result = cli_read_scene(job->session, job->session->options->files[0], out_scene);
  if (result || job->are_files_checked) return result;
  job->are_files_checked = true;
  if (!check_files(job, *out_scene)) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return NEPH_ERROR_INVALID_ARGUMENT;
}

static neph_result create(report_job *job) {
  const cli_options *options = job->session->options;
  const char *path = options->files[0], *slash = strrchr(path, '/');
  neph_report_desc desc = NEPH_REPORT_DESC_DEFAULT;
  desc.name = slash ? slash + 1 : path;
  desc.load = load_scene;
  desc.load_user = job;
  if (options->has_resolution) desc.width = options->resolution[0], desc.height = options->resolution[1];
  desc.reference = options->reference;
  desc.is_quick = options->is_quick;
  desc.budget_s = options->budget_s > 0.0 ? options->budget_s : options->is_quick ? quick_budget_s : budget_s;
  desc.progress = cli_progress_report;
  desc.progress_user = &job->session->progress;
  return neph_report_create(job->session->context, &desc, &job->report);
}

/* Whether at least one setting was measured. */
static bool has_rows(const neph_report *report) {
  neph_report_row row = NEPH_REPORT_ROW_DEFAULT;
  return !neph_report_get_row(report, 0, &row) && row.run_count > 0;
}

static neph_result save(report_job *job) {
  char *text;
  neph_result result = neph_report_save(job->report, job->folder);
  if (!result) result = neph_report_describe(job->report, cli_text_format(job->session), &text);
  if (result) return result;
  cli_print_text(job->session, text);
  if (!job->session->options->is_json) cli_say("%s/report.html", job->folder);
  return NEPH_OK;
}

/* Runs the report. A cancelled report is saved as far as it went, and marked. */
static neph_result run(report_job *job) {
  neph_result result = create(job);
  if (result) return result;
  result = neph_report_run(job->report);
  cli_progress_finish(&job->session->progress);
  const bool is_worth = !result || (result == NEPH_ERROR_CANCELLED && has_rows(job->report));
  const neph_result saved = is_worth ? save(job) : NEPH_OK;
  if (result && is_worth && !saved)
    cli_complain("cancelled: %s/report.html has what was measured by then", job->folder);
  return result ? result : saved;
}

static cli_exit check_options(const cli_options *options) {
  const char *what = options->is_calibrating ? "file" : "folder";
  if (options->output_count > 1) {
    cli_complain("--output of nephos report is given %zu times, must be one %s", options->output_count, what);
    return CLI_USAGE;
  }
  if (options->is_calibrating == (options->file_count == 0)) {
    if (options->is_calibrating || strcmp(options->files[0], "-")) return CLI_DONE;
    cli_complain("nephos report loads its scene again for each setting: give a file, not standard input");
    return CLI_USAGE;
  }
  cli_complain(options->is_calibrating ? "nephos report --calibrate takes no SCENE, %zu are given"
                                       : "nephos report takes a SCENE, or --calibrate; %zu are given",
               options->file_count);
  return CLI_USAGE;
}

static cli_exit run_scene(cli_session *session) {
  report_job job = {.session = session, .folder = name_folder(session->options)};
  if (!job.folder) return CLI_INTERNAL;
  cli_exit exit = make_folder(&job);
  if (!exit) exit = check_files(&job, NULL);
  if (!exit) exit = cli_exit_of(run(&job));
  if (exit && job.is_made) (void)rmdir(job.folder); /* rmdir leaves a folder with files */
  neph_report_destroy(job.report);
  free(job.folder);
  return exit;
}

static cli_exit run_report(cli_session *session) {
  const cli_exit exit = check_options(session->options);
  if (exit) return exit;
  cli_catch_interrupts();
  return session->options->is_calibrating ? cli_calibration_run(session) : run_scene(session);
}

const cli_verb cli_verb_report = {
    .name = "report",
    .arguments = "[SCENE]",
    .summary = "measure error against run time for a scene, or the speed of a machine",
    .argument_min = 0,
    .argument_max = 1,
    .run = run_report,
    .files = "yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_LIMIT),
    .description =
        "Renders a reference by the integrator path, and then the scene with one setting changed at a time: samples, "
        "step tolerance, method and cells of the multiple scattering, tables, precision, voxels. For each it measures "
        "CPU time and error, noise and bias apart.\n\n"
        "report.html is one page: the Pareto front of error against time, a curve for each setting with its order of "
        "convergence, pictures, and the cheapest settings for errors of 10, 3, 1 and 0.3 %. report.csv and "
        "report.json have the figures. The curves are drawn by gnuplot, where it is installed. A report that is "
        "interrupted is written as far as it went, and says so.\n\n"
        "With --calibrate no scene is given: a few small built-in scenes are rendered, and the time of each kind of "
        "work is written into a file that renders predict their time by.",
    .options = {{"--output", "write report.html, report.csv and report.json into the folder FILE", "SCENE.report", NULL,
                 "/"},
                {"--set"},
                {"--resolution", "size of the pictures in pixels", "160 wide, or the size of the reference"},
                {"--budget", NULL, "10m, with --quick 1m"},
                {"--reference"},
                {"--quick"},
                {"--calibrate"},
                {"--progress"}},
    .examples = {{"nephos report scene.yaml --quick --resolution 32x18 --budget 2s", "measure what two seconds allow"},
                 {"nephos report scene.yaml --resolution 32x18 --budget 3s -o measured --json", "print the figures"}},
};
