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

static cli_exit take_setting(const cli_setting *setting, const char *question, neph_probe_desc *desc) {
  const char *option = setting->option ? setting->option : "--set";
  if (!strcmp(option, "--integrator")) return choose_word(setting, integrators, &desc->integrator);
  if (!strcmp(option, "--path-guiding")) return choose_word(setting, guidings, &desc->path_guiding);
  if (!strcmp(option, "--seed")) return choose_seed(setting->value, &desc->seed);
  return refuse_option(option, question);
}

/* Fills the description of a probe. Options that elsewhere set keys of a scene set its members, since there is no
 * scene. */
static cli_exit fill_desc(cli_session *session, const char *question, neph_probe_desc *desc) {
  const cli_options *options = session->options;
  if (options->method) return refuse_option("--method", question);
  if (options->path_count) desc->path_count = options->path_count;
  if (options->target_error > 0.0) desc->target_error = options->target_error;
  desc->progress = cli_progress_report;
  desc->progress_user = &session->progress;
  cli_exit exit = CLI_DONE;
  for (size_t i = 0; !exit && i < options->setting_count; i++)
    exit = take_setting(&options->settings[i], question, desc);
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
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  cli_exit exit = fill_desc(session, "slab", &desc);
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

static cli_exit probe_i3rc(cli_session *session) {
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  cli_exit exit = fill_desc(session, "i3rc", &desc);
  if (exit) return exit;
  for (size_t i = 0; i < session->options->setting_count; i++)
    if (session->options->settings[i].option && !strcmp(session->options->settings[i].option, "--path-guiding"))
      return refuse_option("--path-guiding", "i3rc");
  cli_catch_interrupts();
  char *text;
  neph_result result = neph_probe_i3rc(session->context, session->options->files[1], &desc, &text);
  return deliver(session, result, text);
}

/* ---- Fields ---- */

enum { HEIGHTS_MAX = 256 };

/* Reads numbers with commas in between. */
static cli_exit read_heights(const char *text, double out[HEIGHTS_MAX], unsigned *out_count) {
  for (const char *at = text; at && *out_count < HEIGHTS_MAX;) {
    char *end;
    out[(*out_count)++] = strtod(at, &end);
    if (end == at || (*end && *end != ',')) break;
    if (!*end) return CLI_DONE;
    at = end + 1;
  }
  if (text)
    cli_complain("--heights is %s, must be up to %d numbers with commas in between, such as 0,1500,3e3", text,
                 HEIGHTS_MAX);
  else
    cli_complain("nephos probe field needs --heights, such as 0,1500,3e3");
  return CLI_USAGE;
}

/* The integrator and the seed of a probe; other settings are keys of the scene. */
static cli_exit take_field_setting(const cli_setting *setting, neph_probe_field_desc *desc) {
  const char *option = setting->option ? setting->option : "--set";
  if (!strcmp(option, "--integrator")) return choose_word(setting, integrators, &desc->integrator);
  if (!strcmp(option, "--seed")) return choose_seed(setting->value, &desc->seed);
  return strcmp(option, "--set") ? refuse_option(option, "field") : CLI_DONE;
}

static cli_exit fill_field_desc(cli_session *session, double *heights, neph_probe_field_desc *desc) {
  const cli_options *options = session->options;
  if (options->method) return refuse_option("--method", "field");
  cli_exit exit = read_heights(options->heights, heights, &desc->height_count);
  desc->heights_m = heights;
  if (options->path_count) desc->path_count = options->path_count;
  if (options->target_error > 0.0) desc->target_error = options->target_error;
  if (options->has_frame) desc->frame = options->frame;
  for (int a = 0; a < 2 && options->has_region; a++) {
    desc->box_min_m[a] = options->region_m[a];
    desc->box_max_m[a] = options->region_m[3 + a];
  }
  desc->progress = cli_progress_report;
  desc->progress_user = &session->progress;
  for (size_t i = 0; !exit && i < options->setting_count; i++) exit = take_field_setting(&options->settings[i], desc);
  return exit;
}

static cli_exit probe_field(cli_session *session) {
  neph_probe_field_desc desc = NEPH_PROBE_FIELD_DESC_DEFAULT;
  double heights[HEIGHTS_MAX];
  neph_scene *scene = NULL;
  cli_exit exit = fill_field_desc(session, heights, &desc);
  if (!exit) exit = cli_load_scene(session, session->options->files[1], &scene);
  if (exit) return exit;
  cli_catch_interrupts();
  char *text;
  const neph_result result = neph_probe_field(scene, &desc, &text);
  neph_scene_destroy(scene);
  return deliver(session, result, text);
}

/* Kinds of probe. */
static const struct {
  const char *name;
  cli_exit (*run)(cli_session *session);
} probes[] = {{"slab", probe_slab}, {"sky", probe_sky}, {"field", probe_field}, {"i3rc", probe_i3rc}};

static cli_exit run_probe(cli_session *session) {
  const char *question = session->options->files[0];
  cli_exit exit = check_output(session);
  if (exit) return exit;
  for (size_t i = 0; i < sizeof probes / sizeof *probes; i++)
    if (!strcmp(question, probes[i].name)) return probes[i].run(session);
  cli_complain("%s is not a probe, must be slab, sky, field or i3rc", question);
  return CLI_USAGE;
}

const cli_verb cli_verb_probe = {
    .name = "probe",
    .arguments = "slab|sky|field|i3rc INPUT",
    .summary = "compute benchmark cases of light transport, as CSV",
    .argument_min = 2,
    .argument_max = 2,
    .run = run_probe,
    .words = "slab sky field i3rc",
    .files = "csv",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND),
    .description =
        "`probe slab` sends the light of plane-parallel slabs of cloud through the integrators that render "
        "pictures, for comparison with tables of radiative transfer. `probe sky` computes clear skies from "
        "the tables that pictures use, by a march along the ray, or by the tracer.\n\n"
        "INPUT of these is a table of comma-separated values, a case in each row; lines that begin with # are "
        "comments. The answer repeats every column and adds the results with their standard errors.\n\n"
        "`probe field` computes the light that passes up and down through level planes of the scene INPUT, "
        "and the light that its clouds absorb between them.\n\n"
        "`probe i3rc` computes the step cloud and the Landsat cloud of the Intercomparison of 3D Radiation "
        "Codes, whose inputs and results are in the folder INPUT, and compares domain means and columns with them.",
    .options = {{"--output", "write the answer to FILE, a .csv", .files = "csv"},
                {"--integrator",
                 "for slab, field and i3rc: the integrator; the standard error of march does not show its bias",
                 "path"},
                {"--path-guiding",
                 "for a slab: adjoint: guiding, splitting and roulette by the march's solution; auto: for the results "
                 "that pilots find faster with it",
                 "auto", guidings},
                {"--method"},
                {"--paths", NULL, "65536"},
                {"--target-error", "for slab, field and i3rc: take as many rays as bring the standard error to this "
                                   "part of the light, at most --paths"},
                {"--heights", "for a field: heights of its planes in metres, with commas in between"},
                {"--region", "for a field: the rectangle of its planes; its heights do not count", "the clouds' box"},
                {"--frame", "for a field: frame of the scene"},
                {"--set", "for a field: set a key of the scene as if the file had it"},
                {"--seed"},
                {"--progress"}},
    .examples = {{"nephos probe slab slabs.csv --paths 64", "fluxes of slabs"},
                 {"nephos probe sky skies.csv --method march", "radiances of clear skies by quadrature"},
                 {"nephos probe field scene.yaml --heights 3000,0", "light through two planes of a scene"},
                 {"nephos probe i3rc i3rc --paths 4096", "fluxes and radiances of the I3RC"}},
};
