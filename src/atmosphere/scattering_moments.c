/* SPDX-License-Identifier: Apache-2.0 */
/* Successive orders of scattering (Chandrasekhar 1950, "Radiative Transfer", section 2), source kept by six moments.
 *
 * At each node (altitude, sun cosine) the radiance of one order is gathered over directions and reduced to its moments;
 * these give the source of the next order everywhere. The rule over zenith angles is split at the true horizon, where
 * the radiance jumps. Orders 1 to 4 are summed one by one; later ones form a geometric series with the last ratio
 * M(4)/M(3), which by then is nearly the same everywhere.
 *
 * Order 1 enters the moments with the aerosol's phase function cut after degree 2: only moments up to 2 are wanted, and
 * the cut spares the rule the forward peak.
 *
 * Between the nodes log M and the ratios of the others to M are interpolated by Catmull-Rom splines onto a finer table,
 * once an order, so that every look-up is bilinear.
 */
#include "atmosphere/scattering_moments.h"

#include "atmosphere/ray_path.h"
#include "atmosphere/spline.h"
#include "core/alloc.h"
#include "core/parallel.h"

enum {
  AZIMUTHS = 4,     /* on the half circle; no more than there are lanes */
  SERIES_ORDER = 4, /* the last that is gathered; the rest is a series */
  HALVES = 2
};

/* One number for each azimuth. */
typedef np_bands lanes;

/* Least radiance moment told from nothing, per unit irradiance. */
static const float least = 1e-13f;
/* The geometric series of the later orders goes no further than this ratio. */
static const float ratio_max = 0.9f;
/* The disk for which the table is built; its size matters only at the horizon, and there little. */
static const double disk_angular_radius_rad = 0.00467396;

typedef struct direction {
  float wz;
  float weight; /* of the zenith angle, for each of the AZIMUTHS */
  np_ray ray;
  np_path path;
} direction;

typedef struct builder {
  const np_medium *medium;
  const np_depth_table *depths;
  const np_moment_sizes *n;
  np_moment_table *table; /* holds the order before while the next is gathered */
  np_sun_disk disk;
  unsigned order, order_max;
  bool is_series; /* the last order stands for all that follow it */
  size_t node_count;
  float sun_cosine[NP_MOMENT_NODE_COLUMNS_MAX], sun_sine[NP_MOMENT_NODE_COLUMNS_MAX];
  lanes cos_azimuth;
  direction *directions;                                     /* node rows × directions */
  np_bands *gathered, *total;                                /* nodes × NP_MOMENT_COUNT: this order, and the sum */
  np_bands *last;                                            /* nodes: M of the order before */
  np_bands *half, *half_total;                               /* nodes × HALVES */
  np_bands *irradiance, *irradiance_total, *irradiance_last; /* node columns */
} builder;

static size_t node_at(const builder *b, size_t row, int column) {
  return row * (size_t)b->n->node_columns + (size_t)column;
}

static int count_directions(const builder *b) { return b->n->up + b->n->down; }

static direction *direction_at(const builder *b, size_t row, int k) {
  return &b->directions[row * (size_t)count_directions(b) + (size_t)k];
}

static double altitude_of_node(const builder *b, size_t row) {
  const double y = (double)row / (b->n->node_rows - 1);
  return b->medium->top_m * y * y;
}

static np_sun_scale make_sun_scale(const np_medium *medium, int columns) {
  /* The Earth's twilight, 0.1753, is covered by suns down to −0.4 with center −0.04 and spread 0.3. */
  const float scale = (float)(np_twilight_scale(medium) / 0.1753);
  np_sun_scale sun = {np_maxf(-1.0f, -0.4f * scale), -0.04f * scale, 0.3f * scale, 0.0f, columns, 0.0f};
  const float low = sun.lowest - sun.center, high = 1.0f - sun.center;
  sun.first = low / (fabsf(low) + sun.spread);
  sun.columns_per_unit = (float)(columns - 1) / (high / (fabsf(high) + sun.spread) - sun.first);
  return sun;
}

static float sun_cosine_of_column(const np_sun_scale *sun, double fraction) {
  const float y = sun->first + (float)(fraction * (sun->columns - 1)) / sun->columns_per_unit;
  return np_clampf(sun->center + sun->spread * y / (1.0f - fabsf(y)), sun->lowest, 1.0f);
}

/* Directions of one altitude: Gauss points in the root of the distance to the horizon, on either side of it. */
static void place_directions(builder *b, size_t row, const np_path_rule *rule) {
  const int up_count = b->n->up;
  const np_quadrature up = np_quadrature_gauss(up_count), down = np_quadrature_gauss(b->n->down);
  const double altitude = altitude_of_node(b, row), horizon = np_horizon_cosine(b->medium, altitude);
  for (int k = 0; k < count_directions(b); k++) {
    direction *d = direction_at(b, row, k);
    const np_quadrature *q = k < up_count ? &up : &down;
    const int at = k < up_count ? k : k - up_count;
    const double u = q->x[at], range = k < up_count ? 1.0 - horizon : -(1.0 + horizon);
    d->wz = (float)(horizon + range * u * u);
    d->weight = (float)(fabs(range) * 2.0 * u * q->weight[at] * 2.0 * NP_PI / AZIMUTHS);
    d->ray = np_ray_on_side(b->medium, altitude, d->wz, k >= up_count);
    np_path_build(b->medium, &d->ray, rule, &d->path);
  }
}

/* Cosines of the angles between a direction's azimuths and a node's sun. */
static lanes angles_to_sun(const builder *b, float wz, int column) {
  const float sine = sqrtf(np_maxf(1.0f - wz * wz, 0.0f));
  return wz * b->sun_cosine[column] + (sine * b->sun_sine[column]) * b->cos_azimuth;
}

static lanes clamp_lanes(lanes x, float low, float high) {
  return np_bands_min(np_bands_max(x, np_bands_grey(low)), np_bands_grey(high));
}

/* Sun cosines where a ray has come to, at radius r and distance t. */
static lanes suns_along(const np_ray *ray, float sun_cosine, lanes angle_cosine, double t, float r) {
  return clamp_lanes(((float)ray->r * sun_cosine + (float)t * angle_cosine) * (1.0f / r), -1.0f, 1.0f);
}

/* Sums of order 1 along a ray, without phase functions. */
typedef np_scattering first_order;

static void add_first_order(const np_medium *medium, const np_path_node *node, np_bands sunlight, first_order *sum) {
  const np_bands light = node->weight_m * node->transmittance * sunlight;
  sum->rayleigh += light * node->air.rayleigh;
  for (int i = 0; i < medium->aerosol_count; i++) sum->aerosol[i] += light * node->air.aerosol[i];
}

/* Depths at one altitude: the row of the table, its two neighbours mixed once for all the suns that are asked for. */
typedef struct mixed_row {
  np_depth_row row;
  np_bands depth[NP_DEPTH_COLUMNS_MAX];
} mixed_row;

static void mix_row(const builder *b, double altitude_m, mixed_row *out) {
  out->row = np_depth_table_row(b->depths, altitude_m);
  for (int i = 0; i < out->row.columns; i++)
    out->depth[i] = np_bands_mix(out->row.lower[i], out->row.upper[i], out->row.upper_weight);
}

/* Sunlight for every azimuth. Suns that stand high, most of them, go together: np_depth_row_sun by the same formulas.
 */
static void find_sunlight(const mixed_row *at, lanes sun, np_sun_disk disk, np_bands out[AZIMUTHS]) {
  const np_depth_row *row = &at->row;
  const float lowest = np_minf(np_minf(sun[0], sun[1]), np_minf(sun[2], sun[3]));
  if (lowest < 0.0f || (lowest - row->horizon_cosine) * row->disk_scale <= 0.2f) {
    for (int p = 0; p < AZIMUTHS; p++) out[p] = np_depth_row_sun(row, sun[p], disk);
    return;
  }
  const lanes c = row->r * sun, distance = row->exit / (c + np_bands_sqrt(c * c + row->exit));
  const lanes x = clamp_lanes((distance - row->distance_min) * row->texels_per_m, 0.0f, (float)(row->columns - 1));
  const np_bands_bits i =
      __builtin_convertvector(np_bands_min(x, np_bands_grey((float)(row->columns - 2))), np_bands_bits);
  const lanes f = x - __builtin_convertvector(i, lanes);
  for (int p = 0; p < AZIMUTHS; p++) {
    const np_bands *d = at->depth + i[p];
    out[p] = np_bands_exp(-np_bands_mix(d[0], d[1], f[p]));
  }
}

/* Light of order 1 that the aerosols scatter, by their phase functions cut after degree 2. */
static np_bands cut_aerosol_light(const np_medium *medium, const first_order *first, float c) {
  return (float)(0.25 / NP_PI) * (np_aerosol_sum(medium, first, 0) + 3.0f * c * np_aerosol_sum(medium, first, 1) +
                                  2.5f * (3.0f * c * c - 1.0f) * np_aerosol_sum(medium, first, 2));
}

/* Light that the ground at a ray's end sends back along it: from the sun in order 1, from the sky of the order before
 * else. */
static np_bands ground_radiance(const builder *b, const direction *d, float sun_cosine, float angle) {
  const float at_ground =
      ((float)d->ray.r * sun_cosine + (float)d->ray.length_m * angle) / (float)b->medium->planet_radius_m;
  const float s = np_clampf(at_ground, -1.0f, 1.0f);
  np_bands irradiance;
  if (b->order == 1) {
    const np_depth_row row = np_depth_table_row(b->depths, 0.0);
    irradiance = np_maxf(s, 0.0f) * np_depth_row_sun(&row, s, b->disk);
  } else {
    irradiance = np_moment_table_irradiance(b->table, s);
  }
  return (float)(1.0 / NP_PI) * d->path.end_transmittance * b->medium->ground_albedo * irradiance;
}

static void add_to_moments(np_bands *m, np_bands light, float wx, float wz) {
  m[NP_MOMENT_M] += light;
  m[NP_MOMENT_FX] += wx * light;
  m[NP_MOMENT_FZ] += wz * light;
  m[NP_MOMENT_KXX] += wx * wx * light;
  m[NP_MOMENT_KZZ] += wz * wz * light;
  m[NP_MOMENT_KXZ] += wx * wz * light;
}

/* Inverse integral of an aerosol's phase function by the directions' own rule, at one node: what the halves are
 * multiplied by, so that the forward peak, which the rule cannot resolve, brings neither more nor less light than there
 * is. */
static float invert_phase_sum(const builder *b, const np_phase *phase, size_t row, int column) {
  float sum = 0.0f;
  for (int k = 0; k < count_directions(b); k++) {
    const direction *d = direction_at(b, row, k);
    const lanes angle = angles_to_sun(b, d->wz, column);
    for (int p = 0; p < AZIMUTHS; p++) sum += d->weight * np_phase_eval(phase, 1.0f - angle[p]);
  }
  return 1.0f / np_maxf(sum, 1e-6f);
}

/* Sums of order 1 along one direction, for every sun and azimuth. */
static void sum_first_order(const builder *b, const direction *d, const lanes *angle, first_order (*sum)[AZIMUTHS]) {
  memset(sum, 0, (size_t)b->n->node_columns * sizeof *sum);
  for (int i = 0; i < d->path.count; i++) {
    const np_path_node *node = &d->path.node[i];
    mixed_row row;
    mix_row(b, (double)node->altitude_m, &row);
    for (int column = 0; column < b->n->node_columns; column++) {
      np_bands sunlight[AZIMUTHS];
      const lanes sun = suns_along(&d->ray, b->sun_cosine[column], angle[column], node->t, node->r);
      find_sunlight(&row, sun, b->disk, sunlight);
      for (int p = 0; p < AZIMUTHS; p++) add_first_order(b->medium, node, sunlight[p], &sum[column][p]);
    }
  }
}

/* Adds one direction's order 1, sunlight scattered once and sunlight from the ground, to the nodes of a row.
 * `phase_scale` comes from invert_phase_sum. */
static void reduce_first_order(builder *b, size_t row, int k, const lanes *angle, float (*phase_scale)[NP_AEROSOLS_MAX],
                               first_order (*first)[AZIMUTHS]) {
  const np_medium *medium = b->medium;
  const direction *d = direction_at(b, row, k);
  const lanes wx = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f)) * b->cos_azimuth;
  for (int column = 0; column < b->n->node_columns; column++)
    for (int p = 0; p < AZIMUTHS; p++) {
      const float c = angle[column][p];
      const first_order *f = &first[column][p];
      np_bands light = f->rayleigh * np_phase_rayleigh_eval(c);
      if (d->ray.hits_ground) light += ground_radiance(b, d, b->sun_cosine[column], c);
      const np_bands cut = light + cut_aerosol_light(medium, f, c);
      add_to_moments(b->gathered + node_at(b, row, column) * NP_MOMENT_COUNT, d->weight * cut, wx[p], d->wz);
      for (int i = 0; i < medium->aerosol_count; i++)
        light += phase_scale[column][i] * np_phase_eval(&medium->aerosol[i].phase, 1.0f - c) * f->aerosol[i];
      b->half[node_at(b, row, column) * HALVES + (size_t)(k >= b->n->up)] += d->weight * light;
    }
}

static neph_result gather_direct_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  builder *b = user;
  const int columns = b->n->node_columns;
  for (size_t row = begin; row < end; row++) {
    float phase_scale[NP_MOMENT_NODE_COLUMNS_MAX][NP_AEROSOLS_MAX];
    for (int column = 0; column < columns; column++)
      for (int i = 0; i < b->medium->aerosol_count; i++)
        phase_scale[column][i] = invert_phase_sum(b, &b->medium->aerosol[i].phase, row, column);
    for (int k = 0; k < count_directions(b); k++) {
      const direction *d = direction_at(b, row, k);
      lanes angle[NP_MOMENT_NODE_COLUMNS_MAX];
      first_order first[NP_MOMENT_NODE_COLUMNS_MAX][AZIMUTHS];
      for (int column = 0; column < columns; column++) angle[column] = angles_to_sun(b, d->wz, column);
      sum_first_order(b, d, angle, first);
      reduce_first_order(b, row, k, angle, phase_scale, first);
    }
  }
  return NEPH_OK;
}

/* The source of the order before at one point of a ray, as a quadratic in ωx for each column of the table: along a
 * fixed ray ωz, the coefficients and the altitude are the same for all suns and azimuths. */
typedef struct folded_source {
  np_bands constant, linear, square;
} folded_source;

static void fold_source(const builder *b, const np_path_node *node, folded_source *out) {
  const float z = node->cosine;
  const np_bands weight = (float)(0.25 / NP_PI) * node->weight_m * node->transmittance;
  const np_bands rayleigh = 0.75f * node->air.rayleigh, chi2 = np_aerosol_sum(b->medium, &node->air, 2);
  const np_bands a = weight * (rayleigh + np_aerosol_sum(b->medium, &node->air, 0) - 2.5f * chi2);
  const np_bands f = weight * 3.0f * np_aerosol_sum(b->medium, &node->air, 1), c = weight * (rayleigh + 7.5f * chi2);
  float upper;
  const int row = np_moment_table_row(b->table, (double)node->altitude_m, &upper);
  const int columns = b->table->sun.columns;
  const np_bands *low = np_moment_table_at_row(b->table, row), *high = low + columns * NP_MOMENT_COUNT;
  for (int i = 0; i < columns; i++, low += NP_MOMENT_COUNT, high += NP_MOMENT_COUNT) {
    np_bands m[NP_MOMENT_COUNT];
    for (int k = 0; k < NP_MOMENT_COUNT; k++) m[k] = np_bands_mix(low[k], high[k], upper);
    const np_bands kyy = m[NP_MOMENT_M] - m[NP_MOMENT_KXX] - m[NP_MOMENT_KZZ];
    out[i].constant =
        a * m[NP_MOMENT_M] + z * (f * m[NP_MOMENT_FZ]) + c * ((1.0f - z * z) * kyy + z * z * m[NP_MOMENT_KZZ]);
    out[i].linear = f * m[NP_MOMENT_FX] + (2.0f * z) * (c * m[NP_MOMENT_KXZ]);
    out[i].square = c * (m[NP_MOMENT_KXX] - kyy);
  }
}

/* np_sun_scale_column and np_sun_scale_split for every azimuth. */
static np_bands_bits split_columns(const np_sun_scale *scale, lanes sun_cosine, lanes *out_weight) {
  const lanes d = sun_cosine - scale->center;
  const lanes size = np_bands_max(d, -d);
  const lanes column = clamp_lanes((d / (size + scale->spread) - scale->first) * scale->columns_per_unit, 0.0f,
                                   (float)(scale->columns - 1));
  const np_bands_bits i =
      __builtin_convertvector(np_bands_min(column, np_bands_grey((float)(scale->columns - 2))), np_bands_bits);
  *out_weight = column - __builtin_convertvector(i, lanes);
  return i;
}

/* np_direction_x for every azimuth. */
static lanes directions_x(lanes angle_cosine, float wz, lanes sun_cosine) {
  const float limit = sqrtf(np_maxf(1.0f - wz * wz, 0.0f));
  const lanes sine = np_bands_sqrt(np_bands_max(1.0f - sun_cosine * sun_cosine, np_bands_grey(1e-6f)));
  return clamp_lanes((angle_cosine - wz * sun_cosine) / sine, -limit, limit);
}

/* Adds one point's source to the radiance of every sun and azimuth. */
static void add_source(const builder *b, const direction *d, const np_path_node *node, const lanes *angle,
                       const folded_source *source, np_bands (*radiance)[AZIMUTHS]) {
  for (int column = 0; column < b->n->node_columns; column++) {
    const lanes sun = suns_along(&d->ray, b->sun_cosine[column], angle[column], node->t, node->r);
    const lanes wx = directions_x(angle[column], node->cosine, sun);
    lanes weight;
    const np_bands_bits index = split_columns(&b->table->sun, sun, &weight);
    for (int p = 0; p < AZIMUTHS; p++) {
      const folded_source *s = source + index[p];
      const float f = weight[p], x = wx[p];
      radiance[column][p] +=
          np_bands_mix(s[0].constant, s[1].constant, f) +
          x * (np_bands_mix(s[0].linear, s[1].linear, f) + x * np_bands_mix(s[0].square, s[1].square, f));
    }
  }
}

/* Reduces the radiance along one direction to every sun's moments, halves and irradiance. */
static void reduce_direction(builder *b, size_t row, int k, const lanes *angle, np_bands (*radiance)[AZIMUTHS]) {
  const direction *d = direction_at(b, row, k);
  const lanes wx = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f)) * b->cos_azimuth;
  for (int column = 0; column < b->n->node_columns; column++)
    for (int p = 0; p < AZIMUTHS; p++) {
      np_bands light = radiance[column][p];
      if (d->ray.hits_ground) light += ground_radiance(b, d, b->sun_cosine[column], angle[column][p]);
      light = d->weight * np_bands_max(light, np_bands_grey(0.0f));
      add_to_moments(b->gathered + node_at(b, row, column) * NP_MOMENT_COUNT, light, wx[p], d->wz);
      b->half[node_at(b, row, column) * HALVES + (size_t)(k >= b->n->up)] += light;
      if (row == 0 && k < b->n->up) b->irradiance[column] += d->wz * light;
    }
}

static neph_result gather_scattered_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  builder *b = user;
  for (size_t row = begin; row < end; row++)
    for (int k = 0; k < count_directions(b); k++) {
      const direction *d = direction_at(b, row, k);
      np_bands radiance[NP_MOMENT_NODE_COLUMNS_MAX][AZIMUTHS] = {{{0}}};
      folded_source source[NP_MOMENT_COLUMNS_MAX];
      lanes angle[NP_MOMENT_NODE_COLUMNS_MAX];
      for (int column = 0; column < b->n->node_columns; column++) angle[column] = angles_to_sun(b, d->wz, column);
      for (int i = 0; i < d->path.count; i++) {
        fold_source(b, &d->path.node[i], source);
        add_source(b, d, &d->path.node[i], angle, source, radiance);
      }
      reduce_direction(b, row, k, angle, radiance);
    }
  return NEPH_OK;
}

/* Irradiance of order 1 on the ground, with the whole phase function: a rule about the sun instead of the zenith, Θ =
 * π·u², so that the peak is resolved and the cut at the horizon costs little (the integrand vanishes there as the
 * cosine). */
enum { ANGLES = 16, TURNS = 8 };

static np_bands sum_direct_irradiance(const builder *b, float sun_cosine, const np_path_rule *rule,
                                      const np_quadrature *angles) {
  np_bands sum = np_bands_grey(0.0f);
  const float sun_sine = sqrtf(np_maxf(1.0f - sun_cosine * sun_cosine, 0.0f));
  for (int i = 0; i < ANGLES; i++)
    for (int k = 0; k < TURNS; k++) {
      const double angle = NP_PI * angles->x[i] * angles->x[i], turn = NP_PI * (k + 0.5) / TURNS;
      const float c = (float)cos(angle), s = (float)sin(angle), wz = sun_cosine * c + sun_sine * s * (float)cos(turn);
      if (wz <= 0.0f) continue;
      const np_ray ray = np_ray_on_side(b->medium, 0.0, wz, false);
      np_path path;
      np_path_build(b->medium, &ray, rule, &path);
      first_order first;
      memset(&first, 0, sizeof first);
      for (int n = 0; n < path.count; n++) {
        const np_depth_row row = np_depth_table_row(b->depths, (double)path.node[n].altitude_m);
        const lanes sun = suns_along(&ray, sun_cosine, np_bands_grey(c), path.node[n].t, path.node[n].r);
        add_first_order(b->medium, &path.node[n], np_depth_row_sun(&row, sun[0], b->disk), &first);
      }
      const double weight = 2.0 * NP_PI * angles->x[i] * angles->weight[i] * sin(angle) * 2.0 * NP_PI / TURNS;
      np_bands light = first.rayleigh * np_phase_rayleigh_eval(c);
      for (int a = 0; a < b->medium->aerosol_count; a++)
        light += np_phase_eval(&b->medium->aerosol[a].phase, 1.0f - c) * first.aerosol[a];
      sum += (float)weight * wz * light;
    }
  return sum;
}

static neph_result gather_direct_irradiance(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  builder *b = user;
  const np_path_rule rule = np_path_rule_make(12);
  const np_quadrature angles = np_quadrature_gauss(ANGLES);
  for (size_t column = begin; column < end; column++)
    b->irradiance[column] = sum_direct_irradiance(b, b->sun_cosine[column], &rule, &angles);
  return NEPH_OK;
}

/* ---- Refinement ---- */

/* Refines one quantity from the nodes onto the table; `wide` holds a table row for each node row. */
static void refine(const builder *b, const np_bands *nodes, np_bands *wide, np_bands *fine) {
  const int columns = b->table->sun.columns, node_columns = b->n->node_columns, node_rows = b->n->node_rows;
  for (int i = 0; i < columns; i++) {
    const np_spline s = np_spline_make(i, columns, node_columns);
    for (int row = 0; row < node_rows; row++)
      wide[row * columns + i] = np_spline_eval(&s, nodes + node_at(b, (size_t)row, 0), 1);
  }
  for (int row = 0; row < b->table->rows; row++) {
    const np_spline s = np_spline_make(row, b->table->rows, node_rows);
    for (int i = 0; i < columns; i++) fine[row * columns + i] = np_spline_eval(&s, wide + i, (size_t)columns);
  }
}

static np_bands log_of(np_bands value) { return np_bands_log(np_bands_max(value, np_bands_grey(least))); }

/* Where refinement works: node values of one quantity, those refined along rows, and the whole refined. */
typedef struct workbench {
  np_bands *nodes, *wide, *fine;
} workbench;

/* Refines the k-th of `stride` quantities at the nodes: as a logarithm, or as its ratio to the first of them. */
static void refine_quantity(const builder *b, const np_bands *values, size_t stride, size_t k, bool is_ratio,
                            const workbench *w) {
  for (size_t i = 0; i < b->node_count; i++) {
    const np_bands value = values[i * stride + k];
    w->nodes[i] = is_ratio ? value / np_bands_max(values[i * stride], np_bands_grey(least)) : log_of(value);
  }
  refine(b, w->nodes, w->wide, w->fine);
}

/* The last quarter of the columns' range of night, in which the light is faded to none. */
static float fade_at(const np_sun_scale *sun, int column) {
  const float cosine = sun_cosine_of_column(sun, (double)column / (sun->columns - 1));
  return np_smoothstepf((cosine - sun->lowest) / (-0.2f * sun->lowest));
}

static size_t count_texels(const np_moment_table *table) { return (size_t)table->rows * (size_t)table->sun.columns; }

/* Fills the table from moments at the nodes. `is_final` fades its dark end. */
static void refine_moments(const builder *b, const np_bands *values, const workbench *w, bool is_final) {
  np_bands *out = b->table->moments;
  const size_t columns = (size_t)b->table->sun.columns, texels = count_texels(b->table);
  for (size_t k = 0; k < NP_MOMENT_COUNT; k++) {
    refine_quantity(b, values, NP_MOMENT_COUNT, k, k != NP_MOMENT_M, w);
    for (size_t i = 0; i < texels; i++) {
      np_bands *m = out + i * NP_MOMENT_COUNT;
      m[k] = k == NP_MOMENT_M ? np_bands_exp(w->fine[i]) : w->fine[i] * m[NP_MOMENT_M];
    }
  }
  for (size_t column = 0; is_final && column < columns; column++) {
    const float fade = fade_at(&b->table->sun, (int)column);
    for (size_t i = column; fade < 1.0f && i < texels; i += columns)
      for (size_t k = 0; k < NP_MOMENT_COUNT; k++) out[i * NP_MOMENT_COUNT + k] *= fade;
  }
}

static void refine_halves(const builder *b, const workbench *w) {
  const size_t columns = (size_t)b->table->sun.columns;
  for (size_t k = 0; k < HALVES; k++) {
    refine_quantity(b, b->half_total, HALVES, k, false, w);
    for (size_t i = 0; i < count_texels(b->table); i++)
      b->table->hemisphere[i * HALVES + k] = np_bands_exp(w->fine[i]) * fade_at(&b->table->sun, (int)(i % columns));
  }
}

static void refine_irradiance(const builder *b, const np_bands *values, bool is_final) {
  const int columns = b->table->sun.columns, count = b->n->node_columns;
  np_bands node[NP_MOMENT_NODE_COLUMNS_MAX];
  for (int i = 0; i < count; i++) node[i] = log_of(values[i]);
  for (int i = 0; i < columns; i++) {
    const np_spline s = np_spline_make(i, columns, count);
    b->table->irradiance[i] =
        np_bands_exp(np_spline_eval(&s, node, 1)) * (is_final ? fade_at(&b->table->sun, i) : 1.0f);
  }
}

/* What the last order is multiplied by to stand for all that follow it, itself included. */
static np_bands sum_series(np_bands last, np_bands before) {
  const np_bands ratio = np_bands_min(last / np_bands_max(before, np_bands_grey(least)), np_bands_grey(ratio_max));
  return 1.0f / (1.0f - ratio);
}

/* Adds the order just gathered to the sums. */
static void add_order(builder *b) {
  const bool is_last = b->is_series && b->order == b->order_max;
  for (size_t i = 0; i < b->node_count; i++) {
    const np_bands m = b->gathered[i * NP_MOMENT_COUNT];
    const np_bands factor = is_last ? sum_series(m, b->last[i]) : np_bands_grey(1.0f);
    for (size_t k = 0; k < NP_MOMENT_COUNT; k++)
      b->total[i * NP_MOMENT_COUNT + k] += factor * b->gathered[i * NP_MOMENT_COUNT + k];
    for (size_t k = 0; k < HALVES; k++) b->half_total[i * HALVES + k] += factor * b->half[i * HALVES + k];
    b->last[i] = m;
  }
  for (int i = 0; i < b->n->node_columns; i++) {
    const np_bands e = b->irradiance[i];
    b->irradiance_total[i] += e * (is_last ? sum_series(e, b->irradiance_last[i]) : np_bands_grey(1.0f));
    b->irradiance_last[i] = e;
  }
}

static neph_result gather_order(neph_context *context, builder *b) {
  const size_t rows = (size_t)b->n->node_rows, columns = (size_t)b->n->node_columns;
  memset(b->gathered, 0, b->node_count * NP_MOMENT_COUNT * sizeof(np_bands));
  memset(b->half, 0, b->node_count * HALVES * sizeof(np_bands));
  memset(b->irradiance, 0, columns * sizeof(np_bands));
  if (b->order > 1) return np_parallel_for(context, NULL, rows, 1, gather_scattered_rows, b);
  neph_result result = np_parallel_for(context, NULL, rows, 1, gather_direct_rows, b);
  return result ? result : np_parallel_for(context, NULL, columns, 1, gather_direct_irradiance, b);
}

static neph_result sum_orders(neph_context *context, builder *b, const workbench *w) {
  for (b->order = 1; b->order <= b->order_max; b->order++) {
    neph_result result = gather_order(context, b);
    if (result) return result;
    add_order(b);
    if (b->order == b->order_max) break;
    refine_moments(b, b->gathered, w, false);
    refine_irradiance(b, b->irradiance, false);
  }
  refine_moments(b, b->total, w, true);
  refine_halves(b, w);
  refine_irradiance(b, b->irradiance_total, true);
  return NEPH_OK;
}

static void place_nodes(builder *b) {
  const np_path_rule rule = np_path_rule_make(b->n->points);
  for (int row = 0; row < b->n->node_rows; row++) place_directions(b, (size_t)row, &rule);
  for (int i = 0; i < b->n->node_columns; i++) {
    const float cosine = sun_cosine_of_column(&b->table->sun, (double)i / (b->n->node_columns - 1));
    b->sun_cosine[i] = cosine;
    b->sun_sine[i] = sqrtf(np_maxf(1.0f - cosine * cosine, 0.0f));
  }
  for (int p = 0; p < AZIMUTHS; p++) b->cos_azimuth[p] = (float)cos(NP_PI * (p + 0.5) / AZIMUTHS);
}

static bool allocate_table(neph_context *context, np_moment_table *table) {
  const size_t count = count_texels(table);
  table->moments = np_alloc(context, count * NP_MOMENT_COUNT, sizeof(np_bands));
  if (table->moments) table->hemisphere = np_alloc(context, count * HALVES, sizeof(np_bands));
  if (table->hemisphere) table->irradiance = np_alloc(context, (size_t)table->sun.columns, sizeof(np_bands));
  return table->irradiance;
}

/* Everything the builder works in, as one block of packets. */
static np_bands *allocate_work(neph_context *context, builder *b, workbench *w) {
  const size_t nodes = b->node_count, columns = (size_t)b->n->node_columns;
  const size_t wide = (size_t)b->n->node_rows * (size_t)b->table->sun.columns;
  const size_t each = 2 * NP_MOMENT_COUNT + 2 * HALVES + 2;
  np_bands *work = np_alloc(context, nodes * each + 3 * columns + wide + count_texels(b->table), sizeof(np_bands));
  if (!work) return NULL;
  b->gathered = work;
  b->total = b->gathered + nodes * NP_MOMENT_COUNT;
  b->half = b->total + nodes * NP_MOMENT_COUNT;
  b->half_total = b->half + nodes * HALVES;
  b->last = b->half_total + nodes * HALVES;
  b->irradiance = b->last + nodes;
  b->irradiance_total = b->irradiance + columns;
  b->irradiance_last = b->irradiance_total + columns;
  w->nodes = b->irradiance_last + columns;
  w->wide = w->nodes + nodes;
  w->fine = w->wide + wide;
  return work;
}

neph_result np_moment_table_build(neph_context *context, const np_depth_table *depths, const np_moment_sizes *sizes,
                                  unsigned order_max, bool has_point_sun, np_moment_table *out_table) {
  const np_medium *medium = depths->medium;
  *out_table = (np_moment_table){.medium = medium, .sun = make_sun_scale(medium, sizes->columns), .rows = sizes->rows};
  if (!allocate_table(context, out_table)) return NEPH_ERROR_OUT_OF_MEMORY;
  builder *b = np_alloc(context, 1, sizeof *b);
  if (!b) return NEPH_ERROR_OUT_OF_MEMORY;
  b->medium = medium;
  b->depths = depths;
  b->n = sizes;
  b->table = out_table;
  b->disk = np_sun_disk_make(disk_angular_radius_rad, has_point_sun);
  b->is_series = order_max == NP_ORDERS_ALL;
  b->order_max = b->is_series ? SERIES_ORDER : order_max;
  b->node_count = (size_t)(sizes->node_rows * sizes->node_columns);
  workbench w;
  neph_result result = NEPH_ERROR_OUT_OF_MEMORY;
  np_bands *work = allocate_work(context, b, &w);
  if (work) b->directions = np_alloc(context, (size_t)(sizes->node_rows * count_directions(b)), sizeof *b->directions);
  if (b->directions) {
    place_nodes(b);
    result = sum_orders(context, b, &w);
  }
  np_alloc_free(context, b->directions);
  np_alloc_free(context, work);
  np_alloc_free(context, b);
  return result;
}

/* One place of a table under a sun of cosine `wz`. */
static void add_beam(np_moment_table *table, size_t at, np_bands light, float wz) {
  const float wx = sqrtf(np_maxf(1.0f - wz * wz, 0.0f));
  add_to_moments(table->moments + at * NP_MOMENT_COUNT, light, wx, wz);
  table->hemisphere[at * HALVES] += light;
}

void np_moment_table_add_beam(np_moment_table *table, const np_depth_table *brighter, const np_depth_table *darker,
                              bool has_point_sun) {
  const np_sun_disk disk = np_sun_disk_make(disk_angular_radius_rad, has_point_sun);
  const int columns = table->sun.columns;
  for (int row = 0; row < table->rows; row++) {
    const double y = (double)row / (table->rows - 1), altitude = table->medium->top_m * y * y;
    const np_depth_row bright = np_depth_table_row(brighter, altitude), dark = np_depth_table_row(darker, altitude);
    for (int i = 0; i < columns; i++) {
      const float sun = sun_cosine_of_column(&table->sun, (double)i / (columns - 1));
      const np_bands light = np_bands_max(np_depth_row_sun(&bright, sun, disk) - np_depth_row_sun(&dark, sun, disk),
                                          np_bands_grey(0.0f));
      add_beam(table, (size_t)(row * columns + i), light, sun);
      if (row == 0) table->irradiance[i] += np_maxf(sun, 0.0f) * light;
    }
  }
}

void np_moment_table_free(neph_context *context, np_moment_table *table) {
  np_alloc_free(context, table->moments);
  np_alloc_free(context, table->hemisphere);
  np_alloc_free(context, table->irradiance);
  *table = (np_moment_table){0};
}

np_bands np_moment_table_irradiance(const np_moment_table *table, float sun_cosine) {
  float f;
  const int i = np_sun_scale_split(&table->sun, np_sun_scale_column(&table->sun, sun_cosine), &f);
  return np_bands_mix(table->irradiance[i], table->irradiance[i + 1], f);
}
