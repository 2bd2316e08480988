/* SPDX-License-Identifier: Apache-2.0 */
/* Packets of three bands, and the assembly that they are part of. */
#ifndef NP_STAGES_PACKET_H
#define NP_STAGES_PACKET_H

#include <float.h>

#include "atmosphere/band_set.h"
#include "caches/cloud_light.h"
#include "caches/lighting.h"
#include "image/color_fit.h"
#include "plan/georeference.h"
#include "plan/schedule.h"
#include "scene/camera.h"
#include "stages/cloud_emission.h"
#include "stages/star_field.h"
#include "volume/volume_tint.h"

enum { NP_LIGHTS_MAX = NP_LIGHT_GROUPS_MAX }; /* sun and moon, or groups of lights */

/* Results for one light that all packets of bands share. */
typedef struct np_light_caches {
  np_sun_optical_depth *sun_optical_depth; /* NULL when not needed */
  np_air_visibility air_visibility;        /* empty when not needed */
} np_light_caches;

/* Light of a packet above the atmosphere. */
typedef struct np_light_beam {
  unsigned index; /* number of the light in the picture */
  unsigned group; /* number of the light's group in the picture */
  np_dvec3 direction;
  double angular_radius_rad;
  np_spectrum irradiance; /* above the atmosphere */
} np_light_beam;

/* Results of one light for a packet: its skies, its light in the clouds, and the scene under it. Light adds up, and so
 * do the pictures of a scene under each of its lights. */
typedef struct np_packet_light {
  np_light_beam beam;
  neph_sky *camera_sky, *cloud_sky, *water_sky;
  np_scattering_field *scattering; /* NULL when not needed */
  np_viewer_light *viewer_light;   /* NULL when not needed */
  np_cloud_light *cloud_light;     /* NULL when not needed */
  np_relief_light *relief_light;   /* NULL when not needed */
  np_air_shadow air_shadow;        /* empty when not needed */
  np_sky_guide sky_guide;          /* empty when not needed */
  np_water water;                  /* water of the world; none where the scene has none */
  np_world world;
  np_lighting lighting;
  np_reflection reflection; /* in the water; empty when not needed */
} np_packet_light;

/* Clouds of a packet. */
typedef struct np_placed_clouds {
  np_instance *at;  /* the clouds that are not empty, each by its colours */
  np_places places; /* hierarchy over the clouds' places; empty if each cloud has one place */
} np_placed_clouds;

/* Emission of the clouds in a packet. */
typedef struct np_packet_emission {
  np_emission all; /* without emitters where there is none */
  unsigned group_count;
  np_emission *groups; /* emission of each cloud of the scene, for light groups; NULL: no light groups */
} np_packet_emission;

/* Wavelength-dependent data in three bands: air, lights, and other sources in the sky. */
typedef struct np_packet {
  np_band_set bands;
  float color_weight[3][NP_BAND_COUNT]; /* share of each band in the picture's R, G and B */
  neph_atmosphere *atmosphere;
  np_placed_clouds placed;
  np_packet_emission emission;
  np_cloud_gain *gains; /* gain of each placed cloud; NULL: no approximation, or the scene has a gain for it */
  unsigned light_count; /* the first light's view also has environment, disks and night */
  np_packet_light lights[NP_LIGHTS_MAX];
  np_night night;
  np_star_field stars; /* stars of the camera's picture; empty: none */
} np_packet;

/* Volume and media of a cloud of the scene. */
typedef struct np_cloud_parts {
  neph_volume *volume; /* NULL: the cloud is empty */
  np_instance placed;  /* the cloud at its first place, with the packet's albedo */
  np_instance *copies; /* copies of the parts at each place; NULL: one place */
  unsigned copy_count;
  np_dvec3 low, high;           /* world box of all that it holds */
  np_georeference georeference; /* placement of its file */
  np_cloud_emission emission;   /* emission of the cloud; empty for most clouds */
  np_phase_table phase_table;   /* empty where its phase function is none */
  np_phase_bands *phase_bands;  /* one for each packet; NULL where it has no colour */
  unsigned phase_bands_count;
  np_phase_bands *ice_bands; /* those of crystals in the cold part, one for each packet; NULL: none */
  unsigned ice_bands_count;
  struct np_detailed_bricks *details[NP_TINT_PARTS_MAX]; /* bricks of each of its colours; NULL: it has no detail */
} np_cloud_parts;

/* Bricks of one colour of a cloud, with subvoxel detail. */
const np_bricks *np_cloud_parts_get_bricks(const np_cloud_parts *parts, unsigned k);

/* Maps the world to the voxels of a part of a cloud, where `world_to_cloud` maps it to the whole cloud. */
np_affine np_cloud_parts_get_world_to_index(const np_cloud_parts *parts, unsigned k, const np_affine *world_to_cloud);

/* Clouds of the scene in the frame. */
typedef struct np_frame_clouds {
  unsigned count;        /* clouds of the scene */
  unsigned volume_count; /* clouds that are not empty, each counted by its colours */
  np_cloud_parts *at;
  np_dvec3 low, high; /* world box of all that they hold */
} np_frame_clouds;

/* Bounds of an empty set. */
static const np_dvec3 np_nowhere_low = {DBL_MAX, DBL_MAX, DBL_MAX}, np_nowhere_high = {-DBL_MAX, -DBL_MAX, -DBL_MAX};

/* Whether a cloud repeats without end; its box is then one period. */
static inline bool np_cloud_parts_are_endless(const np_cloud_parts *cloud) {
  return cloud->volume && (cloud->volume->bricks.is_periodic[0] || cloud->volume->bricks.is_periodic[1]);
}

/* The middle of all that the clouds hold. */
static inline np_dvec3 np_frame_clouds_get_middle(const np_frame_clouds *clouds) {
  return np_dvec3_scale(np_dvec3_add(clouds->low, clouds->high), 0.5);
}

/* Lights of a picture: sun and moon, sun first, or groups of lights. */
typedef struct np_picture_lights {
  np_scene_lights places; /* directions of sun, moon and stars */
  np_sphere_map moon_map; /* empty: none */
  bool has_groups;        /* each light has a world with no other light in it */
  unsigned count;
  unsigned group[NP_LIGHTS_MAX]; /* number of each light's group; without groups SUN or MOON */
} np_picture_lights;

/* Conversion of the bands of a picture in colour to X, Y and Z, fitted to the scene's light. */
typedef struct np_picture_color {
  bool is_fitted; /* colours are fitted to the scene's light; false: each band has fixed weights */
  np_color_weights weights;
  double probe_nm[NP_COLOR_PROBE_BAND_COUNT]; /* wavelengths of the probes' bands */
  double light_x[NP_COLOR_PROBE_BAND_COUNT];  /* total irradiance at the camera, relative to the default sun's; 0 in the
                                                 dark */
} np_picture_color;

typedef struct np_assembly {
  neph_context *context;    /* borrowed from the scene */
  struct np_stores *stores; /* borrowed: results are taken from it, and returned */
  uint32_t built;           /* bits of the stages that were */
  bool has_reused;          /* some results are reused from earlier pictures */
  np_schedule schedule;     /* predicted times, without the pixels', after the assembly is built */
  np_camera camera;
  np_frame_clouds clouds;
  struct np_motion *motion; /* motion of camera and clouds about the frame; NULL when not needed */
  neph_terrain *terrain;
  np_star_catalogue catalogue;
  np_sphere_map star_map; /* empty: none */
  np_picture_lights lights;
  np_light_caches caches[NP_LIGHTS_MAX]; /* one for each light */
  bool is_of_bands;                      /* its bands are the picture's channels */
  unsigned packet_count;
  unsigned probe_packet_count; /* further packets, whose bands fit the colours: 1 or 0 */
  np_packet *packets;
  np_picture_color color;
} np_assembly;

/* Bands of a packet of a plan, those of probes behind the picture's. */
np_band_set np_packet_choose_bands(const np_plan *plan, unsigned packet);

/* Number of packets of a plan, with the packet of probes. */
unsigned np_packet_count(const np_plan *plan);

/* A scene's three values in a packet's bands. */
static inline np_spectrum np_bands_convert(const np_band_set *bands, np_band_rule rule,
                                           const double reference[NP_BAND_COUNT]) {
  double values[NP_BAND_COUNT];
  np_band_set_convert(bands, rule, reference, values);
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

/* A scene's albedo in a packet's bands. In the bands that colours are fitted by, the light at the camera gets the
 * colour that it has after such a reflection. */
np_spectrum np_picture_color_fit_albedo(const np_picture_color *color, const np_band_set *bands,
                                        const double reference[NP_BAND_COUNT]);

/* Rounds np_picture_color_fit_albedo to a thousandth where it is fitted: fits change by less as a camera moves, and
 * solutions with an albedo stay. */
np_spectrum np_picture_color_convert_albedo(const np_picture_color *color, const np_band_set *bands,
                                            const double reference[NP_BAND_COUNT]);

/* The law of black bodies in a packet's bands; in the bands that colours are fitted by, a body has its colour. */
np_black_body np_picture_color_make_black_body(const np_picture_color *color, const np_band_set *bands);

/* A scene's radiance in a packet's bands. In the bands that colours are fitted by, it has its colour. */
np_spectrum np_picture_color_convert_radiance(const np_picture_color *color, const np_band_set *bands,
                                              const double reference[NP_BAND_COUNT]);

/* Puts the parts of a cloud, with their albedos in a packet's bands, into its first place, of one without matter the
 * place alone; returns how many. */
unsigned np_cloud_parts_place(const np_cloud_parts *parts, const np_scene_cloud *cloud, unsigned number,
                              const np_picture_color *color, const np_band_set *bands,
                              np_instance out[NP_TINT_PARTS_MAX]);

/* Adds a packet's three bands to a colour of the picture. */
static inline np_spectrum np_packet_add_color(const np_packet *packet, np_spectrum color, np_spectrum bands) {
  for (int c = 0; c < 3; c++)
    for (int b = 0; b < NP_BAND_COUNT; b++) color.band[c] += packet->color_weight[c][b] * bands.band[b];
  return color;
}

#endif
