/* SPDX-License-Identifier: Apache-2.0 */
/* A weather map, an EXR or a PNG as the first byte has it, and a cloud baked from it. */
#include "fuzz_support.h"

#include <nephos/cloud.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size == 0) return 0;
  neph_context *context = fuzz_get_context();
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  neph_volume *volume;
  cloud.map_file = fuzz_write_file(data[0] & 1 ? "map.exr" : "map.png", data + 1, size - 1);
  cloud.map_channels[NEPH_CLOUD_MAP_COVERAGE] = "Y";
  cloud.extent_m[0] = cloud.extent_m[1] = 400.0;
  cloud.voxel_m = 50.0;
  fuzz_expect(neph_cloud_bake(context, &cloud, &bake, &volume));
  neph_volume_release(volume);
  return 0;
}
