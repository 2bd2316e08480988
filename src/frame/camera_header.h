/* SPDX-License-Identifier: Apache-2.0 */
/* Camera of a picture in its header. */
#ifndef NP_FRAME_CAMERA_HEADER_H
#define NP_FRAME_CAMERA_HEADER_H

#include "image/image_private.h"
#include "scene/camera.h"
#include "scene/scene_private.h"

/* Matrices, projection, eye, and OpenEXR's attributes of the lens and the exposure, as far as they were given. */
neph_result np_camera_header_write(const neph_scene *scene, const np_camera *camera, neph_eye eye, neph_image *image);

#endif
