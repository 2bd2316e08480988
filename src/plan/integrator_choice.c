/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/integrator_choice.h"

#include <math.h>

void np_integrator_choice_make(const np_scene_render *render, neph_multiple_scattering multiple,
                               np_integrator_settings *out_settings) {
  *out_settings = (np_integrator_settings){
      .scattering_max = render->scattering_max,
      .is_air_traced = render->atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED,
      .multiple_scattering = multiple,
      .approximation = render->approximation,
      .tolerance = (float)render->tolerance,
      .step_voxels = (float)render->step_voxels,
      .transmittance_end = (float)render->transmittance_end,
  };
  const np_multiple_scattering_row *row = np_multiple_scattering_get_row(multiple);
  const bool is_approximated = row->needs == NP_MULTIPLE_SCATTERING_NEEDS_APPROXIMATION;
  if (!is_approximated || isinf(render->approximation.gain)) out_settings->approximation.gain = 1.0;
}
