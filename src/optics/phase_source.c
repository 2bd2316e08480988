/* SPDX-License-Identifier: Apache-2.0 */
#include "optics/phase_source.h"

static np_phase make_rayleigh(const np_phase_source *s) { return (void)s, np_phase_rayleigh(); }

static np_phase make_isotropic(const np_phase_source *s) { return (void)s, np_phase_isotropic(); }

static np_phase make_droplets(const np_phase_source *s) { return np_phase_droplets(s->diameter_m); }

static np_phase make_henyey_greenstein(const np_phase_source *s) {
  return np_phase_henyey_greenstein((float)s->asymmetry);
}

static np_phase make_two_lobe(const np_phase_source *s) {
  return np_phase_two_lobe((float)s->forward, (float)s->backward, (float)s->backward_weight);
}

static np_phase make_cornette_shanks(const np_phase_source *s) { return np_phase_cornette_shanks((float)s->asymmetry); }

static np_phase make_draine(const np_phase_source *s) {
  return np_phase_draine((float)s->draine_asymmetry, (float)s->alpha);
}

static np_phase (*const makers[NP_PHASE_KIND_COUNT])(const np_phase_source *) = {
    [NP_PHASE_DROPLETS] = make_droplets,   [NP_PHASE_HENYEY_GREENSTEIN] = make_henyey_greenstein,
    [NP_PHASE_TWO_LOBE] = make_two_lobe,   [NP_PHASE_RAYLEIGH] = make_rayleigh,
    [NP_PHASE_ISOTROPIC] = make_isotropic, [NP_PHASE_CORNETTE_SHANKS] = make_cornette_shanks,
    [NP_PHASE_DRAINE] = make_draine,       [NP_PHASE_TABLE] = make_isotropic,
};

np_phase np_phase_make(const np_phase_source *source) { return makers[source->kind](source); }
