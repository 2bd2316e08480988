/* SPDX-License-Identifier: Apache-2.0 */
/* A solution of the multiple scattering from inside: only transport reads it. */
#ifndef NP_TRANSPORT_SCATTERING_FIELD_PRIVATE_H
#define NP_TRANSPORT_SCATTERING_FIELD_PRIVATE_H

#include "transport/fold_light.h"
#include "transport/scattering_field.h"
#include "transport/transport_grid.h"

/* Look-ups of one instruction-set level (scattering_lookup.c). */
typedef struct np_scattering_lookup {
  void (*gather)(const np_scattering_field *field, np_dvec3 position, np_light_moments *out);
  void (*gather_cells)(const np_scattering_field *field, np_dvec3 position, np_scattering_cells *out);
  np_spectrum (*get_outgoing)(const np_scattering_field *field, const np_light_moments *moments, const float *outgoing);
  void (*fill_cell)(const np_scattering_field *field, size_t cell, np_vec3 direction, float *out);
  bool (*get_importance)(const np_scattering_field *field, np_dvec3 position, np_importance *out);
} np_scattering_lookup;

/* Number of moments that a cell keeps of the first band, and of each further one: as many, or those of the least
 * degree, which are added to the first band's times `first_ratio`. */
typedef struct np_kept_moments {
  unsigned first, further;
} np_kept_moments;

struct np_scattering_field {
  neph_context *context; /* borrowed */
  const np_scattering_lookup *lookup;
  np_scattering_medium medium;
  np_scattering_quality quality;
  np_scaled_phase *phases; /* phase function of each cloud; equal ones share their table */
  np_transport_grid grid;
  bool has_whole_grid;      /* the grid has all that it was solved on, the same for all bands */
  np_fold_light fold_light; /* light of the other tiles, where the grid has a fold */
  np_kept_moments kept;
  uint16_t *moments; /* [active][np_scattering_field_get_offset() + harmonic], halves, times `scale`: radiance but for
                        sunlight which went straight on */
  float scale[NP_BAND_COUNT];       /* powers of two */
  float first_ratio[NP_BAND_COUNT]; /* 0: the band keeps all moments */
  uint16_t *beyond; /* moments of the same cells for places that they match but do not hold; NULL: the same */
  float beyond_scale[NP_BAND_COUNT];
  float *delta_m_residual;   /* [active][band], as in np_light_moments; NULL: there is none */
  np_importance *importance; /* [active], in floats, since it may fall by thirty decades; NULL where nothing needs it */
  unsigned sweeps;           /* sweeps of the finest grid, all bands together */
};

/* The first moment of a band among those of a cell; of the number of bands: how many a cell has. */
static inline unsigned np_scattering_field_get_offset(const np_scattering_field *field, unsigned band) {
  return band == 0 ? 0 : field->kept.first + (band - 1) * field->kept.further;
}

/* Moments of a band in an active cell. */
void np_scattering_field_read_band(const np_scattering_field *field, size_t active, unsigned band,
                                   float out[NP_HARMONIC_COUNT_MAX]);

/* One without cells and light; NULL: no memory. */
np_scattering_field *np_scattering_field_create(neph_context *context);

/* A field of clouds that are not solved for, without any multiple scattering; NULL on failure. */
neph_result np_scattering_field_make_dark(neph_context *context, const np_world *world, const np_transport_desc *cells,
                                          np_scattering_field **out_field);

/* Adds light of fires, `fires`, that was solved for apart with open sides: it is in the cells, and not beyond them. */
neph_result np_scattering_field_add_fires(const np_scattering_field *others, const np_scattering_field *fires,
                                          const np_world *world, np_monitor *monitor, np_scattering_field **out_field);

/* Tables of the clouds' phase functions, resolved into a degree. */
neph_result np_scattering_field_build_phases(const np_world *world, unsigned degree, np_scattering_field *out);

#endif
