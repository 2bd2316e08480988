/* SPDX-License-Identifier: Apache-2.0 */
#include <nephos/base.h>

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

const char *neph_result_get_name(neph_result result) {
  switch (result) {
#define NAME_CASE(name, value, text)                                                                                   \
  case name: return #name;
    NEPH_RESULTS(NAME_CASE)
#undef NAME_CASE
  }
  return "unknown";
}

const char *neph_result_get_text(neph_result result) {
  switch (result) {
#define TEXT_CASE(name, value, text)                                                                                   \
  case name: return text;
    NEPH_RESULTS(TEXT_CASE)
#undef TEXT_CASE
  }
  return "unknown result";
}

const char *neph_version_get_text(void) {
  return TEXT(NEPHOS_VERSION_MAJOR) "." TEXT(NEPHOS_VERSION_MINOR) "." TEXT(NEPHOS_VERSION_PATCH);
}

unsigned neph_version_get_number(void) { return NEPHOS_VERSION_NUMBER; }
