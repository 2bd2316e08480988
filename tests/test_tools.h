/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of other packages that tests run. */
#ifndef NP_TEST_TOOLS_H
#define NP_TEST_TOOLS_H

#include "test_support.h"

#include <stdlib.h>

/* Skips the test if `command` is missing (Debian's `package`), but not under tests/run.sh, which installs it. */
static inline void test_require_tool(const char *command, const char *package) {
  if (system(command) == 0) return;
  print_message("skipped: `%s` fails; the package is %s\n", command, package);
  if (getenv("NEPHOS_REQUIRE_TOOLS")) fail_msg("%s is required here", package);
  skip();
}

/* Runs a command of the shell, which must succeed. */
__attribute__((format(printf, 1, 2))) static inline void test_run_command(const char *format, ...) {
  char *command;
  va_list arguments;
  va_start(arguments, format);
  assert_true(vasprintf(&command, format, arguments) >= 0);
  va_end(arguments);
  assert_int_equal(system(command), 0);
  free(command);
}

#endif
