/* SPDX-License-Identifier: Apache-2.0 */
/* Adjoint-driven Russian roulette and splitting: how many paths are to go on from a collision in cloud.
 *
 * What a path is worth is its throughput w times the light I that a collision at its place is expected to bring, which
 * is known from the march's solution of the multiple scattering (light/multi_scatter.h): its mean radiance, its flux,
 * and the sunlight that went straight on are enough,
 *
 *     I(x, ω) = φ/4π − g·(3/4π)·J·ω + E·p(ω·s)
 *
 * Where that is little against what the path's first collision was expected to bring, Russian roulette ends the path
 * (Vorba and Křivánek 2016, "Adjoint-driven Russian roulette and splitting in light transport simulation"; of neutrons,
 * Booth and Hendricks 1984, "Importance estimation in forward Monte Carlo calculations"). Where it is much, that alone
 * is no reason to split: in a thick white cloud I grows from the shaded side to the lit one with J constant, every step
 * adds the same variance whatever I is, and a path is best left one. Variance times time is least where w is in inverse
 * proportion to the change ΔI from one collision to the next: so paths are split when w·ΔI has grown against that of
 * the first collision. Along a step of diffuse light ΔI is (3/4π)·|J|, and of sunlight all of it. In clouds that absorb
 * both I and ΔI fall as e^{−kτ}, and paths grow in number as fast as they fade. What the solution may have wrong in I
 * counts as its change too: in even light there is no other.
 *
 * Long flights through what absorbs much pass places of which each is worth more than the one before: along them a path
 * is looked at now and then as if it collided, but that it flies on (free flights have no memory). It keeps rare paths
 * that come from far from being rare and bright.
 *
 * What is wrong in I costs time, and changes no mean.
 */
#ifndef NP_INTEGRATE_WINDOW_H
#define NP_INTEGRATE_WINDOW_H

#include "core/stable.h"
#include "light/multi_scatter.h"

/* Of a collision, or of a path that collides: then times its throughput. */
typedef struct np_window {
  float worth; /* I */
  float stake; /* ΔI */
} np_window;

/* The cell that a position is in; NULL where there is none. */
static inline const np_importance *np_window_find_cell(const np_multi_scatter *scatter, np_dvec3 position) {
  const np_transport_grid *g = &scatter->grid;
  const double p[3] = {position.x, position.y, position.z};
  int32_t at[3];
  for (int a = 0; a < 3; a++) {
    at[a] = np_transport_grid_locate(g, a, p[a]);
    if (at[a] < 0 || at[a] >= g->size[a]) return NULL;
  }
  const int32_t live = g->live[np_transport_grid_join(g, at)];
  return live == NP_TRANSPORT_CELL_NONE ? NULL : &scatter->importance[live];
}

/* For a path that flies along `direction`, against the light. False where nothing is known, or all is dark. */
static inline bool np_window_find(const np_scene_view *view, const np_view_volume *volume, np_dvec3 position,
                                  np_vec3 direction, np_window *out) {
  const np_importance *cell = np_window_find_cell(view->multi_scatter, position);
  if (!cell) return false;
  const np_scaled_phase *phase = &view->multi_scatter->phases[volume - view->volumes];
  const float asymmetry = phase->moments[1] + phase->forward;
  const np_vec3 d = direction, s = view->to_sun, lean = np_vec3_make(cell->lean[0], cell->lean[1], cell->lean[2]);
  const float versine = np_versine(d.x, d.y, d.z, s.x, s.y, s.z);
  const np_phase_lobe again = {.asymmetry = asymmetry * asymmetry}; /* of sunlight after a scattering more */
  const float once = cell->sun * np_phase_eval(&volume->phase, versine);
  const float twice = cell->sun * np_phase_eval_lobe(again, versine);
  const float around = np_maxf(cell->mean - asymmetry * np_vec3_dot(lean, d), 0.25f * cell->mean);
  out->worth = around + np_maxf(once, twice);
  out->stake = cell->slope + twice + 0.003f * around;
  return out->worth > 0.0f && out->stake > 0.0f;
}

/* The same for a path in flight, of which the light that comes against it is known, and how far it may fly until it is
 * to be asked for again. Not of the sunlight that it may meet: that is asked for at the collision. */
static inline bool np_window_find_in_flight(const np_scene_view *view, np_dvec3 position, np_vec3 direction,
                                            np_window *out, double *out_reach_m) {
  const np_importance *cell = np_window_find_cell(view->multi_scatter, position);
  *out_reach_m = cell && cell->mean > 0.0f ? (double)cell->reach_m : HUGE_VAL;
  if (isinf(*out_reach_m)) return false;
  const np_vec3 lean = np_vec3_make(cell->lean[0], cell->lean[1], cell->lean[2]);
  const float ahead = np_maxf(1.0f - np_vec3_dot(lean, direction) / cell->mean, 0.25f);
  const float sun = cell->sun * (0.25f / NP_PI_F);
  out->worth = cell->mean * ahead + sun;
  out->stake = cell->slope * ahead + sun;
  return true;
}

/* What a path was worth where it came into the light that it flies through, as far back as that changes: of a flight
 * into the depth, which of all those that start there may go far. `out` is left where nothing is known. */
static inline void np_window_find_entry(const np_scene_view *view, np_dvec3 position, np_vec3 direction,
                                        np_window *out) {
  double reach_m;
  for (int step = 0; step < 64; step++) {
    np_window before;
    if (!np_window_find_in_flight(view, position, direction, &before, &reach_m)) return;
    if (step > 0) *out = before;
    position = np_dvec3_along(position, direction, -reach_m);
  }
}

/* The probability with which a path is to go on, the larger the more it is worth against the first collision. */
static inline float np_window_survival(const np_window *path, const np_window *first) {
  const float share = path->worth / first->worth;
  return share < 0.2f ? np_maxf(share, 0.03f) : 1.0f;
}

/* As how many copies it is to go on. */
static inline unsigned np_window_copies(const np_window *path, const np_window *first) {
  const float share = path->stake / first->stake;
  return share < 2.0f ? 1 : (unsigned)np_minf(share + 0.5f, 16.0f);
}

#endif
