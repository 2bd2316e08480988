/* SPDX-License-Identifier: Apache-2.0 */
/* Displacement of the air at a height relative to the base, by the skew and by the wind profile.
 *
 * Rising air is displaced by the difference of the wind at the base and at the heights that it passes: D(h) = ∫₀ʰ (w(z)
 * − w(0))/u dz, with a rising speed u of six thicknesses per lifetime. The profile is linear between its five heights,
 * so that D is a parabola in each of the four layers.
 *
 * Below the base the wind falls linearly to 0 at sea level. Rain falls through it at a speed v and lags behind its
 * cloud: D(h) = −w(0)·h²/(2·v·base). */
#include "cloud/cloud_wind.h"

#include <math.h>

#include "core/math.h"

enum { LAYERS = NEPH_CLOUD_PROFILE_POINTS - 1 };

static const double rises = 6.0; /* rises of a thermal through the thickness, per lifetime */

static const double falls_m_s =
    5.0; /* fall speed of rain; drops of 1 to 2 mm fall at 4 to 6.5 m/s (Gunn and Kinzer 1949) */

/* Sine and cosine of an angle, by their series within 45° of a multiple of 90°: equal bits on every machine. */
void np_cloud_compute_direction(double angle_rad, double out_sine_cosine[2]) {
  const double quarter = 0.5 * 3.14159265358979323846, quarters = floor(angle_rad / quarter + 0.5);
  const double x = angle_rad - quarter * quarters;
  const double x2 = x * x;
  const double sine = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72 * (1 - x2 / 110)))));
  const double cosine = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56 * (1 - x2 / 90 * (1 - x2 / 132)))));
  const int turn = (int)(quarters - 4.0 * floor(quarters / 4.0));
  const double sines[4] = {sine, cosine, -sine, -cosine};
  out_sine_cosine[0] = sines[turn];
  out_sine_cosine[1] = sines[(turn + 1) % 4];
}

static void set_layers(const neph_cloud_desc *desc, np_cloud_wind *wind) {
  const double layer_s = desc->lifetime_s / (rises * LAYERS);
  for (int k = 0; k <= LAYERS; k++) {
    double from[2];
    np_cloud_compute_direction(desc->wind_direction_rad[k], from);
    for (int a = 0; a < 2; a++) wind->gain_m[k][a] = (float)(-desc->wind_speed_m_s[k] * from[a] * layer_s);
  }
  for (int a = 0; a < 2; a++) {
    const float base_m = wind->gain_m[0][a];
    if (desc->base_altitude_m > 0)
      wind->lag_per_m[a] = (float)((double)base_m / layer_s / (2 * falls_m_s * desc->base_altitude_m));
    for (int k = 0; k <= LAYERS; k++) {
      wind->gain_m[k][a] -= base_m;
      wind->gain_max_m[a] = fmaxf(wind->gain_max_m[a], fabsf(wind->gain_m[k][a]));
      if (k > 0) wind->at_m[k][a] = wind->at_m[k - 1][a] + 0.5f * (wind->gain_m[k - 1][a] + wind->gain_m[k][a]);
    }
  }
}

np_cloud_wind np_cloud_wind_make(const neph_cloud_desc *desc, np_cloud_skew skew) {
  np_cloud_wind wind = {.thickness_m = (float)desc->thickness_m,
                        .skew_m = {(float)desc->skew_m[0], (float)desc->skew_m[1]},
                        .skew = skew,
                        .has_winds = desc->has_winds,
                        .has_shift = desc->has_winds || desc->skew_m[0] != 0 || desc->skew_m[1] != 0};
  if (desc->has_winds) set_layers(desc, &wind);
  return wind;
}

void np_cloud_wind_carry(const np_cloud_wind *wind, float height_m, float out_m[2]) {
  out_m[0] = out_m[1] = 0.0f;
  if (!wind->has_winds) return;
  const float below_m = np_minf(height_m, 0.0f);
  const float scaled = np_clampf(height_m / wind->thickness_m, 0.0f, 1.0f) * LAYERS;
  const int k = scaled < LAYERS ? (int)scaled : LAYERS - 1;
  const float t = scaled - (float)k;
  for (int a = 0; a < 2; a++)
    out_m[a] = wind->at_m[k][a] + t * (wind->gain_m[k][a] + 0.5f * t * (wind->gain_m[k + 1][a] - wind->gain_m[k][a])) -
               wind->lag_per_m[a] * below_m * below_m;
}

/* Share of the skew at a height. */
static float compute_skew_share(const np_cloud_wind *wind, float height_m) {
  const float t = height_m / wind->thickness_m, held = np_clampf(t, 0.0f, 1.0f);
  if (wind->skew == NP_CLOUD_SKEW_HOOKED) return held * (2.0f - held);
  return wind->skew == NP_CLOUD_SKEW_TRAILING && t > 0.0f ? t * t : t;
}

void np_cloud_wind_shift(const np_cloud_wind *wind, float height_m, float out_m[2]) {
  const float share = compute_skew_share(wind, height_m);
  np_cloud_wind_carry(wind, height_m, out_m);
  for (int a = 0; a < 2; a++) out_m[a] += wind->skew_m[a] * share;
}

/* The skew is extreme at the ends, the lag of rain at the lower end and at the base; in between, the wind displaces no
 * farther than at its strongest. */
void np_cloud_wind_bound(const np_cloud_wind *wind, float low_m, float high_m, np_interval out_m[2]) {
  float carried_m[3][2];
  const float share[2] = {compute_skew_share(wind, low_m), compute_skew_share(wind, high_m)};
  const float foot_m = np_clampf(0.0f, low_m, high_m), layer_m = wind->thickness_m / LAYERS;
  const float layers = np_maxf(high_m - np_maxf(low_m, 0.0f), 0.0f) / layer_m;
  np_cloud_wind_carry(wind, low_m, carried_m[0]);
  np_cloud_wind_carry(wind, foot_m, carried_m[1]);
  np_cloud_wind_carry(wind, high_m, carried_m[2]);
  for (int a = 0; a < 2; a++) {
    const float skew_m = wind->skew_m[a], pad_m = 0.5001f * layers * wind->gain_max_m[a];
    const float *low = carried_m[0], *foot = carried_m[1], *high = carried_m[2];
    out_m[a].low = fminf(share[0] * skew_m, share[1] * skew_m) + fminf(low[a], fminf(foot[a], high[a])) - pad_m;
    out_m[a].high = fmaxf(share[0] * skew_m, share[1] * skew_m) + fmaxf(low[a], fmaxf(foot[a], high[a])) + pad_m;
  }
}
