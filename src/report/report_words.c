/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_words.h"

#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>

#include "core/text.h"

const char *np_setting_get_knob(const np_setting *setting) { return setting->knob ? setting->knob->name : "scene"; }

const char *np_setting_get_integrator(const np_setting *setting) {
  return setting->integrator == NEPH_INTEGRATOR_PATH ? "path" : "march";
}

const char *np_report_get_state(const neph_report *report) {
  if (report->is_cancelled) return "cancelled before all settings were measured";
  return report->is_complete ? "complete" : "ended by an error before all settings were measured";
}

/* Value of the first line "model name : …" of the kernel's list of processors. */
static void read_processor(char *out, size_t size) {
  static const char key[] = "model name";
  char line[256];
  FILE *file = fopen("/proc/cpuinfo", "r");
  if (!file) return;
  while (fgets(line, sizeof line, file)) {
    const char *value = strchr(line, ':');
    if (strncmp(line, key, sizeof key - 1) || !value) continue;
    value += 1 + strspn(value + 1, " ");
    line[strcspn(line, "\n")] = '\0';
    np_print_short(out, size, value);
    break;
  }
  fclose(file);
}

void np_machine_describe(np_machine *out) {
  struct utsname system;
  *out = (np_machine){"unknown processor", "unknown system"};
  read_processor(out->processor, sizeof out->processor);
  if (!uname(&system))
    np_print(out->system, sizeof out->system, "%.30s %.40s %.16s", system.sysname, system.release, system.machine);
}
