/* SPDX-License-Identifier: Apache-2.0 */
/* The table of nephos_ocio.so, loaded on first need, and its views. */
#include "image/ocio_view.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "core/module.h"

/* Address space of OpenColorIO, yaml-cpp and the libraries that they load: 30 MB measured. */
static const np_module_kind ocio_kind = {.file = NP_OCIO_MODULE_FILE,
                                         .function = NP_OCIO_MODULE_FUNCTION,
                                         .version = NP_OCIO_MODULE_VERSION,
                                         .purpose = "shows previews by views of OpenColorIO",
                                         .library_bytes = 64 << 20,
                                         .library_threads = 0};

bool np_ocio_module_is_present(neph_context *context) { return np_module_is_present(context, &ocio_kind); }

typedef struct opening {
  neph_context *context;
  const char *config;
  neph_result result;
} opening;

static void fail_opening(void *user, neph_result result, const char *message) {
  opening *o = user;
  o->result = np_fail(o->context, result, "%s: %s", o->config, message);
}

static neph_result check_file(neph_context *context, const char *path) {
  struct stat facts;
  if (stat(path, &facts))
    return np_fail(context, errno == ENOENT ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO, "%s: cannot be read: %s", path,
                   strerror(errno));
  if (S_ISREG(facts.st_mode)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: must be a file, a configuration of OpenColorIO", path);
}

neph_result np_ocio_view_open(neph_context *context, const neph_preview_desc *desc, np_ocio_view *out) {
  const np_ocio_source source = {desc->ocio_config, desc->ocio_display, desc->ocio_view, desc->ocio_input};
  opening o = {context, desc->ocio_config, NEPH_OK};
  const np_ocio_listener listener = {fail_opening, &o};
  const void *table;
  *out = (np_ocio_view){NULL, NULL};
  neph_result result = check_file(context, desc->ocio_config);
  if (!result) result = np_module_get(context, &ocio_kind, &table);
  if (result) return result;
  out->module = table;
  out->transform = out->module->open(&source, &listener);
  return o.result;
}

void np_ocio_view_close(np_ocio_view *view) {
  if (view->module) view->module->close(view->transform);
  *view = (np_ocio_view){NULL, NULL};
}
