/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/camera_header.h"

#include "image/exposure.h"

/* Photographic exposure (ISO 2720): EV at ISO 100. */
static neph_result write_exposure(const np_scene_camera *camera, neph_image *image) {
  double ev100;
  neph_result result = camera->has_shutter ? np_image_set_real(image, "expTime", camera->shutter_s) : NEPH_OK;
  if (!result && camera->has_iso) result = np_image_set_real(image, "isoSpeed", camera->iso);
  if (!result && np_scene_camera_get_ev100(camera, &ev100))
    result = np_image_set_real(image, NP_EXPOSURE_EV100, (double)(float)ev100);
  return result;
}

static neph_result write_lens(const np_scene_camera *scene_camera, const np_camera *camera, neph_image *image) {
  if (!scene_camera->has_lens) return NEPH_OK;
  neph_result result = np_image_set_real(image, "aperture", scene_camera->f_stop);
  if (!result && camera->lens_radius_m > 0.0f) result = np_image_set_real(image, "focus", (double)camera->focus_m);
  return result;
}

neph_result np_camera_header_write(const neph_scene *scene, const np_camera *camera, neph_eye eye, neph_image *image) {
  static const char *const kinds[] = {NULL, "orthographic", "equirectangular", "fisheye"};
  static const char *const eyes[] = {NULL, "left", "right"};
  np_image_header *header = &image->header;
  header->has_camera = true;
  header->has_ndc = np_camera_get_matrices(camera, header->world_to_camera, header->world_to_ndc);
  header->is_latlong = camera->kind == NEPH_CAMERA_EQUIRECTANGULAR;
  neph_result result =
      kinds[camera->kind] ? neph_image_set_attribute(image, "nephos:camera", kinds[camera->kind]) : NEPH_OK;
  if (!result && eyes[eye]) result = neph_image_set_attribute(image, "view", eyes[eye]);
  if (!result) result = write_lens(&scene->camera, camera, image);
  return result ? result : write_exposure(&scene->camera, image);
}
