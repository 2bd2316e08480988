/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/fires_apart.h"

#include "transport/scattering_field.h"
#include "volume/instance_period.h"
#include "world/emission.h"

bool np_scattering_has_fires_apart(const np_world *world) {
  bool are = false;
  for (int axis = 0; axis < 2; axis++) {
    const np_light_period period = np_instances_get_light_period(&world->clouds, axis);
    are = are || (period.length_m > 0.0 && !np_light_period_is_common(period));
  }
  for (unsigned i = 0; are && world->emission && i < world->emission->emitter_count; i++) {
    const np_bricks *bricks = world->emission->emitters[i].bricks;
    are = !bricks->is_periodic[0] && !bricks->is_periodic[1];
  }
  return are && world->emission;
}

np_world np_fires_leave_out(const np_world *world) {
  np_world out = *world;
  out.emission = NULL;
  return out;
}

np_world np_fires_leave_alone(const np_world *world) {
  np_world out = *world;
  out.sun_irradiance = out.environment_radiance = np_spectrum_grey(0.0f);
  out.night = NULL;
  out.atmosphere = NULL;
  out.camera_sky = out.cloud_sky = NULL;
  return out;
}
