/* SPDX-License-Identifier: Apache-2.0 */
/* The march: exponential steps through the clouds, equal in opacity (integrate/step.h).
 *
 * Over a step of optical depth h with source S per unit of extinction, the equation of transfer gives
 * L += T·S·(1 − e^{−h}), T the transmittance to the step: exact where S is constant, whatever the extinction does, and
 * where it is linear too, with S from the mean place of what the step hides. Air between camera and step enters by
 * parts: with I(t) its in-scatter and Tₐ(t) its transmittance to t, ∫T dI = T(end)·I(end) + ∫I·(−dT), so that each step
 * adds (Tₐ·S + I)·(−ΔT).
 *
 * Where the view has a solution of the multiple scattering the march runs in its scaled medium (march_light.c). What
 * lies behind is then seen twice: through the true transmittance, and, spread by the forward peak too little to matter,
 * through what the scaled one has more. Otherwise light is scattered once, and an approximation may represent
 * more (march_approximation.c). Compiled once per instruction-set level.
 */
#include "integrate/march.h"
#include "integrate/surroundings.h"

void NP_KERNEL(np_march_sample)(const np_world *world, const np_lighting *lighting,
                                const np_integrator_settings *settings, const np_camera_ray *ray, np_random *random,
                                np_integrator_sample *out);
double NP_KERNEL(np_march_half_distance)(const np_world *world, const np_camera_ray *ray, double distance_max);
np_view_depth NP_KERNEL(np_march_view_depth)(const np_world *world, const np_camera_ray *ray, double distance_max);

/* Emission seen through the clouds. Emission that their forward peak scatters into the ray counts as scattered. */
static void add_emission(np_march *m, double distance_end) {
  np_spectrum factors[NP_INSTANCES_MAX], straight, scaled;
  for (unsigned v = 0; v < m->world->clouds.count && m->medium; v++)
    factors[v] = np_spectrum_subtract(np_spectrum_grey(1.0f),
                                      np_spectrum_scale(m->world->clouds.at[v].albedo, m->medium->clouds[v].forward));
  np_emission_march(m->world, m->ray, distance_end, m->medium ? factors : NULL, &straight, &scaled);
  np_march_add(m, NP_COMPONENT_EMISSION, 1.0f, straight);
  /* Rounding may leave less than nothing where neither light is hidden. */
  np_spectrum scattered = np_spectrum_subtract(scaled, straight);
  for (int b = 0; b < NP_BAND_COUNT; b++) scattered.band[b] = np_maxf(scattered.band[b], 0.0f);
  np_march_add(m, NP_COMPONENT_MULTIPLE, 1.0f, scattered);
}

/* ---- Cells and steps ---- */

/* The longest step at a distance. Among the tiles of a field that repeats to the horizon it grows with the pixel, as if
 * voxels were as large: a level ray would go through hundreds of them. */
static float get_longest(const np_march *m, double at) {
  return np_maxf(m->step_length_m, m->step_growth * (float)(m->ray->begin_m + at));
}

/* Sets the opacity at which the next step ends, `share` of a step away from a distance. */
static void set_knot(np_march *m, float share, double at) {
  const float budget = np_step_budget(m->settings->tolerance, m->carry, m->field != NULL);
  m->knot = (np_step_knot){.budget = share * share * share * budget, .distance = share * get_longest(m, at)};
}

static void light_step(np_march *m) {
  (m->field ? NP_KERNEL(np_march_light_scaled) : NP_KERNEL(np_march_light_approximation))(m, &m->step);
}

static void record_step(np_march *m) {
  const np_integrator_sample before = *m->out;
  light_step(m);
  np_integrator_record_depth(m->ray, &before, m->out, m->step.begin, m->step.begin + (double)m->step.length);
}

/* Lights the step that has been gathered. */
static void close_step(np_march *m) {
  if (m->step.count > 0 && m->step.hiding > 0.0f) (np_integrator_has_depths(m->ray) ? record_step : light_step)(m);
  m->step.count = 0;
}

/* Ends a step where its clouds end. The next step gets the rest of the error budget. */
static void break_step(np_march *m) {
  if (m->step.count == 0) return;
  const float gone = np_cbrtf_rough(m->knot.hiding * m->knot.bound * m->knot.bound / m->knot.budget);
  const double end = m->step.begin + (double)m->step.length;
  close_step(m);
  np_march_forget_sun(m);
  set_knot(m, np_clampf(1.0f - gone, 0.1f, 1.0f), end);
}

/* Gathers a piece of constant extinction, of which steps count `hiding` a metre, and `bound` at the cell's densest
 * point; lights the steps that end in it. */
static void pass_piece(np_march *m, const np_ray_intervals *all, const np_ray_interval *s, const float *extinction,
                       double begin, float length, float hiding, float bound) {
  if (!(hiding > 0.0f)) {
    break_step(m);
    return;
  }
  while (length > 0.0f && m->carry > 0.0f) {
    if (m->step.count == 0) np_step_open(&m->step, all, s, begin);
    const float change = m->sun_rate * bound;
    const float u = m->knot.hiding + hiding * length, v = m->knot.bound + change * length;
    float part = np_minf(length, np_maxf(m->knot.distance, 0.0f));
    if (u * v * v > m->knot.budget) part = np_minf(part, np_step_room(&m->knot, hiding, change, length));
    np_step_add(&m->step, extinction, part, hiding * part);
    m->knot.hiding += hiding * part;
    m->knot.bound += change * part;
    m->knot.distance -= part;
    const bool is_knot = part < length;
    begin += (double)part;
    length -= part;
    if (!is_knot) continue;
    close_step(m);
    set_knot(m, 1.0f, begin);
  }
}

/* Weight of one metre of a cloud of the view in a step's scaled extinction, over its extinction. */
static float get_extinction_scale(const np_march *m, const np_instance *volume) {
  if (!m->medium) return 1.0f;
  return np_scaled_cloud_get_scale(&m->medium->clouds[np_instances_get_index(&m->world->clouds, volume)],
                                   volume->albedo);
}

/* Scaled extinction of all active clouds of a segment, at the densest points of its cells. */
static float compute_bound(const np_ray_intervals *all, const np_ray_interval *s, const float *hiding) {
  float sum = 0.0f;
  for (unsigned i = 0; i < s->count; i++) sum += hiding[i] * np_ray_instance_bound(&all->instance[s->active[i]]);
  return sum;
}

/* The cloud of a segment whose voxels are smallest. */
static const np_ray_instance *search_finest(const np_ray_intervals *all, const np_ray_interval *s) {
  const np_ray_instance *finest = &all->instance[s->active[0]];
  for (unsigned i = 1; i < s->count; i++)
    if (all->instance[s->active[i]].voxels_per_m > finest->voxels_per_m) finest = &all->instance[s->active[i]];
  return finest;
}

/* Factor of the forward peak on extinction below which pieces are not chosen in the scaled medium alone: the true
 * transmittance, an output of its own, would be inaccurate. */
static const float scale_least = 0.1f;

/* Number of pieces of a segment for which the error is small against the opacity of the ray. Optical depth counts for
 * more towards a light, which is seen through all of it. */
static int count_pieces(const np_march *m, const np_ray_intervals *all, const np_ray_interval *s, const float *hiding) {
  const float length = (float)(s->end - s->begin);
  float variation = 0.0f, weight[NP_INSTANCES_MAX];
  for (unsigned i = 0; i < s->count; i++) {
    weight[i] = np_maxf(hiding[i], scale_least);
    variation += weight[i] * np_ray_instance_variation(&all->instance[s->active[i]]) * length;
  }
  const float sheet = compute_bound(all, s, weight) / search_finest(all, s)->voxels_per_m;
  const float hidden = np_minf(np_maxf(1.0f - m->carry + m->carry * sheet, np_march_opacity_least), 1.0f);
  const int count = np_track_count_samples(2.0f * variation * m->carry / (m->settings->tolerance * hidden));
  return count > 1 ? count : 1;
}

/* Width of a pixel at the middle of a segment. */
static float get_pixel(const np_march *m, const np_ray_interval *s) {
  return m->ray->spread_rad * (float)(m->ray->begin_m + 0.5 * (s->begin + s->end));
}

/* Transmittance below which detail finer than the pieces is left out. */
static const float detail_carry_least = 0.05f;

/* Number of pieces of a segment that needs more than one: at least two for each feature of a cloud's detail that the
 * pixel resolves. */
static int refine_pieces(const np_march *m, const np_ray_intervals *all, const np_ray_interval *s, float pixel_m,
                         int count) {
  const float length = (float)(s->end - s->begin);
  for (unsigned i = 0; i < s->count && count > 1 && m->carry > detail_carry_least; i++) {
    const np_ray_instance *cloud = &all->instance[s->active[i]];
    const np_brick_detail *detail = cloud->volume->bricks->detail;
    if (!detail || !(np_brick_detail_get_share(detail, pixel_m * cloud->voxels_per_m) > 0.0f)) continue;
    const int least = 1 + (int)np_minf(2.0f * length * cloud->voxels_per_m / np_brick_detail_get_size(detail), 1e3f);
    count = count > least ? count : least;
  }
  return count;
}

/* Distances of the midpoints of the next pieces, from index `first` on, which are looked up together; each piece is
 * `length` metres long. Returns their number. */
static int fill_middles(int first, int count, float length, float middle[NP_BRICK_LINE]) {
  for (int k = 0; k < NP_BRICK_LINE; k++) middle[k] = ((float)(first + k) + 0.5f) * length;
  return count - first < NP_BRICK_LINE ? count - first : NP_BRICK_LINE;
}

/* Look-ups above which a segment is cut voxel by voxel; depth of the pieces then. */
static const int deep_count = 256;
static const double deep_piece = 0.125;

/* Cuts a voxel into pieces of equal depth, as long as the ray has not faded. */
static void cross_voxel(np_march *m, const np_ray_intervals *all, const np_ray_interval *s,
                        const np_voxel_segment *voxel, float hiding) {
  const double per_value = (double)all->instance[s->active[0]].volume->extinction_per_value;
  const double whole = np_voxel_segment_integral(voxel, 1.0), depth = (double)hiding * per_value * whole;
  const double count = fmax(ceil(depth / deep_piece), 1.0);
  double begin = 0.0;
  for (double k = 1.0; k <= count && m->carry > 0.0f; k++) {
    const double end = k < count ? np_voxel_segment_invert(voxel, whole * (k / count), 0.0) : 1.0;
    const double length = (end - begin) * voxel->length;
    const float extinction = length > 0.0 ? (float)(per_value * (whole / count) / length) : 0.0f;
    const float rate = hiding * extinction; /* light fades along the ray and towards the sun */
    pass_piece(m, all, s, &extinction, voxel->begin + begin * voxel->length, (float)length, rate, 2.0f * rate);
    begin = end;
  }
}

/* Crosses a segment of one cloud voxel by voxel, where equal pieces would be too coarse. */
static void cross_deep(np_march *m, const np_ray_intervals *all, const np_ray_interval *s, float hiding) {
  const np_ray_instance *cloud = &all->instance[s->active[0]];
  np_voxel_walk walk;
  np_voxel_segment voxel;
  np_voxel_walk_start(&walk, &cloud->walk, &cloud->span, s->begin, s->end);
  while (m->carry > 0.0f && np_voxel_walk_next(&walk, cloud->volume->bricks, cloud->span.brick, &voxel))
    cross_voxel(m, all, s, &voxel, hiding);
}

/* Cuts a segment into equal pieces, and the pieces into steps. */
static void cross(np_march *m, const np_ray_intervals *all, const np_ray_interval *s) {
  float hiding[NP_INSTANCES_MAX], found[NP_INSTANCES_MAX][NP_BRICK_LINE], middle[NP_BRICK_LINE];
  for (unsigned i = 0; i < s->count; i++) hiding[i] = get_extinction_scale(m, all->instance[s->active[i]].volume);
  if (!np_step_goes_on(&m->step, all, s)) break_step(m);
  const float bound = compute_bound(all, s, hiding);
  const float pixel_m = get_pixel(m, s);
  const int count = refine_pieces(m, all, s, pixel_m, count_pieces(m, all, s, hiding));
  if (count > deep_count && s->count == 1 && np_bricks_are_smooth(all->instance[s->active[0]].volume->bricks)) {
    cross_deep(m, all, s, hiding[0]);
    return;
  }
  const float length = (float)(s->end - s->begin) / (float)count;
  for (int first = 0; first < count && m->carry > 0.0f; first += NP_BRICK_LINE) {
    const int some = fill_middles(first, count, length, middle);
    for (unsigned i = 0; i < s->count; i++)
      np_ray_instance_fill_extinction(&all->instance[s->active[i]], s->begin, np_maxf(length, pixel_m), middle, some,
                                      found[i]);
    for (int k = 0; k < some && m->carry > 0.0f; k++) {
      float extinction[NP_INSTANCES_MAX], sum = 0.0f;
      for (unsigned i = 0; i < s->count; i++) sum += hiding[i] * (extinction[i] = found[i][k]);
      pass_piece(m, all, s, extinction, s->begin + (double)((float)(first + k) * length), length, sum, bound);
    }
  }
}

/* The longest step, m, by the cloud whose voxels are smallest. */
static float compute_step_length(const np_march *m, const np_ray_intervals *all) {
  return m->settings->step_voxels / np_ray_intervals_get_finest(all);
}

static void start(np_march *m, const np_world *world, const np_lighting *lighting,
                  const np_integrator_settings *settings, const np_camera_ray *ray, np_random *random,
                  np_integrator_sample *out) {
  m->world = world;
  m->lighting = lighting;
  m->settings = settings;
  m->ray = ray;
  m->view = np_camera_ray_get_view(ray);
  m->random = random;
  m->field = settings->scattering_max > 1 ? lighting->scattering : NULL;
  m->medium = m->field ? np_scattering_field_get_medium(m->field) : NULL;
  m->scaled = np_spectrum_grey(1.0f);
  m->peak_depth = np_spectrum_grey(0.0f);
  m->carry = m->transmittance = 1.0f;
  m->step.count = 0;
  m->passed = 0.0f;
  m->has_motion = false;
  for (unsigned i = 0; i < world->clouds.count; i++)
    m->has_motion = m->has_motion || world->clouds.at[i].index_to_frame;
  np_march_forget_sun(m);
  m->out = out;
}

/* Share of the light behind the visible clouds that reaches the camera by the forward peak alone. */
static np_spectrum get_peak_weight(const np_march *m) {
  const np_spectrum weight = np_spectrum_subtract(m->scaled, np_spectrum_grey(m->transmittance));
  if (!m->settings->has_holdout) return weight;
  const float shown = m->out->opaque_weight, all = shown + m->out->held_out;
  return np_spectrum_scale(weight, all > 0.0f ? shown / all : 0.0f);
}

/* Largest tolerance of a reflection; it grows as the reflection's weight falls. */
static const float reflection_tolerance = 0.2f;

/* Facets of the waves that may reflect clear sky, by a lattice from the ray's own on. Their number has no factor with
 * 2, of whose powers the points of the rays are. */
enum { FACETS = 5, LATTICE_STEP = 2 };

/* A direction that a facet reflects to, with the weight of its light; a weight of 0: it reflects nothing. */
typedef struct wave_facet {
  np_vec3 direction;
  float weight;
} wave_facet;

static float turn(float number, int step) {
  const float sum = number + (float)(step % FACETS) / FACETS;
  return sum < 1.0f ? sum : sum - 1.0f;
}

static wave_facet get_facet(const np_camera_ray *ray, const np_ground_hit *hit, int k) {
  wave_facet out;
  out.direction = np_water_sample(hit->water, hit->normal, np_vec3_scale(ray->direction, -1.0f), turn(ray->facet[0], k),
                                  turn(ray->facet[1], LATTICE_STEP * k), &out.weight);
  return out;
}

static np_camera_ray reflect_ray(const np_camera_ray *ray, const np_ground_hit *hit, np_vec3 direction) {
  return (np_camera_ray){.origin = hit->position, .direction = direction, .jitter = ray->choice, .is_reflected = true};
}

/* Whether sky is all that a ray meets. */
static bool is_clear(const np_world *world, const np_camera_ray *ray) {
  np_ground_hit ground;
  np_ray_intervals all;
  np_ray_interval s;
  if (world->emission || np_camera_ray_intersect_ground(world, ray, &ground)) return false;
  np_ray_intervals_start(&all, &world->clouds, ray->origin, ray->direction, INFINITY);
  return !np_ray_intervals_next(&all, &s);
}

static np_spectrum march_facet(const np_reflection *reflection, const np_integrator_settings *settings,
                               const np_camera_ray *reflected, float weight, np_random *random) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  if (!(weight > 0.0f)) return sum;
  np_integrator_settings own = *settings;
  own.tolerance = np_minf(settings->tolerance / weight, np_maxf(settings->tolerance, reflection_tolerance));
  own.has_sun_share = own.is_ground_held_out = false;
  np_integrator_sample sample;
  NP_KERNEL(np_march_sample)(&reflection->world, &reflection->lighting, &own, reflected, random, &sample);
  for (int c = 0; c < NP_COMPONENT_COUNT; c++) sum = np_spectrum_add(sum, sample.component[c]);
  return np_spectrum_scale(sum, weight);
}

/* Light that the waves reflect, without disks: that of all facets if each reflects clear sky, else that of the ray's
 * own. The condition is the same whichever facet of the lattice is the ray's: so both have one mean. */
static np_spectrum reflect(const np_reflection *reflection, const np_integrator_settings *settings,
                           const np_camera_ray *ray, const np_ground_hit *hit, np_random *random) {
  const np_world *world = &reflection->world;
  wave_facet facets[FACETS];
  np_camera_ray rays[FACETS];
  bool are_clear = true;
  for (int k = 0; k < FACETS && are_clear; k++) {
    facets[k] = get_facet(ray, hit, k);
    rays[k] = reflect_ray(ray, hit, facets[k].direction);
    are_clear = !(facets[k].weight > 0.0f) || is_clear(world, &rays[k]);
  }
  if (!are_clear) return march_facet(reflection, settings, &rays[0], facets[0].weight, random);
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int k = 0; k < FACETS; k++) {
    if (!(facets[k].weight > 0.0f)) continue;
    const np_spectrum light = np_world_sky_radiance(world, world->camera_sky, hit->position, facets[k].direction);
    sum = np_spectrum_add(sum, np_spectrum_scale(light, facets[k].weight / FACETS));
  }
  return sum;
}

/* Adds ground or sky behind the clouds. `peak` is the transmittance by the forward peak alone. */
static void add_behind(np_march *m, const np_ground_hit *hit, np_spectrum peak) {
  np_behind behind = {.hit = hit};
  np_spectrum water;
  const bool is_seen = !m->settings->is_ground_held_out &&
                       (m->transmittance > 0.0f || (m->field && np_spectrum_max(peak) >= np_surroundings_peak_least));
  if (hit && hit->water && m->lighting->reflection && !m->ray->is_reflected && is_seen) {
    water = reflect(m->lighting->reflection, m->settings, m->ray, hit, m->random);
    water = np_surroundings_water(m->world, m->lighting, m->settings, hit, np_vec3_scale(m->ray->direction, -1.0f),
                                  water, NP_KERNEL(np_march_sun_transmittance), NP_KERNEL(np_march_shadow), m->random);
    behind.water = &water;
  }
  np_surroundings_add_behind(m->world, m->lighting, m->settings, m->ray, &behind, m->transmittance,
                             NP_KERNEL(np_march_shadow), m->random, m->out);
  if (m->field)
    np_surroundings_add_peak(m->world, m->lighting, m->settings, m->ray, &behind, peak, NP_KERNEL(np_march_shadow),
                             m->random, m->out);
}

void NP_KERNEL(np_march_sample)(const np_world *world, const np_lighting *lighting,
                                const np_integrator_settings *settings, const np_camera_ray *ray, np_random *random,
                                np_integrator_sample *out) {
  *out = (np_integrator_sample){.transmittance = 1.0f};
  np_ground_hit hit;
  out->is_ground_behind = np_camera_ray_intersect_ground(world, ray, &hit);
  const double distance_end = out->is_ground_behind ? hit.distance_m : np_camera_ray_get_end(ray);
  np_march m; /* assigned by member: its tables are large, and are filled for existing clouds alone */
  start(&m, world, lighting, settings, ray, random, out);
  np_ray_intervals all;
  np_ray_intervals_start(&all, &world->clouds, ray->origin, ray->direction, distance_end);
  if (all.count > 0) {
    m.to_sun = np_world_sample_sun(world, np_random_float(random), np_random_float(random));
    (m.field ? NP_KERNEL(np_march_start_scaled) : NP_KERNEL(np_march_start_approximation))(&m);
    m.step_length_m = compute_step_length(&m, &all);
    const bool has_tiles = m.field && np_scattering_field_get_fold(m.field)->period_m > 0.0;
    m.step_growth = has_tiles ? settings->step_voxels * ray->spread_rad : 0.0f;
    set_knot(&m, ray->jitter, 0.0);
    np_ray_interval s;
    while (m.carry > 0.0f && np_ray_intervals_next(&all, &s)) cross(&m, &all, &s);
    close_step(&m);
  }
  if (world->emission) add_emission(&m, distance_end);
  out->transmittance = m.transmittance;
  const np_spectrum peak_weight = get_peak_weight(&m);
  if (out->is_ground_behind)
    np_surroundings_add_opaque_ground(world, lighting, settings, &hit, m.transmittance,
                                      NP_KERNEL(np_march_sun_transmittance), random, out);
  add_behind(&m, out->is_ground_behind ? &hit : NULL, peak_weight);
}

/* Extinction of all clouds in the pieces of a segment. */
static inline void fill_extinction(const np_ray_intervals *all, const np_ray_interval *s, float length,
                                   float extinction[NP_BRICK_EDGE]) {
  float at[NP_BRICK_LINE] = {0.0f}, own[NP_BRICK_LINE];
  for (int k = 0; k < NP_BRICK_EDGE; k++) {
    at[k] = length * ((float)k + 0.5f);
    extinction[k] = 0.0f;
  }
  for (unsigned i = 0; i < s->count; i++) {
    np_ray_instance_fill_extinction(&all->instance[s->active[i]], s->begin, length, at, NP_BRICK_EDGE, own);
    for (int k = 0; k < NP_BRICK_EDGE; k++) extinction[k] += own[k];
  }
}

double NP_KERNEL(np_march_half_distance)(const np_world *world, const np_camera_ray *ray, double distance_max) {
  np_ray_intervals all;
  np_ray_interval s;
  float depth = 0.0f, extinction[NP_BRICK_EDGE];
  np_ray_intervals_start(&all, &world->clouds, ray->origin, ray->direction, distance_max);
  while (np_ray_intervals_next(&all, &s)) {
    const float length = (float)(s.end - s.begin) / NP_BRICK_EDGE;
    fill_extinction(&all, &s, length, extinction);
    for (int k = 0; k < NP_BRICK_EDGE; k++) {
      const float added = extinction[k] * length, missing = NP_LN2_F - depth;
      if (added >= missing) return s.begin + (double)(length * ((float)k + missing / added));
      depth += added;
    }
  }
  return INFINITY;
}

/* Transmittance below which the rest of a ray counts neither for motion vectors nor for opacity. */
static const float view_transmittance_end = 1.0f / 32.0f;

np_view_depth NP_KERNEL(np_march_view_depth)(const np_world *world, const np_camera_ray *ray, double distance_max) {
  np_ray_intervals all;
  np_ray_interval s;
  np_view_depth out = {.half_m = INFINITY, .cloud_m = INFINITY};
  float depth = 0.0f, transmittance = 1.0f, extinction[NP_BRICK_EDGE];
  double moment = 0.0;
  np_ray_intervals_start(&all, &world->clouds, ray->origin, ray->direction, distance_max);
  while (transmittance > view_transmittance_end && np_ray_intervals_next(&all, &s)) {
    const float length = (float)(s.end - s.begin) / NP_BRICK_EDGE;
    fill_extinction(&all, &s, length, extinction);
    for (int k = 0; k < NP_BRICK_EDGE; k++) {
      const float added = extinction[k] * length, missing = NP_LN2_F - depth;
      if (added >= missing && missing > 0.0f) out.half_m = s.begin + (double)(length * ((float)k + missing / added));
      depth += added;
      const float hidden = transmittance - np_transmittance(depth);
      moment += (double)hidden * (s.begin + (double)(length * ((float)k + 0.5f)));
      transmittance -= hidden;
    }
  }
  out.opacity = 1.0f - transmittance;
  if (out.opacity > 0.0f) out.cloud_m = moment / (double)out.opacity;
  return out;
}
