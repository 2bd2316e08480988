/* SPDX-License-Identifier: Apache-2.0 */
/* The sky for one observer: radiance up to the end of every ray, and optical depth and in-scatter along it.
 *
 * Rows of constant zenith angle concentrate at the true horizon from both sides, θ = θ_h + (θ_end − θ_h)·v², and end
 * there: sky and ground are never interpolated. Azimuth covers the half circle from the sun; the other half mirrors it.
 * The view table holds logarithms, because a sky spans decades within a few degrees of twilight. It is split into a
 * smooth part and the aerosol's first order without its phase function, by which the reader multiplies.
 *
 * Aerial perspective stores the optical depth (one for all azimuths) and the in-scatter at slices along each ray,
 * divided by the distance: such means hardly change between rows, although the lengths of rays and slices do. One
 * sample in the middle of a slice gives its source; the transmittance across it has a closed form. */
#include "atmosphere/atmosphere_tables.h"

#include "atmosphere/spline.h"
#include "atmosphere/tables_disk.h"
#include "core/alloc.h"
#include "core/parallel.h"
#include "core/stable.h"

/* Floor of the logarithms: radiance per unit of irradiance, or per metre of a ray. Less counts as 0. */
static const float light_floor = 1e-20f;
/* A step of aerial perspective spans at most this part of its altitude, or of the atmosphere's height (2.4 km on the
 * Earth); with a limit on the steps in a slice. */
static const double step_altitudes = 0.5, step_heights = 0.024, steps_max = 8.0;
/* Reach of aerial perspective along a ray below sea level, in heights of the atmosphere: 10 km on the Earth. */
static const double below_sea_level = 0.1;

np_sky_light np_sky_light_make(const neph_sky *sky) {
  const neph_atmosphere *a = sky->atmosphere;
  const bool has_later = a->order_max > 1;
  return (np_sky_light){np_fan_get_kernels(a->context->isa),
                        &a->medium,
                        &a->depths,
                        has_later ? &a->moments : NULL,
                        has_later && a->medium.aerosol_count && sky->view ? &sky->gather : NULL,
                        np_sun_disk_make((double)sky->sun_angular_radius, a->has_point_sun)};
}

/* Rays of a row: `count` azimuths, starting at the sun's. */
static void make_fan(const neph_sky *sky, const np_ray *ray, float cosine, int count, np_fan *out_fan) {
  const np_sky_frame *frame = &sky->frame;
  const float sine = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  const double r = sky->atmosphere->medium.planet_radius_m + frame->altitude_m;
  out_fan->count = count;
  out_fan->r = (float)ray->r;
  for (int i = 0; i < count; i++) {
    const float turn = (float)cos(NP_PI * i / (count - 1));
    const float angle = np_clampf(cosine * frame->sun_cosine + sine * frame->sun_sine * turn, -1.0f, 1.0f);
    const double at_entry = (r * (double)frame->sun_cosine + ray->offset_m * (double)angle) / ray->r;
    out_fan->angle_cosine[i] = angle;
    out_fan->sun_cosine[i] = (float)np_clamp(at_entry, -1.0, 1.0);
  }
  np_fan_pad(out_fan);
}

/* Splines from the node azimuths of a row to all of its azimuths. */
typedef struct azimuth_splines {
  int count, node_count;
  np_spline at[NP_VIEW_AZIMUTHS_MAX];
} azimuth_splines;

static azimuth_splines make_splines(const np_view_sizes *n) {
  azimuth_splines s = {.count = n->azimuths, .node_count = n->node_azimuths};
  for (int i = 0; i < s.count; i++) s.at[i] = np_spline_make(i, s.count, s.node_count);
  return s;
}

/* Fills a row's azimuths, `stride` apart. */
static void refine_azimuths(const azimuth_splines *s, const np_scattered *nodes, np_scattered *out, size_t stride) {
  for (int i = 0; i < s->count; i++)
    out[(size_t)i * stride] =
        (np_scattered){np_spline_eval(&s->at[i], &nodes->smooth, 2), np_spline_eval(&s->at[i], &nodes->peak, 2)};
}

static void refine_bands(const azimuth_splines *s, const np_bands *nodes, np_bands *out, size_t stride) {
  for (int i = 0; i < s->count; i++) out[(size_t)i * stride] = np_spline_eval(&s->at[i], nodes, 1);
}

float np_sky_view_length(const neph_sky *sky, double cosine, bool is_below) {
  if (!is_below) return 1.0f;
  const np_ray ray = np_ray_on_side(&sky->atmosphere->medium, sky->frame.altitude_m, cosine, true);
  return np_maxf((float)ray.length_m, 1e-3f);
}

/* Logarithm of light times a scale, in the form of the tables. */
static np_bands log_light(np_bands light, float scale) { return np_bands_log(light * scale + light_floor); }

static np_scattered log_scattered(np_scattered s, float scale) {
  return (np_scattered){log_light(s.smooth, scale), log_light(s.peak, scale)};
}

/* A table under construction, with inputs shared by all rows. */
typedef struct table_job {
  neph_sky *sky;
  np_sky_light light;
  np_path_rule rule; /* rule along the view table's rays */
  azimuth_splines splines;
} table_job;

static void build_view_row(const table_job *job, int row) {
  const neph_sky *sky = job->sky;
  const np_medium *medium = job->light.medium;
  const np_view_sizes *n = &sky->atmosphere->sizes.view;
  const np_sky_layout layout = np_sky_view_layout(sky);
  const double cosine = np_sky_row_cosine(&sky->frame, &layout, row);
  const np_ray ray = np_ray_on_side(medium, sky->frame.altitude_m, cosine, row >= n->up);
  np_path path;
  np_fan fan;
  np_scattered light[NP_FAN_MAX];
  np_path_build(medium, &ray, &job->rule, &path);
  make_fan(sky, &ray, (float)cosine, n->node_azimuths, &fan);
  np_sky_trace(&job->light, &fan, &path, light);
  const float scale = 1.0f / np_sky_view_length(sky, cosine, row >= n->up);
  for (int i = 0; i < fan.count; i++) light[i] = log_scattered(light[i], scale);
  refine_azimuths(&job->splines, light, sky->view + row * n->azimuths, 1);
}

static neph_result build_view_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) build_view_row(user, (int)row);
  return NEPH_OK;
}

np_ray np_aerial_ray(const np_medium *medium, const np_sky_frame *frame, double cosine, bool is_below) {
  np_ray ray = np_ray_on_side(medium, frame->altitude_m, cosine, is_below);
  if (is_below) ray.length_m += below_sea_level * medium->top_m;
  return ray;
}

/* (1 − e⁻ᵈ)/d in every band. */
static np_bands step_weight(np_bands depth) {
  return (np_bands){np_step_weight(depth[0]), np_step_weight(depth[1]), np_step_weight(depth[2]), 0.0f};
}

/* Number of steps in a slice: one if the air hardly changes along it, more at high altitude, where it spans scale
 * heights. */
static int count_steps(const np_sky_light *light, const np_ray *ray, double near, double far) {
  const double low = fmax(np_ray_altitude(ray, near), 0.0), high = fmax(np_ray_altitude(ray, far), 0.0);
  const double unit = fmax(step_altitudes * fmin(low, high), step_heights * light->medium->top_m);
  return (int)np_clamp(ceil(fabs(high - low) / unit), 1.0, steps_max);
}

static np_path_node resolve_step(const np_sky_light *light, const np_ray *ray, double t) {
  const double altitude = np_ray_altitude(ray, t);
  np_path_node middle = {.t = t,
                         .altitude_m = (float)altitude,
                         .r = (float)(ray->r + (altitude - ray->altitude_m)),
                         .cosine = (float)np_ray_cosine(ray, t)};
  np_scattering_at(light->medium, altitude, &middle.air);
  return middle;
}

/* One row under construction: its rays at the node azimuths (none for optical depths alone), and the depth and
 * in-scatter so far. */
typedef struct aerial_row {
  const np_sky_light *light;
  np_ray ray;
  np_aerial_scale scale;
  np_fan fan;
  np_bands depth;
  np_scattered sum[NP_VIEW_AZIMUTHS_MAX];
  np_bands molecules[NP_VIEW_AZIMUTHS_MAX]; /* part scattered once by molecules */
} aerial_row;

/* Adds the in-scatter between two points on the scale, with the source at their middle. A ray of zero length, at the
 * edge of the air, counts as 1 m long, so that the mean is the source. */
static void add_step(aerial_row *row, double begin, double end) {
  const double near = np_aerial_scale_distance(&row->scale, begin);
  const double far = fmax(np_aerial_scale_distance(&row->scale, end), near);
  const np_bands gap = np_ray_gap_depth(row->light->medium, &row->ray, near, far);
  const float length = row->ray.length_m > 0.0 ? (float)(far - near) : 1.0f;
  const np_bands weight = np_bands_exp(-row->depth) * step_weight(gap) * length;
  row->depth += gap;
  if (!row->fan.count) return;
  const np_path_node node =
      resolve_step(row->light, &row->ray, np_aerial_scale_distance(&row->scale, 0.5 * (begin + end)));
  np_scattered scattered[NP_VIEW_AZIMUTHS_MAX];
  memset(scattered, 0, (size_t)row->fan.count * sizeof *scattered);
  np_sky_add_scattered(row->light, &row->fan, &node, weight, scattered, row->molecules);
  for (int i = 0; i < row->fan.count; i++) {
    row->sum[i].smooth += np_bands_max(scattered[i].smooth, np_bands_grey(0.0f));
    row->sum[i].peak += scattered[i].peak;
  }
}

/* Builds slice by slice: the mean extinction up to the far plane, and the logarithms of the mean in-scatter at every
 * azimuth. */
static void build_slices(aerial_row *row, const np_view_sizes *n, const azimuth_splines *splines, np_bands *depths,
                         np_scattered *planes, np_bands *molecules) {
  const double count = n->points;
  np_scattered plane[NP_VIEW_AZIMUTHS_MAX];
  np_bands first[NP_VIEW_AZIMUTHS_MAX];
  for (int k = 0; k < n->points; k++) {
    const double near = np_aerial_scale_distance(&row->scale, k / count);
    const double far = fmax(np_aerial_scale_distance(&row->scale, (k + 1.0) / count), near);
    const int steps = count_steps(row->light, &row->ray, near, far);
    for (int i = 0; i < steps; i++) add_step(row, (k + (double)i / steps) / count, (k + (i + 1.0) / steps) / count);
    const float inverse_far = (float)(far > 0.0 ? 1.0 / far : 1.0 / (k + 1.0));
    depths[k] = inverse_far * row->depth;
    for (int i = 0; i < row->fan.count; i++) {
      plane[i] = log_scattered(row->sum[i], inverse_far);
      first[i] = log_light(row->molecules[i], inverse_far);
    }
    if (!planes) continue;
    refine_azimuths(splines, plane, planes + k, (size_t)n->points);
    refine_bands(splines, first, molecules + k, (size_t)n->points);
  }
}

static void build_aerial_row(const table_job *job, int at) {
  const neph_sky *sky = job->sky;
  const np_sky_light *light = &job->light;
  const np_view_sizes *n = &sky->atmosphere->sizes.aerial;
  const np_sky_layout layout = np_sky_aerial_layout(sky);
  const double cosine = np_sky_row_cosine(&sky->frame, &layout, at);
  aerial_row row = {.light = light, .ray = np_aerial_ray(light->medium, &sky->frame, cosine, at >= n->up)};
  row.scale = np_aerial_scale_make(&row.ray, &sky->frame);
  if (sky->aerial) make_fan(sky, &row.ray, (float)cosine, n->node_azimuths, &row.fan);
  const size_t first = (size_t)(at * n->azimuths) * (size_t)n->points;
  np_scattered *planes = sky->aerial ? sky->aerial + first : NULL;
  build_slices(&row, n, &job->splines, sky->depth + at * n->points, planes,
               sky->aerial ? sky->molecules + first : NULL);
}

static neph_result build_aerial_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) build_aerial_row(user, (int)row);
  return NEPH_OK;
}

/* Half the range of sun angles of the gather: 2° on the Earth, and the range of aerosol that the observer sees. */
static double gather_spread(const np_medium *medium, const np_sky_frame *frame) {
  const double unit = 2.0 * NP_DEGREE * np_twilight_scale(medium) / 0.1753;
  const double seen = frame->horizon_angle - 0.5 * NP_PI;
  return fmax(unit, seen + 0.5 * unit);
}

neph_result np_sky_gather_build(neph_sky *sky) {
  const neph_atmosphere *a = sky->atmosphere;
  if (!np_sky_has_gather(a)) return NEPH_OK;
  const np_moment_table *dome = a->order_max == NP_ORDERS_ALL ? &a->moments
                                : a->order_max > 2            ? &a->dome_moments
                                                              : NULL;
  return np_gather_table_build(
      a->context, &a->depths, &a->moments, dome, &a->kernel, a->sea.share > 0.0f ? &a->sea : NULL,
      acos((double)sky->frame.sun_cosine), gather_spread(&a->medium, &sky->frame),
      np_sun_disk_make((double)sky->sun_angular_radius, a->has_point_sun), sky->monitor, &sky->gather);
}

neph_result np_sky_view_build(neph_sky *sky) {
  const np_view_sizes *n = &sky->atmosphere->sizes.view;
  table_job job = {sky, np_sky_light_make(sky), np_path_rule_make(n->points), make_splines(n)};
  return np_parallel_for(sky->atmosphere->context, sky->monitor, (size_t)(n->up + n->down), 4, build_view_rows, &job);
}

neph_result np_sky_aerial_build(neph_sky *sky) {
  const np_view_sizes *n = &sky->atmosphere->sizes.aerial;
  table_job job = {.sky = sky, .light = np_sky_light_make(sky), .splines = make_splines(n)};
  return np_parallel_for(sky->atmosphere->context, sky->monitor, (size_t)(n->up + n->down), 2, build_aerial_rows, &job);
}

/* Only depths are needed in the dark. */
/* Computes the tables; without light only optical depths. */
static neph_result compute_tables(neph_sky *sky, bool is_dark) {
  if (np_sky_load_tables(sky)) return NEPH_OK;
  np_monitor_set_range(sky->monitor, 0.0, 0.4);
  neph_result result = is_dark ? NEPH_OK : np_sky_gather_build(sky);
  np_monitor_set_range(sky->monitor, 0.4, 0.6);
  if (!result && !is_dark) result = np_sky_view_build(sky);
  np_monitor_set_range(sky->monitor, 0.6, 1.0);
  if (!result) result = np_sky_aerial_build(sky);
  if (!result) np_sky_save_tables(sky);
  return result;
}

neph_result np_sky_tables_build(neph_sky *sky) {
  neph_atmosphere *a = sky->atmosphere;
  neph_context *context = a->context;
  const np_view_sizes *view = &sky->atmosphere->sizes.view, *aerial = &sky->atmosphere->sizes.aerial;
  const size_t view_rows = (size_t)(view->up + view->down), aerial_rows = (size_t)(aerial->up + aerial->down);
  const size_t slices = (size_t)aerial->points;
  const bool is_dark = !(sky->frame.twilight > 0.0f);
  sky->depth = np_alloc(context, aerial_rows * slices, sizeof *sky->depth);
  if (!sky->depth) return NEPH_ERROR_OUT_OF_MEMORY;
  if (is_dark) return compute_tables(sky, true);
  sky->view = np_alloc(context, view_rows * (size_t)view->azimuths, sizeof *sky->view);
  if (!sky->view) return NEPH_ERROR_OUT_OF_MEMORY;
  sky->aerial = np_alloc(context, aerial_rows * (size_t)aerial->azimuths * slices, sizeof *sky->aerial);
  sky->molecules = np_alloc(context, aerial_rows * (size_t)aerial->azimuths * slices, sizeof *sky->molecules);
  if (!sky->aerial || !sky->molecules) return NEPH_ERROR_OUT_OF_MEMORY;
  return compute_tables(sky, false);
}

void np_sky_tables_free(neph_sky *sky) {
  neph_context *context = sky->atmosphere->context;
  np_alloc_free(context, sky->view);
  np_alloc_free(context, sky->depth);
  np_alloc_free(context, sky->aerial);
  np_alloc_free(context, sky->molecules);
}

/* Exponent of the spacing of rows in one half. */
static float choose_power(const np_sky_frame *frame, const np_sky_layout *layout, bool is_below) {
  if (is_below) return 3.0f;
  return layout->is_aerial ? frame->aerial_power : 2.0f;
}

double np_sky_row_cosine(const np_sky_frame *frame, const np_sky_layout *layout, int row) {
  const bool is_below = row >= layout->up;
  const double v = is_below ? (row - layout->up) / (layout->down - 1.0) : row / (layout->up - 1.0);
  const double end = is_below ? NP_PI : frame->top_angle;
  return cos(frame->horizon_angle +
             (end - frame->horizon_angle) * pow(v, (double)choose_power(frame, layout, is_below)));
}

np_sky_place np_sky_locate(const np_sky_frame *frame, np_vec3 direction, const np_sky_layout *layout) {
  const float x = np_vec3_dot(direction, frame->toward), y = np_vec3_dot(direction, frame->across);
  const double angle = (double)atan2f(sqrtf(x * x + y * y), np_vec3_dot(direction, frame->up));
  np_sky_place place = {.is_below = angle > frame->horizon_angle, .is_in_air = angle >= frame->top_angle};
  const double end = place.is_below ? NP_PI : frame->top_angle;
  const float part = (float)np_clamp((angle - frame->horizon_angle) / (end - frame->horizon_angle), 0.0, 1.0);
  const int rows = place.is_below ? layout->down : layout->up;
  const float power = choose_power(frame, layout, place.is_below);
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

/* Radiance from a logarithm of a table, without the floor; never negative. */
static np_bands undo_log(np_bands logarithm) {
  return np_bands_max(np_bands_exp(logarithm) - 1.00002f * light_floor, np_bands_grey(0.0f));
}

np_scattered np_sky_view_lookup(const neph_sky *sky, const np_sky_place *place, float length_m) {
  const int azimuths = sky->atmosphere->sizes.view.azimuths;
  const np_scattered *low = sky->view + place->row * azimuths + place->azimuth, *high = low + azimuths;
  const np_scattered s = mix_scattered(mix_scattered(low[0], low[1], place->azimuth_upper),
                                       mix_scattered(high[0], high[1], place->azimuth_upper), place->row_upper);
  return (np_scattered){length_m * undo_log(s.smooth), length_m * undo_log(s.peak)};
}

/* Optical depth and in-scatter at the far plane of a slice, `distance_m` away in the air; 0 before the first slice. */
static np_aerial_sample lookup_plane(const neph_sky *sky, const np_sky_place *place, int slice, double distance_m) {
  if (slice < 0) return (np_aerial_sample){0};
  const float t = (float)distance_m;
  const np_view_sizes *n = &sky->atmosphere->sizes.aerial;
  const np_bands *rows = sky->depth + place->row * n->points + slice;
  const np_bands depth = t * np_bands_mix(rows[0], rows[n->points], place->row_upper);
  if (!sky->aerial) return (np_aerial_sample){.depth = depth};
  const np_scattered *low = sky->aerial + (place->row * n->azimuths + place->azimuth) * n->points + slice;
  const np_scattered *high = low + n->azimuths * n->points;
  const np_scattered s = mix_scattered(mix_scattered(low[0], low[n->points], place->azimuth_upper),
                                       mix_scattered(high[0], high[n->points], place->azimuth_upper), place->row_upper);
  return (np_aerial_sample){depth, {t * undo_log(s.smooth), t * undo_log(s.peak)}};
}

/* First-order in-scatter by molecules at the far plane of a slice. */
static np_bands lookup_molecules(const neph_sky *sky, const np_sky_place *place, int slice, double distance_m) {
  if (slice < 0 || !sky->molecules) return np_bands_grey(0.0f);
  const np_view_sizes *n = &sky->atmosphere->sizes.aerial;
  const np_bands *low = sky->molecules + (place->row * n->azimuths + place->azimuth) * n->points + slice;
  const np_bands *high = low + n->azimuths * n->points;
  const np_bands logarithm =
      np_bands_mix(np_bands_mix(low[0], low[n->points], place->azimuth_upper),
                   np_bands_mix(high[0], high[n->points], place->azimuth_upper), place->row_upper);
  return (float)distance_m * undo_log(logarithm);
}

/* y/(1 − e⁻ʸ), to 4 % at y = 3 and far better below. */
static np_bands inverse_step_weight(np_bands y) { return 1.0f + y * (0.5f + y * (1.0f / 12.0f)); }

/* Part of a slice's in-scatter from its nearer part `x`, for a constant source: (1 − e⁻ˣᵈ)/(1 − e⁻ᵈ). It stops growing
 * at x·d = 3.4: beyond that depth the slice contributes nothing. */
static np_bands part_of_slice(np_bands depth, float x) {
  const np_bands d = np_bands_min(depth, np_bands_grey(3.0f));
  const np_bands part = np_bands_min(np_bands_grey(x), 3.4f / np_bands_max(d, np_bands_grey(1e-6f)));
  return part * inverse_step_weight(d) / inverse_step_weight(part * d);
}

np_aerial_sample np_sky_aerial_lookup(const neph_sky *sky, const np_sky_place *place, const np_ray *ray,
                                      double distance_m, np_bands *out_molecules) {
  const np_aerial_scale scale = np_aerial_scale_make(ray, &sky->frame);
  const int count = sky->atmosphere->sizes.aerial.points;
  const double t = np_clamp(distance_m - ray->offset_m, 0.0, 2.0 * ray->length_m), within = fmin(t, ray->length_m);
  const double s = np_clamp(np_aerial_scale_fraction(&scale, within), 0.0, 1.0) * count;
  const int slice = s < count - 1 ? (int)s : count - 1;
  const double near = slice > 0 ? np_aerial_scale_distance(&scale, (double)slice / count) : 0.0;
  const double far = np_aerial_scale_distance(&scale, (slice + 1.0) / count);
  /* Beyond the last plane, below ground, the air of the last slice continues. */
  const double end = ray->hits_ground ? t : within;
  const float x = far > near ? (float)fmax((end - near) / (far - near), 0.0) : 0.0f;
  const np_aerial_sample a = lookup_plane(sky, place, slice - 1, near), b = lookup_plane(sky, place, slice, far);
  const np_bands part = part_of_slice(b.depth - a.depth, x);
  if (out_molecules) {
    const np_bands before = lookup_molecules(sky, place, slice - 1, near);
    *out_molecules = before + part * (lookup_molecules(sky, place, slice, far) - before);
  }
  return (np_aerial_sample){a.depth + x * (b.depth - a.depth),
                            {a.inscatter.smooth + part * (b.inscatter.smooth - a.inscatter.smooth),
                             a.inscatter.peak + part * (b.inscatter.peak - a.inscatter.peak)}};
}
