/* SPDX-License-Identifier: Apache-2.0 */
/* A solution of the multiple scattering without light, with the phase functions of its clouds. */
#include "core/alloc.h"
#include "core/isa.h"
#include "transport/scattering_field_private.h"

/* Equal phase functions share one table. */
static neph_result build_phase(const np_world *world, unsigned cloud, unsigned degree, np_scattering_field *out) {
  const np_phase *phase = &world->clouds.at[cloud].phase;
  np_scaled_cloud *scaled = &out->medium.clouds[cloud];
  np_scaled_phase *own = &out->phases[cloud];
  unsigned same = 0;
  while (same < cloud && !np_phase_is_equal(&out->phases[same].phase, phase)) same++;
  if (same < cloud) {
    *own = out->phases[same];
    *scaled = out->medium.clouds[same];
    return NEPH_OK;
  }
  const neph_result result = np_scaled_phase_init(out->context, phase, degree, own);
  *scaled = (np_scaled_cloud){.forward = own->forward,
                              .least_forward = own->least_forward,
                              .asymmetry = own->moments[1] + own->forward,
                              .second = own->moments[2] + own->forward,
                              .phase_kind = (unsigned char)out->medium.phase_count};
  out->medium.phase_count += !result;
  return result;
}

neph_result np_scattering_field_build_phases(const np_world *world, unsigned degree, np_scattering_field *out) {
  out->phases = np_alloc(out->context, world->clouds.count, sizeof *out->phases);
  neph_result result = out->phases ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned v = 0; v < world->clouds.count && !result; v++) {
    result = build_phase(world, v, degree, out);
    out->medium.cloud_count += !result;
  }
  return result;
}

extern const np_scattering_lookup np_scattering_lookup_v1, np_scattering_lookup_v3, np_scattering_lookup_v4;

np_scattering_field *np_scattering_field_create(neph_context *context) {
  static const np_scattering_lookup *const lookups[NP_ISA_COUNT] = {&np_scattering_lookup_v1, &np_scattering_lookup_v3,
                                                                    &np_scattering_lookup_v4};
  np_scattering_field *field = np_alloc(context, 1, sizeof *field);
  if (!field) return NULL;
  field->context = context;
  field->lookup = lookups[neph_context_get_isa(context)];
  return field;
}

void np_scattering_field_destroy(np_scattering_field *field) {
  if (!field) return;
  for (unsigned v = 0, known = 0; v < field->medium.cloud_count; v++) {
    if (field->medium.clouds[v].phase_kind < known) continue;
    known++;
    np_scaled_phase_clear(&field->phases[v]);
  }
  np_alloc_free(field->context, field->phases);
  np_transport_grid_clear(&field->grid);
  np_alloc_free(field->context, field->moments);
  np_alloc_free(field->context, field->beyond);
  np_alloc_free(field->context, field->importance);
  np_alloc_free(field->context, field->delta_m_residual);
  np_alloc_free(field->context, field);
}
