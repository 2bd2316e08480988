/* SPDX-License-Identifier: Apache-2.0 */
/* Headers of the files of clouds. */
#ifndef NP_PLAN_INPUT_HEADERS_H
#define NP_PLAN_INPUT_HEADERS_H

#include "plan/inputs.h"

/* Reads the header of a cloud's file and places its box; an unknown one where there is no file. */
neph_result np_input_file_read(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               np_input_file *out);

#endif
