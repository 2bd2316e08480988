/* SPDX-License-Identifier: Apache-2.0 */
/* The velocity that advects a cloud's extinction from one time to the next, for motion blur and retiming.
 *
 * Result: u with ∂σ/∂t + u·∇σ = 0, approximately, one vector for each voxel. Method: the wind W advects everything; the
 * remaining change in its moving frame is D = dσ/dt along W. The rest of u follows from D and the gradient over the
 * voxel and its 26 neighbours, by least squares: (Σ∇σ∇σᵀ + λI)·u' = −Σ D∇σ, the optical flow of Lucas and Kanade 1981,
 * "An Iterative Image Registration Technique", eq. 9, with Tikhonov's λ where the gradient does not determine it. Both
 * are central differences of the model itself, half a voxel and a short time apart. */
#include "cloud/bake_velocity.h"

#include <math.h>
#include <string.h>

#include "cloud/bake_field.h"
#include "cloud/cloud_build.h"
#include "cloud/cloud_density.h"
#include "cloud/cloud_grain.h"
#include "core/alloc.h"

enum {
  BLOCK_EDGE = NP_LEAF_EDGE + 2, /* a leaf with its neighbours */
  BLOCK_SIZE = BLOCK_EDGE * BLOCK_EDGE * BLOCK_EDGE,
  FLOW_SUMS = 9 /* six of the matrix, three of the right-hand side */
};

typedef struct velocity_job {
  const np_bake *bake;
  np_cloud_model before, after;
  double span_s; /* half of the time between the two positions */
  double speed_max_m_s;
  double slack; /* λ, the damping of the normal equations */
  const np_sparse_grid *density;
  np_sparse_grid *velocity; /* x, y, z */
} velocity_job;

/* ---- Evaluation of the model ---- */

/* Extinction at the block of points around a leaf, displaced. */
static void eval_block(const velocity_job *job, const np_cloud_model *model, const int32_t origin[3],
                       const double shift_m[3], float *out) {
  np_bake_points points = {.count = 0};
  size_t done = 0;
  for (int32_t n = 0; n < BLOCK_SIZE; n++) {
    const int32_t at[3] = {n / (BLOCK_EDGE * BLOCK_EDGE), n / BLOCK_EDGE % BLOCK_EDGE, n % BLOCK_EDGE};
    double offset_m[3];
    for (int a = 0; a < 3; a++)
      offset_m[a] = np_bake_compute_offset_m(job->bake, a, origin[a] + at[a] - 1) + shift_m[a];
    np_bake_add_point(job->bake, offset_m, &points);
    if (points.count < NP_CLOUD_BLOCK && n + 1 < BLOCK_SIZE) continue;
    np_bake_eval(model, &points, out + done);
    done += points.count;
    points.count = 0;
  }
}

/* Central differences in time along the wind, and in space. */
static void compute_differences(const velocity_job *job, const int32_t origin[3], float (*out)[BLOCK_SIZE]) {
  const double *wind_m_s = job->bake->model.desc.wind_m_s, half_m = 0.5 * np_bake_get_finest_m(job->bake);
  float low[BLOCK_SIZE];
  for (int c = 0; c < 4; c++) {
    double shift_m[3] = {0, 0, 0};
    if (c < 3)
      shift_m[c] = half_m;
    else
      for (int a = 0; a < 2; a++) shift_m[a] = wind_m_s[a] * job->span_s;
    eval_block(job, c < 3 ? &job->bake->model : &job->after, origin, shift_m, out[c]);
    for (int a = 0; a < 3; a++) shift_m[a] = -shift_m[a];
    eval_block(job, c < 3 ? &job->bake->model : &job->before, origin, shift_m, low);
    const float per = (float)(0.5 / (c < 3 ? half_m : job->span_s));
    for (int n = 0; n < BLOCK_SIZE; n++) out[c][n] = per * (out[c][n] - low[n]);
  }
}

/* ---- Least squares ---- */

static int compute_index_in_block(int n) {
  return ((n / 64 + 1) * BLOCK_EDGE + n / 8 % 8 + 1) * BLOCK_EDGE + n % 8 + 1;
}

/* Sums over a voxel of a leaf and its 26 neighbours. */
static void sum_window(float (*differences)[BLOCK_SIZE], int n, double out[FLOW_SUMS]) {
  const int center = compute_index_in_block(n);
  memset(out, 0, FLOW_SUMS * sizeof *out);
  for (int i = -1; i <= 1; i++)
    for (int j = -1; j <= 1; j++)
      for (int k = -1; k <= 1; k++) {
        const int m = center + (i * BLOCK_EDGE + j) * BLOCK_EDGE + k;
        const double x = differences[0][m], y = differences[1][m], z = differences[2][m], t = differences[3][m];
        const double terms[FLOW_SUMS] = {x * x, y * y, z * z, x * y, x * z, y * z, -x * t, -y * t, -z * t};
        for (int s = 0; s < FLOW_SUMS; s++) out[s] += terms[s];
      }
}

/* Solves the symmetric system by Cramer's rule; λ on its diagonal keeps the determinant above λ³. */
static void solve_flow(const velocity_job *job, const double s[FLOW_SUMS], double out_m_s[3]) {
  const double xx = s[0] + job->slack, yy = s[1] + job->slack, zz = s[2] + job->slack, xy = s[3], xz = s[4], yz = s[5];
  const double cx = yy * zz - yz * yz, cy = xz * yz - xy * zz, cz = xy * yz - xz * yy;
  const double determinant = xx * cx + xy * cy + xz * cz;
  const double inverse[3][3] = {
      {cx, cy, cz}, {cy, xx * zz - xz * xz, xy * xz - xx * yz}, {cz, xy * xz - xx * yz, xx * yy - xy * xy}};
  double speed2 = 0;
  for (int a = 0; a < 3; a++) {
    out_m_s[a] = (inverse[a][0] * s[6] + inverse[a][1] * s[7] + inverse[a][2] * s[8]) / determinant;
    speed2 += out_m_s[a] * out_m_s[a];
  }
  const double limit = job->speed_max_m_s;
  for (int a = 0; a < 3 && speed2 > limit * limit; a++) out_m_s[a] *= limit / sqrt(speed2);
}

static void make_leaf(const velocity_job *job, size_t leaf) {
  const np_leaf *density = &job->density->leaves[leaf];
  float differences[4][BLOCK_SIZE];
  compute_differences(job, density->origin, differences);
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    double sums[FLOW_SUMS], flow_m_s[3] = {0, 0, 0};
    const bool is_active = density->active[n / 64] >> (n % 64) & 1u;
    if (is_active) {
      sum_window(differences, n, sums);
      solve_flow(job, sums, flow_m_s);
    }
    for (int a = 0; a < 3; a++)
      job->velocity[a].leaves[leaf].values[n] = job->velocity[a].background + (float)flow_m_s[a];
  }
}

static neph_result make_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const velocity_job *job = user;
  (void)thread;
  for (size_t leaf = begin; leaf < end; leaf++) make_leaf(job, leaf);
  return NEPH_OK;
}

/* ---- The grids ---- */

/* Makes grids with the same leaves, without values; their background is the wind. */
static neph_result make_grids(const np_bake *bake, const np_sparse_grid *density, np_sparse_grid velocity[3]) {
  neph_result result = NEPH_OK;
  for (int a = 0; a < 3 && !result; a++) {
    result = np_sparse_grid_init(bake->context, "vel", &velocity[a]);
    if (result) break;
    velocity[a].index_to_world = density->index_to_world;
    velocity[a].background = a < 2 ? (float)bake->model.desc.wind_m_s[a] : 0.0f;
    result = np_sparse_grid_reserve(&velocity[a], density->leaf_count, 0);
    for (size_t i = 0; i < density->leaf_count && !result; i++) {
      np_leaf *leaf = np_sparse_grid_add_leaf(&velocity[a], density->leaves[i].origin);
      if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
      memcpy(leaf->active, density->leaves[i].active, sizeof leaf->active);
    }
  }
  return result;
}

static neph_result build_moment(const velocity_job *job, double time_s, np_cloud_model *out_model) {
  neph_cloud_desc cloud = np_cloud_model_get_desc(&job->bake->model);
  cloud.time_s = time_s;
  const np_bake *bake = job->bake;
  return np_cloud_model_build(bake->context, &cloud, bake->desc.planet_radius_m, bake->monitor, out_model);
}

neph_result np_bake_make_velocity(const np_bake *bake, const np_sparse_grid *density, np_sparse_grid out_velocity[3]) {
  const neph_cloud_desc own = np_cloud_model_get_desc(&bake->model), *cloud = &own;
  velocity_job job = {.bake = bake, .density = density, .velocity = out_velocity};
  /* In this time the fastest matter, a billow in a third of its life, rises by half a voxel or more; an apparent motion
   * of two voxels is growth and decay instead. */
  job.span_s = cloud->voxel_m * cloud->lifetime_s / (8 * cloud->billow_m);
  job.speed_max_m_s = 2 * cloud->voxel_m / job.span_s;
  const double gradient_per_m2 = 1e-2 * cloud->extinction_per_m / cloud->voxel_m;
  job.slack = 27 * gradient_per_m2 * gradient_per_m2;
  np_monitor_set_stage(bake->monitor, "finding velocities");
  neph_result result = make_grids(bake, density, out_velocity);
  if (!result) result = build_moment(&job, cloud->time_s - job.span_s, &job.before);
  if (!result) result = build_moment(&job, cloud->time_s + job.span_s, &job.after);
  if (!result) result = np_parallel_for(bake->context, bake->monitor, density->leaf_count, 4, make_leaves, &job);
  np_cloud_model_clear(&job.before);
  np_cloud_model_clear(&job.after);
  for (int a = 0; a < 3 && result; a++) np_sparse_grid_clear(&out_velocity[a]);
  return result;
}
