/* SPDX-License-Identifier: Apache-2.0 */
#include "render/integrator_choice.h"

static np_look choose_look(const np_scene_render *render, neph_multiple_scattering multiple) {
  static const np_look_kind kinds[] = {
      [NEPH_MULTIPLE_SCATTERING_NONE] = NP_LOOK_OCTAVES,
      [NEPH_MULTIPLE_SCATTERING_OCTAVES] = NP_LOOK_OCTAVES,
      [NEPH_MULTIPLE_SCATTERING_ORDINATES] = NP_LOOK_OCTAVES,
      [NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER] = NP_LOOK_SOFTENED_BEER,
      [NEPH_MULTIPLE_SCATTERING_POWDER] = NP_LOOK_POWDER,
      [NEPH_MULTIPLE_SCATTERING_DERIVATIVE] = NP_LOOK_DERIVATIVE,
  };
  const bool is_look = multiple != NEPH_MULTIPLE_SCATTERING_NONE && multiple != NEPH_MULTIPLE_SCATTERING_ORDINATES;
  return (np_look){
      .kind = kinds[multiple],
      .gain = is_look ? (float)render->look_gain : 1.0f,
      .octave_count = multiple == NEPH_MULTIPLE_SCATTERING_OCTAVES ? render->octave_count : 1,
      .octave_light = (float)render->octave_factors[0],
      .octave_depth = (float)render->octave_factors[1],
      .octave_asymmetry = (float)render->octave_factors[2],
      .softened_share = (float)render->softened_share,
      .softened_rate = (float)render->softened_rate,
      .powder_strength = (float)render->powder_strength,
      .derivative_distance_m = (float)render->derivative_distance_m,
  };
}

void np_integrator_choice_make(const np_scene_render *render, neph_multiple_scattering multiple,
                               np_integrator_settings *out_settings) {
  *out_settings = (np_integrator_settings){
      .scattering_max = render->scattering_max,
      .is_air_traced = render->atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED,
      .look = choose_look(render, multiple),
      .tolerance = (float)render->tolerance,
      .step_voxels = (float)render->step_voxels,
      .transmittance_end = (float)render->transmittance_end,
  };
}
