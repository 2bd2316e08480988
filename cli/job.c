/* SPDX-License-Identifier: Apache-2.0 */
#include "job.h"

#include <stdlib.h>
#include <string.h>

#include "options.h"
#include "print.h"

void farm_job_set_name(farm_job *job) {
  const char *slash = strrchr(job->given, '/'), *stem = slash ? slash + 1 : job->given, *dot = strrchr(stem, '.');
  const size_t length = dot && dot > stem ? (size_t)(dot - stem) : strlen(stem), most = sizeof job->name - 1;
  memcpy(job->name, stem, length < most ? length : most);
  job->name[length < most ? length : most] = '\0';
  for (char *c = job->name; *c; c++)
    if (!strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_", *c)) *c = '_';
}

/* ---- Frames ---- */

size_t farm_job_count_chunks(const farm_job *job) { return (job->frame_count + job->chunk_size - 1) / job->chunk_size; }

size_t farm_job_get_chunk_length(const farm_job *job) {
  return job->chunk_size < job->frame_count ? job->chunk_size : job->frame_count;
}

/* Number of frames from index `begin` on that have the same step. */
static size_t count_run(const int *frames, size_t begin, size_t end) {
  size_t count = end - begin < 2 ? end - begin : 2;
  while (begin + count < end && frames[begin + count] - frames[begin + count - 1] == frames[begin + 1] - frames[begin])
    count++;
  return count;
}

void farm_job_print_frames(const farm_job *job, size_t begin, size_t end, char step) {
  const int *frames = job->frames;
  for (size_t i = begin; i < end;) {
    size_t run = count_run(frames, i, end);
    const int apart = run > 1 ? frames[i + 1] - frames[i] : 1;
    if (run == 2 && apart > 1) run = 1; /* "1,5", not "1-5x4" */
    fprintf(job->out, i > begin ? ",%d" : "%d", frames[i]);
    if (run > 1) fprintf(job->out, "-%d", frames[i + run - 1]);
    if (run > 1 && apart > 1) fprintf(job->out, "%c%d", step, apart);
    i += run;
  }
}

void farm_job_print_chunk(const farm_job *job, size_t chunk) {
  const size_t begin = chunk * job->chunk_size, end = begin + job->chunk_size;
  farm_job_print_frames(job, begin, end < job->frame_count ? end : job->frame_count, 'x');
}

/* ---- Commands ---- */

static void print_option(const farm_job *job, const char *name, const char *value, farm_print_fn *print) {
  print(job, name, false);
  print(job, value, false);
}

static void print_template(const farm_job *job, const char *name, const char *value, farm_print_fn *print) {
  print(job, name, false);
  print(job, value, true);
}

void farm_job_print_render(const farm_job *job, const char *frames, const char *tile, const char *style,
                           farm_print_fn *print) {
  print(job, "render", false);
  print(job, job->scene, false);
  print_template(job, "--frames", frames, print);
  if (job->tile_count > 1) print_template(job, "--tile", tile, print);
  for (size_t i = 0; i < job->argument_count; i++) print(job, job->arguments[i], false);
  print_option(job, "--checkpoint", job->checkpoint, print);
  print(job, "--resume", false);
  print(job, "--skip-existing", false);
  print_option(job, "--progress", style, print);
}

void farm_job_print_threads(const farm_job *job, farm_print_fn *print) {
  char count[16];
  if (!job->thread_count) return;
  cli_print(count, sizeof count, "%u", job->thread_count);
  print_option(job, "--threads", count, print);
}

void farm_job_print_merge(const farm_job *job, const char *frames, farm_print_fn *print) {
  char tiles[16];
  cli_print(tiles, sizeof tiles, "%u", job->tile_count);
  print(job, "merge", false);
  print(job, job->scene, false);
  print_template(job, "--frames", frames, print);
  print_option(job, "--tiles", tiles, print);
  for (size_t i = 0; i < job->setting_count; i++) print_option(job, "--set", job->settings[i], print);
}

static void print_shown(const farm_job *job, const char *text) {
  putc(' ', job->out);
  farm_text_put_shown(job->out, text);
}

void farm_job_print_origin(const farm_job *job, const char *mark, const farm *of) {
  fprintf(job->out, "%s nephos job %s", mark, of->name);
  print_shown(job, job->given);
  fprintf(job->out, " --frames ");
  farm_job_print_frames(job, 0, job->frame_count, 'x');
  fprintf(job->out, " --tiles %u --chunk %u", job->tile_count, job->chunk_size);
  if (job->thread_count) fprintf(job->out, " --threads %u", job->thread_count);
  fprintf(job->out, " --checkpoint");
  print_shown(job, job->checkpoint);
  if (job->argument_count) fprintf(job->out, " --");
  for (size_t i = 0; i < job->argument_count; i++) print_shown(job, job->arguments[i]);
}

/* ---- Texts ---- */

/* A text of the job, called `role` in messages, with a remedy. */
typedef struct farm_text {
  const char *text, *role, *remedy;
  bool is_option;
} farm_text;

static bool check_text(const farm *of, const farm_text *text) {
  farm_text_fault fault;
  if (farm_text_check(&of->text, text->text, text->is_option, &fault)) return true;
  char *shown = NULL;
  size_t size;
  FILE *out = open_memstream(&shown, &size);
  if (out) farm_text_put_shown(out, text->text);
  if (out) fclose(out);
  cli_complain("%s %s has %s at byte %zu, which a job of %s cannot hold: %s", text->role, shown ? shown : "",
               fault.name, fault.place, of->name, text->remedy);
  free(shown);
  return false;
}

bool farm_job_check_texts(const farm_job *job, const farm *of) {
  const farm_text texts[] = {{job->given, "the scene's name", "rename it", false},
                             {job->folder, "the working folder's name", "start from another", false},
                             {job->checkpoint, "--checkpoint", "give digits and a unit, as 60s", true}};
  for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
    if (!check_text(of, &texts[i])) return false;
  for (size_t i = 0; i < job->argument_count; i++) {
    const farm_text option = {job->arguments[i], "behind --", "set it in the scene", true};
    if (!check_text(of, &option)) return false;
  }
  return true;
}
