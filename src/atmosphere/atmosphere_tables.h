/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of an atmosphere and of a sky. */
#ifndef NP_ATMOSPHERE_ATMOSPHERE_TABLES_H
#define NP_ATMOSPHERE_ATMOSPHERE_TABLES_H

#include <stdatomic.h>

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/medium.h"
#include "atmosphere/sky_trace.h"

struct neph_atmosphere {
  neph_context *context;
  atomic_size_t references;
  np_medium medium;
  neph_atmosphere_desc desc; /* as described, by these layers, whose tables are the medium's */
  neph_atmosphere_layer *layers;
  np_table_sizes sizes;
  np_depth_table depths;
  bool has_point_sun;           /* in probes: of a point, as others have it, not of a disk */
  unsigned order_max;           /* of light in its skies: NP_ORDERS_ALL but in probes */
  np_moment_table moments;      /* of all orders, or of one less than order_max; absent when that is none */
  np_moment_table dome_moments; /* of two less; absent when that is none, or where orders are not limited */
  np_gather_kernel kernel;
  np_air_shells air_shells;
};

/* One whose tables have any size. */
neph_result np_atmosphere_create_sized(neph_context *context, const neph_atmosphere_desc *desc, unsigned order_max,
                                       bool has_point_sun, const np_table_sizes *sizes, np_monitor *monitor,
                                       neph_atmosphere **out_atmosphere);

/* An atmosphere whose skies hold the first `order_max` orders alone, a bounce on the ground counting as one. */
neph_result np_atmosphere_create_orders(neph_context *context, const neph_atmosphere_desc *desc, unsigned order_max,
                                        bool has_point_sun, np_monitor *monitor, neph_atmosphere **out_atmosphere);

/* neph_sky_create under a monitor. */
neph_result np_sky_create_monitored(neph_atmosphere *atmosphere, const neph_sky_desc *desc, np_monitor *monitor,
                                    neph_sky **out_sky);

/* The observer's frame: up, horizontally towards the sun, and across. */
typedef struct np_sky_frame {
  np_vec3 up, toward, across;
  double altitude_m; /* 0 at the least */
  float sun_cosine, sun_sine;
  double horizon_angle; /* zenith angle of the true horizon */
  double top_angle;     /* zenith angle where the air begins: 0 inside it */
  float aerial_power;   /* how its rows above the horizon crowd about it: 2 from space, where only the limb is seen */
  double inward;        /* where slices of aerial perspective are centered, by altitude: see np_aerial_scale */
  double downward;      /* the same on rays to the ground */
  float twilight;       /* what is left of the light when its source is deep below the horizon: 1, fading to 0 */
} np_sky_frame;

struct neph_sky {
  neph_atmosphere *atmosphere;
  np_monitor *monitor;   /* while the tables are built; may be NULL */
  np_path_rule ray_rule; /* of a row of the view, for rays from elsewhere */
  np_spectrum irradiance;
  np_vec3 sun;
  float sun_angular_radius;
  np_dvec3 observer;
  np_sky_frame frame;
  np_sky_frame built; /* the frame, and the angular radius, that the tables were built for */
  float built_angular_radius;
  np_gather_table gather;
  np_scattered *view;   /* NULL in the dark: rows × azimuths: logarithms, per unit of sun irradiance */
  np_bands *depth;      /* aerial rows × slices: optical depth from the observer to the far plane, over the distance */
  np_scattered *aerial; /* NULL in the dark: aerial rows × azimuths × slices: logarithms of in-scatter, per unit of sun
                           irradiance */
  np_bands *molecules;  /* of that, what molecules scattered once; the aerosol's is its peak */
};

/* Moves a sky to another light and observer if its tables stand for them within their tolerance; else false, and why,
 * to follow on "since". Rows and azimuths are laid from the horizon and the sun, so that they move along. */
bool np_sky_move(neph_sky *sky, const neph_sky_desc *desc, char *out_reason, size_t reason_size);

/* The light and observer nearby, on a lattice, whose tables stand for those of a description within the tolerance: the
 * same whichever of its neighbours asks. */
void np_sky_snap(const neph_atmosphere *atmosphere, const neph_sky_desc *desc, neph_sky_desc *out);

/* Inputs of a sky's rays, once it has its gather. */
np_sky_light np_sky_light_make(const neph_sky *sky);

/* Fills the tables of a sky whose frame and light are set. */
neph_result np_sky_tables_build(neph_sky *sky);

/* One table of a sky whose tables are there, in this order. */
neph_result np_sky_gather_build(neph_sky *sky);

/* Whether skies that are not dark have a gather. */
static inline bool np_sky_has_gather(const neph_atmosphere *a) { return a->order_max > 1 && a->medium.aerosol_count; }
neph_result np_sky_view_build(neph_sky *sky);
neph_result np_sky_aerial_build(neph_sky *sky);
void np_sky_tables_free(neph_sky *sky);

/* A direction in a table's rows and azimuths. */
typedef struct np_sky_place {
  int row, azimuth; /* the lower neighbours */
  float row_upper, azimuth_upper;
  bool is_below;  /* the horizon */
  bool is_in_air; /* false: the ray passes the atmosphere by */
} np_sky_place;

/* Rows above the true horizon, rows below it, azimuths on the half circle from the sun (both ends included), and how
 * rows crowd about the horizon: θ = θ_h + (θ_end − θ_h)·vᵖ, v even; p is 3 below it, above it 2, or what the frame says
 * for aerial perspective. */
typedef struct np_sky_layout {
  int up, down, azimuths;
  bool is_aerial;
} np_sky_layout;

static inline np_sky_layout np_sky_view_layout(const neph_sky *sky) {
  const np_view_sizes *n = &sky->atmosphere->sizes.view;
  return (np_sky_layout){n->up, n->down, n->azimuths, false};
}
static inline np_sky_layout np_sky_aerial_layout(const neph_sky *sky) {
  const np_view_sizes *n = &sky->atmosphere->sizes.aerial;
  return (np_sky_layout){n->up, n->down, n->azimuths, true};
}

/* Cosine of the zenith angle of a row. Rows below the horizon follow those above, each half starting at the horizon. */
double np_sky_row_cosine(const np_sky_frame *frame, const np_sky_layout *layout, int row);

/* In-scatter to the ray's end, as the view table has it, per unit of sun irradiance. */
np_scattered np_sky_view_lookup(const neph_sky *sky, const np_sky_place *place, float length_m);

/* Divisor of the view table's radiances: the length of a ray to the ground, by which its light goes near the
 * horizon; one above it. */
float np_sky_view_length(const neph_sky *sky, double cosine, bool is_below);

np_sky_place np_sky_locate(const np_sky_frame *frame, np_vec3 direction, const np_sky_layout *layout);

/* Ray from the observer for aerial perspective: to the ground it goes on below sea level, where valleys may lie. */
np_ray np_aerial_ray(const np_medium *medium, const np_sky_frame *frame, double cosine, bool is_below);

/* Slices of aerial perspective along a ray. One that does not meet the ground: evenly in the signed root w of the
 * distance from a center, t = center + w·|w|. One that does: t = L·((1 − 2k)·s² + 2k·s), s even from 0 to 1; k goes
 * from 0, where t is as s² and slices crowd about the observer, to 1, where they crowd about the ground. */
typedef struct np_aerial_scale {
  bool hits_ground;
  double center_m;
  double first, extent; /* w runs from −first to −first + extent */
  double length_m, k;
} np_aerial_scale;

/* From low down the center is the observer, about whom things are seen; from high up it is the point nearest to the
 * planet, where the air is. */
static inline np_aerial_scale np_aerial_scale_make(const np_ray *ray, const np_sky_frame *frame) {
  const double center = frame->inward * np_ray_perigee(ray), first = sqrt(center);
  return (np_aerial_scale){ray->hits_ground, center,         first, first + sqrt(ray->length_m - center),
                           ray->length_m,    frame->downward};
}
static inline double np_aerial_scale_distance(const np_aerial_scale *scale, double fraction) {
  if (scale->hits_ground) return scale->length_m * fraction * ((1.0 - 2.0 * scale->k) * fraction + 2.0 * scale->k);
  const double w = scale->extent * fraction - scale->first;
  return scale->center_m + w * fabs(w);
}
static inline double np_aerial_scale_fraction(const np_aerial_scale *scale, double distance_m) {
  if (scale->hits_ground) {
    const double x = scale->length_m > 0.0 ? distance_m / scale->length_m : 0.0, k = scale->k;
    return x > 0.0 ? x / (k + sqrt(fmax(k * k + (1.0 - 2.0 * k) * x, 0.0))) : 0.0;
  }
  const double d = distance_m - scale->center_m;
  return scale->extent > 0.0 ? (copysign(sqrt(fabs(d)), d) + scale->first) / scale->extent : 0.0;
}

/* Aerial perspective at one place: optical depth and in-scatter, per unit of sun irradiance. */
typedef struct np_aerial_sample {
  np_bands depth;
  np_scattered inscatter;
} np_aerial_sample;

/* Up to `distance_m` from the observer along `ray`, whose direction `place` is. What molecules scattered once goes to
 * `out_molecules`, where that is not NULL. */
np_aerial_sample np_sky_aerial_lookup(const neph_sky *sky, const np_sky_place *place, const np_ray *ray,
                                      double distance_m, np_bands *out_molecules);

/* Gathers for suns evenly spread over zenith angles `sun_zenith_rad` ± `spread_rad`: in passes, so that each
 * sees the aerosol's light as the one before found it. `dome_moments` are those of the sky that is gathered: `moments`
 * themselves or, where orders are limited, one order less, NULL for none. `disk` is the sun's. */
neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  double sun_zenith_rad, double spread_rad, np_sun_disk disk, np_monitor *monitor,
                                  np_gather_table *out_table);

#endif
