/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups in a solution of the multiple scattering. */
#include "core/half.h"
#include "transport/scattering_field_private.h"

void np_scattering_field_set_world(np_scattering_field *field, const np_world *world) {
  for (unsigned v = 0; v < field->medium.cloud_count; v++) field->phases[v].phase = world->clouds.at[v].phase;
}

np_scattering_quality np_scattering_field_get_quality(const np_scattering_field *field) { return field->quality; }

unsigned np_scattering_field_get_degree(const np_scattering_field *field) { return field->grid.degree; }

const np_scattering_medium *np_scattering_field_get_medium(const np_scattering_field *field) { return &field->medium; }

float np_scattering_compute_least_scale(const np_phase *phase, np_spectrum albedo) {
  return 1.0f - np_scaled_phase_compute_forward(phase, NP_DEGREE_MIN) * np_spectrum_max(albedo);
}

void np_scattering_field_fill_column(const np_scattering_field *field, unsigned cloud, float versine,
                                     np_peak_column *out) {
  np_scaled_phase_fill_column(&field->phases[cloud], versine, out);
}

void np_scattering_field_fill_harmonics(const np_scattering_field *field, np_vec3 direction,
                                        float out[NP_HARMONIC_COUNT_MAX]) {
  np_harmonics_eval(field->grid.degree, direction, out);
}

void np_scattering_field_fill_outgoing(const np_scattering_field *field, unsigned cloud,
                                       const float harmonics[NP_HARMONIC_COUNT_MAX], float out[NP_HARMONIC_COUNT_MAX]) {
  const np_scaled_phase *phase = &field->phases[cloud];
  for (unsigned l = 0, i = 0; l <= phase->degree; l++)
    for (; i < (l + 1) * (l + 1); i++) out[i] = phase->moments[l] * harmonics[i];
}

void np_scattering_field_read_band(const np_scattering_field *field, size_t active, unsigned band,
                                   float out[NP_HARMONIC_COUNT_MAX]) {
  const uint16_t *first = field->moments + active * np_scattering_field_get_offset(field, field->medium.band_count);
  const uint16_t *own = first + np_scattering_field_get_offset(field, band);
  const unsigned kept = band == 0 ? field->kept.first : field->kept.further;
  const float scale = field->scale[band], ratio = field->first_ratio[band] * field->scale[0];
  for (unsigned i = 0; i < field->kept.first; i++)
    out[i] = ratio * np_half_to_float(first[i]) + (i < kept ? scale * np_half_to_float(own[i]) : 0.0f);
}

void np_scattering_field_gather(const np_scattering_field *field, np_dvec3 position, np_light_moments *out) {
  field->lookup->gather(field, position, out);
}

np_spectrum np_scattering_field_get_outgoing(const np_scattering_field *field, const np_light_moments *moments,
                                             const float outgoing[NP_HARMONIC_COUNT_MAX]) {
  return field->lookup->get_outgoing(field, moments, outgoing);
}

const np_transport_fold *np_scattering_field_get_fold(const np_scattering_field *field) { return &field->grid.fold; }

void np_scattering_field_bound(const np_scattering_field *field, np_dvec3 *out_low, np_dvec3 *out_high) {
  const np_transport_grid *g = &field->grid;
  *out_low = np_dvec3_make(g->edge_m[0][0], g->edge_m[1][0], g->edge_m[2][0]);
  *out_high = np_dvec3_make(g->edge_m[0][g->size[0]], g->edge_m[1][g->size[1]], g->edge_m[2][g->size[2]]);
}

bool np_scattering_field_holds(const np_scattering_field *field, np_dvec3 position) {
  const np_transport_grid *g = &field->grid;
  if (g->fold.period_m > 0.0) return np_transport_fold_is_within(&g->fold, position, 0.0);
  const double p[3] = {position.x, position.y, position.z};
  bool is_held = true;
  for (int a = 0; a < 3; a++) {
    const double first = np_transport_grid_middle(g, a, 0), last = np_transport_grid_middle(g, a, g->size[a] - 1);
    is_held = is_held && (!g->is_wrapped[a] || (p[a] >= first && p[a] <= last));
  }
  return is_held;
}

size_t np_scattering_field_count_cells(const np_scattering_field *field) { return field->grid.active_count; }

np_dvec3 np_scattering_field_get_cell(const np_scattering_field *field, size_t cell, double *out_width) {
  const np_transport_grid *g = &field->grid;
  int32_t at[3];
  np_transport_grid_split(g, g->cell[cell], at);
  *out_width = 0.0;
  for (int a = 0; a < 3; a++) *out_width = fmax(*out_width, np_transport_grid_width(g, a, at[a]));
  return np_transport_grid_centre(g, g->cell[cell]);
}

void np_scattering_field_fill_cell(const np_scattering_field *field, size_t cell, np_vec3 direction, float *out) {
  field->lookup->fill_cell(field, cell, direction, out);
}

void np_scattering_field_gather_cells(const np_scattering_field *field, np_dvec3 position, np_scattering_cells *out) {
  field->lookup->gather_cells(field, position, out);
}

bool np_scattering_field_get_importance(const np_scattering_field *field, np_dvec3 position, np_importance *out) {
  return field->lookup->get_importance(field, position, out);
}
