/* SPDX-License-Identifier: Apache-2.0 */
/* The same from C++: the headers, their defaults and a lambda as a callback. */
#include <cstdio>

#include <nephos/nephos.h>

int main() {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.log = [](void *, neph_log_level, const char *message) { std::fprintf(stderr, "%s\n", message); };
  desc.thread_count = 0; /* which is refused, not taken for a default */
  neph_context *context = nullptr;
  const neph_result result = neph_context_create(&desc, &context);
  std::printf("%s\n", neph_result_get_name(result));
  return result != NEPH_ERROR_INVALID_ARGUMENT || context;
}
