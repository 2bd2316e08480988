/* SPDX-License-Identifier: Apache-2.0 */
#include "core/given.h"

#include <string.h>

/* Skips a name and the ", " after it. */
static const char *skip_name(const char *names) {
  names += strcspn(names, ",");
  return names + strspn(names, ", ");
}

bool np_lacks(neph_context *context, const char *function, const char *names, const void *const *pointers,
              size_t count) {
  if (!context) return true;
  for (size_t i = 0; i < count; i++, names = skip_name(names)) {
    if (pointers[i]) continue;
    (void)np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "%s: %.*s is NULL, must be given", function,
                  (int)strcspn(names, ","), names);
    return true;
  }
  return false;
}
