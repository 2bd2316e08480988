/* SPDX-License-Identifier: Apache-2.0 */
/* Light that comes into the cells from outside, the sun's disk excluded: sky, air and ground, by face and place.
 *
 * Each face of the cells' box has 5 × 5 nodes, from which rays look out; the lower face has more at its rims, since
 * ground beyond them is sunlit and ground under the clouds is not. Air is dimmed where clouds or hills shade it from
 * the sun. Ground and air below the clouds are lit by what the clouds let through, and air above by what they send up,
 * which only a solution knows: the radiance at a node is linear in that irradiance, and its coefficients are kept, so
 * that a solution under way renews its border without a ray. Hills within the box are solid cells (ground_columns.h).
 */
#ifndef NP_TRANSPORT_BORDER_H
#define NP_TRANSPORT_BORDER_H

#include "transport/ordinates.h"
#include "transport/transport_grid.h"

enum {
  NP_BORDER_NODES = 9,  /* largest number of nodes along an axis of a face */
  NP_BORDER_PLAN = 24,  /* squares along each side of the box's plan, … */
  NP_BORDER_WIDE = 40,  /* … and as many beyond each side, for ground that its light reaches */
  NP_BORDER_LEVELS = 5, /* below the box, from its bottom to the lowest ground; and above it */
  NP_BORDER_SETS_MAX = 2
};

/* Nodes along one axis of a face: ascending shares of the box's extent, the first 0 and the last 1. */
typedef struct np_border_nodes {
  unsigned count;
  float at[NP_BORDER_NODES];
} np_border_nodes;

/* Nodes of the low and the high face of an axis, along u and v. v is z on the sides and y at top and bottom, u the
 * other axis. */
typedef struct np_border_layout {
  np_border_nodes nodes[3][2][2]; /* [axis][is high][along v] */
} np_border_layout;

/* Radiance of one band, [octant][axis][v][u][block][lane]; 0 beyond the nodes that a face has. An octant's light comes
 * in through one face of each axis; that of a periodic axis is dark. */
typedef struct np_border_faces {
  unsigned block_count;
  float *radiance;
  const np_border_layout *layout;
  const float *glint; /* np_border.glint */
} np_border_faces;

/* Radiance of ground in or close below a column of cells. */
typedef struct np_column_light {
  float even;  /* radiance of the ground without glint, equal in all directions; −1: no ground is in the column */
  float glint; /* mean radiance of the sun's light that waves reflect, which depends on np_border's glint */
} np_column_light;

/* Ways out of the box. */
typedef enum np_border_way { NP_BORDER_DOWN, NP_BORDER_UP, NP_BORDER_WAYS } np_border_way;

/* Irradiance of scattered light on a plane beneath the clouds that faces up, and on one above them that faces down, by
 * square of the plan, [v][u]. */
typedef struct np_outflow {
  float way[NP_BORDER_WAYS][NP_BORDER_PLAN][NP_BORDER_PLAN];
} np_outflow;

/* Coefficient of a boundary radiance: its increase by the irradiance on a square at a level below or above the box. */
typedef struct np_border_response {
  uint32_t radiance; /* index of the radiance in np_border_faces */
  uint32_t square;   /* [way][level][v][u] */
  np_spectrum gain;  /* 1/sr */
} np_border_response;

typedef struct np_border {
  np_border_layout layout;
  np_border_faces faces[NP_BAND_COUNT];
  np_border_faces clear[NP_BAND_COUNT]; /* light with a clear sky above all ground and air */
  struct {
    np_border_response *at;
    size_t count;
  } responses[6 * NP_BORDER_NODES * NP_BORDER_NODES];                                   /* response of each node */
  _Alignas(32) float glint[NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES]; /* sun's light that the waves of
                                                                                            water reflect along the
                                                                                            ordinates, over its mean */
  double square_m[2], depth_m; /* sides of a square; from the bottom of the box to the lowest ground */
  bool is_wrapped[2];
  unsigned axis_count; /* number of axes that are not periodic, across which light enters */
  struct {
    np_spectrum clear;    /* irradiance on a plane past the box, without clouds */
    np_spectrum entering; /* irradiance on the opposite face of the box, by the ordinates */
    np_spectrum air;      /* what sunlit air in the cells adds to it on the way through the box */
  } way[NP_BORDER_WAYS];
  float open[NP_BORDER_PLAN][NP_BORDER_PLAN]; /* transmittance of the sun's beam to the bottom of the box; 1 at night */
} np_border;

static inline size_t np_border_count_radiances(unsigned block_count) {
  return (size_t)NP_OCTANT_COUNT * 3 * NP_BORDER_NODES * NP_BORDER_NODES * block_count * NP_ORDINATE_LANES;
}

/* Nodes of the face through which light in an octant's directions enters the box. */
static inline const np_border_nodes *np_border_get_nodes(const np_border_faces *faces, unsigned octant, int axis) {
  return faces->layout->nodes[axis][octant >> axis & 1u];
}

/* The radiances of a node, by block and lane. */
static inline float *np_border_get_node(const np_border_faces *faces, unsigned octant, int axis, unsigned v,
                                        unsigned u) {
  const size_t node = (((size_t)octant * 3 + (size_t)axis) * NP_BORDER_NODES + v) * NP_BORDER_NODES + u;
  return faces->radiance + node * faces->block_count * NP_ORDINATE_LANES;
}

/* A border for one set of directions. The sets of a solution share their rays. */
typedef struct np_border_set {
  const np_ordinates *ordinates;
  np_border *border; /* zero before; np_border_clear frees it, on failure too */
} np_border_set;

/* `fade`: of each cloud, the share of its optical depth that dims the beam in the solution's scaled medium. `is_rough`:
 * by a quarter of the rays. */
neph_result np_border_fill(const np_transport_grid *grid, const np_world *world,
                           const np_sun_optical_depth_source *depths, const float *fade, np_monitor *monitor,
                           bool is_rough, const np_border_set *sets, unsigned set_count);
void np_border_clear(neph_context *context, np_border *border);

/* Renews a band's faces for the light that leaves the box, in place of that in clear air. */
void np_border_set_outflow(neph_context *context, np_border *border, unsigned band, const np_outflow *outflow);

/* Distance of a level from the box, and the level nearest to a distance. */
double np_border_get_level(const np_border *border, np_border_way way, int level);
int np_border_search_level(const np_border *border, np_border_way way, double distance_m);

/* Resets a band's boundary radiance to clear air, without light that leaves the box. */
void np_border_reset(np_border *border, unsigned band);

/* Mean radiance of a band under a clear sky over the nodes through which an octant's light enters. */
double np_border_get_mean(const np_border *border, unsigned band, unsigned octant, unsigned block, unsigned lane);

/* Sum over the ordinates of the changes of mean radiances by the light that leaves, from those under a clear sky. */
double np_border_sum_change(const np_border *border, unsigned band, const np_ordinates *ordinates);

/* Irradiance past a square of the box's plan beyond that without clouds: air within the box that is not in the cells
 * adds to what comes through gaps, and the ordinates' sum is not quite the sky's. Gaps are the share of the beam that
 * comes through, or the share of the irradiance that enters, if that is less. */
float np_border_compute_excess(const np_border *border, unsigned band, np_border_way way, int v, int u,
                               float irradiance);

#endif
