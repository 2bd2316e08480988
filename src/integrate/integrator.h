/* SPDX-License-Identifier: Apache-2.0 */
/* Integrators: one camera ray to radiance. `march` is fast and biased, `path` is unbiased. */
#ifndef NP_INTEGRATE_INTEGRATOR_H
#define NP_INTEGRATE_INTEGRATOR_H

#include <nephos/context.h>

#include "core/parallel.h"
#include "core/random.h"
#include "optics/multiple_scattering.h"
#include "caches/lighting.h"

/* Components of the beauty, which add up to it. */
typedef enum np_component {
  NP_COMPONENT_BACKGROUND, /* sky and sun's disk behind everything */
  NP_COMPONENT_TERRAIN,    /* ground that the camera sees */
  NP_COMPONENT_AIR,        /* light that air scatters between the camera and the first cloud or ground */
  NP_COMPONENT_SUN,        /* sunlight scattered once in cloud */
  NP_COMPONENT_SKY,        /* skylight scattered once in cloud */
  NP_COMPONENT_GROUND,     /* light from the ground scattered once in cloud */
  NP_COMPONENT_MULTIPLE,   /* multiple scattering in cloud, and all scattered light of emission */
  NP_COMPONENT_EMISSION,   /* emission in cloud, not scattered */
  NP_COMPONENT_COUNT,

  NP_COMPONENT_GROUND_AIR = NP_COMPONENT_COUNT, /* the part of AIR before ground; the rest is before cloud */
  NP_COMPONENT_ALL
} np_component;

enum {
  NP_COMPONENTS_OF_BEAUTY = (1 << NP_COMPONENT_COUNT) - 1,
  NP_COMPONENTS_OF_CLOUDS = 1 << NP_COMPONENT_SUN | 1 << NP_COMPONENT_SKY | 1 << NP_COMPONENT_GROUND |
                            1 << NP_COMPONENT_MULTIPLE | 1 << NP_COMPONENT_EMISSION
};

typedef struct np_integrator_settings {
  unsigned scattering_max; /* scatterings in cloud along a path; 0xffffffff: no limit */
  float lost_share;        /* share of the cut paths that are followed to measure the loss; 0: none */
  bool is_split;           /* paths are guided and split by the view's solution of the multiple scattering */
  bool has_sun_share;      /* an output needs np_opaque.sun_share */
  bool has_holdout;        /* some cloud is held out */
  bool is_ground_held_out; /* the ground is a holdout: it hides what is behind it, and is not visible itself */
  bool is_air_traced;      /* paths are traced through air and from ground; else tables give the light of both */
  neph_multiple_scattering multiple_scattering; /* the march's method where multiple scattering is not solved for */
  np_approximation approximation;
  float tolerance;           /* error that the march's steps may have, as a share of a ray's light */
  float step_voxels;         /* its longest step */
  float transmittance_end;   /* transmittance below which a ray of the march is subject to Russian roulette */
  const np_monitor *monitor; /* when it is cancelled, paths in progress end and their samples are void; may be NULL */
} np_integrator_settings;

/* Opacity and light of a segment of the camera's ray, attenuated by the clouds in front of it. */
typedef struct np_depth_record {
  float begin, end; /* m, from the eye */
  float opacity;
  np_spectrum light;
} np_depth_record;

enum { NP_DEPTH_RECORDS_MAX = 512 };

/* Facts of a ray that few outputs need, added up beside its sample. */
typedef struct np_integrator_layers {
  float cloud_opacity[NP_INSTANCES_MAX];  /* visible opacity of each cloud of the scene, 0 for a holdout */
  np_spectrum group[NP_LIGHT_GROUPS_MAX]; /* light of each group of lights */
  float motion[4];                        /* pixels right and up, to the frame after and to that before */
  unsigned depth_components; /* bit mask of the components whose light is recorded by depth; 0: no records */
  unsigned depth_count;
  /* in ascending order, but records of emission form an order of their own */
  np_depth_record depths[NP_DEPTH_RECORDS_MAX];
} np_integrator_layers;

typedef struct np_camera_ray {
  np_dvec3 origin;              /* start of the ray; clouds and ground before it are invisible */
  np_vec3 direction;            /* unit */
  float jitter;                 /* 0 to 1: where in its step the march samples */
  float choice;                 /* 0 to 1, even over all seeds: where the tracer looks first in the air */
  float facet[2];               /* 0 to 1: tilt of the wave that reflects it, along the view and across */
  np_integrator_layers *layers; /* NULL: no output needs it */
  float film[2];                /* place of the film, in pixels */
  float spread_rad;             /* angle to the ray of the next pixel, for filtering of look-ups; 0: no filtering */
  double begin_m;               /* distance from the eye to the origin, between which there is air */
  bool has_end;                 /* clouds and ground beyond `end_m` are invisible */
  double end_m;                 /* distance from the origin */
  double time;                  /* time of the exposure, in frames after the frame's own */
  bool is_reflected; /* reflected by water, in the march; without disks of sun and moon, other water is land */
} np_camera_ray;

/* The ray for look-ups of its air, at distances from the eye. */
static inline np_view_ray np_camera_ray_get_view(const np_camera_ray *ray) {
  return (np_view_ray){.eye = ray->begin_m > 0.0 ? np_dvec3_along(ray->origin, ray->direction, -ray->begin_m)
                                                 : ray->origin,
                       .direction = ray->direction,
                       .film = {ray->film[0], ray->film[1]}};
}

static inline double np_camera_ray_get_end(const np_camera_ray *ray) { return ray->has_end ? ray->end_m : HUGE_VAL; }

/* Hit of a camera's ray with the ground within its range, with the distance from its origin. False for a ray that
 * begins in the ground. */
static inline bool np_camera_ray_intersect_ground(const np_world *world, const np_camera_ray *ray,
                                                  np_ground_hit *out_hit) {
  const np_ground_cone cone = {ray->begin_m, ray->spread_rad};
  return np_world_intersect_ground_cone(world, ray->origin, ray->direction, &cone, out_hit) &&
         !(out_hit->distance_m > np_camera_ray_get_end(ray)) && !(ray->begin_m > 0.0 && out_hit->distance_m <= 0.0);
}

/* Aerial perspective between the eye and a point at `distance_m` from the ray's origin, with the shadows in the air. */
static inline np_aerial_perspective np_camera_ray_get_air(const np_lighting *lighting, const np_world *world,
                                                          const np_camera_ray *ray, double distance_m, np_ray_end end) {
  const np_view_ray view = np_camera_ray_get_view(ray);
  return np_lighting_camera_air(lighting, world, &view, ray->begin_m + distance_m, end);
}

typedef struct np_integrator_sample {
  np_spectrum component[NP_COMPONENT_ALL]; /* W m⁻² sr⁻¹ nm⁻¹ */
  np_spectrum lost;                        /* estimate of the light lost to the limit on scatterings */
  unsigned cut_count, followed_count;      /* number of paths that met the limit, and of the followed ones among them */
  float transmittance;                     /* transmittance of the clouds along the whole ray */
  float held_out;                          /* share of the ray that holdout clouds hide */
  bool is_ground_behind;
  /* Opacity of cloud and ground along the ray, then sums of properties weighted by it. The mean opacity is
   * 1 − transmittance, or 1 before ground. */
  float opaque_weight;
  float opaque_distance; /* m */
  np_spectrum opaque_albedo;
  np_vec3 opaque_normal;
  float opaque_sun_share;
  float optical_depth; /* sum over all clouds up to ground or space, where an output needs it */
} np_integrator_sample;

/* Properties of a point, in cloud or on the ground, that adds opacity to the camera's ray. */
typedef struct np_opaque {
  double distance_m; /* along the camera's ray, from its origin */
  np_spectrum albedo;
  np_vec3 normal;  /* normal of the ground, in the world; 0 in cloud */
  float sun_share; /* share of the sun's light that clouds, hills and planet let through; 0 where no output needs it */
} np_opaque;

/* Counts `weight` of opacity. */
static inline void np_integrator_add_opaque(np_integrator_sample *sample, float weight, const np_opaque *opaque) {
  sample->opaque_weight += weight;
  sample->opaque_distance += weight * (float)opaque->distance_m;
  sample->opaque_albedo = np_spectrum_add_scaled(sample->opaque_albedo, weight, opaque->albedo);
  sample->opaque_normal = np_vec3_add(sample->opaque_normal, np_vec3_scale(opaque->normal, weight));
  sample->opaque_sun_share += weight * opaque->sun_share;
}

/* Sum of the components in a bit mask. */
static inline np_spectrum np_integrator_sum_light(const np_integrator_sample *sample, unsigned components) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned c = 0; c < NP_COMPONENT_COUNT; c++)
    if (components & 1u << c) sum = np_spectrum_add(sum, sample->component[c]);
  return sum;
}

static inline bool np_integrator_has_depths(const np_camera_ray *ray) {
  return ray->layers && ray->layers->depth_components;
}

/* Records a segment. If the array is full, each pair of neighbours is merged first. */
static inline void np_integrator_add_depth(np_integrator_layers *layers, np_depth_record record) {
  if (layers->depth_count == NP_DEPTH_RECORDS_MAX) {
    layers->depth_count /= 2;
    for (unsigned i = 0; i < layers->depth_count; i++) {
      const np_depth_record *a = &layers->depths[2 * i], *b = a + 1;
      layers->depths[i] = (np_depth_record){np_minf(a->begin, b->begin), np_maxf(a->end, b->end),
                                            a->opacity + b->opacity, np_spectrum_add(a->light, b->light)};
    }
  }
  layers->depths[layers->depth_count++] = record;
}

/* Adds the light of a further light source along the same ray: its records' light, without their opacity. */
static inline void np_integrator_append_light(np_integrator_layers *layers, const np_integrator_layers *more) {
  for (unsigned g = 0; g < NP_LIGHT_GROUPS_MAX; g++)
    layers->group[g] = np_spectrum_add(layers->group[g], more->group[g]);
  for (unsigned i = 0; i < more->depth_count; i++) {
    np_depth_record record = more->depths[i];
    record.opacity = 0.0f;
    np_integrator_add_depth(layers, record);
  }
}

/* The segment since a sample was as `before`, which has added to it all that it has more. */
static inline void np_integrator_record_depth(const np_camera_ray *ray, const np_integrator_sample *before,
                                              const np_integrator_sample *after, double begin, double end) {
  const unsigned components = ray->layers->depth_components;
  np_integrator_add_depth(
      ray->layers, (np_depth_record){.begin = (float)(ray->begin_m + begin),
                                     .end = (float)(ray->begin_m + end),
                                     .opacity = after->opaque_weight - before->opaque_weight,
                                     .light = np_spectrum_subtract(np_integrator_sum_light(after, components),
                                                                   np_integrator_sum_light(before, components))});
}

/* Counts `weight` of the opacity of one cloud. */
static inline void np_integrator_add_cloud(const np_camera_ray *ray, const np_instance *cloud, float weight) {
  if (ray->layers && !cloud->is_held_out) ray->layers->cloud_opacity[cloud->number] += weight;
}

typedef void (*np_integrator_fn)(const np_world *world, const np_lighting *lighting,
                                 const np_integrator_settings *settings, const np_camera_ray *ray, np_random *random,
                                 np_integrator_sample *out);

/* Distance from the ray's origin at which the transmittance through cloud falls below one half; infinite when it does
 * not before `distance_max`. */
typedef double (*np_half_distance_fn)(const np_world *world, const np_camera_ray *ray, double distance_max);

/* The clouds along a ray by their opacity alone, without their light. */
typedef struct np_view_depth {
  double half_m;  /* distance at which the transmittance falls below one half (np_half_distance_fn) */
  double cloud_m; /* mean distance, weighted by visible opacity; infinite without clouds */
  float opacity;  /* opacity of clouds; a 32nd of it may be missing */
} np_view_depth;

typedef np_view_depth (*np_view_depth_fn)(const np_world *world, const np_camera_ray *ray, double distance_max);

/* The functions for one instruction-set level. */
typedef struct np_integrator_kernels {
  np_integrator_fn march, path;
  np_half_distance_fn half_distance;
  np_view_depth_fn view_depth;
} np_integrator_kernels;

const np_integrator_kernels *np_integrator_get_kernels(neph_isa isa);

#endif
