/* SPDX-License-Identifier: Apache-2.0 */
/* Names and options in jobs of the four farms. A job is refused with one message, or it has the lines of a job whose
 * texts are plain. The words of its lines, read again by the rules below, are the texts that were given.
 *
 * An input is a byte for the farm, one for tiles, threads and chunks, and then texts that end with a zero: scene,
 * working folder behind its first slash, checkpoint, and options. */
#include "fuzz_support.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../cli/job.h"
#include "../../cli/options.h"

enum { TEXT_MAX = 12 };

#define ADDRESS(name) &farm_##name,
static const farm *const farms[] = {CLI_FARMS(ADDRESS)};
#undef ADDRESS

static unsigned complaint_count;

/* The linker puts it in the place of cli_complain. */
void __wrap_cli_complain(const char *format, ...);
void __wrap_cli_complain(const char *format, ...) {
  (void)format;
  complaint_count++;
}

static void require(bool is_held) {
  if (!is_held) abort();
}

static bool is_letter(char c) { return ((c | 32) >= 'a' && (c | 32) <= 'z') || (c >= '0' && c <= '9'); }

/* ---- Jobs ---- */

static int frames[] = {1, 2, 3, 7};

/* `paths` has room for two texts more. */
static farm_job make_job(uint8_t shape, const char **texts, size_t count, char *paths) {
  char *folder = paths, *scene = paths + strlen(texts[1]) + 2;
  sprintf(folder, "/%s", texts[1]);
  sprintf(scene, "/%s/%s", texts[1], texts[0]);
  farm_job job = {.given = texts[0],
                  .folder = folder,
                  .scene = scene,
                  .frames = frames,
                  .frame_count = 4,
                  .chunk_size = 1 + (shape >> 1 & 1),
                  .tile_count = 1 + (shape & 1),
                  .thread_count = shape >> 2 & 3,
                  .checkpoint = texts[2],
                  .arguments = texts + 3,
                  .argument_count = count - 3,
                  .settings = texts + 3,
                  .setting_count = count - 3};
  farm_job_set_name(&job);
  return job;
}

static char *print_job(const farm *chosen, farm_job job) {
  char *text;
  size_t size;
  job.out = open_memstream(&text, &size);
  require(job.out != NULL);
  if (chosen->maps_scene) job.scene = job.given;
  chosen->print(&job);
  require(!fclose(job.out) && strlen(text) == size);
  return text;
}

/* ---- A reader of words ---- */

static void skip(const char **at, const char *expected) {
  require(!strncmp(*at, expected, strlen(expected)));
  *at += strlen(expected);
}

/* Reads a word of a shell into `out`. Outside quotes stand letters, digits and a few signs that no shell replaces. */
static void read_word(const char **at, char *out) {
  const char *begin = *at;
  for (; **at && **at != ' ' && **at != '\n'; ++*at) {
    if (**at == '\'')
      for (++*at; require(**at && **at != '\n'), **at != '\''; ++*at) *out++ = **at;
    else if (**at == '\\')
      require((*at)[1] == '\''), *out++ = *++*at;
    else
      require(is_letter(**at) || strchr("+,-./:@_%=", **at) || (**at == '#' && *at > begin)), *out++ = **at;
  }
  require(*at > begin);
  *out = '\0';
}

static void skip_word(const char **at, const char *expected) {
  char *word = malloc(strlen(*at) + 1);
  require(word != NULL);
  read_word(at, word);
  require(!strcmp(word, expected));
  free(word);
}

static void skip_argument(const char **at, const char *expected) {
  skip(at, " ");
  skip_word(at, expected);
}

/* Behind "nephos": the words of a task, or of a merging. */
static void skip_render(const char **at, const farm_job *job, const char *frames_and_tile, const char *style) {
  skip(at, " render");
  skip_argument(at, job->scene);
  skip(at, frames_and_tile);
  for (size_t i = 0; i < job->argument_count; i++) skip_argument(at, job->arguments[i]);
  skip(at, " --checkpoint");
  skip_argument(at, job->checkpoint);
  skip(at, " --resume --skip-existing --progress ");
  skip(at, style);
}

static void skip_merge(const char **at, const farm_job *job, const char *frames_and_tiles) {
  skip(at, " merge");
  skip_argument(at, job->scene);
  skip(at, frames_and_tiles);
  for (size_t i = 0; i < job->setting_count; i++) {
    skip(at, " --set");
    skip_argument(at, job->settings[i]);
  }
}

/* ---- Lines ---- */

/* A line of the job beside the line of a plain job, which is like it but for texts. */
typedef struct line {
  const farm_job *job;
  const char *at;
  unsigned render_count;
} line;

static bool begins(const line *l, const char *text) { return !strncmp(l->at, text, strlen(text)); }

static void skip_threads(line *l) {
  char text[32];
  if (!l->job->thread_count) return;
  snprintf(text, sizeof text, " --threads %u", l->job->thread_count);
  skip(&l->at, text);
}

/* A comment is of printable ASCII. A name of a job has letters, digits, - and _. */
static bool skip_common(line *l) {
  static const char *const names[] = {"#SBATCH --job-name=", "#SBATCH --output=", "  <shot>", "  <job name=\"",
                                      "      <depjob>",      "      <onjob>",     "name: \""};
  if (begins(l, "# nephos job ")) {
    for (; *l->at != '\n'; l->at++) require(*l->at >= 0x20 && *l->at < 0x7f);
    return true;
  }
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    if (!begins(l, names[i])) continue;
    skip(&l->at, names[i]);
    skip(&l->at, l->job->name);
    l->at += strcspn(l->at, "\n");
    return true;
  }
  return false;
}

static void read_slurm(line *l) {
  static const char frames_and_tile[] = " --frames \"$1\" --tile \"$((SLURM_ARRAY_TASK_ID % tiles + 1))/$tiles\"";
  const bool has_tiles = l->job->tile_count > 1;
  if (begins(l, "render=") || begins(l, "merge=")) {
    skip(&l->at, begins(l, "render=") ? "render=$(sbatch --parsable --chdir="
                                      : "merge=$(sbatch --parsable --dependency=\"afterok:${render%%;*}\" "
                                        "--kill-on-invalid-dep=yes --chdir=");
    skip_word(&l->at, l->job->folder);
    skip(&l->at, " \"$@\" <<'TASK'");
  } else if (begins(l, "nephos render")) {
    skip(&l->at, "nephos");
    skip_render(&l->at, l->job, has_tiles ? frames_and_tile : " --frames \"$1\"", "lines &");
  } else {
    skip(&l->at, "exec nephos");
    skip_merge(&l->at, l->job, " --frames \"$1\" --tiles 2");
  }
}

/* Within the command of parallel each { of a text has quotes behind it. */
static void check_braces(const char *command) {
  for (const char *c = command; (c = strchr(c, '{')); c++) {
    const bool is_own = (c[1] == '1' || c[1] == '2') && c[2] == '}';
    require(!strncmp(c, "{''", 3) || (is_own && c > command && c[-1] == ' '));
  }
}

static void read_parallel(line *l) {
  if (begins(l, "cd ")) {
    skip(&l->at, "cd ");
    skip_word(&l->at, l->job->folder);
    return;
  }
  char *command = malloc(strlen(l->at) + 1);
  require(command != NULL);
  skip(&l->at, "  ");
  read_word(&l->at, command);
  skip(&l->at, " \\");
  check_braces(command);
  line inner = {.job = l->job, .at = command};
  skip(&inner.at, "nephos");
  if (l->render_count++ == 0) {
    skip_render(&inner.at, l->job, l->job->tile_count > 1 ? " --frames {1} --tile {2}/2" : " --frames {1}", "none");
    skip_threads(&inner);
  } else
    skip_merge(&inner.at, l->job, " --frames {1} --tiles 2");
  require(!*inner.at);
  free(command);
}

/* Text of an element, its references replaced. */
static void read_element(const char **at, char *out) {
  static const char *const references[] = {"&amp;", "&lt;", "&gt;"};
  for (; **at != '<'; ++*at) {
    require((unsigned char)**at >= 0x20 || **at == '\t');
    if (**at != '&') {
      *out++ = **at;
      continue;
    }
    size_t i = 0;
    while (i < 3 && strncmp(*at, references[i], strlen(references[i]))) i++;
    require(i < 3);
    *out++ = "&<>"[i];
    *at += strlen(references[i]) - 1;
  }
  *out = '\0';
}

/* Cuebot's marks are #NAME#; a shell within double quotes replaces $ and `, and \ but before a single quote. */
static void check_command(const char *command) {
  for (const char *c = command; *c; c++) {
    require(*c != '$' && *c != '`' && (*c != '\\' || c[1] == '\''));
    if (*c == '#' && c[1] >= 'A' && c[1] <= 'Z') require(!strncmp(c, "#FRAMESPEC#", 11) && c[-1] == ' ');
  }
}

static void read_opencue(line *l) {
  char *command = malloc(strlen(l->at) + 1), tile[64];
  require(command != NULL);
  skip(&l->at, "        <cmd>");
  read_element(&l->at, command);
  skip(&l->at, "</cmd>");
  check_command(command);
  line inner = {.job = l->job, .at = command};
  skip(&inner.at, "env --chdir=");
  skip_word(&inner.at, l->job->folder);
  skip(&inner.at, " nephos");
  snprintf(tile, sizeof tile, " --frames #FRAMESPEC#");
  if (l->job->tile_count > 1) snprintf(tile, sizeof tile, " --frames #FRAMESPEC# --tile %u/2", l->render_count + 1);
  if (l->render_count++ < l->job->tile_count) {
    skip_render(&inner.at, l->job, tile, "lines");
    skip_threads(&inner);
  } else
    skip_merge(&inner.at, l->job, " --frames #FRAMESPEC# --tiles 2");
  require(!*inner.at);
  free(command);
}

/* A string of JSON with the text that is expected: no byte below the blank, no line break of YAML. */
static void skip_json(const char **at, const char *expected) {
  skip(at, "\"");
  for (; **at != '"'; ++*at) {
    require((unsigned char)**at >= 0x20 && **at != 0x7f);
    require(strncmp(*at, "\xe2\x80\xa8", 3) && strncmp(*at, "\xc2\x85", 2));
    if (!strncmp(*at, "\\u", 2)) {
      char code[5] = "";
      const size_t length = 3; /* length of a YAML line break in UTF-8 */
      memcpy(code, *at + 2, 4);
      const unsigned long c = strtoul(code, NULL, 16);
      require(((unsigned char)expected[0] & 15u) == c >> 12 && ((unsigned char)expected[1] & 63u) == (c >> 6 & 63u) &&
              ((unsigned char)expected[2] & 63u) == (c & 63u));
      expected += length;
      *at += 5;
      continue;
    }
    if (**at == '\\') ++*at;
    require(**at == *expected++);
  }
  require(!*expected);
  skip(at, "\"");
}

/* An argument, of which there are as many as words of the command lines. */
static void read_openjd(line *l, const char *plain) {
  const farm_job *job = l->job;
  if (begins(l, "    default: ")) {
    skip(&l->at, "    default: ");
    skip_json(&l->at, job->given);
    return;
  }
  skip(&l->at, "            - ");
  for (size_t i = 0; i < job->argument_count; i++) {
    char text[64];
    snprintf(text, sizeof text, "            - \"x%zu\"\n", i);
    if (strncmp(plain, text, strlen(text))) continue;
    require(!strstr(job->arguments[i], "{{"));
    skip_json(&l->at, job->arguments[i]);
    return;
  }
  skip_json(&l->at, job->checkpoint);
}

/* ---- The rule ---- */

static void read_line(line *l, const farm *chosen, const char *plain) {
  const size_t length = strcspn(plain, "\n");
  if (skip_common(l)) return;
  if (!strncmp(l->at, plain, length + 1)) {
    l->at += length;
    const bool is_command = strstr(chosen->name, "parallel") && !strncmp(plain, "  '", 3);
    l->render_count += is_command || !strncmp(plain, "        <cmd>", 13);
    return;
  }
  if (chosen == &farm_slurm)
    read_slurm(l);
  else if (chosen == &farm_parallel)
    read_parallel(l);
  else if (chosen == &farm_opencue)
    read_opencue(l);
  else
    read_openjd(l, plain);
}

static void compare_jobs(const farm *chosen, const farm_job *job, const char *text, const char *plain) {
  line l = {.job = job, .at = text};
  for (; *plain; plain += strcspn(plain, "\n") + 1) {
    read_line(&l, chosen, plain);
    skip(&l.at, "\n");
  }
  require(!*l.at);
}

static void check_job(const farm *chosen, uint8_t shape, const char **texts, size_t count, size_t size) {
  const char *plain_texts[TEXT_MAX] = {"s.yaml", "f", "60s", "x0", "x1", "x2", "x3", "x4", "x5", "x6", "x7", "x8"};
  char *paths = malloc(2 * size + 8), plain_paths[32];
  require(paths != NULL);
  const farm_job job = make_job(shape, texts, count, paths), simple = make_job(shape, plain_texts, count, plain_paths);
  complaint_count = 0;
  const bool is_held = farm_job_check_texts(&job, chosen);
  require(complaint_count == !is_held && farm_job_check_texts(&simple, chosen));
  if (is_held) {
    char *text = print_job(chosen, job), *plain = print_job(chosen, simple);
    compare_jobs(chosen, &job, text, plain);
    free(text);
    free(plain);
  }
  free(paths);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *texts[TEXT_MAX];
  size_t count = 0;
  char *bytes = malloc(size + 1);
  require(bytes != NULL);
  memcpy(bytes, data, size);
  bytes[size] = '\0';
  for (size_t at = 2; at < size && count < TEXT_MAX; at += strlen(bytes + at) + 1) texts[count++] = bytes + at;
  if (count >= 3 && *texts[0]) check_job(farms[data[0] % 4], data[1], texts, count, size);
  free(bytes);
  return 0;
}
