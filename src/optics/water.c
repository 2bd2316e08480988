/* SPDX-License-Identifier: Apache-2.0 */
#include "optics/water.h"

#include "core/units.h"

static const float refractive_index = 1.33f;

/* Least cosine of a view with the surface: at lower angles waves hide all but their crests. */
static const float cosine_least = 1e-4f;

float np_water_fresnel(float cosine) {
  const float c = np_clampf(cosine, 0.0f, 1.0f), n = refractive_index;
  const float g = sqrtf(n * n - 1.0f + c * c);
  const float across = (g - c) / (g + c), along = (c * (g + c) - 1.0f) / (c * (g - c) + 1.0f);
  return 0.5f * across * across * (1.0f + along * along);
}

/* ---- Facets, in a frame whose z is the zenith ---- */

/* Smith's Λ for Beckmann's distribution (Walter et al. 2007, section 5.3; Heitz 2014, eq. 72): exact. */
static float compute_lambda(float roughness, float cosine) {
  const float c = np_clampf(cosine, cosine_least, 1.0f), sine = sqrtf(np_maxf(1.0f - c * c, 0.0f));
  if (sine < 1e-6f) return 0.0f;
  const float a = c / (roughness * sine);
  return a > 6.0f ? 0.0f : 0.5f * (expf(-a * a) / (a * sqrtf(NP_PI_F)) - erfcf(a));
}

static float compute_distribution(float roughness, float cosine) {
  const float c2 = cosine * cosine, a2 = roughness * roughness;
  return expf(-(1.0f - c2) / (c2 * a2)) / (NP_PI_F * a2 * c2 * c2);
}

/* erf⁻¹ within 4e-7 or so (Giles 2010, "Approximating the erfinv function"). */
static float invert_erf(float x) {
  static const float near[9] = {1.50140941f,      0.246640727f,    -0.00417768164f, -0.00125372503f, 0.000218580870f,
                                -4.39150654e-06f, -3.5233877e-06f, 3.43273939e-07f, 2.81022636e-08f};
  static const float far[9] = {2.83297682f,     1.00167406f,    0.00943887047f,  -0.0076224613f,  0.00573950773f,
                               -0.00367342844f, 0.00134934322f, 0.000100950558f, -0.000200214257f};
  x = np_clampf(x, -0.99999f, 0.99999f);
  const float w = -logf((1.0f - x) * (1.0f + x));
  const bool is_near = w < 5.0f;
  const float *c = is_near ? near : far, t = is_near ? w - 2.5f : sqrtf(w) - 3.0f;
  float sum = c[8];
  for (int k = 7; k >= 0; k--) sum = sum * t + c[k];
  return sum * x;
}

/* Slope along the view of a facet of unit roughness that is seen at a cosine, by Newton's method within brackets (Jakob
 * 2014, "An improved visible normal sampling routine for the Beckmann distribution"). */
static float sample_slope_along(float cosine, float u) {
  const float tangent = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f)) / cosine, cotangent = 1.0f / tangent;
  const float sqrt_pi_inverse = 0.564189584f, theta = acosf(cosine), sample = np_maxf(u, 1e-6f);
  float low = -1.0f, high = erff(cotangent);
  const float fit = 1.0f + theta * (-0.876f + theta * (0.4265f - 0.0594f * theta));
  float b = high - (1.0f + high) * powf(1.0f - sample, fit);
  const float scale = 1.0f / (1.0f + high + sqrt_pi_inverse * tangent * expf(-cotangent * cotangent));
  for (int k = 0; k < 10; k++) {
    if (!(b >= low && b <= high)) b = 0.5f * (low + high);
    const float slope = invert_erf(b);
    const float error = scale * (1.0f + b + sqrt_pi_inverse * tangent * expf(-slope * slope)) - sample;
    if (fabsf(error) < 1e-5f) break;
    *(error > 0.0f ? &high : &low) = b;
    b -= error / (scale * (1.0f - slope * tangent));
  }
  return invert_erf(b);
}

/* Samples the normal of a facet visible to the viewer. */
static np_vec3 sample_facet(float roughness, np_vec3 viewer, float u, float v) {
  const np_vec3 stretched = np_vec3_normalize(np_vec3_make(roughness * viewer.x, roughness * viewer.y, viewer.z));
  const float sine = sqrtf(stretched.x * stretched.x + stretched.y * stretched.y);
  float along, across, cos_azimuth = 1.0f, sin_azimuth = 0.0f;
  if (stretched.z > 0.9999f) {
    const float radius = sqrtf(-logf(1.0f - np_minf(u, 0.999999f))), azimuth = 2.0f * NP_PI_F * v;
    along = radius * cosf(azimuth);
    across = radius * sinf(azimuth);
  } else {
    cos_azimuth = stretched.x / sine;
    sin_azimuth = stretched.y / sine;
    along = sample_slope_along(stretched.z, u);
    across = invert_erf(2.0f * np_maxf(v, 1e-6f) - 1.0f);
  }
  const float east = roughness * (cos_azimuth * along - sin_azimuth * across);
  const float north = roughness * (sin_azimuth * along + cos_azimuth * across);
  return np_vec3_normalize(np_vec3_make(-east, -north, 1.0f));
}

/* ---- Frame ---- */

typedef struct wave_frame {
  np_vec3 tangent, bitangent, zenith;
} wave_frame;

static wave_frame make_frame(np_vec3 zenith) {
  wave_frame frame = {.zenith = zenith};
  np_frame_around(zenith, &frame.tangent, &frame.bitangent);
  return frame;
}

/* Transforms a direction into the frame, with at least the least cosine. */
static np_vec3 enter(const wave_frame *frame, np_vec3 d) {
  return np_vec3_make(np_vec3_dot(d, frame->tangent), np_vec3_dot(d, frame->bitangent),
                      np_maxf(np_vec3_dot(d, frame->zenith), cosine_least));
}

static np_vec3 transform_to_world(const wave_frame *frame, np_vec3 d) {
  np_vec3 out = np_vec3_scale(frame->tangent, d.x);
  out = np_vec3_add(out, np_vec3_scale(frame->bitangent, d.y));
  return np_vec3_normalize(np_vec3_add(out, np_vec3_scale(frame->zenith, d.z)));
}

/* F·G₂/G₁ of a visible facet, in the frame; `*out_light` is the mirrored direction. */
static float reflect(float roughness, np_vec3 viewer, np_vec3 facet, np_vec3 *out_light) {
  const float cosine = np_vec3_dot(viewer, facet);
  *out_light = np_vec3_subtract(np_vec3_scale(facet, 2.0f * cosine), viewer);
  if (!(cosine > 0.0f) || !(out_light->z > 0.0f)) return 0.0f;
  const float seen = compute_lambda(roughness, viewer.z), lit = compute_lambda(roughness, out_light->z);
  return np_water_fresnel(cosine) * (1.0f + seen) / (1.0f + seen + lit);
}

/* ---- Creation ---- */

/* Number of facets over which R is averaged. */
enum { FACETS = 512 };

static void fill_node(np_water *water, int node) {
  const float root = (float)node / (NP_WATER_NODES - 1), cosine = np_maxf(root * root, cosine_least);
  const np_vec3 viewer = np_vec3_make(sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f)), 0.0f, cosine);
  double reflected = 0.0, actinic = 0.0;
  for (int k = 0; k < FACETS; k++) {
    np_vec3 light;
    const double v = 0.6180339887498949 * k;
    const np_vec3 facet = sample_facet(water->roughness, viewer, ((float)k + 0.5f) / FACETS, (float)(v - floor(v)));
    const float weight = reflect(water->roughness, viewer, facet, &light);
    reflected += (double)weight / FACETS;
    if (weight > 0.0f) actinic += 0.5 * (double)(weight / np_maxf(light.z, 0.02f)) / FACETS;
  }
  water->reflectance[node] = (float)reflected;
  water->actinic[node] = (float)actinic;
}

static float interpolate(const float table[NP_WATER_NODES], float cosine) {
  const float place = sqrtf(np_clampf(cosine, 0.0f, 1.0f)) * (NP_WATER_NODES - 1);
  const int i = place < NP_WATER_NODES - 2 ? (int)place : NP_WATER_NODES - 2;
  return np_mixf(table[i], table[i + 1], place - (float)i);
}

np_water np_water_make(double level_m, double wind_m_s, np_spectrum albedo) {
  np_water water = {.level_m = level_m, .roughness = (float)sqrt(0.003 + 0.00512 * wind_m_s), .albedo = albedo};
  for (int i = 0; i < NP_WATER_NODES; i++) fill_node(&water, i);
  enum { STEPS = 256 };
  double transmitted = 0.0, actinic = 0.0;
  for (int k = 0; k < STEPS; k++) {
    const double cosine = (k + 0.5) / STEPS, weight = 2.0 * cosine / STEPS;
    transmitted += weight * (1.0 - (double)interpolate(water.reflectance, (float)cosine));
    actinic += weight * (double)interpolate(water.actinic, (float)cosine);
  }
  water.mean_transmittance = (float)transmitted;
  water.mean_actinic = (float)actinic;
  return water;
}

/* ---- Queries ---- */

float np_water_reflectance(const np_water *water, float cosine) { return interpolate(water->reflectance, cosine); }

/* Optical depths of clear air at 680, 550 and 440 nm, also used for other bands, and the downward share of its
 * scattered light. */
static const float air_depth[NP_BAND_COUNT] = {0.13f, 0.2f, 0.34f}, air_downward = 0.6f;

/* Mean of values under sun and sky, weighted by their shares of the light. */
static float mix_light(int band, float sun_cosine, float under_sun, float under_sky) {
  if (!(sun_cosine > 0.0f)) return under_sky;
  const float passed = expf(-air_depth[band] / sun_cosine), scattered = air_downward * (1.0f - passed);
  return np_mixf(under_sun, under_sky, scattered / (scattered + passed));
}

np_spectrum np_water_get_albedo(const np_water *water, float sun_cosine) {
  np_spectrum out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float entered =
        mix_light(b, sun_cosine, 1.0f - np_water_reflectance(water, sun_cosine), water->mean_transmittance);
    out.band[b] = 1.0f - entered + entered * water->albedo.band[b];
  }
  return out;
}

np_spectrum np_water_get_air_albedo(const np_water *water, float sun_cosine) {
  np_spectrum out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float entered =
        mix_light(b, sun_cosine, 1.0f - np_water_reflectance(water, sun_cosine), water->mean_transmittance);
    const float actinic = mix_light(b, sun_cosine, interpolate(water->actinic, sun_cosine), water->mean_actinic);
    out.band[b] = np_minf(actinic + entered * water->albedo.band[b], 1.0f);
  }
  return out;
}

np_spectrum np_water_reflect_even(const np_water *water, float cosine) {
  const float reflected = np_water_reflectance(water, cosine);
  return np_spectrum_add_scaled(np_spectrum_grey(reflected), 1.0f - reflected, water->albedo);
}

/* Light that comes out of the water, per unit of albedo: a BRDF times the cosine of the light. */
static float compute_diffuse(const np_water *water, float to_viewer, float to_light) {
  const float entered = 1.0f - np_water_reflectance(water, to_light),
              left = 1.0f - np_water_reflectance(water, to_viewer);
  return entered * left * to_light / (NP_PI_F * water->mean_transmittance);
}

np_water_value np_water_eval(const np_water *water, np_vec3 zenith, np_vec3 to_viewer, np_vec3 to_light) {
  np_water_value out = {.density = 0.0f};
  const float cosine = np_vec3_dot(zenith, to_light);
  if (!(cosine > 0.0f)) return out;
  const wave_frame frame = make_frame(zenith);
  const np_vec3 viewer = enter(&frame, to_viewer), light = enter(&frame, to_light);
  const np_vec3 facet = np_vec3_normalize(np_vec3_add(viewer, light));
  const float seen = compute_lambda(water->roughness, viewer.z), lit = compute_lambda(water->roughness, light.z);
  const float common = compute_distribution(water->roughness, facet.z) / (4.0f * viewer.z);
  out.reflected = np_water_fresnel(np_vec3_dot(viewer, facet)) * common / (1.0f + seen + lit);
  out.density = common / (1.0f + seen);
  out.scattered =
      np_spectrum_add_scaled(np_spectrum_grey(out.reflected), compute_diffuse(water, viewer.z, cosine), water->albedo);
  return out;
}

np_spectrum np_water_reflect_beam(const np_water *water, float to_viewer, float to_light, float between) {
  if (!(to_light > 0.0f)) return np_spectrum_grey(0.0f);
  const float viewer = np_maxf(to_viewer, cosine_least), light = np_maxf(to_light, cosine_least);
  /* The facet's normal is the sum of both directions over its length. */
  const float length = sqrtf(np_maxf(2.0f + 2.0f * between, 1e-6f));
  const float normal = np_clampf((viewer + light) / length, cosine_least, 1.0f);
  const float shadow = 1.0f + compute_lambda(water->roughness, viewer) + compute_lambda(water->roughness, light);
  const float reflected =
      np_water_fresnel(0.5f * length) * compute_distribution(water->roughness, normal) / (4.0f * viewer * shadow);
  return np_spectrum_add_scaled(np_spectrum_grey(reflected), compute_diffuse(water, viewer, to_light), water->albedo);
}

np_vec3 np_water_sample(const np_water *water, np_vec3 zenith, np_vec3 to_viewer, float u, float v, float *out_weight) {
  const wave_frame frame = make_frame(zenith);
  const np_vec3 viewer = enter(&frame, to_viewer);
  np_vec3 light;
  *out_weight = reflect(water->roughness, viewer, sample_facet(water->roughness, viewer, u, v), &light);
  return transform_to_world(&frame, light);
}
