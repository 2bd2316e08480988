/* SPDX-License-Identifier: Apache-2.0 */
/* OpenCue: a job specification in XML, of cjsl-1.12.dtd. A layer for each tile; merging follows frame by frame. */
#include "job.h"

#include <pwd.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void print_text(const char *text) {
  for (const char *c = text; *c; c++)
    if (*c == '&')
      printf("&amp;");
    else if (*c == '<')
      printf("&lt;");
    else if (*c == '>')
      printf("&gt;");
    else
      putchar(*c);
}

/* Cuebot replaces #FRAMESPEC# by the frames of the chunk, before a shell splits the command. */
static void print_argument(const char *argument) {
  const bool is_plain = *argument == '#' || !argument[strcspn(argument, " \t\n'\"\\$&|;<>()*?`~[]!{}")];
  printf(is_plain ? " " : " '");
  for (const char *quote = argument; *quote; quote++) {
    const char one[2] = {*quote, '\0'};
    print_text(*quote == '\'' ? "'\\''" : one);
  }
  if (!is_plain) putchar('\'');
}

static void open_layer(const char *name, const char *type) {
  printf("      <layer name=\"%s\" type=\"%s\">\n        <cmd>nephos", name, type);
}

static void close_layer(const farm_job *job, unsigned cores) {
  printf("</cmd>\n        <range>");
  farm_job_print_frames(job, 0, job->frame_count, 'x');
  printf("</range>\n        <chunk>%u</chunk>\n", job->chunk_size);
  if (cores) printf("        <cores>%u</cores>\n", cores);
  printf("        <services><service>shell</service></services>\n      </layer>\n");
}

static void print_tile(const farm_job *job, unsigned index) {
  char name[32], tile[32];
  snprintf(name, sizeof name, "render_%u", index);
  snprintf(tile, sizeof tile, "%u/%u", index, job->tile_count);
  open_layer(job->tile_count > 1 ? name : "render", "Render");
  farm_job_print_render(job, "#FRAMESPEC#", tile, "lines", print_argument);
  farm_job_print_threads(job, print_argument);
  close_layer(job, job->thread_count);
}

static void print_depends(const farm_job *job) {
  printf("  <depends>\n");
  for (unsigned i = 1; i <= job->tile_count; i++)
    printf("    <depend type=\"FRAME_BY_FRAME\" anyframe=\"false\">\n"
           "      <depjob>%s</depjob><deplayer>merge</deplayer>\n"
           "      <onjob>%s</onjob><onlayer>render_%u</onlayer>\n    </depend>\n",
           job->name, job->name, i);
  printf("  </depends>\n");
}

static void print_user(void) {
  const struct passwd *user = getpwuid(getuid());
  printf("  <user>");
  print_text(user ? user->pw_name : "nobody");
  printf("</user>\n  <uid>%u</uid>\n", (unsigned)getuid());
}

static void print_spec(const farm_job *job) {
  printf("<?xml version=\"1.0\"?>\n<!DOCTYPE spec PUBLIC \"SPI Cue Specification Language\" "
         "\"http://localhost:8080/spcue/dtd/cjsl-1.12.dtd\">\n"
         "<spec>\n  <facility>local</facility>\n  <show>nephos</show>\n  <shot>%s</shot>\n",
         job->name);
  print_user();
  printf("  <job name=\"%s\">\n    <paused>false</paused>\n    <maxretries>3</maxretries>\n"
         "    <autoeat>false</autoeat>\n    <layers>\n",
         job->name);
  for (unsigned i = 1; i <= job->tile_count; i++) print_tile(job, i);
  if (job->tile_count > 1) {
    open_layer("merge", "Util");
    farm_job_print_merge(job, "#FRAMESPEC#", print_argument);
    close_layer(job, 0);
  }
  printf("    </layers>\n  </job>\n");
  if (job->tile_count > 1) print_depends(job);
  printf("</spec>\n");
}

/* Cuebot starts commands in a folder of its own. */
static void print_job(const farm_job *job) {
  farm_job absolute = *job;
  char *path = realpath(job->scene, NULL);
  if (path) absolute.scene = path;
  print_spec(&absolute);
  free(path);
}

const farm farm_opencue = {.name = "opencue", .print = print_job};
