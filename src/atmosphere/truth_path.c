/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/truth_path.h"

#include <string.h>

/* Gauss-Legendre on [0, 1] with NP_TRUTH_POINTS points. */
static const double gauss_x[NP_TRUTH_POINTS] = {0.04691007703066802, 0.23076534494715845, 0.5, 0.76923465505284155,
                                                0.95308992296933198};
static const double gauss_weight[NP_TRUTH_POINTS] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                                     0.23931433524968324, 0.11846344252809454};

/* Panels of a path made for its transmittance alone, over the whole atmosphere. */
enum { SUN_PANELS = 6 };

np_truth_air np_truth_air_at(const np_medium *medium, double altitude_m) {
  const double h = fmax(altitude_m, 0.0);
  const double rayleigh = exp(-h / (double)medium->rayleigh_height_m), mie = exp(-h / (double)medium->mie_height_m);
  const double ozone = fmax(0.0, 1.0 - fabs(h - (double)medium->ozone_center_m) / (double)medium->ozone_width_m);
  np_truth_air air;
  for (int b = 0; b < NP_TRUTH_BANDS; b++) {
    air.rayleigh[b] = (double)medium->rayleigh_scattering[b] * rayleigh;
    air.mie[b] = (double)medium->mie_scattering[b] * mie;
    air.extinction[b] =
        air.rayleigh[b] + (double)medium->mie_extinction[b] * mie + (double)medium->ozone_absorption[b] * ozone;
  }
  return air;
}

static double signed_root(double x) { return copysign(sqrt(fabs(x)), x); }

/* Adds a cut to a list in ascending order, if it lies within it. */
static int add_cut(double *cuts, int count, double cut) {
  if (!(cut > cuts[0] && cut < cuts[count - 1])) return count;
  int i = count;
  for (; cuts[i - 1] > cut; i--) cuts[i] = cuts[i - 1];
  cuts[i] = cut;
  return count + 1;
}

enum { KINKS = 3, CUTS_MAX = 2 * KINKS + 3 };

static int cut_ray(const np_truth_path *path, double cuts[CUTS_MAX]) {
  const np_medium *medium = path->medium;
  const np_ray *ray = &path->ray;
  const double b = ray->r * ray->cosine;
  int count = 2;
  cuts[0] = signed_root(-path->perigee_m);
  cuts[1] = signed_root(ray->length_m - path->perigee_m);
  count = add_cut(cuts, count, 0.0);
  for (int i = -1; i <= 1; i++) {
    const double kink = (double)medium->ozone_center_m + i * (double)medium->ozone_width_m;
    const double root = b * b - (ray->altitude_m - kink) * (2.0 * medium->planet_radius_m + ray->altitude_m + kink);
    if (!(root > 0.0)) continue;
    count = add_cut(cuts, count, signed_root(-b - sqrt(root) - path->perigee_m));
    count = add_cut(cuts, count, signed_root(-b + sqrt(root) - path->perigee_m));
  }
  return count;
}

/* Adds the depth between two places in w. */
static void add_depth(const np_truth_path *path, double begin, double end, double depth[NP_TRUTH_BANDS]) {
  for (int k = 0; k < NP_TRUTH_POINTS; k++) {
    const double w = begin + gauss_x[k] * (end - begin);
    const double weight = gauss_weight[k] * (end - begin) * 2.0 * fabs(w);
    const np_truth_air air = np_truth_air_at(path->medium, np_ray_altitude(&path->ray, path->perigee_m + w * fabs(w)));
    for (int b = 0; b < NP_TRUTH_BANDS; b++) depth[b] += weight * air.extinction[b];
  }
}

void np_truth_path_build(const np_medium *medium, const np_ray *ray, int panels, np_truth_path *out_path) {
  np_truth_path *path = out_path;
  path->medium = medium;
  path->ray = *ray;
  path->perigee_m = np_ray_perigee(ray);
  path->panel_count = 0;
  memset(path->depth[0], 0, sizeof path->depth[0]);
  double cuts[CUTS_MAX];
  const int count = cut_ray(path, cuts);
  const double extent = cuts[count - 1] - cuts[0];
  path->edge[0] = cuts[0];
  for (int i = 0; extent > 0.0 && i + 1 < count; i++) {
    const double span = cuts[i + 1] - cuts[i];
    const int pieces = (int)fmax(ceil(span / extent * fmin(panels, NP_TRUTH_PANELS_MAX - CUTS_MAX)), 1.0);
    for (int k = 1; k <= pieces; k++) {
      const int at = ++path->panel_count;
      path->edge[at] = k < pieces ? cuts[i] + span * k / pieces : cuts[i + 1];
      memcpy(path->depth[at], path->depth[at - 1], sizeof path->depth[at]);
      add_depth(path, path->edge[at - 1], path->edge[at], path->depth[at]);
    }
  }
}

void np_truth_path_transmit(const np_truth_path *path, double out_transmittance[NP_TRUTH_BANDS]) {
  for (int b = 0; b < NP_TRUTH_BANDS; b++) out_transmittance[b] = exp(-path->depth[path->panel_count][b]);
}

void np_truth_path_transmit_to(const np_truth_path *path, int panel, double w,
                               double out_transmittance[NP_TRUTH_BANDS]) {
  double depth[NP_TRUTH_BANDS];
  memcpy(depth, path->depth[panel], sizeof depth);
  add_depth(path, path->edge[panel], w, depth);
  for (int b = 0; b < NP_TRUTH_BANDS; b++) out_transmittance[b] = exp(-depth[b]);
}

void np_truth_transmit_to_space(const np_medium *medium, double altitude_m, double cosine,
                                double out_transmittance[NP_TRUTH_BANDS]) {
  const np_ray ray = np_ray_on_side(medium, altitude_m, cosine, false);
  np_truth_path path;
  np_truth_path_build(medium, &ray, SUN_PANELS, &path);
  np_truth_path_transmit(&path, out_transmittance);
}

static double panel_length(const np_truth_path *path, int panel) {
  return np_truth_path_distance(path, path->edge[panel + 1]) - np_truth_path_distance(path, path->edge[panel]);
}

/* Transmittance from a place to the sun, to the tables' accuracy, for a density needs no better. */
static np_bands transmit_to_sun(const np_truth_path *path, const np_truth_guide *guide, double t) {
  const np_ray *ray = &path->ray;
  const double altitude = np_ray_altitude(ray, t), r = ray->r + (altitude - ray->altitude_m);
  const np_depth_row row = np_depth_table_row(guide->depths, altitude);
  const double sun = (ray->r * guide->sun_cosine + t * guide->angle_cosine) / r;
  return np_depth_row_sun(&row, (float)np_clamp(sun, -1.0, 1.0), np_sun_disk_make(5e-3, true));
}

/* The better of two places in a panel, for the planet's shadow may end in it. */
static np_bands guide_to_sun(const np_truth_path *path, const np_truth_guide *guide, int panel) {
  const double near = path->edge[panel], span = path->edge[panel + 1] - near;
  return np_bands_max(transmit_to_sun(path, guide, np_truth_path_distance(path, near + 0.2 * span)),
                      transmit_to_sun(path, guide, np_truth_path_distance(path, near + 0.8 * span)));
}

typedef double panel_weights[NP_TRUTH_BANDS];

/* Light that each panel scatters and lets through, and of that what comes straight from the sun: air and transmittance
 * taken in its middle. */
static void weigh_panels(const np_truth_path *path, const np_truth_guide *guide, panel_weights *scattered,
                         panel_weights *lit) {
  for (int i = 0; i < path->panel_count; i++) {
    const double t = np_truth_path_distance(path, 0.5 * (path->edge[i] + path->edge[i + 1]));
    const np_truth_air air = np_truth_air_at(path->medium, np_ray_altitude(&path->ray, t));
    const np_bands sun = guide->depths ? guide_to_sun(path, guide, i) : np_bands_grey(1.0f);
    for (int b = 0; b < NP_TRUTH_BANDS; b++) {
      const double transmittance = exp(-0.5 * (path->depth[i][b] + path->depth[i + 1][b]));
      scattered[i][b] = (air.rayleigh[b] + air.mie[b]) * transmittance * panel_length(path, i);
      lit[i][b] = scattered[i][b] * (double)sun[b];
    }
  }
}

/* Adds `share` of a density to the panels' probabilities, every band counting alike. False when there is none. */
static bool add_density(int count, panel_weights *weight, double share, double *probability) {
  double sum[NP_TRUTH_BANDS] = {0};
  int bands = 0;
  for (int b = 0; b < NP_TRUTH_BANDS; b++) {
    for (int i = 0; i < count; i++) sum[b] += weight[i][b];
    bands += sum[b] > 0.0;
  }
  for (int b = 0; b < NP_TRUTH_BANDS; b++)
    for (int i = 0; i < count && sum[b] > 0.0; i++) probability[i] += share / bands * weight[i][b] / sum[b];
  return bands;
}

void np_truth_path_prepare(np_truth_path *path, const np_truth_guide *guide) {
  panel_weights scattered[NP_TRUTH_PANELS_MAX], lit[NP_TRUTH_PANELS_MAX];
  double probability[NP_TRUTH_PANELS_MAX] = {0};
  weigh_panels(path, guide, scattered, lit);
  double rest = 1.0;
  if (add_density(path->panel_count, scattered, 0.35, probability)) rest -= 0.35;
  if (guide->depths && add_density(path->panel_count, lit, 0.35, probability)) rest -= 0.35;
  path->cumulated[0] = 0.0;
  for (int i = 0; i < path->panel_count; i++)
    path->cumulated[i + 1] = path->cumulated[i] + probability[i] + rest * panel_length(path, i) / path->ray.length_m;
}

np_truth_sample np_truth_path_sample(const np_truth_path *path, double u) {
  const double place = u * path->cumulated[path->panel_count];
  int i = 0;
  while (i + 1 < path->panel_count && place >= path->cumulated[i + 1]) i++;
  const double probability = path->cumulated[i + 1] - path->cumulated[i], span = path->edge[i + 1] - path->edge[i];
  const double w = path->edge[i] + np_clamp((place - path->cumulated[i]) / probability, 0.0, 1.0) * span;
  np_truth_sample sample = {.t = np_truth_path_distance(path, w)};
  sample.inverse_pdf_m = 2.0 * fabs(w) * span * path->cumulated[path->panel_count] / probability;
  np_truth_path_transmit_to(path, i, w, sample.transmittance);
  return sample;
}
