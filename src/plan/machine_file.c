/* SPDX-License-Identifier: Apache-2.0 */
/* The speed of a machine in a file: JSON, flat, a factor for each kind of work. */
#include <math.h>
#include <string.h>

#include <nephos/machine.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/json.h"
#include "core/parallel.h"
#include "core/text.h"
#include "scene/scene_values.h"

static const char format_name[] = "nephos machine", version_text[] = "1";

static const char *const names[NEPH_WORK_COUNT] = {
    [NEPH_WORK_TERRAIN] = "terrain", [NEPH_WORK_BAKE] = "bake",   [NEPH_WORK_SKY] = "sky",
    [NEPH_WORK_SOLVE] = "solve",     [NEPH_WORK_MARCH] = "march", [NEPH_WORK_PATH] = "path"};

/* Largest credible ratio of a machine's speed to the constants'. */
static const double factor_max = 1e3;

const char *neph_work_get_name(neph_work work) { return (unsigned)work < NEPH_WORK_COUNT ? names[work] : NULL; }

neph_result neph_machine_save(neph_context *context, const neph_machine *machine, const char *path) {
  if (NP_LACKS(context, machine, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_json *json = np_json_create(context);
  char *text = NULL;
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  np_json_put_text(json, "format", format_name);
  np_json_put_text(json, "version", version_text);
  np_json_put_text(json, "cpu", machine->cpu);
  for (int i = 0; i < NEPH_WORK_COUNT; i++) np_json_put_real(json, names[i], machine->factor[i]);
  locale_t saved = np_values_enter();
  neph_result result = np_json_finish(json, &text);
  np_values_leave(saved);
  if (!result) result = neph_text_save(context, text, path);
  np_alloc_free(context, text);
  return result;
}

static neph_result fail_damaged(neph_context *context, const char *path, const char *what) {
  return np_fail(context, NEPH_ERROR_BAD_FILE,
                 "%s: %s, must be a file that `nephos report --calibrate` wrote: write it anew, or remove it", path,
                 what);
}

static bool is_text(const np_json_value *json, const char *key, const char *wanted) {
  const char *text = np_json_get_text(json, key);
  return text && !strcmp(text, wanted);
}

static neph_result read_values(neph_context *context, const char *path, const np_json_value *json, neph_machine *out) {
  if (!json || !is_text(json, "format", format_name)) return fail_damaged(context, path, "not a calibration");
  if (!is_text(json, "version", version_text)) return fail_damaged(context, path, "its version is not 1");
  const char *cpu = np_json_get_text(json, "cpu");
  if (!cpu) return fail_damaged(context, path, "it names no cpu");
  np_print_short(out->cpu, sizeof out->cpu, cpu);
  for (int i = 0; i < NEPH_WORK_COUNT; i++) {
    char what[64];
    const bool has_factor = np_json_get_reals(json, names[i], &out->factor[i], 1);
    np_print(what, sizeof what, "its factor of %s is missing or not in (0, %g]", names[i], factor_max);
    if (!has_factor || !(out->factor[i] > 0.0) || out->factor[i] > factor_max) return fail_damaged(context, path, what);
  }
  return NEPH_OK;
}

/* Checks the processor's name: the calibration of another machine is ignored. */
static void check_cpu(neph_context *context, const char *path, neph_machine *machine) {
  neph_machine own = NEPH_MACHINE_DEFAULT;
  np_cpu_name(own.cpu, sizeof own.cpu);
  if (!strcmp(own.cpu, machine->cpu)) return;
  np_log(context, NEPH_LOG_WARNING,
         "%s: measured with %s, this machine has %s: not taken; run `nephos report --calibrate` here", path,
         *machine->cpu ? machine->cpu : "an unknown CPU", *own.cpu ? own.cpu : "an unknown CPU");
  *machine = (neph_machine)NEPH_MACHINE_DEFAULT;
}

neph_result neph_machine_load(neph_context *context, const char *path, neph_machine *out_machine) {
  if (NP_LACKS(context, path, out_machine)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_machine machine = NEPH_MACHINE_DEFAULT;
  void *bytes = NULL;
  size_t size;
  neph_result result = np_desc_check_size(context, "neph_machine", out_machine, sizeof machine);
  if (!result) result = np_file_read_text(context, path, &bytes, &size);
  if (result) return result;
  np_json_value *json = np_json_read(bytes);
  result = read_values(context, path, json, &machine);
  np_json_value_destroy(json);
  np_alloc_free(context, bytes);
  if (result) return result;
  check_cpu(context, path, &machine);
  return np_desc_write(context, "neph_machine", &machine, sizeof machine, out_machine);
}
