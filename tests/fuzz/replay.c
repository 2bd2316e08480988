/* SPDX-License-Identifier: Apache-2.0 */
/* Replays inputs to a fuzz target without a fuzzer: PROGRAM FOLDER… gives it every file of these folders, in the order
 * of their names, the empty input, and each file cut off in the middle. A target aborts where a rule is broken; the
 * name of the input is the last that was printed. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>

#include "fuzz_support.h"

static uint8_t *read_input(const char *path, size_t *out_size) {
  FILE *file = fopen(path, "rb");
  long size;
  if (!file || fseek(file, 0, SEEK_END) || (size = ftell(file)) < 0) abort();
  rewind(file);
  uint8_t *bytes = malloc((size_t)size + 1);
  if (!bytes || fread(bytes, 1, (size_t)size, file) != (size_t)size) abort();
  fclose(file);
  *out_size = (size_t)size;
  return bytes;
}

static void replay_file(const char *folder, const char *name) {
  char path[4096];
  size_t size;
  snprintf(path, sizeof path, "%s/%s", folder, name);
  printf("%s\n", path);
  fflush(stdout);
  uint8_t *bytes = read_input(path, &size);
  LLVMFuzzerTestOneInput(bytes, size);
  LLVMFuzzerTestOneInput(bytes, size / 2);
  free(bytes);
}

static int is_visible(const struct dirent *entry) { return entry->d_name[0] != '.'; }

/* Number of inputs. */
static int replay_folder(const char *folder) {
  struct dirent **entries;
  const int count = scandir(folder, &entries, is_visible, alphasort);
  for (int i = 0; i < count; i++) {
    replay_file(folder, entries[i]->d_name);
    free(entries[i]);
  }
  if (count >= 0) free(entries);
  return count;
}

int main(int count, char **folders) {
  LLVMFuzzerTestOneInput((const uint8_t *)"", 0);
  for (int i = 1; i < count; i++)
    if (replay_folder(folders[i]) < 1) {
      fprintf(stderr, "%s: has no inputs\n", folders[i]);
      return EXIT_FAILURE;
    }
  return count > 1 ? EXIT_SUCCESS : EXIT_FAILURE;
}
