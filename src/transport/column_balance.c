/* SPDX-License-Identifier: Apache-2.0 */
/* Endless layers: a sweep gives the distribution of light over directions, and a balance in double gives its amount
 * (the quasi-diffusion method; Gol'din 1964, "A quasi-diffusion method for solving the kinetic equation"; reviewed by
 * Adams and Larsen 2002, "Fast iterative methods for discrete-ordinates particle transport calculations", section IV).
 *
 * With φ the integral of the radiance over directions, J the flux upwards, E = ∫μ²L / φ, s the sine of the sun's
 * light's descent and r_l, d·E₀ as in scattering_solver.c, the first two moments of the equation of transfer are
 *
 *     J′ + (1−r₀)·σ·φ = r₀·d·E₀,     (E·φ)′ + (1−r₁)·σ·J = r₁·d·E₀·s
 *
 * exactly. E is smooth, between 0 and 1, and 1/3 wherever light is diffuse: floats hold it well. They do not hold the
 * difference of two large streams, which is J in a thick layer: at depth 10⁶ it is a millionth of φ. At either face
 * J = J_out − J_in with J_out/(φ − φ_in) from the sweep as well. The system is tridiagonal, and solved directly, so
 * that the number of sweeps does not grow with the depth.
 */
#include "core/units.h"
#include "transport/transport_level.h"

enum { AXIS = 2, FLUX = 2, SECOND = 6 }; /* harmonics (1, 0) and (2, 0) */

bool np_transport_grid_is_column(const np_transport_grid *g) {
  return g->size[0] == 1 && g->size[1] == 1 && g->is_wrapped[0] && g->is_wrapped[1] && !g->is_wrapped[AXIS] &&
         g->size[AXIS] >= 3 && g->active_count == (size_t)g->size[AXIS];
}

/* Coefficients of one cell, or of the face above it. */
typedef struct balance_column {
  const np_transport_level *level;
  const np_transport_lights *lights;
  float *phi;
  int32_t size;
  double *shape;         /* E */
  double *slant, *drive; /* values at faces: (1−r₁)·σ and r₁·d·E₀·s, integrated from middle to middle */
  double *diagonal, *right, *answer; /* coefficients of the tridiagonal system, and φ */
} balance_column;

static float *get_moments(const balance_column *c, int32_t i) {
  return c->phi + (size_t)i * np_harmonics_count(c->level->grid.degree);
}

static double get_phi(const balance_column *c, int32_t i) { return sqrt(4.0 * NP_PI) * (double)get_moments(c, i)[0]; }
static double get_flux(const balance_column *c, int32_t i) {
  return sqrt(4.0 * NP_PI / 3.0) * (double)get_moments(c, i)[FLUX];
}

static double compute_shape(const balance_column *c, int32_t i) {
  const double mean = (double)get_moments(c, i)[0], second = (double)get_moments(c, i)[SECOND];
  if (!(mean > 0.0)) return 1.0 / 3.0;
  return np_clamp((1.0 + 2.0 / sqrt(5.0) * second / mean) / 3.0, 0.01, 0.99);
}

/* Adds the share of half a cell to a face's integrals. */
static void add_half(const balance_column *c, int32_t cell, double *slant, double *drive) {
  const np_transport_grid *g = &c->level->grid;
  const double half = 0.5 * np_transport_grid_width(g, AXIS, cell);
  const double ratio = (double)g->ratio[(size_t)cell * (g->degree + 1) + 1];
  const double sine = sqrt(4.0 * NP_PI / 3.0) * (double)c->lights->sun_harmonics[FLUX];
  *slant += half * (1.0 - ratio) * (double)g->extinction[cell];
  *drive += half * ratio * sine * (double)c->level->sun[cell];
}

static void fill_coefficients(const balance_column *c) {
  for (int32_t i = 0; i < c->size; i++) c->shape[i] = compute_shape(c, i);
  for (int32_t i = 0; i + 1 < c->size; i++) {
    c->slant[i] = 1e-9; /* two empty cells side by side keep a finite, if large, exchange */
    c->drive[i] = 0.0;
    add_half(c, i, &c->slant[i], &c->drive[i]);
    add_half(c, i + 1, &c->slant[i], &c->drive[i]);
  }
}

/* Fluence φ and inward flux of the light that enters at the bottom or at the top. */
static void compute_boundary_flux(const balance_column *c, bool is_top, double *out_phi, double *out_flux) {
  const np_ordinates *o = c->lights->ordinates;
  const np_border_faces *border = c->lights->border;
  *out_phi = *out_flux = 0.0;
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++) {
    if ((octant >> AXIS & 1u) != (is_top ? 1u : 0u)) continue;
    const np_border_nodes *nodes = np_border_get_nodes(border, octant, AXIS);
    const float *middle = np_border_get_node(border, octant, AXIS, nodes[1].count / 2, nodes[0].count / 2);
    for (unsigned n = 0; n < o->count; n++) {
      const unsigned block = n / NP_ORDINATE_LANES, lane = n % NP_ORDINATE_LANES;
      const double radiance = (double)(o->weight[block][lane] * middle[n]);
      *out_phi += radiance;
      *out_flux += radiance * (double)o->cosine[AXIS][block][lane];
    }
  }
}

/* J_out = rate·(φ − φ_in) in the empty cell beyond a face. */
static double compute_outflow_rate(const balance_column *c, bool is_top, double phi_in, double flux_in) {
  const int32_t cell = is_top ? c->size - 1 : 0;
  const double flux = (is_top ? 1.0 : -1.0) * get_flux(c, cell) + flux_in, phi = get_phi(c, cell) - phi_in;
  return phi > 1e-5 * phi_in && phi > 0.0 ? np_clamp(flux / phi, 0.01, 1.0) : 0.5;
}

/* Sets row i of the tridiagonal system: flux through the faces plus absorption equals the source. */
static void fill_rows(const balance_column *c) {
  const np_transport_grid *g = &c->level->grid;
  for (int32_t i = 0; i < c->size; i++) {
    const double width = np_transport_grid_width(g, AXIS, i), ratio = (double)g->ratio[(size_t)i * (g->degree + 1)];
    c->diagonal[i] = width * (1.0 - ratio) * (double)g->extinction[i];
    c->right[i] = width * ratio * (double)c->level->sun[i];
    if (c->level->emission) c->right[i] += width * sqrt(4.0 * NP_PI) * (double)c->level->emission[i];
    for (int32_t face = i - 1; face <= i; face++) {
      if (face < 0 || face + 1 >= c->size) continue;
      c->diagonal[i] += c->shape[i] / c->slant[face];
      c->right[i] -= (face == i ? 1.0 : -1.0) * c->drive[face] / c->slant[face];
    }
  }
  for (int top = 0; top < 2; top++) {
    const int32_t cell = top ? c->size - 1 : 0;
    double phi, flux;
    compute_boundary_flux(c, top, &phi, &flux);
    const double rate = compute_outflow_rate(c, top, phi, flux);
    c->diagonal[cell] += rate;
    c->right[cell] += rate * phi + flux;
  }
}

/* Elimination from the bottom up; off the diagonal stand −E/slant of the neighbour. */
static void solve_rows(const balance_column *c) {
  for (int32_t i = 1; i < c->size; i++) {
    const double factor = c->shape[i - 1] / c->slant[i - 1] / c->diagonal[i - 1];
    c->diagonal[i] -= factor * c->shape[i] / c->slant[i - 1];
    c->right[i] += factor * c->right[i - 1];
  }
  for (int32_t i = c->size - 1; i >= 0; i--) {
    const double above = i + 1 < c->size ? c->shape[i + 1] / c->slant[i] * c->answer[i + 1] : 0.0;
    c->answer[i] = (c->right[i] + above) / c->diagonal[i];
  }
}

static double compute_face_flux(const balance_column *c, int32_t face) {
  return (c->shape[face] * c->answer[face] - c->shape[face + 1] * c->answer[face + 1] + c->drive[face]) /
         c->slant[face];
}

static void store_answer(const balance_column *c) {
  for (int32_t i = 0; i < c->size; i++) {
    const double below = compute_face_flux(c, i > 0 ? i - 1 : 0),
                 above = compute_face_flux(c, i + 1 < c->size ? i : i - 1);
    get_moments(c, i)[0] = (float)(fmax(0.0, c->answer[i]) / sqrt(4.0 * NP_PI));
    get_moments(c, i)[FLUX] = (float)(0.5 * (below + above) * sqrt(0.75 / NP_PI));
  }
}

void np_column_balance(const np_transport_lights *lights, const np_transport_level *level, double *scratch,
                       float *phi) {
  const int32_t n = level->grid.size[AXIS];
  const balance_column c = {.level = level,
                            .lights = lights,
                            .phi = phi,
                            .size = n,
                            .shape = scratch,
                            .slant = scratch + n,
                            .drive = scratch + 2 * n,
                            .diagonal = scratch + 3 * n,
                            .right = scratch + 4 * n,
                            .answer = scratch + 5 * n};
  fill_coefficients(&c);
  fill_rows(&c);
  solve_rows(&c);
  store_answer(&c);
}
