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
#include "core/alloc.h"
#include "core/parallel.h"

enum {
  ROWS = 16,    /* nodes over altitude */
  COLUMNS = 32, /* nodes over sun cosine */
  UP = 10,      /* directions above the horizon */
  DOWN = 5,     /* and below */
  DIRECTIONS = UP + DOWN,
  AZIMUTHS = 4,     /* on the half circle */
  POINTS = 20,      /* along each ray */
  SERIES_ORDER = 4, /* the last that is gathered; the rest is a series */
  HALVES = 2
};

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
  np_moment_table *table; /* holds the order before while the next is gathered */
  np_sun_disk disk;
  unsigned order, order_max;
  bool is_series; /* the last order stands for all that follow it */
  double altitude[ROWS];
  float sun_cosine[COLUMNS], cos_azimuth[AZIMUTHS];
  direction *directions;       /* ROWS × DIRECTIONS */
  np_bands *gathered, *total;  /* ROWS × COLUMNS × NP_MOMENT_COUNT: this order, and the sum */
  np_bands *last;              /* ROWS × COLUMNS: M of the order before */
  np_bands *half, *half_total; /* ROWS × COLUMNS × HALVES */
  np_bands irradiance[COLUMNS], irradiance_total[COLUMNS], irradiance_last[COLUMNS];
} builder;

static size_t node_at(int row, int column) { return (size_t)row * COLUMNS + (size_t)column; }

static np_sun_scale make_sun_scale(const np_medium *medium) {
  /* The Earth's twilight, 0.1753, is covered by suns down to −0.4 with center −0.04 and spread 0.3. */
  const float scale = (float)(np_twilight_scale(medium) / 0.1753);
  np_sun_scale sun = {np_maxf(-1.0f, -0.4f * scale), -0.04f * scale, 0.3f * scale, 0.0f, 0.0f};
  const float low = sun.lowest - sun.center, high = 1.0f - sun.center;
  sun.first = low / (fabsf(low) + sun.spread);
  sun.columns_per_unit = (float)(NP_MOMENT_COLUMNS - 1) / (high / (fabsf(high) + sun.spread) - sun.first);
  return sun;
}

static float sun_cosine_of_column(const np_sun_scale *sun, double fraction) {
  const float y = sun->first + (float)(fraction * (NP_MOMENT_COLUMNS - 1)) / sun->columns_per_unit;
  return np_clampf(sun->center + sun->spread * y / (1.0f - fabsf(y)), sun->lowest, 1.0f);
}

/* Directions of one altitude: Gauss points in the root of the distance to the horizon, on either side of it. */
static void place_directions(builder *b, int row) {
  const np_quadrature up = np_quadrature_gauss(UP), down = np_quadrature_gauss(DOWN);
  const np_path_rule rule = np_path_rule_make(POINTS);
  const double horizon = np_horizon_cosine(b->medium, b->altitude[row]);
  for (int k = 0; k < DIRECTIONS; k++) {
    direction *d = &b->directions[row * DIRECTIONS + k];
    const np_quadrature *q = k < UP ? &up : &down;
    const double u = q->x[k < UP ? k : k - UP], range = k < UP ? 1.0 - horizon : -(1.0 + horizon);
    d->wz = (float)(horizon + range * u * u);
    d->weight = (float)(fabs(range) * 2.0 * u * q->weight[k < UP ? k : k - UP] * 2.0 * NP_PI / AZIMUTHS);
    d->ray = np_ray_on_side(b->medium, b->altitude[row], d->wz, k >= UP);
    np_path_build(b->medium, &d->ray, &rule, &d->path);
  }
}

/* Cosine of the angle between a direction and the sun. */
static float angle_to_sun(float wz, float sun_cosine, float cos_azimuth) {
  return wz * sun_cosine +
         sqrtf(np_maxf(1.0f - wz * wz, 0.0f) * np_maxf(1.0f - sun_cosine * sun_cosine, 0.0f)) * cos_azimuth;
}

/* Sun cosine where a ray has come to, at radius r and distance t. */
static float sun_cosine_along(const np_ray *ray, float sun_cosine, float angle_cosine, double t, float r) {
  return np_clampf(((float)ray->r * sun_cosine + (float)t * angle_cosine) / r, -1.0f, 1.0f);
}

/* Sums of order 1 along a ray, without phase functions. */
typedef np_scattering first_order;

static first_order gather_first_order(const builder *b, const np_depth_row *depth_rows, const direction *d,
                                      float sun_cosine, float angle) {
  const int count = b->medium->aerosol_count;
  first_order sum = {.rayleigh = np_bands_grey(0.0f)};
  for (int i = 0; i < d->path.count; i++) {
    const np_path_node *node = &d->path.node[i];
    const float s = sun_cosine_along(&d->ray, sun_cosine, angle, node->t, node->r);
    const np_bands light = node->weight_m * node->transmittance * np_depth_row_sun(&depth_rows[i], s, b->disk);
    sum.rayleigh += light * node->air.rayleigh;
    for (int k = 0; k < count; k++) sum.aerosol[k] += light * node->air.aerosol[k];
  }
  return sum;
}

/* Light of order 1 that the aerosols scatter, by their phase functions cut after degree 2. */
static np_bands cut_aerosol_light(const np_medium *medium, const first_order *first, float c) {
  return (float)(0.25 / NP_PI) * (np_aerosol_sum(medium, first, 0) + 3.0f * c * np_aerosol_sum(medium, first, 1) +
                                  2.5f * (3.0f * c * c - 1.0f) * np_aerosol_sum(medium, first, 2));
}

/* Light that the ground at a ray's end sends back along it: from the sun in order 1, from the sky of the order before
 * else. */
static np_bands ground_radiance(const builder *b, const direction *d, float sun_cosine, float angle) {
  const float s = sun_cosine_along(&d->ray, sun_cosine, angle, d->ray.length_m, (float)b->medium->planet_radius_m);
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
static float invert_phase_sum(const builder *b, const np_phase *phase, int row, float sun_cosine) {
  float sum = 0.0f;
  for (int k = 0; k < DIRECTIONS; k++)
    for (int p = 0; p < AZIMUTHS; p++) {
      const direction *d = &b->directions[row * DIRECTIONS + k];
      sum += d->weight * np_phase_eval(phase, 1.0f - angle_to_sun(d->wz, sun_cosine, b->cos_azimuth[p]));
    }
  return 1.0f / np_maxf(sum, 1e-6f);
}

/* Order 1 of one node: sunlight scattered once, and sunlight from the ground. */
static void gather_direct(builder *b, int row, int column, const np_depth_row (*depth_rows)[POINTS]) {
  const np_medium *medium = b->medium;
  const float sun = b->sun_cosine[column];
  float inverse_sum[NP_AEROSOLS_MAX];
  for (int i = 0; i < medium->aerosol_count; i++)
    inverse_sum[i] = invert_phase_sum(b, &medium->aerosol[i].phase, row, sun);
  np_bands *moments = b->gathered + node_at(row, column) * NP_MOMENT_COUNT;
  for (int k = 0; k < DIRECTIONS; k++)
    for (int p = 0; p < AZIMUTHS; p++) {
      const direction *d = &b->directions[row * DIRECTIONS + k];
      const float angle = angle_to_sun(d->wz, sun, b->cos_azimuth[p]);
      const float wx = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f)) * b->cos_azimuth[p];
      const first_order first = gather_first_order(b, depth_rows[k], d, sun, angle);
      np_bands light = first.rayleigh * np_phase_rayleigh_eval(angle);
      if (d->ray.hits_ground) light += ground_radiance(b, d, sun, angle);
      add_to_moments(moments, d->weight * (light + cut_aerosol_light(medium, &first, angle)), wx, d->wz);
      for (int i = 0; i < medium->aerosol_count; i++)
        light += inverse_sum[i] * np_phase_eval(&medium->aerosol[i].phase, 1.0f - angle) * first.aerosol[i];
      b->half[node_at(row, column) * HALVES + (k >= UP)] += d->weight * light;
    }
}

static neph_result gather_direct_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  builder *b = user;
  for (size_t row = begin; row < end; row++) {
    np_depth_row depth_rows[DIRECTIONS][POINTS];
    for (int k = 0; k < DIRECTIONS; k++) {
      const np_path *path = &b->directions[row * DIRECTIONS + (size_t)k].path;
      for (int i = 0; i < path->count; i++)
        depth_rows[k][i] = np_depth_table_row(b->depths, (double)path->node[i].altitude_m);
    }
    for (int column = 0; column < COLUMNS; column++)
      gather_direct(b, (int)row, column, (const np_depth_row(*)[POINTS])depth_rows);
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
  const np_bands *low = b->table->moments + (size_t)row * NP_MOMENT_COLUMNS * NP_MOMENT_COUNT;
  const np_bands *high = low + NP_MOMENT_COLUMNS * NP_MOMENT_COUNT;
  for (int i = 0; i < NP_MOMENT_COLUMNS; i++, low += NP_MOMENT_COUNT, high += NP_MOMENT_COUNT) {
    np_bands m[NP_MOMENT_COUNT];
    for (int k = 0; k < NP_MOMENT_COUNT; k++) m[k] = np_bands_mix(low[k], high[k], upper);
    const np_bands kyy = m[NP_MOMENT_M] - m[NP_MOMENT_KXX] - m[NP_MOMENT_KZZ];
    out[i].constant =
        a * m[NP_MOMENT_M] + z * (f * m[NP_MOMENT_FZ]) + c * ((1.0f - z * z) * kyy + z * z * m[NP_MOMENT_KZZ]);
    out[i].linear = f * m[NP_MOMENT_FX] + (2.0f * z) * (c * m[NP_MOMENT_KXZ]);
    out[i].square = c * (m[NP_MOMENT_KXX] - kyy);
  }
}

/* Adds one point's source to the radiance of every sun and azimuth. */
static void add_source(const builder *b, const direction *d, const np_path_node *node, const folded_source *source,
                       np_bands (*radiance)[AZIMUTHS]) {
  for (int column = 0; column < COLUMNS; column++)
    for (int p = 0; p < AZIMUTHS; p++) {
      const float angle = angle_to_sun(d->wz, b->sun_cosine[column], b->cos_azimuth[p]);
      const float sun = sun_cosine_along(&d->ray, b->sun_cosine[column], angle, node->t, node->r);
      const float wx = np_direction_x(angle, node->cosine, sun);
      float f;
      const folded_source *s = source + np_sun_scale_split(np_sun_scale_column(&b->table->sun, sun), &f);
      radiance[column][p] +=
          np_bands_mix(s[0].constant, s[1].constant, f) +
          wx * (np_bands_mix(s[0].linear, s[1].linear, f) + wx * np_bands_mix(s[0].square, s[1].square, f));
    }
}

/* Reduces the radiance along one direction to every sun's moments, halves and irradiance. */
static void reduce_direction(builder *b, int row, int k, np_bands (*radiance)[AZIMUTHS]) {
  const direction *d = &b->directions[row * DIRECTIONS + k];
  for (int column = 0; column < COLUMNS; column++)
    for (int p = 0; p < AZIMUTHS; p++) {
      const float angle = angle_to_sun(d->wz, b->sun_cosine[column], b->cos_azimuth[p]);
      np_bands light = radiance[column][p];
      if (d->ray.hits_ground) light += ground_radiance(b, d, b->sun_cosine[column], angle);
      light = d->weight * np_bands_max(light, np_bands_grey(0.0f));
      const float wx = sqrtf(np_maxf(1.0f - d->wz * d->wz, 0.0f)) * b->cos_azimuth[p];
      add_to_moments(b->gathered + node_at(row, column) * NP_MOMENT_COUNT, light, wx, d->wz);
      b->half[node_at(row, column) * HALVES + (k >= UP)] += light;
      if (row == 0 && k < UP) b->irradiance[column] += d->wz * light;
    }
}

static neph_result gather_scattered_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  builder *b = user;
  for (size_t row = begin; row < end; row++)
    for (int k = 0; k < DIRECTIONS; k++) {
      const direction *d = &b->directions[row * DIRECTIONS + (size_t)k];
      np_bands radiance[COLUMNS][AZIMUTHS] = {{{0}}};
      folded_source source[NP_MOMENT_COLUMNS];
      for (int i = 0; i < d->path.count; i++) {
        fold_source(b, &d->path.node[i], source);
        add_source(b, d, &d->path.node[i], source, radiance);
      }
      reduce_direction(b, (int)row, k, radiance);
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
      direction d = {.wz = wz, .ray = np_ray_on_side(b->medium, 0.0, wz, false)};
      np_path_build(b->medium, &d.ray, rule, &d.path);
      np_depth_row depth_rows[NP_PATH_MAX];
      for (int n = 0; n < d.path.count; n++)
        depth_rows[n] = np_depth_table_row(b->depths, (double)d.path.node[n].altitude_m);
      const first_order first = gather_first_order(b, depth_rows, &d, sun_cosine, c);
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

/* Catmull-Rom over `count` nodes at a place in index space; beyond the ends the nodes go on along their last step. */
typedef struct spline {
  int index[4];
  float weight[4];
} spline;

static spline make_spline(double place, int count) {
  const int i = (int)fmin(floor(place), count - 2);
  const float t = (float)(place - i), u = 1.0f - t;
  spline s = {{i - 1, i, i + 1, i + 2},
              {-0.5f * t * u * u, u * u * (1.0f + 2.0f * t) + 0.5f * t * t * u, 0.0f, -0.5f * t * t * u}};
  s.weight[2] = 1.0f - s.weight[0] - s.weight[1] - s.weight[3];
  if (i == 0) {
    s.weight[1] += 2.0f * s.weight[0];
    s.weight[2] -= s.weight[0];
    s.weight[0] = 0.0f;
    s.index[0] = 0;
  }
  if (i == count - 2) {
    s.weight[2] += 2.0f * s.weight[3];
    s.weight[1] -= s.weight[3];
    s.weight[3] = 0.0f;
    s.index[3] = count - 1;
  }
  return s;
}

/* Refines one quantity: `nodes` (ROWS × COLUMNS) onto `fine` (NP_MOMENT_ROWS × NP_MOMENT_COLUMNS). */
static void refine(const np_bands *nodes, np_bands *fine) {
  np_bands wide[ROWS][NP_MOMENT_COLUMNS];
  for (int i = 0; i < NP_MOMENT_COLUMNS; i++) {
    const spline s = make_spline((double)i * (COLUMNS - 1) / (NP_MOMENT_COLUMNS - 1), COLUMNS);
    for (int row = 0; row < ROWS; row++) {
      const np_bands *n = nodes + node_at(row, 0);
      wide[row][i] = s.weight[0] * n[s.index[0]] + s.weight[1] * n[s.index[1]] + s.weight[2] * n[s.index[2]] +
                     s.weight[3] * n[s.index[3]];
    }
  }
  for (int row = 0; row < NP_MOMENT_ROWS; row++) {
    const spline s = make_spline((double)row * (ROWS - 1) / (NP_MOMENT_ROWS - 1), ROWS);
    for (int i = 0; i < NP_MOMENT_COLUMNS; i++)
      fine[row * NP_MOMENT_COLUMNS + i] = s.weight[0] * wide[s.index[0]][i] + s.weight[1] * wide[s.index[1]][i] +
                                          s.weight[2] * wide[s.index[2]][i] + s.weight[3] * wide[s.index[3]][i];
  }
}

static np_bands log_of(np_bands value) { return np_bands_log(np_bands_max(value, np_bands_grey(least))); }

/* Refines the k-th of `stride` quantities at the nodes: as a logarithm, or as its ratio to `fine_base`. */
static void refine_quantity(const np_bands *nodes, int stride, int k, const np_bands *base, np_bands *fine) {
  np_bands plane[ROWS * COLUMNS];
  for (size_t i = 0; i < ROWS * COLUMNS; i++) {
    const np_bands value = nodes[i * (size_t)stride + (size_t)k];
    plane[i] = base ? value / np_bands_max(base[i * (size_t)stride], np_bands_grey(least)) : log_of(value);
  }
  refine(plane, fine);
}

/* The last quarter of the columns' range of night, in which the light is faded to none. */
static float fade_at(const np_sun_scale *sun, int column) {
  const float cosine = sun_cosine_of_column(sun, (double)column / (NP_MOMENT_COLUMNS - 1));
  return np_smoothstepf((cosine - sun->lowest) / (-0.2f * sun->lowest));
}

/* Fills the table from moments at the nodes. `is_final` fades its dark end. */
static void refine_moments(const builder *b, const np_bands *nodes, np_bands *plane, bool is_final) {
  np_bands *out = b->table->moments;
  for (int k = 0; k < NP_MOMENT_COUNT; k++) {
    refine_quantity(nodes, NP_MOMENT_COUNT, k, k == NP_MOMENT_M ? NULL : nodes, plane);
    for (size_t i = 0; i < NP_MOMENT_ROWS * NP_MOMENT_COLUMNS; i++) {
      np_bands *m = out + i * NP_MOMENT_COUNT;
      m[k] = k == NP_MOMENT_M ? np_bands_exp(plane[i]) : plane[i] * m[NP_MOMENT_M];
    }
  }
  for (size_t i = 0; is_final && i < NP_MOMENT_ROWS * NP_MOMENT_COLUMNS; i++)
    for (int k = 0; k < NP_MOMENT_COUNT; k++)
      out[i * NP_MOMENT_COUNT + (size_t)k] *= fade_at(&b->table->sun, (int)(i % NP_MOMENT_COLUMNS));
}

static void refine_halves(const builder *b, np_bands *plane) {
  for (int k = 0; k < HALVES; k++) {
    refine_quantity(b->half_total, HALVES, k, NULL, plane);
    for (size_t i = 0; i < NP_MOMENT_ROWS * NP_MOMENT_COLUMNS; i++)
      b->table->hemisphere[i * HALVES + (size_t)k] =
          np_bands_exp(plane[i]) * fade_at(&b->table->sun, (int)(i % NP_MOMENT_COLUMNS));
  }
}

static void refine_irradiance(const builder *b, const np_bands *nodes, bool is_final) {
  for (int i = 0; i < NP_MOMENT_COLUMNS; i++) {
    const spline s = make_spline((double)i * (COLUMNS - 1) / (NP_MOMENT_COLUMNS - 1), COLUMNS);
    np_bands sum = np_bands_grey(0.0f);
    for (int k = 0; k < 4; k++) sum += s.weight[k] * log_of(nodes[s.index[k]]);
    b->table->irradiance[i] = np_bands_exp(sum) * (is_final ? fade_at(&b->table->sun, i) : 1.0f);
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
  for (size_t i = 0; i < ROWS * COLUMNS; i++) {
    const np_bands m = b->gathered[i * NP_MOMENT_COUNT];
    const np_bands factor = is_last ? sum_series(m, b->last[i]) : np_bands_grey(1.0f);
    for (size_t k = 0; k < NP_MOMENT_COUNT; k++)
      b->total[i * NP_MOMENT_COUNT + k] += factor * b->gathered[i * NP_MOMENT_COUNT + k];
    for (size_t k = 0; k < HALVES; k++) b->half_total[i * HALVES + k] += factor * b->half[i * HALVES + k];
    b->last[i] = m;
  }
  for (int i = 0; i < COLUMNS; i++) {
    const np_bands e = b->irradiance[i];
    b->irradiance_total[i] += e * (is_last ? sum_series(e, b->irradiance_last[i]) : np_bands_grey(1.0f));
    b->irradiance_last[i] = e;
  }
}

static neph_result gather_order(neph_context *context, builder *b) {
  memset(b->gathered, 0, ROWS * COLUMNS * NP_MOMENT_COUNT * sizeof(np_bands));
  memset(b->half, 0, ROWS * COLUMNS * HALVES * sizeof(np_bands));
  memset(b->irradiance, 0, sizeof b->irradiance);
  neph_result result;
  if (b->order == 1) {
    result = np_parallel_for(context, NULL, ROWS, 1, gather_direct_rows, b);
    if (!result) result = np_parallel_for(context, NULL, COLUMNS, 1, gather_direct_irradiance, b);
  } else {
    result = np_parallel_for(context, NULL, ROWS, 1, gather_scattered_rows, b);
  }
  return result;
}

static neph_result sum_orders(neph_context *context, builder *b, np_bands *plane) {
  for (b->order = 1; b->order <= b->order_max; b->order++) {
    neph_result result = gather_order(context, b);
    if (result) return result;
    add_order(b);
    refine_moments(b, b->gathered, plane, false);
    refine_irradiance(b, b->irradiance, false);
  }
  refine_moments(b, b->total, plane, true);
  refine_halves(b, plane);
  refine_irradiance(b, b->irradiance_total, true);
  return NEPH_OK;
}

static void place_nodes(builder *b) {
  for (int row = 0; row < ROWS; row++) {
    const double y = (double)row / (ROWS - 1);
    b->altitude[row] = b->medium->top_m * y * y;
    place_directions(b, row);
  }
  for (int i = 0; i < COLUMNS; i++) b->sun_cosine[i] = sun_cosine_of_column(&b->table->sun, (double)i / (COLUMNS - 1));
  for (int p = 0; p < AZIMUTHS; p++) b->cos_azimuth[p] = (float)cos(NP_PI * (p + 0.5) / AZIMUTHS);
}

static bool allocate_table(neph_context *context, np_moment_table *table) {
  const size_t count = NP_MOMENT_ROWS * NP_MOMENT_COLUMNS;
  table->moments = np_alloc(context, count * NP_MOMENT_COUNT, sizeof(np_bands));
  if (table->moments) table->hemisphere = np_alloc(context, count * HALVES, sizeof(np_bands));
  if (table->hemisphere) table->irradiance = np_alloc(context, NP_MOMENT_COLUMNS, sizeof(np_bands));
  return table->irradiance;
}

/* Everything the builder works in, as one block of packets. */
static np_bands *allocate_work(neph_context *context, builder *b) {
  const size_t nodes = ROWS * COLUMNS, each = 2 * NP_MOMENT_COUNT + 2 * HALVES + 1;
  np_bands *work = np_alloc(context, nodes * each + NP_MOMENT_ROWS * NP_MOMENT_COLUMNS, sizeof(np_bands));
  if (!work) return NULL;
  b->gathered = work;
  b->total = b->gathered + nodes * NP_MOMENT_COUNT;
  b->half = b->total + nodes * NP_MOMENT_COUNT;
  b->half_total = b->half + nodes * HALVES;
  b->last = b->half_total + nodes * HALVES;
  return work;
}

neph_result np_moment_table_build(neph_context *context, const np_depth_table *depths, unsigned order_max,
                                  bool has_point_sun, np_moment_table *out_table) {
  const np_medium *medium = depths->medium;
  *out_table = (np_moment_table){.medium = medium, .sun = make_sun_scale(medium)};
  if (!allocate_table(context, out_table)) return NEPH_ERROR_OUT_OF_MEMORY;
  builder *b = np_alloc(context, 1, sizeof *b);
  if (!b) return NEPH_ERROR_OUT_OF_MEMORY;
  b->medium = medium;
  b->depths = depths;
  b->table = out_table;
  b->disk = np_sun_disk_make(disk_angular_radius_rad, has_point_sun);
  b->is_series = order_max == NP_ORDERS_ALL;
  b->order_max = b->is_series ? SERIES_ORDER : order_max;
  neph_result result = NEPH_ERROR_OUT_OF_MEMORY;
  np_bands *work = allocate_work(context, b);
  if (work) b->directions = np_alloc(context, ROWS * DIRECTIONS, sizeof *b->directions);
  if (b->directions) {
    place_nodes(b);
    result = sum_orders(context, b, b->last + ROWS * COLUMNS);
  }
  np_alloc_free(context, b->directions);
  np_alloc_free(context, work);
  np_alloc_free(context, b);
  return result;
}

void np_moment_table_free(neph_context *context, np_moment_table *table) {
  np_alloc_free(context, table->moments);
  np_alloc_free(context, table->hemisphere);
  np_alloc_free(context, table->irradiance);
  *table = (np_moment_table){0};
}

np_bands np_moment_table_irradiance(const np_moment_table *table, float sun_cosine) {
  float f;
  const int i = np_sun_scale_split(np_sun_scale_column(&table->sun, sun_cosine), &f);
  return np_bands_mix(table->irradiance[i], table->irradiance[i + 1], f);
}
