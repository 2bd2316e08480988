/* SPDX-License-Identifier: Apache-2.0 */
/* The whole public interface of nephos. */
#ifndef NEPHOS_NEPHOS_H
#define NEPHOS_NEPHOS_H

#include <nephos/atmosphere.h>
#include <nephos/base.h>
#include <nephos/cloud.h>
#include <nephos/context.h>
#include <nephos/ephemeris.h>
#include <nephos/image.h>
#include <nephos/noise_texture.h>
#include <nephos/probe.h>
#include <nephos/render.h>
#include <nephos/renderer.h>
#include <nephos/scene.h>
#include <nephos/scene_build.h>
#include <nephos/terrain.h>
#include <nephos/volume.h>

#endif
