/* SPDX-License-Identifier: Apache-2.0 */
/* The whole public interface of nephos.
 *
 * Threads: calls on different objects may run at the same time, of one context too; they share its threads. Of one
 * object:
 *
 * - context: any calls at the same time.
 * - volume, terrain, atmosphere: any calls at the same time; they never change after creation. Retain and release count
 *   atomically.
 * - image, sky: any calls at the same time that take it as const; one that does not takes it alone.
 * - scene: one call at a time, whatever it takes it as: rendering leaves in it what the next picture may use.
 * - renderer: one call at a time, but for neph_renderer_cancel, which may come from any thread. A second picture at the
 *   same time is refused (NEPH_ERROR_INVALID_ARGUMENT). A scene that it renders is in use, too.
 *
 * Callbacks of progress and tiles come on the thread of the call; those of the log and the allocator on any
 * thread, several at once. A callback may call the library, but not on the objects of the call that it comes from.
 *
 * NULL: an object is optional only where its function says so. Without it functions that return neph_result return
 * NEPH_ERROR_INVALID_ARGUMENT, and log the argument's name where they have a context; getters return 0, NULL or false,
 * or write zeros; functions without a result do nothing. Their other pointers are as objects; `desc` may be NULL where
 * its function says so, `user` always.
 *
 * Structs that callers hand over begin with struct_size: start them from their default initializers, NEPH_…_DEFAULT.
 */
#ifndef NEPHOS_NEPHOS_H
#define NEPHOS_NEPHOS_H

#include <nephos/atmosphere.h>
#include <nephos/base.h>
#include <nephos/check.h>
#include <nephos/cloud.h>
#include <nephos/context.h>
#include <nephos/ephemeris.h>
#include <nephos/exposure.h>
#include <nephos/files.h>
#include <nephos/image.h>
#include <nephos/machine.h>
#include <nephos/names.h>
#include <nephos/noise_texture.h>
#include <nephos/parts.h>
#include <nephos/phase.h>
#include <nephos/probe.h>
#include <nephos/render.h>
#include <nephos/renderer.h>
#include <nephos/report.h>
#include <nephos/scene.h>
#include <nephos/scene_build.h>
#include <nephos/terrain.h>
#include <nephos/text.h>
#include <nephos/textures.h>
#include <nephos/volume.h>

#endif
