/* SPDX-License-Identifier: Apache-2.0 */
#include "view_browser.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "print.h"

/* Makes a folder that this user alone can enter. */
static bool make_folder(cli_view_browser *browser) {
  const char *parent = getenv("XDG_RUNTIME_DIR");
  cli_text text = {0};
  cli_text_add(&text, "%s/nephos-view-XXXXXX", parent && *parent == '/' ? parent : "/tmp");
  browser->folder = text.has_failed ? NULL : mkdtemp(text.characters);
  if (!browser->folder) cli_text_clear(&text);
  return browser->folder;
}

/* Writes a page that leads to the address. */
static bool write_file(cli_view_browser *browser, const char *url) {
  cli_text text = {0};
  cli_text_add(&text, "%s/view.html", browser->folder);
  if (text.has_failed) return false;
  browser->file = text.characters;
  FILE *file = fopen(browser->file, "wxe");
  if (!file) return false;
  fprintf(file, "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url=%s\">\n", url);
  return !fclose(file);
}

cli_exit cli_view_browser_open(cli_view_browser *browser, const char *url) {
  pid_t child;
  if (!make_folder(browser) || !write_file(browser, url)) {
    cli_complain("--open: a file for the browser cannot be written: %s", strerror(errno));
    return CLI_IO;
  }
  char program[] = "xdg-open";
  char *const words[] = {program, browser->file, NULL};
  posix_spawnattr_t attributes; /* a group of its own: Ctrl-C ends the view, not the browser */
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawnp(&child, program, NULL, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  if (error) cli_complain("--open: xdg-open cannot be started: %s: open the address above", strerror(error));
  return CLI_DONE;
}

void cli_view_browser_close(cli_view_browser *browser) {
  if (browser->file) unlink(browser->file);
  if (browser->folder) rmdir(browser->folder);
  free(browser->file);
  free(browser->folder);
}
