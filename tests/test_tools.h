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

#endif
