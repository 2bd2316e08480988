/* SPDX-License-Identifier: Apache-2.0 */
/* The door to OpenColorIO: a module of C functions, loaded on first need. */
#ifndef NP_IMAGE_OCIO_TABLE_H
#define NP_IMAGE_OCIO_TABLE_H

#include <stdint.h>

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

#define NP_OCIO_MODULE_VERSION 1u

/* Name of the module's file and of the function in it. */
#define NP_OCIO_MODULE_FILE "nephos_ocio.so"
#define NP_OCIO_MODULE_FUNCTION "nephos_ocio_module"

typedef struct np_ocio_transform np_ocio_transform;

typedef struct np_ocio_source {
  const char *config;  /* path of the configuration */
  const char *display; /* NULL: the configuration's default */
  const char *view;    /* NULL: the display's default */
  const char *input;   /* colour space of linear light with Rec.709's primaries; NULL: by the configuration's roles */
} np_ocio_source;

/* Receiver of one message about a failure; the module never logs by itself. */
typedef struct np_ocio_listener {
  void (*fail)(void *user, neph_result result, const char *message);
  void *user;
} np_ocio_listener;

typedef struct np_ocio_module {
  uint32_t version; /* NP_OCIO_MODULE_VERSION, checked before anything else is used */

  /* The transform of a view; NULL after a failure, of which the listener has the message. */
  np_ocio_transform *(*open)(const np_ocio_source *source, const np_ocio_listener *listener);
  void (*close)(np_ocio_transform *transform); /* NULL is allowed */

  /* Maps one pixel, in place, from linear light with Rec.709's primaries to the components of the display, which may
   * lie beyond [0, 1]. Several threads may call it at once. */
  void (*map)(const np_ocio_transform *transform, float rgb[3]);
} np_ocio_module;

/* The only exported symbol of nephos_ocio.so. */
NEPH_API const np_ocio_module *nephos_ocio_module(void);

#ifdef __cplusplus
}
#endif

#endif
