/* SPDX-License-Identifier: Apache-2.0 */
/* OpenCue: a job specification in XML, of cjsl-1.12.dtd. A layer for each tile; merging follows frame by frame.
 * Commands start in a folder of the host, and so change to that of the job. */
#include "job.h"
#include "print.h"

#include <pwd.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void print_text(const farm_job *job, const char *text) {
  for (const char *c = text; *c; c++)
    if (*c == '&')
      fputs("&amp;", job->out);
    else if (*c == '<')
      fputs("&lt;", job->out);
    else if (*c == '>')
      fputs("&gt;", job->out);
    else
      putc(*c, job->out);
}

/* Prints a word of the command, which a shell on the machine splits. */
static void print_word(const farm_job *job, const char *word) {
  char *quoted = NULL;
  size_t size;
  FILE *out = open_memstream(&quoted, &size);
  if (!out) abort();
  farm_text_put_word(out, &farm_opencue.text, word);
  if (fclose(out)) abort();
  print_text(job, quoted);
  free(quoted);
}

static void print_argument(const farm_job *job, const char *argument, bool is_template) {
  putc(' ', job->out);
  if (is_template)
    print_text(job, argument);
  else
    print_word(job, argument);
}

static void open_layer(const farm_job *job, const char *name, const char *type) {
  fprintf(job->out, "      <layer name=\"%s\" type=\"%s\">\n        <cmd>env --chdir=", name, type);
  print_word(job, job->folder);
  fprintf(job->out, " nephos");
}

static void close_layer(const farm_job *job, unsigned cores) {
  fprintf(job->out, "</cmd>\n        <range>");
  farm_job_print_frames(job, 0, job->frame_count, 'x');
  fprintf(job->out, "</range>\n        <chunk>%u</chunk>\n", job->chunk_size);
  if (cores) fprintf(job->out, "        <cores>%u</cores>\n", cores);
  fprintf(job->out, "        <services><service>shell</service></services>\n      </layer>\n");
}

static void print_tile(const farm_job *job, unsigned index) {
  char name[32], tile[32];
  cli_print(name, sizeof name, "render_%u", index);
  cli_print(tile, sizeof tile, "%u/%u", index, job->tile_count);
  open_layer(job, job->tile_count > 1 ? name : "render", "Render");
  farm_job_print_render(job, "#FRAMESPEC#", tile, "lines", print_argument);
  farm_job_print_threads(job, print_argument);
  close_layer(job, job->thread_count);
}

static void print_depends(const farm_job *job) {
  fprintf(job->out, "  <depends>\n");
  for (unsigned i = 1; i <= job->tile_count; i++)
    fprintf(job->out,
            "    <depend type=\"FRAME_BY_FRAME\" anyframe=\"false\">\n"
            "      <depjob>%s</depjob><deplayer>merge</deplayer>\n"
            "      <onjob>%s</onjob><onlayer>render_%u</onlayer>\n    </depend>\n",
            job->name, job->name, i);
  fprintf(job->out, "  </depends>\n");
}

static void print_user(const farm_job *job) {
  const struct passwd *user = getpwuid(getuid());
  fprintf(job->out, "  <user>");
  print_text(job, user ? user->pw_name : "nobody");
  fprintf(job->out, "</user>\n  <uid>%u</uid>\n", (unsigned)getuid());
}

static void print_spec(const farm_job *job) {
  fprintf(job->out,
          "<?xml version=\"1.0\"?>\n<!DOCTYPE spec PUBLIC \"SPI Cue Specification Language\" "
          "\"http://localhost:8080/spcue/dtd/cjsl-1.12.dtd\">\n"
          "<spec>\n  <facility>local</facility>\n  <show>nephos</show>\n  <shot>%s</shot>\n",
          job->name);
  print_user(job);
  fprintf(job->out,
          "  <job name=\"%s\">\n    <paused>false</paused>\n    <maxretries>3</maxretries>\n"
          "    <autoeat>false</autoeat>\n    <layers>\n",
          job->name);
  for (unsigned i = 1; i <= job->tile_count; i++) print_tile(job, i);
  if (job->tile_count > 1) {
    open_layer(job, "merge", "Util");
    farm_job_print_merge(job, "#FRAMESPEC#", print_argument);
    close_layer(job, 0);
  }
  fprintf(job->out, "    </layers>\n  </job>\n");
  if (job->tile_count > 1) print_depends(job);
  fprintf(job->out, "</spec>\n");
}

/* Cuebot replaces #FRAMESPEC#, #JOB# and similar texts anywhere in a command: quotes split # from the letters in other
 * texts. Its hosts pass the command to a shell, and hosts that start containers pass it to a shell within double
 * quotes, where $, ` and \ keep their meaning whatever the inner quotes are. */
const farm farm_opencue = {.name = "opencue",
                           .text = {.has_tabs = true,
                                    .is_unicode = true,
                                    .refused = "$`\\",
                                    .split = '#',
                                    .split_before = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"},
                           .print = print_spec};
