/* SPDX-License-Identifier: Apache-2.0 */
/* The sky around one observer: radiance to the end of every ray, and depth and in-scatter along it.
 *
 * Rows of constant zenith angle crowd about the true horizon from both sides, θ = θ_h + (θ_end − θ_h)·v², and end
 * there: the sky's are never mixed with the ground's. Azimuth runs over the half circle from the sun, which a clear sky
 * mirrors. The view table keeps logarithms, for a sky spans decades in a few degrees of twilight; it is split into what
 * is smooth and the aerosol's first order without its phase function, which the reader multiplies on.
 *
 * Aerial perspective keeps, at slices along each ray, the optical depth (one for all azimuths) and the in-scatter, each
 * over the distance: such means hardly change between rows, though the rays' lengths, and so the slices', do. One
 * sample in the middle of a slice stands for its source; the transmittance across it is taken in closed form.
 */
#include "atmosphere/atmosphere_tables.h"

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/stable.h"

enum { VIEW_POINTS = 32 };

/* Radiance, per unit of irradiance, that the logarithms tell from none. */
static const float view_floor = 1e-14f;
/* How far aerial perspective follows a ray below sea level, in heights of the atmosphere: 10 km on the Earth. */
static const double below_sea_level = 0.1;

np_sky_light np_sky_light_make(const neph_sky *sky) {
  const neph_atmosphere *a = sky->atmosphere;
  const bool has_later = a->order_max > 1;
  return (np_sky_light){&a->medium, &a->depths, has_later ? &a->moments : NULL,
                        has_later && a->medium.aerosol_count ? &sky->gather : NULL,
                        np_sun_disk_make((double)sky->sun_angular_radius, a->has_point_sun)};
}

/* Cosine of the angle between the sun and a direction at zenith cosine `cosine` and the i-th of `count` azimuths. */
static float angle_of_azimuth(const np_sky_frame *frame, float cosine, int i, int count) {
  const float sine = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  return np_clampf(cosine * frame->sun_cosine + sine * frame->sun_sine * (float)cos(NP_PI * i / (count - 1)), -1.0f,
                   1.0f);
}

/* Sun cosine where a ray's part in the air begins. */
static float sun_at_entry(const neph_sky *sky, const np_ray *ray, float to_sun) {
  const double r = sky->atmosphere->medium.planet_radius_m + sky->frame.altitude_m;
  return (float)np_clamp((r * (double)sky->frame.sun_cosine + ray->offset_m * (double)to_sun) / ray->r, -1.0, 1.0);
}

static void build_view_row(neph_sky *sky, const np_sky_light *light, const np_path_rule *rule, int row) {
  const bool is_below = row >= NP_VIEW_UP;
  const np_sky_layout layout = np_sky_view_layout();
  const double cosine = np_sky_row_cosine(&sky->frame, &layout, row);
  const np_ray ray = np_ray_on_side(light->medium, sky->frame.altitude_m, cosine, is_below);
  np_path path;
  np_sky_node nodes[VIEW_POINTS];
  np_path_build(light->medium, &ray, rule, &path);
  for (int i = 0; i < path.count; i++) np_sky_node_resolve(light, &path.node[i], &nodes[i]);
  for (int i = 0; i < NP_VIEW_AZIMUTHS; i++) {
    const float to_sun = angle_of_azimuth(&sky->frame, (float)cosine, i, NP_VIEW_AZIMUTHS);
    const np_scattered s = np_sky_trace(light, &ray, &path, nodes, sun_at_entry(sky, &ray, to_sun), to_sun, false);
    sky->view[row * NP_VIEW_AZIMUTHS + i] =
        (np_scattered){np_bands_log(s.smooth + view_floor), np_bands_log(s.peak + view_floor)};
  }
}

static neph_result build_view_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  neph_sky *sky = user;
  const np_sky_light light = np_sky_light_make(sky);
  const np_path_rule rule = np_path_rule_make(VIEW_POINTS);
  for (size_t row = begin; row < end; row++) build_view_row(sky, &light, &rule, (int)row);
  return NEPH_OK;
}

np_ray np_aerial_ray(const np_medium *medium, const np_sky_frame *frame, double cosine, bool is_below) {
  np_ray ray = np_ray_on_side(medium, frame->altitude_m, cosine, is_below);
  if (is_below) ray.length_m += below_sea_level * medium->top_m;
  return ray;
}

/* One slice of aerial perspective: its middle, and what turns the source there into in-scatter seen by the observer. */
typedef struct aerial_slice {
  np_sky_node node;
  np_bands weight;
  float inverse_far; /* 1/m, to the far plane */
} aerial_slice;

/* (1 − e⁻ᵈ)/d in every band. */
static np_bands step_weight(np_bands depth) {
  return (np_bands){np_step_weight(depth[0]), np_step_weight(depth[1]), np_step_weight(depth[2]), 0.0f};
}

/* Places the slices of one row and writes the mean extinctions to their far planes. */
static void build_slices(const np_sky_light *light, const np_ray *ray, double inward, np_bands *depths,
                         aerial_slice *slices) {
  const np_aerial_scale scale = np_aerial_scale_make(ray, inward);
  np_bands depth = np_bands_grey(0.0f);
  double near = 0.0;
  for (int i = 0; i < NP_AERIAL_SLICES; i++) {
    const double far = fmax(np_aerial_scale_distance(&scale, (i + 1.0) / NP_AERIAL_SLICES), near);
    const double t = np_aerial_scale_distance(&scale, (i + 0.5) / NP_AERIAL_SLICES);
    const double altitude = np_ray_altitude(ray, t);
    np_path_node middle = {.t = t,
                           .altitude_m = (float)altitude,
                           .r = (float)(ray->r + (altitude - ray->altitude_m)),
                           .cosine = (float)np_ray_cosine(ray, t)};
    np_scattering_at(light->medium, altitude, &middle.air);
    np_sky_node_resolve(light, &middle, &slices[i].node);
    const np_bands gap = np_ray_gap_depth(light->medium, ray, near, far);
    slices[i].weight = np_bands_exp(-depth) * step_weight(gap) * (float)(far - near);
    slices[i].inverse_far = far > 0.0 ? (float)(1.0 / far) : 0.0f;
    depth += gap;
    depths[i] = slices[i].inverse_far * depth;
    near = far;
  }
}

static void build_aerial_row(neph_sky *sky, const np_sky_light *light, int row) {
  const bool is_below = row >= NP_AERIAL_UP;
  const np_sky_layout layout = np_sky_aerial_layout();
  const double cosine = np_sky_row_cosine(&sky->frame, &layout, row);
  const np_ray ray = np_aerial_ray(light->medium, &sky->frame, cosine, is_below);
  aerial_slice slices[NP_AERIAL_SLICES];
  build_slices(light, &ray, sky->frame.inward, sky->depth + row * NP_AERIAL_SLICES, slices);
  for (int i = 0; i < NP_AERIAL_AZIMUTHS; i++) {
    np_scattered *plane = sky->aerial + (row * NP_AERIAL_AZIMUTHS + i) * NP_AERIAL_SLICES;
    const float to_sun = angle_of_azimuth(&sky->frame, (float)cosine, i, NP_AERIAL_AZIMUTHS);
    const float sun = sun_at_entry(sky, &ray, to_sun);
    np_scattered sum = {np_bands_grey(0.0f), np_bands_grey(0.0f)};
    for (int k = 0; k < NP_AERIAL_SLICES; k++) {
      const np_scattered s = np_sky_node_source(light, &slices[k].node, (float)ray.r, sun, to_sun);
      sum.smooth += np_bands_max(slices[k].weight * s.smooth, np_bands_grey(0.0f));
      sum.peak += slices[k].weight * s.peak;
      plane[k] = (np_scattered){slices[k].inverse_far * sum.smooth, slices[k].inverse_far * sum.peak};
    }
  }
}

static neph_result build_aerial_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  neph_sky *sky = user;
  const np_sky_light light = np_sky_light_make(sky);
  for (size_t row = begin; row < end; row++) build_aerial_row(sky, &light, (int)row);
  return NEPH_OK;
}

/* Half the range of sun angles to gather for: two degrees of an Earth, and as far as the observer sees the aerosol. */
static double gather_spread(const np_medium *medium, const np_sky_frame *frame) {
  const double unit = 2.0 * NP_DEGREE * np_twilight_scale(medium) / 0.1753;
  const double seen = frame->horizon_angle - 0.5 * NP_PI;
  return fmax(unit, seen + 0.5 * unit);
}

static neph_result build_gather(neph_sky *sky) {
  const neph_atmosphere *a = sky->atmosphere;
  const np_moment_table *dome = a->order_max == NP_ORDERS_ALL ? &a->moments
                                : a->order_max > 2            ? &a->dome_moments
                                                              : NULL;
  return np_gather_table_build(a->context, &a->depths, &a->moments, dome, &a->kernel,
                               acos((double)sky->frame.sun_cosine), gather_spread(&a->medium, &sky->frame),
                               np_sun_disk_make((double)sky->sun_angular_radius, a->has_point_sun), &sky->gather);
}

neph_result np_sky_tables_build(neph_sky *sky) {
  neph_atmosphere *a = sky->atmosphere;
  neph_context *context = a->context;
  sky->view = np_alloc(context, NP_VIEW_ROWS * NP_VIEW_AZIMUTHS, sizeof *sky->view);
  if (!sky->view) return NEPH_ERROR_OUT_OF_MEMORY;
  sky->depth = np_alloc(context, NP_AERIAL_ROWS * NP_AERIAL_SLICES, sizeof *sky->depth);
  if (!sky->depth) return NEPH_ERROR_OUT_OF_MEMORY;
  sky->aerial = np_alloc(context, NP_AERIAL_ROWS * NP_AERIAL_AZIMUTHS * NP_AERIAL_SLICES, sizeof *sky->aerial);
  if (!sky->aerial) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = a->order_max > 1 && a->medium.aerosol_count ? build_gather(sky) : NEPH_OK;
  if (!result) result = np_parallel_for(context, NULL, NP_VIEW_ROWS, 4, build_view_rows, sky);
  if (!result) result = np_parallel_for(context, NULL, NP_AERIAL_ROWS, 2, build_aerial_rows, sky);
  return result;
}

void np_sky_tables_free(neph_sky *sky) {
  neph_context *context = sky->atmosphere->context;
  np_alloc_free(context, sky->view);
  np_alloc_free(context, sky->depth);
  np_alloc_free(context, sky->aerial);
}

/* Exponent that spaces the rows of one half. */
static float find_power(const np_sky_frame *frame, const np_sky_layout *layout, bool is_below) {
  if (!layout->is_aerial) return 2.0f;
  return is_below ? 3.0f : frame->aerial_power;
}

double np_sky_row_cosine(const np_sky_frame *frame, const np_sky_layout *layout, int row) {
  const bool is_below = row >= layout->up;
  const double v = is_below ? (row - layout->up) / (layout->down - 1.0) : row / (layout->up - 1.0);
  const double end = is_below ? NP_PI : frame->top_angle;
  return cos(frame->horizon_angle + (end - frame->horizon_angle) * pow(v, (double)find_power(frame, layout, is_below)));
}

np_sky_place np_sky_locate(const np_sky_frame *frame, np_vec3 direction, const np_sky_layout *layout) {
  const float x = np_vec3_dot(direction, frame->toward), y = np_vec3_dot(direction, frame->across);
  const double angle = (double)atan2f(sqrtf(x * x + y * y), np_vec3_dot(direction, frame->up));
  np_sky_place place = {.is_below = angle > frame->horizon_angle, .is_in_air = angle >= frame->top_angle};
  const double end = place.is_below ? NP_PI : frame->top_angle;
  const float part = (float)np_clamp((angle - frame->horizon_angle) / (end - frame->horizon_angle), 0.0, 1.0);
  const int rows = place.is_below ? layout->down : layout->up;
  const float power = find_power(frame, layout, place.is_below);
  const float v = (power == 2.0f ? sqrtf(part) : powf(part, 1.0f / power)) * (float)(rows - 1);
  const int i = v < (float)(rows - 2) ? (int)v : rows - 2;
  place.row = (place.is_below ? layout->up : 0) + i;
  place.row_upper = v - (float)i;
  const float u = atan2f(fabsf(y), x) * (float)((layout->azimuths - 1) / NP_PI);
  place.azimuth = u < (float)(layout->azimuths - 2) ? (int)u : layout->azimuths - 2;
  place.azimuth_upper = np_clampf(u - (float)place.azimuth, 0.0f, 1.0f);
  return place;
}

static np_scattered mix_scattered(np_scattered a, np_scattered b, float t) {
  return (np_scattered){np_bands_mix(a.smooth, b.smooth, t), np_bands_mix(a.peak, b.peak, t)};
}

/* Radiance of a logarithm read from the view table: what the floor added is taken off again, and what rounding makes of
 * it. */
static np_bands undo_log(np_bands logarithm) {
  return np_bands_max(np_bands_exp(logarithm) - 1.00002f * view_floor, np_bands_grey(0.0f));
}

np_scattered np_sky_view_lookup(const neph_sky *sky, const np_sky_place *place) {
  const np_scattered *low = sky->view + place->row * NP_VIEW_AZIMUTHS + place->azimuth, *high = low + NP_VIEW_AZIMUTHS;
  const np_scattered s = mix_scattered(mix_scattered(low[0], low[1], place->azimuth_upper),
                                       mix_scattered(high[0], high[1], place->azimuth_upper), place->row_upper);
  return (np_scattered){undo_log(s.smooth), undo_log(s.peak)};
}

/* Optical depth and in-scatter at the far plane of a slice, `distance_m` away in the air; nothing before the first. */
static np_aerial_sample lookup_plane(const neph_sky *sky, const np_sky_place *place, int slice, double distance_m) {
  if (slice < 0) return (np_aerial_sample){0};
  const float t = (float)distance_m;
  const np_bands *depth = sky->depth + place->row * NP_AERIAL_SLICES + slice;
  const np_scattered *low = sky->aerial + (place->row * NP_AERIAL_AZIMUTHS + place->azimuth) * NP_AERIAL_SLICES + slice;
  const np_scattered *high = low + NP_AERIAL_AZIMUTHS * NP_AERIAL_SLICES;
  const np_scattered s =
      mix_scattered(mix_scattered(low[0], low[NP_AERIAL_SLICES], place->azimuth_upper),
                    mix_scattered(high[0], high[NP_AERIAL_SLICES], place->azimuth_upper), place->row_upper);
  return (np_aerial_sample){t * np_bands_mix(depth[0], depth[NP_AERIAL_SLICES], place->row_upper),
                            {t * s.smooth, t * s.peak}};
}

/* y/(1 − e⁻ʸ), to 4 % at y = 3 and far better below. */
static np_bands inverse_step_weight(np_bands y) { return 1.0f + y * (0.5f + y * (1.0f / 12.0f)); }

/* Part of a slice's in-scatter that comes from its nearer `x`, for a constant source: (1 − e⁻ˣᵈ)/(1 − e⁻ᵈ), grows with
 * x as far as x·d = 3.4 and stays there: so far into a slice what lies deeper no longer counts. */
static np_bands part_of_slice(np_bands depth, float x) {
  const np_bands d = np_bands_min(depth, np_bands_grey(3.0f));
  const np_bands part = np_bands_min(np_bands_grey(x), 3.4f / np_bands_max(d, np_bands_grey(1e-6f)));
  return part * inverse_step_weight(d) / inverse_step_weight(part * d);
}

np_aerial_sample np_sky_aerial_lookup(const neph_sky *sky, const np_sky_place *place, const np_ray *ray,
                                      double distance_m) {
  const np_aerial_scale scale = np_aerial_scale_make(ray, sky->frame.inward);
  const double t = np_clamp(distance_m - ray->offset_m, 0.0, 2.0 * ray->length_m), within = fmin(t, ray->length_m);
  const double s = np_clamp(np_aerial_scale_fraction(&scale, within), 0.0, 1.0) * NP_AERIAL_SLICES;
  const int slice = s < NP_AERIAL_SLICES - 1 ? (int)s : NP_AERIAL_SLICES - 1;
  const double near = slice > 0 ? np_aerial_scale_distance(&scale, (double)slice / NP_AERIAL_SLICES) : 0.0;
  const double far = np_aerial_scale_distance(&scale, (slice + 1.0) / NP_AERIAL_SLICES);
  /* Underground, past the last plane, the last slice's air goes on. */
  const double end = ray->hits_ground ? t : within;
  const float x = far > near ? (float)fmax((end - near) / (far - near), 0.0) : 0.0f;
  const np_aerial_sample a = lookup_plane(sky, place, slice - 1, near), b = lookup_plane(sky, place, slice, far);
  const np_bands part = part_of_slice(b.depth - a.depth, x);
  return (np_aerial_sample){a.depth + x * (b.depth - a.depth),
                            {a.inscatter.smooth + part * (b.inscatter.smooth - a.inscatter.smooth),
                             a.inscatter.peak + part * (b.inscatter.peak - a.inscatter.peak)}};
}
