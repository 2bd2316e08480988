/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "command_files.h"
#include "print.h"
#include "verbs.h"

static const char *const integrators[] = {[NEPH_INTEGRATOR_MARCH] = "march", [NEPH_INTEGRATOR_PATH] = "path", NULL};
static const char *const guidings[] = {[NEPH_PATH_GUIDING_NONE] = "none",
                                       [NEPH_PATH_GUIDING_ADJOINT] = "adjoint",
                                       [NEPH_PATH_GUIDING_AUTO] = "auto",
                                       NULL};

/* The index of a setting's word. */
static cli_exit choose_word(const cli_setting *setting, const char *const *words, unsigned *out) {
  for (unsigned i = 0; words[i]; i++)
    if (!strcmp(setting->value, words[i])) return *out = i, CLI_DONE;
  char range[CLI_RANGE_SIZE];
  cli_option_describe_words(words, range, sizeof range);
  cli_complain("%s is %s, must be %s", setting->option, setting->value, range);
  return CLI_USAGE;
}

static cli_exit choose_seed(const char *text, uint64_t *out) {
  char *end;
  errno = 0;
  *out = strtoull(text, &end, 10);
  if (*text >= '0' && *text <= '9' && !*end && !errno) return CLI_DONE;
  cli_complain("--seed is %s, must be a whole number from 0 to %" PRIu64, text, UINT64_MAX);
  return CLI_USAGE;
}

static cli_exit refuse_option(const char *option, const char *question) {
  cli_complain("%s is not an option of nephos probe %s", option, question);
  return CLI_USAGE;
}

static cli_exit take_setting(const cli_setting *setting, neph_probe_desc *desc) {
  const char *option = setting->option ? setting->option : "--set";
  if (!strcmp(option, "--integrator")) return choose_word(setting, integrators, &desc->integrator);
  if (!strcmp(option, "--path-guiding")) return choose_word(setting, guidings, &desc->path_guiding);
  if (!strcmp(option, "--seed")) return choose_seed(setting->value, &desc->seed);
  return refuse_option(option, "slab");
}

/* Fills the description of a probe. Options that elsewhere set keys of a scene set its members, since there is no
 * scene. */
static cli_exit fill_desc(cli_session *session, neph_probe_desc *desc) {
  const cli_options *options = session->options;
  if (options->path_count) desc->path_count = options->path_count;
  if (options->target_error > 0.0) desc->target_error = options->target_error;
  desc->progress = cli_progress_report;
  desc->progress_user = &session->progress;
  cli_exit exit = CLI_DONE;
  for (size_t i = 0; !exit && i < options->setting_count; i++) exit = take_setting(&options->settings[i], desc);
  return exit;
}

static cli_exit check_target(const cli_session *session) {
  const cli_exit exit = cli_check_target(session, session->options->outputs[0]);
  return exit ? exit : cli_files_check_output(session);
}

static cli_exit check_output(const cli_session *session) {
  const cli_options *options = session->options;
  if (!options->output_count) return CLI_DONE;
  if (options->output_count == 1 && cli_has_extension(options->outputs[0], ".csv")) return check_target(session);
  cli_complain("--output of nephos probe must be one .csv");
  return CLI_USAGE;
}

/* Prints the result of a probe, or saves it. */
static cli_exit deliver(cli_session *session, neph_result result, char *text) {
  const cli_options *options = session->options;
  cli_progress_finish(&session->progress);
  if (result) return cli_exit_of(result);
  if (!options->output_count) return cli_print_text(session, text), CLI_DONE;
  result = neph_text_save(session->context, text, options->outputs[0]);
  neph_text_destroy(session->context, text);
  return cli_exit_of(result);
}

static cli_exit probe_slab(cli_session *session) {
  if (session->options->method) return refuse_option("--method", "slab");
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  cli_exit exit = fill_desc(session, &desc);
  if (exit) return exit;
  cli_catch_interrupts();
  char *text;
  neph_result result = neph_probe_slab(session->context, session->options->files[1], &desc, &text);
  return deliver(session, result, text);
}

/* `name` is one of the option's words, or NULL. */
static void choose_method(const char *name, neph_sky_method *out) {
  static const char *const names[] = {
      [NEPH_SKY_METHOD_LUT] = "lut", [NEPH_SKY_METHOD_MARCH] = "march", [NEPH_SKY_METHOD_TRACE] = "trace"};
  for (int i = NEPH_SKY_METHOD_LUT; name && i <= NEPH_SKY_METHOD_TRACE; i++)
    if (!strcmp(name, names[i])) *out = (neph_sky_method)i;
}

static cli_exit take_sky_setting(const cli_setting *setting, neph_probe_sky_desc *desc) {
  const char *option = setting->option ? setting->option : "--set";
  return strcmp(option, "--seed") ? refuse_option(option, "sky") : choose_seed(setting->value, &desc->seed);
}

static cli_exit fill_sky_desc(cli_session *session, neph_probe_sky_desc *desc) {
  const cli_options *options = session->options;
  if (options->target_error > 0.0) return refuse_option("--target-error", "sky");
  if (options->path_count) desc->path_count = options->path_count;
  desc->progress = cli_progress_report;
  desc->progress_user = &session->progress;
  choose_method(options->method, &desc->method);
  cli_exit exit = CLI_DONE;
  for (size_t i = 0; !exit && i < options->setting_count; i++) exit = take_sky_setting(&options->settings[i], desc);
  return exit;
}

static cli_exit probe_sky(cli_session *session) {
  if (session->options->target_error > 0.0) {
    cli_complain("--target-error is not an option of nephos probe sky");
    return CLI_USAGE;
  }
  neph_probe_sky_desc desc = NEPH_PROBE_SKY_DESC_DEFAULT;
  cli_exit exit = fill_sky_desc(session, &desc);
  if (exit) return exit;
  cli_catch_interrupts();
  char *text;
  neph_result result = neph_probe_sky(session->context, session->options->files[1], &desc, &text);
  return deliver(session, result, text);
}

static cli_exit run_probe(cli_session *session) {
  const char *question = session->options->files[0];
  cli_exit exit = check_output(session);
  if (exit) return exit;
  if (!strcmp(question, "slab")) return probe_slab(session);
  if (!strcmp(question, "sky")) return probe_sky(session);
  cli_complain("%s is not a probe, must be slab or sky", question);
  return CLI_USAGE;
}

const cli_verb cli_verb_probe = {
    .name = "probe",
    .arguments = "slab|sky CASES",
    .summary = "compute benchmark cases of light transport, as CSV",
    .argument_min = 2,
    .argument_max = 2,
    .run = run_probe,
    .words = "slab sky",
    .files = "csv",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND),
    .description = "`probe slab` sends the light of plane-parallel slabs of cloud through the integrators that render "
                   "pictures, for comparison with tables of radiative transfer. `probe sky` computes clear skies from "
                   "the tables that pictures use, by a march along the ray, or by the tracer.\n\n"
                   "CASES is a table of comma-separated values, a case in each row; lines that begin with # are "
                   "comments. The answer repeats every column and adds the results with their standard errors.",
    .options =
        {{"--output", "write the answer to FILE, a .csv", .files = "csv"},
         {"--integrator", "for a slab: the integrator; the standard error of march does not show its bias", "path"},
         {"--path-guiding",
          "for a slab: adjoint: guiding, splitting and roulette by the march's solution; auto: for the results "
          "that pilots find faster with it",
          "auto", guidings},
         {"--method"},
         {"--paths", NULL, "65536"},
         {"--target-error",
          "for a slab: take as many rays as bring the standard error to this part of the scattered light, at most "
          "--paths"},
         {"--seed"},
         {"--progress"}},
    .examples = {{"nephos probe slab slabs.csv --paths 64", "fluxes of slabs"},
                 {"nephos probe sky skies.csv --method march", "radiances of clear skies by quadrature"}},
};
