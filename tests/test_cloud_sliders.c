/* SPDX-License-Identifier: Apache-2.0 */
/* Each parameter of thermals from 0 to 1: a named statistic that never turns, and a picture that changes. */
#include "test_clouds.h"

/* Share of the light of a uniform sky that passes straight through, seen along x and along z. */
enum { SIDE = 110, STEPS = 5 };

typedef struct slider_view {
  double transmittance[2][SIDE][SIDE];
  double covered, top, volume, rugged, thin, depth, depth_below, creased;
} slider_view;

typedef struct slider {
  const char *name;
  size_t offset;
  size_t statistic; /* statistic of a slider_view */
  int sign;         /* 1: it rises */
  bool is_of_shape; /* else of a field, whose base is wider */
} slider;

#define SLIDER(field, statistic, sign)                                                                                 \
  { #field, offsetof(neph_cloud_desc, field), offsetof(slider_view, statistic), sign, false }
#define PART(field, part, statistic, is_of_shape)                                                                      \
  {                                                                                                                    \
#field "[" #part "]", offsetof(neph_cloud_desc, field) + part * sizeof(double), offsetof(slider_view, statistic),  \
        1, is_of_shape                                                                                                 \
  }

static const slider sliders[] = {
    SLIDER(coverage, covered, 1),
    SLIDER(type, top, -1),
    SLIDER(billowiness, volume, 1),
    {"erosion", offsetof(neph_cloud_desc, erosion), offsetof(slider_view, creased), 1, true},
    SLIDER(wispiness, rugged, 1),
    SLIDER(turbulence, rugged, 1),
    SLIDER(softness, thin, 1),
    SLIDER(age, depth, -1),
    SLIDER(precipitation, depth_below, 1),
    PART(billow_amounts, 0, volume, true),
    PART(billow_amounts, 1, volume, true),
    PART(billow_amounts, 2, volume, true),
    PART(wisp_amounts, 0, rugged, true),
    PART(wisp_amounts, 1, rugged, true),
    PART(wisp_amounts, 2, rugged, false),
};

static neph_cloud_desc make_desc(void) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.model = NEPH_CLOUD_MODEL_THERMALS;
  desc.seed = 3;
  desc.extent_m[0] = desc.extent_m[1] = 4340;
  desc.thickness_m = 1500;
  desc.voxel_m = 40;
  desc.cell_m = 2400;
  desc.billow_m = 760;
  desc.coverage = 0.25;
  desc.erosion = 0.4;
  return desc;
}

/* A given shape, whose volume no coverage makes up for. */
static void set_shape(neph_cloud_desc *desc) {
  static const neph_cloud_point spheres[] = {
      {-600, 0, 300, 500}, {100, 200, 600, 560}, {700, -200, 350, 450}, {0, -300, 250, 400}};
  desc->shape.spheres = (neph_cloud_points){spheres, sizeof spheres / sizeof *spheres, NULL, 0};
  desc->wispiness = desc->billowiness = 1;
  desc->age = 0;
}

typedef struct field_sums {
  double tops, columns, change, sum, thin, active;
  int32_t top[SIDE][SIDE];
} field_sums;

static void add_leaf(const np_leaf *leaf, const neph_cloud_desc *desc, slider_view *view, field_sums *f) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const double value = (double)leaf->values[n], core = desc->extinction_per_m;
    const int x = leaf->origin[0] + n / 64, y = leaf->origin[1] + n / 8 % 8, z = leaf->origin[2] + n % 8;
    if (!(value > 0) || x >= SIDE || y >= SIDE) continue;
    view->transmittance[0][y][(z + SIDE) % SIDE] += value * desc->voxel_m;
    view->transmittance[1][x][y] += value * desc->voxel_m;
    if (z < 0) view->depth_below += value;
    if (z < 0) continue;
    if (z > f->top[x][y]) f->top[x][y] = z;
    if (n % 64 / 8 < 7) f->change += fabs(value - (double)leaf->values[n + 8]);
    f->sum += value;
    f->active++;
    f->thin += value < 0.2 * core;
  }
}

/* Mean bend of the surface of tops over four voxels: of billows and the creases between them. */
static double compute_bend(const field_sums *f) {
  enum { REACH = 2 };
  double sum = 0, count = 0;
  for (int i = REACH; i < SIDE - REACH; i++)
    for (int j = REACH; j < SIDE - REACH; j++) {
      const int32_t low = f->top[i - REACH][j], high = f->top[i + REACH][j], here = f->top[i][j];
      if (!(low > 0 && high > 0 && here > 0)) continue;
      sum += abs(low + high - 2 * here);
      count++;
    }
  return sum / fmax(count, 1);
}

static void compute_view(neph_context *context, const neph_cloud_desc *desc, slider_view *view) {
  np_sparse_grid grid = test_bake(context, desc);
  field_sums *f = calloc(1, sizeof *f);
  *view = (slider_view){.covered = 0};
  for (size_t i = 0; i < grid.leaf_count; i++) add_leaf(&grid.leaves[i], desc, view, f);
  for (int i = 0; i < SIDE; i++)
    for (int j = 0; j < SIDE; j++) {
      if (f->top[i][j] > 0) f->columns++, f->tops += f->top[i][j];
      for (int v = 0; v < 2; v++) view->transmittance[v][i][j] = exp(-view->transmittance[v][i][j]);
    }
  view->top = f->tops / fmax(f->columns, 1);
  view->volume = f->active;
  view->covered = f->columns;
  view->rugged = f->change / fmax(f->sum, 1e-9);
  view->thin = f->thin / fmax(f->active, 1);
  view->creased = compute_bend(f);
  view->depth = f->sum / fmax(f->active, 1);
  free(f);
  np_sparse_grid_clear(&grid);
}

/* Root mean square of the difference over that of the first picture's opacity. */
static double compare(const slider_view *one, const slider_view *other) {
  double difference2 = 0, opacity2 = 0;
  for (int v = 0; v < 2; v++)
    for (int i = 0; i < SIDE; i++)
      for (int j = 0; j < SIDE; j++) {
        const double d = one->transmittance[v][i][j] - other->transmittance[v][i][j];
        const double o = 1 - fmin(one->transmittance[v][i][j], other->transmittance[v][i][j]);
        difference2 += d * d;
        opacity2 += o * o;
      }
  return sqrt(difference2 / opacity2);
}

static void each_slider_changes_the_picture_steadily(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  slider_view *views = calloc(STEPS, sizeof *views);
  for (size_t s = 0; s < sizeof sliders / sizeof *sliders; s++) {
    double statistic[STEPS];
    for (int step = 0; step < STEPS; step++) {
      neph_cloud_desc desc = make_desc();
      if (sliders[s].offset == offsetof(neph_cloud_desc, coverage)) desc.billow_m = 300;
      if (sliders[s].is_of_shape) set_shape(&desc);
      if (!strcmp(sliders[s].name, "erosion")) desc.billowiness = desc.wispiness = 0; /* both bend it, too */
      if (!strncmp(sliders[s].name, "wisp_amounts", strlen("wisp_amounts"))) desc.wispiness = 1;
      *(double *)(void *)((char *)&desc + sliders[s].offset) = step / (double)(STEPS - 1);
      compute_view(context, &desc, &views[step]);
      statistic[step] = *(const double *)(const void *)((const char *)&views[step] + sliders[s].statistic);
    }
    const double change = compare(&views[0], &views[STEPS - 1]);
    print_message("%-14s %5.1f %%: %.4g %.4g %.4g %.4g %.4g\n", sliders[s].name, 100 * change, statistic[0],
                  statistic[1], statistic[2], statistic[3], statistic[4]);
    for (int step = 1; step < STEPS; step++)
      if (!(sliders[s].sign * (statistic[step] - statistic[step - 1]) > 0))
        fail_msg("%s: its statistic turns at %d", sliders[s].name, step);
    if (!(change >= 0.1)) fail_msg("%s changes the picture by %.3g only", sliders[s].name, change);
  }
  free(views);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(each_slider_changes_the_picture_steadily)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
