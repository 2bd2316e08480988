/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include "core/hash.h"

static void assert_hash(neph_context *context, const void *bytes, size_t size, size_t piece, const char *expected) {
  np_hash *hash = np_hash_create(context);
  assert_non_null(hash);
  for (size_t done = 0; done < size; done += piece)
    np_hash_add(hash, (const char *)bytes + done, size - done < piece ? size - done : piece);
  char hex[33];
  assert_int_equal(np_hash_finish(hash, hex), NEPH_OK);
  assert_string_equal(hex, expected);
}

/* Values of XXH3_128bits as xxHash's own `xxhsum -H2` prints them. */
static void known_values_come_out(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  assert_hash(context, "", 0, 1, "99aa06d3014798d86001c324468d497f");
  assert_hash(context, "a", 1, 1, "a96faf705af16834e6c632b61e964e1f");
  neph_context_destroy(context);
}

static void pieces_do_not_matter(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  unsigned char bytes[5000];
  for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = (unsigned char)(i * i * 7);
  np_hash *hash = np_hash_create(context);
  np_hash_add(hash, bytes, sizeof bytes);
  char hex[33];
  assert_int_equal(np_hash_finish(hash, hex), NEPH_OK);
  for (size_t piece = 1; piece < sizeof bytes; piece = piece * 3 + 1)
    assert_hash(context, bytes, sizeof bytes, piece, hex);
  neph_context_destroy(context);
}

static neph_result make_hash(neph_context *context, void *user) {
  (void)user;
  np_hash *hash = np_hash_create(context);
  char hex[33];
  np_hash_add(hash, hex, 0);
  return np_hash_finish(hash, hex);
}

static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  assert_survives_failed_allocations(make_hash, NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(known_values_come_out),
      cmocka_unit_test(pieces_do_not_matter),
      cmocka_unit_test(failed_allocations_leave_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
