/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/reference_path.h"

#include <assert.h>
#include <string.h>

#include "atmosphere/ray_cuts.h"

/* Gauss-Legendre on [0, 1] with NP_REFERENCE_POINTS points. */
static const double gauss_x[NP_REFERENCE_POINTS] = {0.04691007703066802, 0.23076534494715845, 0.5, 0.76923465505284155,
                                                    0.95308992296933198};
static const double gauss_weight[NP_REFERENCE_POINTS] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                                         0.23931433524968324, 0.11846344252809454};

/* Panels over the whole atmosphere of a path that only serves its transmittance. */
enum { SUN_PANELS = 6 };

void np_reference_air_at(const np_medium *medium, double altitude_m, np_reference_air *out_air) {
  const double h = fmax(altitude_m, 0.0);
  memset(out_air->rayleigh, 0, sizeof out_air->rayleigh);
  memset(out_air->aerosol, 0, (size_t)medium->aerosol_count * sizeof *out_air->aerosol);
  for (int i = 0; i < medium->layer_count; i++) {
    const np_layer *layer = &medium->layers[i];
    const double density = np_layer_density_exact(layer, h);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
      out_air->rayleigh[b] += density * (double)layer->rayleigh[b];
      for (int k = 0; k < layer->part_count; k++)
        out_air->aerosol[layer->part[k].aerosol][b] += density * (double)layer->part[k].scattering[b];
    }
  }
}

void np_reference_air_sum(const np_medium *medium, const np_reference_air *air,
                          double out_scattering[NP_REFERENCE_BANDS]) {
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    out_scattering[b] = air->rayleigh[b];
    for (int i = 0; i < medium->aerosol_count; i++) out_scattering[b] += air->aerosol[i][b];
  }
}

static void compute_scattering(const np_medium *medium, double altitude_m, double out_scattering[NP_REFERENCE_BANDS]) {
  np_reference_air air;
  np_reference_air_at(medium, altitude_m, &air);
  np_reference_air_sum(medium, &air, out_scattering);
}

void np_reference_air_eval(const np_medium *medium, const np_reference_air *air, double versine,
                           double out_scattering[NP_REFERENCE_BANDS]) {
  const double rayleigh = np_reference_rayleigh(versine);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_scattering[b] = air->rayleigh[b] * rayleigh;
  for (int i = 0; i < medium->aerosol_count; i++) {
    const double phase = (double)np_phase_eval(&medium->aerosol[i].phase, (float)versine);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_scattering[b] += air->aerosol[i][b] * phase;
  }
}

np_dvec3 np_reference_compute_bright_direction(np_dvec3 zenith, np_dvec3 to_sun) {
  const double rise = fmax(0.06 - np_dvec3_dot(zenith, to_sun), 0.0);
  return np_dvec3_normalize(np_dvec3_add(to_sun, np_dvec3_scale(zenith, rise)));
}

double np_reference_bright_share(np_dvec3 zenith, np_dvec3 to_sun) {
  return np_dvec3_dot(zenith, to_sun) > 0.05 ? 0.15 : 0.5;
}

static double signed_root(double x) { return copysign(sqrt(fabs(x)), x); }

/* Adds the depth between two points in w. */
static void add_depth(const np_reference_path *path, double begin, double end, double depth[NP_REFERENCE_BANDS]) {
  const np_medium *medium = path->medium;
  for (int k = 0; k < NP_REFERENCE_POINTS; k++) {
    const double w = begin + gauss_x[k] * (end - begin);
    const double weight = gauss_weight[k] * (end - begin) * 2.0 * fabs(w);
    const double h = fmax(np_ray_altitude(&path->ray, path->perigee_m + w * fabs(w)), 0.0);
    for (int i = 0; i < medium->layer_count; i++) {
      const double part = weight * np_layer_density_exact(&medium->layers[i], h);
      for (int b = 0; b < NP_REFERENCE_BANDS; b++) depth[b] += part * (double)medium->layers[i].extinction[b];
    }
  }
}

static void add_panels(np_reference_path *path, double begin, double end, int count) {
  for (int k = 1; k <= count; k++) {
    const int at = ++path->panel_count;
    assert((size_t)at < sizeof path->edge / sizeof *path->edge && begin < end);
    path->edge[at] = k < count ? begin + (end - begin) * k / count : end;
    memcpy(path->depth[at], path->depth[at - 1], sizeof path->depth[at]);
    add_depth(path, path->edge[at - 1], path->edge[at], path->depth[at]);
  }
}

/* Limits on panels, at least one for each piece, and on altitudes, each crossed twice: together they fit the arrays. */
enum { PANELS_MOST = 64, CUTS_MOST = 30 };

void np_reference_path_build(const np_medium *medium, const np_ray *ray, int panels, np_reference_path *out_path) {
  np_reference_path *path = out_path;
  path->medium = medium;
  path->ray = *ray;
  path->perigee_m = np_ray_perigee(ray);
  path->panel_count = 0;
  memset(path->depth[0], 0, sizeof path->depth[0]);
  path->edge[0] = signed_root(-path->perigee_m);
  const double last = signed_root(ray->length_m - path->perigee_m), extent = last - path->edge[0];
  const double panels_per_unit = fmin(panels, PANELS_MOST) / extent;
  np_ray_cuts cuts = np_ray_cuts_make(medium, ray, CUTS_MOST);
  for (double from = path->edge[0]; from < last;) {
    const double cut = signed_root(np_ray_cuts_next(&cuts) - path->perigee_m), to = fmin(cut, last);
    if (cut <= from) continue;
    add_panels(path, from, to, (int)fmax(ceil((to - from) * panels_per_unit), 1.0));
    from = to;
  }
}

void np_reference_path_transmit(const np_reference_path *path, double out_transmittance[NP_REFERENCE_BANDS]) {
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_transmittance[b] = exp(-path->depth[path->panel_count][b]);
}

void np_reference_path_transmit_to(const np_reference_path *path, int panel, double w,
                                   double out_transmittance[NP_REFERENCE_BANDS]) {
  double depth[NP_REFERENCE_BANDS];
  memcpy(depth, path->depth[panel], sizeof depth);
  add_depth(path, path->edge[panel], w, depth);
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) out_transmittance[b] = exp(-depth[b]);
}

void np_reference_transmit_to_space(const np_medium *medium, double altitude_m, double cosine,
                                    double out_transmittance[NP_REFERENCE_BANDS]) {
  const np_ray ray = np_ray_on_side(medium, altitude_m, cosine, false);
  np_reference_path path;
  np_reference_path_build(medium, &ray, SUN_PANELS, &path);
  np_reference_path_transmit(&path, out_transmittance);
}

/* Transmittance to the sun with the accuracy of tables, which is enough for a sampling density. */
static np_bands transmit_to_sun(const np_reference_path *path, const np_reference_guide *guide, double t) {
  const np_ray *ray = &path->ray;
  const double altitude = np_ray_altitude(ray, t), r = ray->r + (altitude - ray->altitude_m);
  const np_depth_row row = np_depth_table_row(guide->depths, altitude);
  const double sun = (ray->r * guide->sun_cosine + t * guide->angle_cosine) / r;
  return np_depth_row_sun(&row, (float)np_clamp(sun, -1.0, 1.0), np_sun_disk_make(5e-3, true));
}

/* Larger transmittance of two points in a panel: the planet's shadow may end within it. */
static np_bands guide_to_sun(const np_reference_path *path, const np_reference_guide *guide, int panel) {
  const double near = path->edge[panel], span = path->edge[panel + 1] - near;
  return np_bands_max(transmit_to_sun(path, guide, np_reference_path_distance(path, near + 0.2 * span)),
                      transmit_to_sun(path, guide, np_reference_path_distance(path, near + 0.8 * span)));
}

void np_reference_path_weigh(const np_reference_path *path, const np_reference_guide *guide,
                             np_reference_weights *out_scattered, np_reference_weights *out_lit) {
  for (int i = 0; i < path->panel_count; i++) {
    const double t = np_reference_path_distance(path, 0.5 * (path->edge[i] + path->edge[i + 1]));
    double scattering[NP_REFERENCE_BANDS];
    compute_scattering(path->medium, np_ray_altitude(&path->ray, t), scattering);
    const np_bands sun = guide->depths ? guide_to_sun(path, guide, i) : np_bands_grey(1.0f);
    for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
      const double transmittance = exp(-0.5 * (path->depth[i][b] + path->depth[i + 1][b]));
      out_scattered[i][b] = scattering[b] * transmittance * np_reference_panel_length(path, i);
      out_lit[i][b] = out_scattered[i][b] * (double)sun[b];
    }
  }
}

/* Adds `share` of a density to the probabilities of panels, with equal weight for every band. False if the density is
 * 0. */
static bool add_density(int count, np_reference_weights *weight, double share, double *probability) {
  double sum[NP_REFERENCE_BANDS] = {0};
  int bands = 0;
  for (int b = 0; b < NP_REFERENCE_BANDS; b++) {
    for (int i = 0; i < count; i++) sum[b] += weight[i][b];
    bands += sum[b] > 0.0;
  }
  for (int b = 0; b < NP_REFERENCE_BANDS; b++)
    for (int i = 0; i < count && sum[b] > 0.0; i++) probability[i] += share / bands * weight[i][b] / sum[b];
  return bands;
}

void np_reference_path_prepare(np_reference_path *path, const np_reference_guide *guide) {
  np_reference_weights scattered[NP_REFERENCE_PANELS_MAX], lit[NP_REFERENCE_PANELS_MAX];
  double probability[NP_REFERENCE_PANELS_MAX] = {0};
  np_reference_path_weigh(path, guide, scattered, lit);
  double rest = 1.0;
  if (add_density(path->panel_count, scattered, 0.35, probability)) rest -= 0.35;
  if (guide->depths && add_density(path->panel_count, lit, 0.35, probability)) rest -= 0.35;
  path->cumulated[0] = 0.0;
  for (int i = 0; i < path->panel_count; i++)
    path->cumulated[i + 1] =
        path->cumulated[i] + probability[i] + rest * np_reference_panel_length(path, i) / path->ray.length_m;
}

np_reference_sample np_reference_path_sample(const np_reference_path *path, double u) {
  const double place = u * path->cumulated[path->panel_count];
  int i = 0;
  while (i + 1 < path->panel_count && place >= path->cumulated[i + 1]) i++;
  const double probability = path->cumulated[i + 1] - path->cumulated[i], span = path->edge[i + 1] - path->edge[i];
  const double w = path->edge[i] + np_clamp((place - path->cumulated[i]) / probability, 0.0, 1.0) * span;
  np_reference_sample sample = {.t = np_reference_path_distance(path, w)};
  sample.inverse_pdf_m = 2.0 * fabs(w) * span * path->cumulated[path->panel_count] / probability;
  np_reference_path_transmit_to(path, i, w, sample.transmittance);
  return sample;
}
