/* SPDX-License-Identifier: Apache-2.0 */
/* Script and drawing pass through files that have no name, so that no process waits for a full pipe. */
#include "report/report_gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/text.h"

/* ---- The program ---- */

/* Whether gnuplot ran, and found nothing wrong. Its messages are lost. */
static bool run(int script, int drawing) {
  char name[] = "gnuplot", option[] = "-d", variable[] = "LC_ALL=C"; /* without the user's own settings */
  char *const arguments[] = {name, option, NULL}, *const environment[] = {variable, NULL};
  posix_spawn_file_actions_t actions;
  pid_t process;
  int status = 1;
  if (posix_spawn_file_actions_init(&actions)) return false;
  bool has_failed = posix_spawn_file_actions_adddup2(&actions, script, STDIN_FILENO) ||
                    posix_spawn_file_actions_adddup2(&actions, drawing, STDOUT_FILENO) ||
                    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  has_failed = has_failed || posix_spawnp(&process, name, &actions, NULL, arguments, environment);
  posix_spawn_file_actions_destroy(&actions);
  if (has_failed || waitpid(process, &status, 0) != process) return false;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static bool write_all(int file, const char *text) {
  const ssize_t length = (ssize_t)strlen(text);
  return write(file, text, (size_t)length) == length && lseek(file, 0, SEEK_SET) == 0;
}

/* The whole of a file; NULL when it is empty, or there is no memory. */
static char *read_all(neph_context *context, int file) {
  const off_t size = lseek(file, 0, SEEK_END);
  char *text = size > 0 ? np_alloc(context, (size_t)size + 1, 1) : NULL;
  if (text && pread(file, text, (size_t)size, 0) == (ssize_t)size) return text;
  np_alloc_free(context, text);
  return NULL;
}

static char *draw(neph_context *context, const char *script) {
  const int in = memfd_create("script", MFD_CLOEXEC), out = memfd_create("drawing", MFD_CLOEXEC);
  char *svg = NULL;
  if (in >= 0 && out >= 0 && write_all(in, script) && run(in, out)) svg = read_all(context, out);
  if (in >= 0) close(in);
  if (out >= 0) close(out);
  return svg;
}

/* ---- The drawing ---- */

typedef struct rename {
  const char *from, *to;
} rename_row;

/* Copies a text with each `from` replaced by its `to`, in which `%` is replaced by `name`. */
static void replace(np_text *out, const char *svg, const char *name, const rename_row *rows, size_t count) {
  while (*svg) {
    size_t i = 0;
    while (i < count && strncmp(svg, rows[i].from, strlen(rows[i].from)) != 0) i++;
    if (i == count) {
      np_text_add(out, "%c", *svg++);
      continue;
    }
    const char *mark = strchr(rows[i].to, '%');
    if (mark)
      np_text_add(out, "%.*s%s%s", (int)(mark - rows[i].to), rows[i].to, name, mark + 1);
    else
      np_text_add(out, "%s", rows[i].to);
    svg += strlen(rows[i].from);
  }
}

neph_result np_gnuplot_draw(neph_context *context, const char *script, const char *name, char **out_svg) {
  static const rename_row rows[] = {
      {"\"black\"", "\"currentColor\""},  {"'black'", "'currentColor'"},
      {" color='white'", " opacity='0'"}, {"id='gp", "id='%gp"},
      {"href='#gp", "href='#%gp"},        {"id='textbox'", "id='%text'"},
      {"id='greybox'", "id='%grey'"},     {"id=\"gnuplot", "id=\"%gnuplot"},
      {"<title>Gnuplot</title>", ""},
  };
  *out_svg = NULL;
  char *svg = draw(context, script);
  const char *begin = svg ? strstr(svg, "<svg") : NULL;
  np_text text = {.context = context};
  if (begin) replace(&text, begin, name, rows, sizeof rows / sizeof *rows);
  np_alloc_free(context, svg);
  return begin ? np_text_finish(&text, out_svg) : NEPH_OK;
}
