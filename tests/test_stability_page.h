/* SPDX-License-Identifier: Apache-2.0 */
/* The page docs/stability.md, of which each test of stability has a section: called with `page FILE` it writes the
 * section; else it looks for the same facts, counts and refusals, on the page as it stands. */
#ifndef NP_TEST_STABILITY_PAGE_H
#define NP_TEST_STABILITY_PAGE_H

#include <stdlib.h>

#include "test_support.h"

typedef struct test_page {
  FILE *out;     /* NULL: facts are checked */
  uint8_t *text; /* the page, ended by 0 */
} test_page;

static inline test_page test_page_open(int argc, char **argv) {
  test_page page = {0};
  for (int i = 1; i + 1 < argc; i++)
    if (strcmp(argv[i], "page") == 0) page.out = fopen(argv[i + 1], "w");
  if (page.out) return page;
  const test_file file = test_file_read(NEPHOS_TEST_SOURCE_DIR "/../docs/stability.md");
  page.text = realloc(file.bytes, file.size + 1);
  page.text[file.size] = 0;
  return page;
}

static inline void test_page_close(test_page *page) {
  if (page->out) (void)fclose(page->out);
  free(page->text);
}

enum { TEST_PAGE_LINE = 1024 };

/* Text of a line, into `line`. */
#define TEST_PAGE_PRINT(line, format)                                                                                  \
  do {                                                                                                                 \
    va_list values;                                                                                                    \
    va_start(values, format);                                                                                          \
    (void)vsnprintf(line, sizeof line, format, values);                                                                \
    va_end(values);                                                                                                    \
  } while (0)

/* A line that any run must find on the page. */
__attribute__((format(printf, 2, 3))) static inline void test_page_add_fact(test_page *page, const char *format, ...) {
  char line[TEST_PAGE_LINE];
  TEST_PAGE_PRINT(line, format);
  if (page->out)
    (void)fprintf(page->out, "%s\n", line);
  else if (!strstr((const char *)page->text, line))
    fail_msg("docs/stability.md lacks \"%s\": generate it anew by tests/bench/stability.sh", line);
}

/* A line of figures, which differ from machine to machine. */
__attribute__((format(printf, 2, 3))) static inline void test_page_add_figure(test_page *page, const char *format,
                                                                              ...) {
  char line[TEST_PAGE_LINE];
  TEST_PAGE_PRINT(line, format);
  if (page->out)
    (void)fprintf(page->out, "%s\n", line);
  else
    print_message("%s\n", line);
}

/* A refusal: the one message of a log, in which nothing but its end is cut off; then clears the log. */
static inline void test_page_add_refusal(test_page *page, const char *input, test_log *log) {
  char *end = strchr(log->text, '\n');
  if (log->counts[NEPH_LOG_ERROR] != 1 || !end)
    fail_msg("%s: refused with other than one message: %s", input, log->text);
  *end = 0;
  test_page_add_fact(page, "| %s | %s |", input, log->text);
  test_log_clear(log);
}

#endif
