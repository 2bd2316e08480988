/* SPDX-License-Identifier: Apache-2.0 */
#include "options.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "option_values.h"
#include "suggest.h"

enum {
  SCENE_VERBS = CLI_BAKE | CLI_RENDER | CLI_SKY,
  EVERY_VERB = CLI_BAKE | CLI_RENDER | CLI_INFO | CLI_SKY | CLI_COMPARE | CLI_SCHEMA | CLI_PROBE
};

/* ---- What options do ---- */

struct option_row;

/* Takes an option, with its argument where it has one; false when the argument is not what the option takes. */
typedef bool (*take_fn)(cli_options *out, const struct option_row *option, const char *argument);

typedef struct option_row {
  const char *name;
  char letter;          /* 0: none */
  const char *argument; /* NULL: takes none */
  unsigned verbs;       /* of cli_verb */
  const char *meaning;
  take_fn take;
  size_t field;    /* of cli_options, for those that only fill one */
  const char *key; /* of the scene, for those that stand for one */
} option_row;

/* Storage for a changed copy of an argument, with room for what add_resolution adds. */
static char *copy_argument(cli_options *out, const char *argument) {
  char *copy = out->storage;
  strcpy(copy, argument);
  out->storage += strlen(argument) + 8;
  return copy;
}

static bool take_frames(cli_options *out, const option_row *option, const char *text) {
  (void)option;
  size_t count = 1;
  for (const char *c = text; *c; c++) count += *c == ',';
  free(out->frames);
  out->frames = calloc(count, sizeof *out->frames);
  if (!out->frames) return false;
  for (out->frame_range_count = 0; out->frame_range_count < count; out->frame_range_count++) {
    if (out->frame_range_count && *text++ != ',') return false;
    if (!cli_read_frame_range(&text, &out->frames[out->frame_range_count])) return false;
  }
  return !*text;
}

static bool take_tile(cli_options *out, const option_row *option, const char *text) {
  (void)option;
  unsigned tile[2];
  if (!cli_read_list(text, '/', 2, tile) || tile[0] < 1 || tile[0] > tile[1]) return false;
  out->tile_index = tile[0];
  out->tile_count = tile[1];
  return true;
}

static bool add_setting(cli_options *out, const char *option, const char *key, const char *value) {
  out->settings[out->setting_count++] = (cli_setting){key, value, option};
  return true;
}

/* Splits KEY=VALUE in place; `text` is a copy of ours. */
static bool add_assignment(cli_options *out, char *text) {
  char *mark = strchr(text, '=');
  if (!mark || mark == text) return false;
  *mark = '\0';
  return add_setting(out, NULL, text, mark + 1);
}

/* WxH as the list that camera.resolution takes. */
static bool add_resolution(cli_options *out, const char *option, char *text, const char *original) {
  unsigned size[2];
  if (!cli_read_list(original, 'x', 2, size)) return false;
  sprintf(text, "[%u, %u]", size[0], size[1]);
  return add_setting(out, option, "camera.resolution", text);
}

static void *find_field(cli_options *out, const option_row *option) { return (char *)out + option->field; }

static bool take_flag(cli_options *out, const option_row *option, const char *argument) {
  (void)argument;
  return *(bool *)find_field(out, option) = true;
}

static bool take_text(cli_options *out, const option_row *option, const char *argument) {
  *(const char **)find_field(out, option) = argument;
  return true;
}

static bool take_count(cli_options *out, const option_row *option, const char *argument) {
  unsigned *count = find_field(out, option);
  return cli_read_whole(argument, count) && *count >= 1;
}

/* No number of samples has none. */
static bool take_target_error(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  return cli_read_real(argument, &out->target_error) && out->target_error > 0.0;
}

static bool take_setting(cli_options *out, const option_row *option, const char *argument) {
  return add_setting(out, option->name, option->key, argument);
}

static bool take_output(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  out->outputs[out->output_count++] = argument;
  return true;
}

static bool take_assignment(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  return add_assignment(out, copy_argument(out, argument));
}

static bool take_resolution(cli_options *out, const option_row *option, const char *argument) {
  out->has_resolution = true;
  return add_resolution(out, option->name, copy_argument(out, argument), argument);
}

static bool take_crop(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  out->has_crop = true;
  return cli_read_list(argument, ',', 4, out->crop);
}

static bool take_prune(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  return cli_read_real(argument, &out->prune_per_m) && out->prune_per_m <= 100;
}

static bool take_levels(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  return cli_read_whole(argument, &out->level_count) && out->level_count >= 1 && out->level_count <= 8;
}

static bool take_region(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  out->has_region = true;
  return cli_read_region(argument, out->region_m);
}

static bool take_max_memory(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  out->has_memory_max = true;
  return cli_read_real(argument, &out->memory_max_gb);
}

static bool take_time_limit(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  out->has_time_limit = true;
  return cli_read_real(argument, &out->time_limit_s);
}

static bool take_relative_mse(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  out->has_relative_mse_max = true;
  return cli_read_real(argument, &out->relative_mse_max);
}

static bool take_isa(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  return cli_read_isa(argument, &out->isa);
}

static bool take_progress(cli_options *out, const option_row *option, const char *argument) {
  (void)option;
  return cli_read_progress(argument, &out->progress);
}

static bool take_verbose(cli_options *out, const option_row *option, const char *argument) {
  (void)option, (void)argument;
  out->log_level = NEPH_LOG_DEBUG;
  return true;
}

static bool take_quiet(cli_options *out, const option_row *option, const char *argument) {
  (void)option, (void)argument;
  out->log_level = NEPH_LOG_WARNING;
  out->progress = CLI_PROGRESS_NONE;
  return true;
}

/* ---- The table ---- */

#define INTO(member) offsetof(cli_options, member)

static const option_row options[] = {
    {"--output", 'o', "FILE", SCENE_VERBS | CLI_COMPARE | CLI_PROBE, "write to FILE, see docs/cli.md",
     .take = take_output},
    {"--set", 0, "KEY=VALUE", SCENE_VERBS | CLI_INFO, "set a key of the scene, as `nephos schema` lists them",
     .take = take_assignment},
    {"--frames", 0, "LIST", CLI_BAKE | CLI_RENDER, "frames such as 1-100x2,120 (default 1)", .take = take_frames},
    {"--resolution", 0, "WxH", CLI_RENDER | CLI_SKY, "size of the picture in pixels", .take = take_resolution},
    {"--crop", 0, "X0,Y0,X1,Y1", CLI_RENDER, "only these pixels, from the top left, the last two excluded",
     .take = take_crop},
    {"--tile", 0, "I/N", CLI_RENDER, "only the I-th of N bands of rows, 1 at the top", .take = take_tile},
    {"--samples", 0, "N", CLI_RENDER, "samples for each pixel", .take = take_setting, .key = "render.samples"},
    {"--seed", 0, "N", CLI_RENDER | CLI_PROBE, "seed of all random numbers", .take = take_setting,
     .key = "render.seed"},
    {"--integrator", 0, "NAME", CLI_RENDER | CLI_PROBE, "march or path", .take = take_setting,
     .key = "render.integrator"},
    {"--path-guiding", 0, "NAME", CLI_RENDER | CLI_PROBE,
     "of paths in clouds: none or adjoint; of a probe auto (default) too", .take = take_setting,
     .key = "render.path_guiding"},
    {"--method", 0, "NAME", CLI_PROBE, "of a sky: lut (default), march or trace", .take = take_text,
     .field = INTO(method)},
    {"--paths", 0, "N", CLI_PROBE | CLI_SKY, "camera rays for each number asked for (default 65536, of a sky 4096)",
     .take = take_count, .field = INTO(path_count)},
    {"--target-error", 0, "X", CLI_RENDER | CLI_PROBE,
     "as many samples or paths as give a relative standard error of X, above 0", .take = take_target_error},
    {"--time-limit", 0, "SECONDS", CLI_RENDER, "end each frame then, with the samples it has", .take = take_time_limit},
    {"--half", 0, NULL, CLI_BAKE, "values in the file as halves, not floats", .take = take_flag,
     .field = INTO(is_half)},
    {"--prune", 0, "X", CLI_BAKE, "leave out extinction of at most X 1/m", .take = take_prune},
    {"--levels", 0, "N", CLI_BAKE, "N grids, each with voxels twice as long as the one before", .take = take_levels},
    {"--region", 0, "BOX", CLI_BAKE, "only what lies in X0,Y0,Z0,X1,Y1,Z1, in metres", .take = take_region},
    {"--max-memory", 0, "GB", CLI_BAKE, "refuse a bake that may need more", .take = take_max_memory},
    {"--velocity", 0, NULL, CLI_BAKE, "add a grid `vel`: how wind and growth move the cloud, in m/s", .take = take_flag,
     .field = INTO(wants_velocity)},
    {"--error", 0, NULL, CLI_BAKE, "say what the file lost against the model evaluated directly", .take = take_flag,
     .field = INTO(wants_error)},
    {"--verify", 0, NULL, CLI_BAKE | CLI_SKY,
     "bake .vdb FILE anew, and fail (7) when it differs; of a sky: measure its tables", .take = take_flag,
     .field = INTO(is_verifying)},
    {"--tables", 0, "DIR", CLI_SKY, "write each table as a picture, .exr and .png, into the folder DIR",
     .take = take_text, .field = INTO(table_folder)},
    {"--explain", 0, NULL, CLI_RENDER, "print what would be done, and why, and stop", .take = take_flag,
     .field = INTO(wants_plan)},
    {"--dry-run", 'n', NULL, SCENE_VERBS, "check everything, print what would be written, and stop", .take = take_flag,
     .field = INTO(is_dry_run)},
    {"--exact", 0, NULL, CLI_COMPARE, "fail (7) when any value of any channel differs", .take = take_flag,
     .field = INTO(is_exact)},
    {"--max-rel-mse", 0, "X", CLI_COMPARE, "fail (7) when the relative MSE is above X", .take = take_relative_mse},
    {"--json", 0, NULL, EVERY_VERB, "results as JSON", .take = take_flag, .field = INTO(is_json)},
    {"--threads", 't', "N", EVERY_VERB, "threads to work with (default: the CPUs there are)", .take = take_count,
     .field = INTO(thread_count)},
    {"--isa", 0, "LEVEL", EVERY_VERB, "at most x86-64, x86-64-v3 or x86-64-v4", .take = take_isa},
    {"--progress", 0, "MODE", SCENE_VERBS | CLI_PROBE, "auto, bar, lines, json or none, on standard error",
     .take = take_progress},
    {"--verbose", 'v', NULL, EVERY_VERB, "more messages", .take = take_verbose},
    {"--quiet", 'q', NULL, EVERY_VERB, "warnings and errors only, no progress", .take = take_quiet},
    {"--help", 'h', NULL, EVERY_VERB, "this text", .take = take_flag, .field = INTO(wants_help)},
    {"--version", 0, NULL, EVERY_VERB, "print the version", .take = take_flag, .field = INTO(wants_version)},
};

typedef struct verb_row {
  cli_verb verb;
  const char *name, *operands, *meaning;
  size_t file_min, file_max;
} verb_row;

static const verb_row verbs[] = {
    {CLI_BAKE, "bake", "SCENE|FILE", "bake the procedural clouds of a scene to .vdb", 1, 1},
    {CLI_RENDER, "render", "SCENE", "render frames to OpenEXR and PNG", 1, 1},
    {CLI_INFO, "info", "FILE...", "say what is in .vdb, .hgt, .exr, .png and scene files", 1, SIZE_MAX},
    {CLI_SKY, "sky", "SCENE", "the sky alone: irradiances, and a latitude-longitude picture", 1, 1},
    {CLI_PROBE, "probe", "slab|sky CASES", "put questions with known answers to the integrators, as CSV", 2, 2},
    {CLI_COMPARE, "compare", "PICTURE REFERENCE", "measure how far an OpenEXR picture lies from another", 2, 2},
    {CLI_SCHEMA, "schema", "", "list every key of a scene", 0, 0},
};

static const size_t option_count = sizeof options / sizeof *options, verb_count = sizeof verbs / sizeof *verbs;

void cli_complain(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  flockfile(stderr);
  fputs("nephos: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  funlockfile(stderr);
  va_end(arguments);
}

static const verb_row *get_verb(cli_verb verb) {
  for (size_t i = 0; i < verb_count; i++)
    if (verbs[i].verb == verb) return &verbs[i];
  return NULL;
}

/* ---- Help ---- */

static void print_option(const option_row *option) {
  char left[48];
  snprintf(left, sizeof left, "%s%c%s%s%s%s", option->letter ? "-" : "   ", option->letter ? option->letter : ' ',
           option->letter ? ", " : "", option->name, option->argument ? " " : "",
           option->argument ? option->argument : "");
  printf("  %-26s %s\n", left, option->meaning);
}

static void print_program_help(void) {
  printf("usage: nephos VERB [SCENE|FILE...] [options]\n\nverbs:\n");
  for (size_t i = 0; i < verb_count; i++) printf("  %-10s %s\n", verbs[i].name, verbs[i].meaning);
  printf("\n`nephos VERB --help` lists the options of a verb. `-` is standard input.\n");
}

void cli_options_print_help(cli_verb verb) {
  const verb_row *row = get_verb(verb);
  if (!row) {
    print_program_help();
    return;
  }
  printf("usage: nephos %s%s%s [options]\n%s\n\noptions:\n", row->name, *row->operands ? " " : "", row->operands,
         row->meaning);
  for (size_t i = 0; i < option_count; i++)
    if (options[i].verbs & verb) print_option(&options[i]);
}

static const option_row *find_long_option(const char *text, size_t length) {
  for (size_t i = 0; i < option_count; i++)
    if (strlen(options[i].name) == length && !strncmp(options[i].name, text, length)) return &options[i];
  return NULL;
}

static const option_row *find_letter(char letter) {
  for (size_t i = 0; i < option_count; i++)
    if (letter && options[i].letter == letter) return &options[i];
  return NULL;
}

static cli_exit fail_unknown_option(const char *text) {
  const char *names[sizeof options / sizeof *options];
  for (size_t i = 0; i < option_count; i++) names[i] = options[i].name;
  const char *guess = cli_suggest(text, names, option_count);
  cli_complain("%s is not an option%s%s%s", text, guess ? ", did you mean " : "", guess ? guess : "", guess ? "?" : "");
  return CLI_USAGE;
}

/* Takes the option that begins argv[*index], with its argument, which may be the next. */
static cli_exit take_option(cli_options *out, int argc, char **argv, int *index) {
  const char *text = argv[*index], *value = NULL;
  bool is_long = text[1] == '-';
  size_t length = is_long ? strcspn(text, "=") : 2;
  const option_row *option = is_long ? find_long_option(text, length) : find_letter(text[1]);
  if (!option) return fail_unknown_option(text);
  out->given[option - options] = true;
  if (text[length]) value = text + length + (is_long ? 1 : 0);
  if (value && !option->argument) {
    cli_complain("%s takes no value, and is given %s", option->name, value);
    return CLI_USAGE;
  }
  if (option->argument && !value) {
    if (*index + 1 == argc) {
      cli_complain("%s needs %s behind it", option->name, option->argument);
      return CLI_USAGE;
    }
    value = argv[++*index];
  }
  if (option->take(out, option, value)) return CLI_DONE;
  cli_complain("%s is %s, must be %s: %s", option->name, value, option->argument, option->meaning);
  return CLI_USAGE;
}

static cli_exit take_verb(cli_options *out, const char *text) {
  const char *names[sizeof verbs / sizeof *verbs];
  for (size_t i = 0; i < verb_count; i++) {
    names[i] = verbs[i].name;
    if (!strcmp(text, names[i])) return out->verb = verbs[i].verb, CLI_DONE;
  }
  const char *guess = cli_suggest(text, names, verb_count);
  cli_complain("%s is not a verb%s%s%s", text, guess ? ", did you mean " : "", guess ? guess : "", guess ? "?" : "");
  return CLI_USAGE;
}

/* Options may stand before the verb: only now is it known whether they are its own. */
static cli_exit check_options(const cli_options *out, const verb_row *verb) {
  for (size_t i = 0; i < option_count; i++) {
    if (!out->given[i] || options[i].verbs & verb->verb) continue;
    cli_complain("%s is not an option of nephos %s", options[i].name, verb->name);
    return CLI_USAGE;
  }
  return CLI_DONE;
}

static cli_exit check_command(const cli_options *out) {
  const verb_row *verb = get_verb(out->verb);
  if (!verb) {
    cli_complain("no verb is given; `nephos --help` lists them");
    return CLI_USAGE;
  }
  cli_exit exit = check_options(out, verb);
  if (exit) return exit;
  if (out->file_count >= verb->file_min && out->file_count <= verb->file_max) return CLI_DONE;
  cli_complain("usage: nephos %s%s%s [options]", verb->name, *verb->operands ? " " : "", verb->operands);
  return CLI_USAGE;
}

/* ---- Command line ---- */

/* Lists as long as the command line: no argument adds more than one element. */
static bool allocate_lists(cli_options *out, int argc, char **argv, char **out_storage) {
  size_t count = (size_t)argc + 1, bytes = 1;
  for (int i = 0; i < argc; i++) bytes += strlen(argv[i]) + 8;
  out->files = calloc(count, sizeof *out->files);
  out->settings = calloc(count, sizeof *out->settings);
  out->outputs = calloc(count, sizeof *out->outputs);
  out->given = calloc(option_count, sizeof *out->given);
  *out_storage = out->storage = malloc(bytes);
  return out->files && out->settings && out->outputs && out->given && out->storage;
}

/* The verb is the first argument that is no option. */
static cli_exit read_arguments(cli_options *out, int argc, char **argv) {
  bool has_ended = false;
  for (int i = 1; i < argc; i++) {
    cli_exit exit = CLI_DONE;
    if (!has_ended && !strcmp(argv[i], "--"))
      has_ended = true;
    else if (!has_ended && argv[i][0] == '-' && argv[i][1])
      exit = take_option(out, argc, argv, &i);
    else if (!out->verb)
      exit = take_verb(out, argv[i]);
    else
      out->files[out->file_count++] = argv[i];
    if (exit) return exit;
  }
  return CLI_DONE;
}

cli_exit cli_options_read(int argc, char **argv, cli_options *out) {
  *out = (cli_options){.thread_count = NEPH_THREADS_ALL, .isa = NEPH_ISA_X86_64_V4, .log_level = NEPH_LOG_INFO};
  char *storage = NULL;
  if (!allocate_lists(out, argc, argv, &storage)) {
    cli_complain("out of memory");
    return CLI_INTERNAL;
  }
  cli_exit exit = read_arguments(out, argc, argv);
  out->storage = storage;
  if (exit || out->wants_help || out->wants_version) return exit;
  return check_command(out);
}

void cli_options_clear(cli_options *out) {
  free(out->files);
  free(out->settings);
  free(out->outputs);
  free(out->given);
  free(out->frames);
  free(out->storage);
}
