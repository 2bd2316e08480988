/* SPDX-License-Identifier: Apache-2.0 */
#include <nephos/cloud.h>
#include <nephos/render.h>
#include <nephos/textures.h>

#include "option_table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "option_values.h"
#include "print.h"

/* ---- Takers ---- */

/* Storage for a changed copy of an argument. */
static char *copy_argument(cli_options *out, const char *argument) {
  char *copy = out->storage;
  strcpy(copy, argument);
  out->storage += strlen(argument) + 1;
  return copy;
}

enum { FRAMES_MAX = 100000, THREADS_MAX = 1024 };

/* Whether few enough frames are listed: more would take minutes to list before the first is rendered. */
static bool are_few(const cli_options *options) {
  int64_t count = 0;
  for (size_t i = 0; i < options->frame_range_count; i++) {
    const cli_frame_range *range = &options->frames[i];
    count += ((int64_t)range->last - range->first) / range->step + 1;
  }
  return count <= FRAMES_MAX;
}

static bool take_frames(cli_options *out, const cli_option *option, const char *text) {
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
  return !*text && are_few(out);
}

static bool take_frame(cli_options *out, const cli_option *option, const char *text) {
  (void)option;
  cli_frame_range range;
  out->has_frame = cli_read_frame_range(&text, &range) && !*text && range.first == range.last;
  out->frame = out->has_frame ? range.first : 0;
  return out->has_frame;
}

static bool take_tile(cli_options *out, const cli_option *option, const char *text) {
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

/* Splits KEY=VALUE in place; `text` is a copy owned by the options. */
static bool add_assignment(cli_options *out, char *text) {
  char *mark = strchr(text, '=');
  if (!mark || mark == text) return false;
  *mark = '\0';
  return add_setting(out, NULL, text, mark + 1);
}

static void *get_field(cli_options *out, const cli_option *option) { return (char *)out + option->field; }

static bool take_flag(cli_options *out, const cli_option *option, const char *argument) {
  (void)argument;
  return *(bool *)get_field(out, option) = true;
}

static bool take_text(cli_options *out, const cli_option *option, const char *argument) {
  *(const char **)get_field(out, option) = argument;
  return *argument;
}

/* Takes one of the option's words unchanged. */
static bool take_choice(cli_options *out, const cli_option *option, const char *argument) {
  for (unsigned i = 0; option->words[i]; i++)
    if (!strcmp(argument, option->words[i])) return take_text(out, option, argument);
  return false;
}

static bool take_count(cli_options *out, const cli_option *option, const char *argument) {
  unsigned *count = get_field(out, option);
  return cli_read_whole(argument, count) && *count >= 1;
}

static bool take_threads(cli_options *out, const cli_option *option, const char *argument) {
  return take_count(out, option, argument) && out->thread_count <= THREADS_MAX;
}

/* Takes a target error; one without a number represents no target. */
static bool take_target_error(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  return cli_read_real(argument, &out->target_error) && out->target_error > 0.0;
}

static bool take_setting(cli_options *out, const cli_option *option, const char *argument) {
  return add_setting(out, option->name, option->key, argument);
}

static bool take_output(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->outputs[out->output_count++] = argument;
  return *argument;
}

static bool take_assignment(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  return add_assignment(out, copy_argument(out, argument));
}

static bool take_resolution(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_resolution = true;
  return cli_read_list(argument, 'x', 2, out->resolution);
}

static bool take_crop(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_crop = true;
  return cli_read_list(argument, ',', 4, out->crop);
}

static bool take_sample_range(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_sample_range = true;
  const unsigned *range = out->sample_range;
  return cli_read_list(argument, '-', 2, out->sample_range) && range[0] < range[1] && range[1] < NEPH_SAMPLES_ALL;
}

static bool take_checkpoint(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->checkpoint = argument;
  return cli_read_duration(argument, &out->checkpoint_s);
}

static bool take_prune(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  return cli_read_real(argument, &out->prune_per_m) && out->prune_per_m <= 100;
}

static bool take_levels(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  return cli_read_whole(argument, &out->level_count) && out->level_count >= 1 && out->level_count <= 8;
}

static bool take_texture_size(cli_options *out, const cli_option *option, const char *argument) {
  return take_count(out, option, argument) && out->texture_size >= NEPH_TEXTURE_SIZE_MIN &&
         out->texture_size <= NEPH_TEXTURE_SIZE_MAX;
}

static bool take_region(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_region = true;
  return cli_read_region(argument, out->region_m);
}

static bool take_max_memory(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  double gb;
  if (!cli_read_real(argument, &gb)) return false;
  out->has_memory_max = true;
  out->memory_max_bytes = gb < 1e9 ? (uint64_t)(gb * 1e9) : NEPH_MEMORY_UNLIMITED;
  return true;
}

static bool take_cache_size(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  double gb;
  if (!cli_read_real(argument, &gb)) return false;
  out->cache_size_max_bytes = gb < 1e9 ? (uint64_t)(gb * 1e9) : UINT64_MAX;
  return true;
}

static bool take_time_limit(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_time_limit = true;
  return cli_read_real(argument, &out->time_limit_s);
}

static bool take_port(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  return cli_read_whole(argument, &out->port) && out->port <= UINT16_MAX;
}

static bool take_budget(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  return cli_read_duration(argument, &out->budget_s);
}

static bool take_center(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_center = true;
  return cli_read_real(argument, &out->center_deg) && out->center_deg <= 360.0;
}

static bool take_relative_mse(cli_options *out, const cli_option *option, const char *argument) {
  (void)option;
  out->has_relative_mse_max = true;
  return cli_read_real(argument, &out->relative_mse_max);
}

/* Takes a word as its index in an enumeration. */
static bool take_word(cli_options *out, const cli_option *option, const char *argument) {
  for (unsigned i = 0; option->words[i]; i++)
    if (!strcmp(argument, option->words[i])) return *(unsigned *)get_field(out, option) = i, true;
  return false;
}

static bool take_verbose(cli_options *out, const cli_option *option, const char *argument) {
  (void)option, (void)argument;
  out->log_level = NEPH_LOG_DEBUG;
  return true;
}

static bool take_quiet(cli_options *out, const cli_option *option, const char *argument) {
  (void)option, (void)argument;
  out->log_level = NEPH_LOG_WARNING;
  out->progress = CLI_PROGRESS_NONE;
  return true;
}

/* ---- The table ---- */

#define INTO(member) offsetof(cli_options, member)

static const char *const integrators[] = {"march", "path", NULL};
static const char *const qualities[] = {"draft", "preview", "final", "reference", NULL};
static const char *const guidings[] = {"none", "adjoint", NULL};
static const char *const sky_disks[] = {"include", "layer", "none", NULL};
static const char *const sky_methods[] = {"lut", "march", "trace", NULL};
static const char *const export_uses[] = {"clouds", "textures", NULL};
static const char *const texture_files[] = {"ktx2", "raw", NULL};
static const char *const isa_levels[] = {
    [NEPH_ISA_X86_64] = "x86-64", [NEPH_ISA_X86_64_V3] = "x86-64-v3", [NEPH_ISA_X86_64_V4] = "x86-64-v4", NULL};
static const char *const progress_modes[] = {[CLI_PROGRESS_AUTO] = "auto",   [CLI_PROGRESS_BAR] = "bar",
                                             [CLI_PROGRESS_LINES] = "lines", [CLI_PROGRESS_JSON] = "json",
                                             [CLI_PROGRESS_ALF] = "alf",     [CLI_PROGRESS_OPENJD] = "openjd",
                                             [CLI_PROGRESS_NONE] = "none",   NULL};
static const char *const shells[] = {"bash", "fish", "zsh", NULL};

/* clang-format off */
static const cli_option options[] = {
    {.name = "--output", .letter = 'o', .argument = "FILE", .take = take_output, .files = "",
     .meaning = "write to FILE"},
    {.name = "--set", .argument = "KEY=VALUE", .take = take_assignment,
     .range = "a key as `nephos schema` lists them, = and its value",
     .meaning = "set a key of the scene as if the file had it; may be repeated"},
    {.name = "--frames", .argument = "LIST", .take = take_frames, .fallback = "1",
     .range = "numbers, and ranges with or without a step, such as 1-100x2,120 or -10--1; at most 100000 frames",
     .meaning = "frames to compute"},
    {.name = "--frame", .argument = "N", .take = take_frame, .range = "a whole number", .fallback = "1",
     .meaning = "frame for the values of animated keys"},
    {.name = "--resolution", .argument = "WxH", .take = take_resolution, .range = "two whole numbers from 1 to 65536",
     .fallback = "as in the scene", .meaning = "size of the picture in pixels"},
    {.name = "--crop", .argument = "X0,Y0,X1,Y1", .take = take_crop, .range = "four whole numbers",
     .meaning = "render these pixels alone, from the top left, the last two excluded"},
    {.name = "--tile", .argument = "I/N", .take = take_tile, .range = "I from 1 to N",
     .meaning = "render the I-th of N bands of rows, 1 at the top"},
    {.name = "--tiles", .argument = "N", .take = take_count, .field = INTO(shard_count),
     .range = "a whole number from 1", .fallback = "1", .meaning = "tiles of each frame"},
    {.name = "--chunk", .argument = "N", .take = take_count, .field = INTO(chunk_size),
     .range = "a whole number from 1", .fallback = "1", .meaning = "frames of a task"},
    {.name = "--sample-range", .argument = "A-B", .take = take_sample_range,
     .range = "two whole numbers, the first below the second",
     .meaning = "render the samples from A, a multiple of 16, up to B, which is excluded, into a part"},
    {.name = "--checkpoint", .argument = "TIME", .take = take_checkpoint, .range = "a time above 0, as 60s, 5m or 1h",
     .meaning = "save the samples of a frame every TIME, and on SIGTERM, to an .npart beside it"},
    {.name = "--resume", .take = take_flag, .field = INTO(is_resumed),
     .meaning = "continue from a frame's checkpoint, if there is one of the same scene and settings"},
    {.name = "--skip-existing", .take = take_flag, .field = INTO(skips_existing),
     .meaning = "skip frames whose file is complete and, by its header, of the same scene and settings"},
    {.name = "--samples", .argument = "N", .take = take_setting, .key = "render.samples",
     .meaning = "samples per pixel"},
    {.name = "--seed", .argument = "N", .take = take_setting, .key = "render.seed",
     .meaning = "seed of all random numbers"},
    {.name = "--integrator", .argument = "NAME", .take = take_setting, .key = "render.integrator",
     .words = integrators, .meaning = "march is fast and biased, path is unbiased and noisy"},
    {.name = "--quality", .argument = "NAME", .take = take_setting, .key = "render.quality", .words = qualities,
     .meaning = "preset of settings, which set keys override: draft for visual checks, reference without bias"},
    {.name = "--path-guiding", .argument = "NAME", .take = take_setting, .key = "render.path_guiding",
     .words = guidings, .meaning = "adjoint: guiding, splitting and roulette in clouds by the march's solution"},
    {.name = "--method", .argument = "NAME", .take = take_choice, .field = INTO(method), .words = sky_methods,
     .fallback = "lut", .meaning = "for a sky: tables, order 1 by quadrature, or a Monte Carlo"},
    {.name = "--paths", .argument = "N", .take = take_count, .field = INTO(path_count),
     .range = "a whole number from 1",
     .meaning = "camera rays for each result, rounded up to a multiple of 64"},
    {.name = "--heights", .argument = "LIST", .take = take_text, .field = INTO(heights),
     .meaning = "heights of planes in metres, with commas in between"},
    {.name = "--target-error", .argument = "X", .take = take_target_error, .range = "a number above 0",
     .meaning = "take enough samples for a relative error of X"},
    {.name = "--time-limit", .argument = "SECONDS", .take = take_time_limit, .range = "a number from 0",
     .fallback = "as in the scene", .meaning = "end each frame then, with the samples it has"},
    {.name = "--half", .take = take_flag, .field = INTO(is_half),
     .meaning = "write values as halves, not floats"},
    {.name = "--prune", .argument = "X", .take = take_prune, .range = "a number in [0, 100]", .fallback = "0",
     .meaning = "leave out extinction of at most X 1/m"},
    {.name = "--levels", .argument = "N", .take = take_levels, .range = "a whole number from 1 to 8", .fallback = "1",
     .meaning = "write N grids, each with voxels twice as long as the one before"},
    {.name = "--region", .argument = "X0,Y0,Z0,X1,Y1,Z1", .take = take_region,
     .range = "six numbers, the first three below the last", .fallback = "the whole field",
     .meaning = "bake this box of the world alone, in metres"},
    {.name = "--max-memory", .argument = "GB", .take = take_max_memory, .range = "a number from 0",
     .fallback = "none", .meaning = "refuse, with exit code 6, more memory than this"},
    {.name = "--cache", .argument = "DIR", .take = take_text, .field = INTO(cache_dir), .files = "/",
     .meaning = "cache light, bakes, ridges and tables of the air in the folder DIR, for later renders"},
    {.name = "--cache-size", .argument = "GB", .take = take_cache_size, .range = "a number from 0", .fallback = "4",
     .meaning = "size of the folder of --cache, beyond which the least recently used entries are removed"},
    {.name = "--velocity", .take = take_flag, .field = INTO(wants_velocity),
     .meaning = "add a grid `vel`: velocities of the cloud by wind and growth, in m/s"},
    {.name = "--error", .take = take_flag, .field = INTO(wants_error),
     .meaning = "measure the losses of the file against the model evaluated directly"},
    {.name = "--preview-map", .argument = "FILE", .take = take_text, .field = INTO(preview_map), .files = "png",
     .meaning = "write the weather map from above to FILE, a .png, or into the folder FILE"},
    {.name = "--verify", .take = take_flag, .field = INTO(is_verifying),
     .meaning = "compare with a second computation"},
    {.name = "--tables", .argument = "DIR", .take = take_text, .field = INTO(table_folder), .files = "/",
     .meaning = "write each table of air and sky as a picture, .exr and .png, into the folder DIR"},
    {.name = "--disks", .argument = "WHERE", .take = take_choice, .field = INTO(disks), .words = sky_disks,
     .fallback = "include", .meaning = "disks of sun and moon: in R, G, B; in a layer `disk`; left out"},
    {.name = "--center", .argument = "AZIMUTH", .take = take_center, .range = "a number in [0, 360]",
     .fallback = "180", .meaning = "azimuth in the middle of the picture, degrees clockwise from north"},
    {.name = "--usd", .argument = "FILE", .take = take_text, .field = INTO(usd_path), .files = "usda",
     .meaning = "write the sky's picture as a dome light, sun, moon and camera to FILE, a .usda"},
    {.name = "--for", .argument = "USE", .take = take_choice, .field = INTO(export_use), .words = export_uses,
     .fallback = "clouds",
     .meaning = "write clouds as volumes, or textures for renderers in real time, with a textures.json"},
    {.name = "--format", .argument = "NAME", .take = take_choice, .field = INTO(texture_file), .words = texture_files,
     .fallback = "ktx2", .meaning = "format of textures: Khronos texture 2.0, or texels alone"},
    {.name = "--size", .argument = "N", .take = take_texture_size, .field = INTO(texture_size),
     .range = "a whole number from 16 to 1024", .fallback = "128",
     .meaning = "voxels along the longest edge of textures of a cloud's distances and optical depths, at most"},
    {.name = "--budget", .argument = "TIME", .take = take_budget, .range = "a number above 0, with s, m or h",
     .fallback = "10m", .meaning = "time for the whole report; settings that do not fit are left out and listed"},
    {.name = "--reference", .argument = "FILE", .take = take_text, .field = INTO(reference), .files = "exr",
     .fallback = "one is made", .meaning = "picture of the scene to measure against, best with standard_error"},
    {.name = "--quick", .take = take_flag, .field = INTO(is_quick),
     .meaning = "measure few values of each knob, within a minute"},
    {.name = "--calibrate", .take = take_flag, .field = INTO(is_calibrating),
     .meaning = "measure the speed of this machine instead, for predictions of time"},
    {.name = "--machine", .argument = "FILE", .take = take_text, .field = INTO(machine), .files = "json",
     .fallback = "nephos/machine.json in $XDG_CACHE_HOME or ~/.cache, if it is there",
     .meaning = "predict time by FILE, which `nephos report --calibrate` wrote"},
    {.name = "--explain", .take = take_flag, .field = INTO(wants_plan),
     .meaning = "print the stages that would run, and the reasons, and stop"},
    {.name = "--dry-run", .letter = 'n', .take = take_flag, .field = INTO(is_dry_run),
     .meaning = "check everything, print the names of the files that would be written, and stop"},
    {.name = "--fix", .take = take_flag, .field = INTO(is_fixed),
     .meaning = "write a copy, by --output, with repaired values: what is not finite, negative or subnormal becomes "
                "0, as does a density's background; other grids and metadata are kept"},
    {.name = "--exact", .take = take_flag, .field = INTO(is_exact),
     .meaning = "fail, with exit code 7, when any value of any channel differs"},
    {.name = "--max-rel-mse", .argument = "X", .take = take_relative_mse, .range = "a number from 0",
     .meaning = "fail, with exit code 7, when the relative mean square error is above X"},
    {.name = "--second", .argument = "FILE", .take = take_text, .field = INTO(second), .files = "exr",
     .meaning = "tell noise from bias by FILE, the same picture with another seed"},
    {.name = "--port", .argument = "N", .take = take_port, .range = "a whole number from 0 to 65535",
     .fallback = "0: a free one", .meaning = "port of the page"},
    {.name = "--listen", .argument = "ADDRESS", .take = take_text, .field = INTO(listen),
     .range = "a numeric address of this machine", .fallback = "127.0.0.1",
     .meaning = "serve the page there: other machines reach any address but those of the loopback interface"},
    {.name = "--open", .take = take_flag, .field = INTO(opens_browser), .meaning = "start a browser, by xdg-open"},
    {.name = "--allow-files", .take = take_flag, .field = INTO(allows_files),
     .meaning = "let the page set keys that name files"},
    {.name = "--man", .take = take_flag, .field = INTO(wants_man), .meaning = "print as a man page"},
    {.name = "--completion", .argument = "SHELL", .take = take_choice, .field = INTO(shell), .words = shells,
     .meaning = "print a script that completes the command line in a shell"},
    {.name = "--json", .take = take_flag, .field = INTO(is_json), .is_common = true,
     .meaning = "print results as JSON"},
    {.name = "--threads", .letter = 't', .argument = "N", .take = take_threads, .field = INTO(thread_count),
     .is_common = true, .range = "a whole number from 1 to 1024",
     .fallback = "SLURM_CPUS_PER_TASK, or the CPUs that the process may use",
     .meaning = "threads to work with"},
    {.name = "--isa", .argument = "LEVEL", .take = take_word, .field = INTO(isa), .words = isa_levels,
     .is_common = true, .fallback = "the machine's", .meaning = "highest instruction-set level of the kernels"},
    {.name = "--progress", .argument = "MODE", .take = take_word, .field = INTO(progress), .words = progress_modes,
     .fallback = "auto", .meaning = "progress on standard error; auto: a bar on a terminal, else lines"},
    {.name = "--path-mapping", .argument = "FILE", .take = take_text, .field = INTO(path_mapping), .files = "json",
     .meaning = "map names of files in the scene by the rules in FILE, which Open Job Description writes"},
    {.name = "--log", .argument = "FILE", .take = take_text, .field = INTO(log_path), .is_common = true, .files = "",
     .meaning = "add messages, stages and results to FILE, each with its time in UTC"},
    {.name = "--loop-log", .argument = "FILE", .take = take_text, .field = INTO(loop_log), .is_hidden = true,
     .files = "", .meaning = "write the CPU time of each piece of each parallel loop to FILE"},
    {.name = "--verbose", .letter = 'v', .take = take_verbose, .is_common = true, .meaning = "print more messages"},
    {.name = "--quiet", .letter = 'q', .take = take_quiet, .is_common = true,
     .meaning = "print warnings and errors only, and no progress"},
    {.name = "--help", .letter = 'h', .take = take_flag, .field = INTO(wants_help), .is_common = true,
     .meaning = "print this text"},
    {.name = "--version", .take = take_flag, .field = INTO(wants_version), .is_common = true,
     .meaning = "print the version"},
};
/* clang-format on */

/* Options by their old names. */
static const struct { const char *old_name, *name; } renames[] = {{"--splitting", "--path-guiding"}};

size_t cli_option_count(void) { return sizeof options / sizeof *options; }

const cli_option *cli_option_at(size_t index) { return &options[index]; }

static bool is_name(const char *name, const char *text, size_t length) {
  return strlen(name) == length && !strncmp(name, text, length);
}

const cli_option *cli_option_get(const char *name, size_t length) {
  for (size_t i = 0; i < sizeof renames / sizeof *renames; i++)
    if (is_name(renames[i].old_name, name, length)) {
      cli_complain("warning: %s is the old name of %s: use the new one", renames[i].old_name, renames[i].name);
      return cli_option_get(renames[i].name, strlen(renames[i].name));
    }
  for (size_t i = 0; i < cli_option_count(); i++)
    if (is_name(options[i].name, name, length)) return &options[i];
  return NULL;
}

void cli_option_describe_words(const char *const *words, char *out, size_t size) {
  out[0] = '\0';
  for (size_t i = 0; words && words[i]; i++) {
    const size_t length = strlen(out);
    cli_print(out + length, size - length, "%s%s", !i ? "" : words[i + 1] ? ", " : " or ", words[i]);
  }
}

const cli_option *cli_option_get_by_letter(char letter) {
  for (size_t i = 0; i < cli_option_count(); i++)
    if (letter && options[i].letter == letter) return &options[i];
  return NULL;
}
