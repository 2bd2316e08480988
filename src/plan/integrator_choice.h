/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_PLAN_INTEGRATOR_CHOICE_H
#define NP_PLAN_INTEGRATOR_CHOICE_H

#include "integrate/integrator.h"
#include "scene/scene_private.h"

/* The integrators' settings for a scene's render keys and a method of multiple scattering for the march. */
void np_integrator_choice_make(const np_scene_render *render, neph_multiple_scattering multiple,
                               np_integrator_settings *out_settings);

#endif
