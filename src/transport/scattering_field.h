/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering in clouds, solved once for all views of a scene under its lights.
 *
 * A field answers three questions: how much of its extinction a cloud keeps in the scaled medium in which the rest is
 * light (np_scaled_cloud), the radiance that a cloud scatters out at a point in a direction, and how much light paths
 * can expect at a point. Cells, moments and phase tables are transport's own (scattering_field_private.h). Look-ups
 * are compiled once per instruction-set level and chosen when a field is built.
 */
#ifndef NP_TRANSPORT_SCATTERING_FIELD_H
#define NP_TRANSPORT_SCATTERING_FIELD_H

#include "core/disk_cache.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "transport/ordinates.h"
#include "transport/peak_column.h"
#include "transport/transport_fold.h"
#include "world/world.h"

typedef struct np_scattering_field np_scattering_field;

/* ---- Building ---- */

typedef struct np_transport_desc {
  np_dvec3 bounds_min, bounds_max; /* box of the clouds, in the world */
  size_t cell_count_max;           /* limit on cells: cells far from the viewer are enlarged to keep it */
  size_t cell_count_cheap;         /* number of cells up to which they are refined to one voxel */
  size_t cell_count_fine; /* number of cells up to which light is resolved on cells half as wide as those of the
                             iteration */
  double cell_depth_max;  /* depth of a cell, (1−g)·σ·edge, where the memory allows */
  double edge_min_m;      /* no cells are smaller, whatever their depth; 0: no limit */
  double thickness_m;     /* typical thickness of the clouds; 0: it is measured */
  np_transport_fold fold; /* tiles of which one is solved for; a period of 0: all clouds are */
  bool has_detail;        /* a cloud has detail finer than its voxels */
  bool has_open_sides;    /* no light comes in where the stretch of clouds that repeat beside others ends */
  bool has_viewer;
  np_dvec3 viewer;       /* the nearest corner of the box that viewers are in, … */
  np_dvec3 viewer_reach; /* … and its size; 0: one viewer */
} np_transport_desc;

/* Storage for the states of an unfinished solution, which can be resumed with the same bits. */
typedef struct np_solution_keeper {
  double interval_s; /* time from one state to the next; infinite: it is kept only when the solution is cancelled */
  void *user;
  bool (*read_begin)(void *user, np_cache_entry *out_entry); /* false: there is none */
  bool (*write_begin)(void *user, np_cache_entry *out_entry);
} np_solution_keeper;

/* Cells of an earlier solution of the same clouds: what they average of these, and their first collisions. */
typedef struct np_reused_cells np_reused_cells;

typedef struct np_scattering_desc {
  np_transport_desc cells;
  double work_max; /* cells × directions × harmonics of a sweep, up to which angles are resolved beyond the least */
  unsigned degree_max; /* most that angles are resolved into */
  double tolerance;
  double seconds_max;  /* after which sweeps end, whatever the residual; infinite: no limit */
  uint64_t left_out;   /* clouds of the scene that are not solved for, a bit for each number; all: the field is dark */
  bool has_importance; /* paths can be guided: importance is kept beside the moments */
  const np_solution_keeper *keeper; /* NULL: states are not stored, as with a time limit */
  np_reused_cells *reused;          /* cells of an earlier solution on the same cells, which it uses up; NULL: none */
} np_scattering_desc;

/* Tolerance of a solution, in drafts, from which light around the clouds is computed by fewer rays. */
#define NP_SCATTERING_ROUGH 0.01

/* (1−g)·σ·edge of 0.35; a million and a half cells, of some 1.5 kB each in cloud while it is solved. */
#define NP_SCATTERING_DESC_DEFAULT                                                                                     \
  {                                                                                                                    \
    .cells = {.cell_count_max = 1500000, .cell_count_cheap = 60000, .cell_depth_max = 0.35}, .work_max = 3e7,          \
    .degree_max = NP_DEGREE_MAX, .tolerance = 3e-4, .seconds_max = HUGE_VAL                                            \
  }

/* Sets the limit on cells by a limit on memory. */
void np_scattering_desc_set_memory(np_scattering_desc *desc, double bytes);

/* Sets the limit on fine cells in proportion to the picture's rays, within `cells.cell_count_max`. */
void np_scattering_desc_set_rays(np_scattering_desc *desc, double rays);

/* Cells of a solution, their memory, and the work of their sweeps. */
typedef struct np_cell_counts {
  double cells;      /* cells that hold cloud or touch one that does */
  double places;     /* cells of their box, empty ones included; 0: not known */
  double bytes;      /* memory of these and of coarser cells while they are solved for */
  double sweep_work; /* directions times moments times cells of one sweep of the cells that are iterated */
  double last_work;  /* work of the sweeps that resolve and refine the solution of a band, in the same unit */
} np_cell_counts;

typedef struct np_scattering_forecast {
  double errors[2];      /* errors of a picture, as shares of its light: from the smallest cells and from the largest */
  double cell_count;     /* in the box of the clouds, and around it */
  double volume_m3;      /* volume of all cells */
  np_cell_counts counts; /* counts of the cells with cloud; of all, where there is no finder */
} np_scattering_forecast;

/* Whether a world box holds cloud, in a forecast. */
typedef struct np_cloud_finder {
  bool (*has_cloud)(const void *user, np_dvec3 low, np_dvec3 high);
  const void *user;
} np_cloud_finder;

/* Forecasts the cells that a description chooses for these clouds. Of their bricks `value_max`, `size`, periods and
 * `brick_count` are read. */
neph_result np_scattering_desc_forecast(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                                        const np_cloud_finder *finder, np_scattering_forecast *out);

/* The same for a number of cells with cloud whose places are unknown. */
np_cell_counts np_scattering_desc_count(const np_scattering_desc *desc, double cells);

/* Adds to a hash all that the choice of cells and the accuracy of a solution depend on. */
neph_result np_scattering_desc_add_to_hash(neph_context *context, const np_world *world, const np_scattering_desc *desc,
                                           np_hash *hash);

/* Whether light of fires is solved for apart, so that it does not come back with clouds that repeat without end: none
 * of the clouds that burn repeats, and others do. */
bool np_scattering_has_fires_apart(const np_world *world);

/* Solves for the world's sun, sky and ground. NULL on failure. */
neph_result np_scattering_field_build(neph_context *context, const np_world *world,
                                      const np_sun_optical_depth_source *depths, const np_scattering_desc *desc,
                                      np_monitor *monitor, np_scattering_field **out_field);
void np_scattering_field_destroy(np_scattering_field *field);

/* Moves the cells out of a solution that is no longer needed, for one of equal clouds, ground and choice of cells.
 * `is_lit`: under the same direction of the sun. NULL: it has none to give. */
np_reused_cells *np_scattering_field_take_cells(np_scattering_field *field, bool is_lit);
void np_reused_cells_destroy(np_reused_cells *cells);

/* A field between two: (1 − share) of the first and `share` of the second, times `gain` in each band. */
typedef struct np_scattering_blend {
  const np_scattering_field *fields[2];
  double share, gain[NP_BAND_COUNT];
} np_scattering_blend;

/* Whether two fields have the same cells, so that they can be interpolated. */
bool np_scattering_field_can_blend(const np_scattering_field *a, const np_scattering_field *b);

/* Restores the interpolated field of a world, without importance; NULL on failure. */
neph_result np_scattering_field_blend(const np_scattering_blend *desc, const np_world *world, np_monitor *monitor,
                                      np_scattering_field **out_field);

/* Saves a field to the disk cache. */
void np_scattering_field_save(const np_scattering_field *field, np_cache_entry *entry);

/* One that was kept, for the world that it was solved for. NULL where the entry holds less than that. */
neph_result np_scattering_field_load(neph_context *context, const np_world *world, np_cache_entry *entry,
                                     np_scattering_field **out_field);

/* Borrows the phase tables of another world, of equal clouds. */
void np_scattering_field_set_world(np_scattering_field *field, const np_world *world);

typedef struct np_scattering_quality {
  double residual;    /* relative residual of the band with the largest */
  double error;       /* expected from the size of the largest cells, as a share of the light */
  bool is_cut;        /* the description's time ended before the last sweep */
  unsigned cut_width; /* edge of the finest cells that were swept till then, in edges of the finest that are iterated */
} np_scattering_quality;

np_scattering_quality np_scattering_field_get_quality(const np_scattering_field *field);
unsigned np_scattering_field_get_degree(const np_scattering_field *field);

/* ---- The scaled medium ---- */

/* One cloud of it. */
typedef struct np_scaled_cloud {
  float forward;            /* f: share of scattering that counts as unscattered */
  float least_forward;      /* forward share of the phase function at the lowest degree of the angular resolution */
  float asymmetry, second;  /* χ₁ = g and χ₂ of the phase function */
  unsigned char phase_kind; /* index of the phase function among the distinct ones */
} np_scaled_cloud;

/* The small part of a field that a ray reads at every step without a call. */
typedef struct np_scattering_medium {
  unsigned cloud_count, phase_count; /* clouds, and phase functions that differ */
  unsigned band_count; /* number of bands that are solved for: 1 where the other bands are multiples of the first by
                          `colour`, which else is 1 */
  np_spectrum colour;
  bool has_delta_m_residual; /* np_light_moments.delta_m_residual is set */
  np_scaled_cloud clouds[NP_INSTANCES_MAX];
} np_scattering_medium;

const np_scattering_medium *np_scattering_field_get_medium(const np_scattering_field *field);

/* Ratio of a cloud's scaled extinction to its extinction, in the band with the largest albedo. */
static inline float np_scaled_cloud_get_scale(const np_scaled_cloud *cloud, np_spectrum albedo) {
  return 1.0f - cloud->forward * np_spectrum_max(albedo);
}

/* The same where angles are resolved into the least degree, of any cloud. */
float np_scattering_compute_least_scale(const np_phase *phase, np_spectrum albedo);

/* The direct term of a cloud at an angle to the sun, for any depths. */
void np_scattering_field_fill_column(const np_scattering_field *field, unsigned cloud, float versine,
                                     np_peak_column *out);

/* ---- Radiance that clouds scatter out ---- */

/* Harmonics of a direction of flight, up to the field's degree. */
void np_scattering_field_fill_harmonics(const np_scattering_field *field, np_vec3 direction,
                                        float out[NP_HARMONIC_COUNT_MAX]);

/* Weights of the moments of the radiance in the light that a cloud scatters into a direction of these harmonics;
 * scattering that counts as going straight on is left out. */
void np_scattering_field_fill_outgoing(const np_scattering_field *field, unsigned cloud,
                                       const float harmonics[NP_HARMONIC_COUNT_MAX], float out[NP_HARMONIC_COUNT_MAX]);

/* Moments of the radiance at one point, [band][harmonic], of the bands that are solved for. */
typedef struct np_light_moments {
  float value[NP_BAND_COUNT * NP_HARMONIC_COUNT_MAX];
  /* Moments of sunlight in the forward peak, over its irradiance and harmonics. */
  float delta_m_residual[NP_BAND_COUNT];
} np_light_moments;

void np_scattering_field_gather(const np_scattering_field *field, np_dvec3 position, np_light_moments *out);

/* Radiance times phase function, over all directions, that a cloud of these weights scatters out. */
np_spectrum np_scattering_field_get_outgoing(const np_scattering_field *field, const np_light_moments *moments,
                                             const float outgoing[NP_HARMONIC_COUNT_MAX]);

/* ---- The same by cells, for light that is prepared for one viewer ---- */

/* Tiles of which the cells hold one; a period of 0: the cells hold all clouds. */
const np_transport_fold *np_scattering_field_get_fold(const np_scattering_field *field);

/* World box of its cells. */
void np_scattering_field_bound(const np_scattering_field *field, np_dvec3 *out_low, np_dvec3 *out_high);

/* Whether the cells around a place lie where it does, and not at its match in another tile or period. */
bool np_scattering_field_holds(const np_scattering_field *field, np_dvec3 position);

size_t np_scattering_field_count_cells(const np_scattering_field *field);
np_dvec3 np_scattering_field_get_cell(const np_scattering_field *field, size_t cell, double *out_width);

/* Light that a cell scatters into a direction for each phase function, [phase_kind][band]; interpolation may make it
 * negative. */
void np_scattering_field_fill_cell(const np_scattering_field *field, size_t cell, np_vec3 direction, float *out);

/* Cells around a point that they hold, and their shares in it. */
typedef struct np_scattering_cells {
  unsigned count;
  int32_t cell[8];
  float weight[8];
  float delta_m_residual[NP_BAND_COUNT]; /* the residual of np_light_moments */
} np_scattering_cells;

void np_scattering_field_gather_cells(const np_scattering_field *field, np_dvec3 position, np_scattering_cells *out);

/* ---- Importance ---- */

/* Light that reaches a cell, averaged over bands; it guides paths (integrate/guide.h). */
typedef struct np_importance {
  float mean;         /* radiance, averaged over directions, but for sunlight that went straight on */
  float linear[3];    /* its part that is linear in the direction of flight Ω is linear·Ω */
  float quadratic[5]; /* the part of degree 2 is Σ quadratic[i]·h_i(Ω), h_i = xy, yz, 3z² − 1, xz, x² − y² */
  float lit; /* irradiance of unscattered sunlight, or, attenuated by distance, of the sunlight in nearby cells */
} np_importance;

/* Interpolated importance at a position, for a description with `has_importance`; false: it is unknown, or 0. */
bool np_scattering_field_get_importance(const np_scattering_field *field, np_dvec3 position, np_importance *out);

/* ---- Light that comes to clouds from outside, the sun's disk excluded: sky above, ground below ---- */

/* Radiance along `towards` of ground under a clear sky and the sun's dimmed beam; and what it gains from irradiance in
 * place of the sky's. `fade` NULL: a beam dimmed by all of the depth. `glint`: factor on the sun's light that waves
 * reflect, by which sums over a few directions keep its flux. */
np_spectrum np_boundary_radiance_light_ground(const np_world *world, const np_sun_optical_depth_source *depths,
                                              const float *fade, const np_ground_hit *hit, np_vec3 towards, float glint,
                                              np_spectrum *out_gain);

/* The same in no direction: what the ground reflects evenly, and beside it the mean radiance of the sun's light that
 * waves reflect. */
np_spectrum np_boundary_radiance_light_column(const np_world *world, const np_sun_optical_depth_source *depths,
                                              const float *fade, const np_ground_hit *hit, np_spectrum *out_glint,
                                              np_spectrum *out_gain);

/* Radiance at a place among the clouds from the direction `towards`, which looks out. */
np_spectrum np_boundary_radiance_compute(const np_world *world, const np_sun_optical_depth_source *depths,
                                         np_dvec3 position, np_vec3 towards);

/* The same along the ordinates, averaged over the solid angle around each. */
typedef float np_boundary_radiance[NP_BAND_COUNT][NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];
neph_result np_boundary_radiance_fill(neph_context *context, const np_world *world,
                                      const np_sun_optical_depth_source *depths, const np_transport_desc *cells,
                                      const np_ordinates *ordinates, np_boundary_radiance out);

#endif
