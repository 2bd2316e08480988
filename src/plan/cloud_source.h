/* SPDX-License-Identifier: Apache-2.0 */
/* Sources of clouds: files, bakes and volumes that calls have added. */
#ifndef NP_PLAN_CLOUD_SOURCE_H
#define NP_PLAN_CLOUD_SOURCE_H

#include "plan/request.h"

/* Source of a cloud. */
typedef enum np_cloud_source {
  NP_CLOUD_SOURCE_FILE,   /* a file that is read */
  NP_CLOUD_SOURCE_BAKE,   /* bake; written to the cloud's file, which does not exist yet, if it has one */
  NP_CLOUD_SOURCE_REBAKE, /* a bake over its file, which holds another cloud */
  NP_CLOUD_SOURCE_GIVEN   /* a volume that a call has added */
} np_cloud_source;

/* The source of a cloud of a scene; `file` is its file in the frame, NULL: it has none. */
neph_result np_plan_choose_source(const neph_scene *scene, const np_scene_cloud *cloud, const char *file, int frame,
                                  np_cloud_source *out_source);

/* The file of a cloud in the request's frame. */
typedef struct np_plan_cloud_file {
  char *path; /* owned; NULL: the cloud has none */
  np_cloud_source source;
  bool is_missing; /* its sequence has none in this frame */
} np_plan_cloud_file;

neph_result np_plan_choose_cloud_file(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud,
                                      np_plan_cloud_file *out);

#endif
