/* SPDX-License-Identifier: Apache-2.0 */
/* Internal structure of an atmosphere and of a sky. */
#ifndef NP_ATMOSPHERE_ATMOSPHERE_TABLES_H
#define NP_ATMOSPHERE_ATMOSPHERE_TABLES_H

#include <stdatomic.h>

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/medium.h"
#include "atmosphere/sea.h"
#include "atmosphere/sky_trace.h"

struct neph_atmosphere {
  neph_context *context;
  atomic_size_t references;
  np_medium medium;
  neph_atmosphere_desc desc; /* the given description; `layers` points to the medium's own copies of the tables */
  neph_atmosphere_layer *layers;
  np_table_sizes sizes;
  np_depth_table depths;
  bool has_point_sun;           /* probe setting: a point sun, as in other models, instead of a disk */
  unsigned order_max;           /* highest order of scattering in its skies: NP_ORDERS_ALL, except in probes */
  np_moment_table moments;      /* moments of all orders, or of order_max − 1 orders; absent for none */
  np_moment_table dome_moments; /* moments of order_max − 2 orders; absent for none, and for unlimited orders */
  np_gather_kernel kernel;
  np_air_shells air_shells;
  np_sea sea;
};

/* Creates an atmosphere with tables of given sizes. */
neph_result np_atmosphere_create_sized(neph_context *context, const neph_atmosphere_desc *desc, unsigned order_max,
                                       bool has_point_sun, const np_table_sizes *sizes, np_monitor *monitor,
                                       neph_atmosphere **out_atmosphere);

/* Creates an atmosphere whose skies hold only the first `order_max` orders of scattering; a bounce on the ground counts
 * as one. */
neph_result np_atmosphere_create_orders(neph_context *context, const neph_atmosphere_desc *desc, unsigned order_max,
                                        bool has_point_sun, np_monitor *monitor, neph_atmosphere **out_atmosphere);

/* Lays open water on the ground, as far as its glint in the light of haze goes: the molecules' light knows the albedo
 * of the description alone. To be called before skies are created. */
void np_atmosphere_set_sea(neph_atmosphere *atmosphere, const np_sea *sea);

/* neph_sky_create with a progress monitor. */
neph_result np_sky_create_monitored(neph_atmosphere *atmosphere, const neph_sky_desc *desc, np_monitor *monitor,
                                    neph_sky **out_sky);

/* Frame of the observer: up, horizontally towards the sun, and across. */
typedef struct np_sky_frame {
  np_vec3 up, toward, across;
  double altitude_m; /* clamped to 0 and above */
  float sun_cosine, sun_sine;
  double horizon_angle; /* zenith angle of the true horizon */
  double top_angle;     /* zenith angle at which the atmosphere begins: 0 inside it */
  float aerial_power;   /* exponent that concentrates the rows above the horizon; 2 from space, from where only the limb
                           is visible */
  double inward; /* centre of the slices of aerial perspective: 0 at the observer, 1 at the perigee (np_aerial_scale) */
  double downward; /* concentration of slices at the ground, for rays that hit it: 0 to 1 */
  float twilight;  /* 1, fading to 0 as the sun sinks far below the horizon */
} np_sky_frame;

enum { NP_SKY_PART_RULES = 6 };

struct neph_sky {
  neph_atmosphere *atmosphere;
  np_monitor *monitor;                         /* set while the tables are built; may be NULL */
  np_path_rule ray_rule;                       /* rule of a view row, for rays from other positions */
  np_quadrature part_rules[NP_SKY_PART_RULES]; /* rules of ascending counts, for parts of such rays */
  np_spectrum irradiance;
  np_vec3 sun;
  float sun_angular_radius;
  np_dvec3 observer;
  np_sky_frame frame;
  np_sky_frame built; /* frame and angular radius for which the tables were built */
  float built_angular_radius;
  np_gather_table gather;
  np_scattered *view; /* NULL in the dark; rows × azimuths: logarithms of radiance per unit of solar irradiance */
  np_bands *depth; /* aerial rows × slices: optical depth from the observer to the far plane, divided by the distance */
  np_scattered *aerial; /* NULL in the dark; aerial rows × azimuths × slices: logarithms of in-scatter per unit of solar
                           irradiance */
  np_bands *molecules; /* first-order in-scatter by molecules; the aerosol's is the peak */
};

/* Moves a sky to another light and observer if its tables hold for them within their tolerance. Otherwise returns false
 * and the reason, as the end of "rebuilt: …". Rows and azimuths are relative to the horizon and the sun, and move with
 * them. */
bool np_sky_move(neph_sky *sky, const neph_sky_desc *desc, char *out_reason, size_t reason_size);

/* Rounds a description to the nearest light and observer on a lattice, whose tables hold for it within the tolerance.
 * Equal lattice points give equal tables. */
void np_sky_snap(const neph_atmosphere *atmosphere, const neph_sky_desc *desc, neph_sky_desc *out);

/* Inputs for rays of a sky whose gather is built. */
np_sky_light np_sky_light_make(const neph_sky *sky);

/* Builds the tables of a sky whose frame and light are set. */
neph_result np_sky_tables_build(neph_sky *sky);

/* Build the tables of a sky, to be called in this order. */
neph_result np_sky_gather_build(neph_sky *sky);

/* Whether skies have a gather, except in the dark. */
static inline bool np_sky_has_gather(const neph_atmosphere *a) { return a->order_max > 1 && a->medium.aerosol_count; }
neph_result np_sky_view_build(neph_sky *sky);
neph_result np_sky_aerial_build(neph_sky *sky);
void np_sky_tables_free(neph_sky *sky);

/* Layout of a table over directions: rows above the true horizon, rows below it, and azimuths on the half circle from
 * the sun, both ends inclusive. Rows concentrate at the horizon: θ = θ_h + (θ_end − θ_h)·vᵖ, v uniform. p is 3 below
 * the horizon and 2 above it; the frame sets it for aerial perspective. */
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

/* Cosine of the zenith angle of a row. The first rows go from the horizon up, the others from the horizon down. */
double np_sky_row_cosine(const np_sky_frame *frame, const np_sky_layout *layout, int row);

/* In-scatter up to the end of a ray, from the view table, per unit of solar irradiance. */
np_scattered np_sky_view_lookup(const neph_sky *sky, const np_sky_place *place, float length_m);

/* Divisor of radiances in the view table: the length of a ray to the ground, to which its radiance is proportional near
 * the horizon; 1 above the horizon. */
float np_sky_view_length(const neph_sky *sky, double cosine, bool is_below);

np_sky_place np_sky_locate(const np_sky_frame *frame, np_vec3 direction, const np_sky_layout *layout);

/* Ray for aerial perspective. A ray to the ground continues below sea level, for valleys. */
np_ray np_aerial_ray(const np_medium *medium, const np_sky_frame *frame, double cosine, bool is_below);

/* Spacing of the slices of aerial perspective along a ray. A ray that does not hit the ground has uniform spacing in
 * the signed root w of the distance from a centre, t = centre + w·|w|. A ray to the ground has t = L·((1 − 2k)·s² +
 * 2k·s), s uniform in [0, 1]: k = 0 concentrates the slices at the observer (t ~ s²), k = 1 at the ground. */
typedef struct np_aerial_scale {
  bool hits_ground;
  double center_m;
  double first, extent; /* w runs from −first to −first + extent */
  double length_m, k;
} np_aerial_scale;

/* The centre is the observer at low altitude, and the perigee, where most air is, at high altitude. */
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

/* Optical depth and in-scatter at one point, per unit of solar irradiance. */
typedef struct np_aerial_sample {
  np_bands depth;
  np_scattered inscatter;
} np_aerial_sample;

/* Aerial perspective up to `distance_m` along `ray`, with the direction `place`. `out_molecules`, if not NULL, receives
 * the in-scatter by molecules of first order. */
np_aerial_sample np_sky_aerial_lookup(const neph_sky *sky, const np_sky_place *place, const np_ray *ray,
                                      double distance_m, np_bands *out_molecules);

/* Builds gathers for sun zenith angles in `sun_zenith_rad` ± `spread_rad`. Several passes: each uses the aerosol light
 * of the pass before. `dome_moments` are the moments of the gathered sky: `moments`, or, with limited orders, one order
 * less; NULL: none. `sea` is on the ground, NULL: land alone; `disk` is the sun. */
neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  const np_sea *sea, double sun_zenith_rad, double spread_rad, np_sun_disk disk,
                                  np_monitor *monitor, np_gather_table *out_table);

#endif
