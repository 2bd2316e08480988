/* SPDX-License-Identifier: Apache-2.0 */
#include "render/assembly.h"

#include <float.h>
#include <glob.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"

typedef struct build {
  const neph_scene *scene;
  const np_plan *plan;
  np_monitor *monitor;
  np_assembly *assembly;
  double to_sun[3];
} build;

static bool needs(const np_plan *plan, np_stage stage) { return plan->stages[stage].is_needed; }

static neph_result bake(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume **out_volume) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.planet_radius_m = b->scene->atmosphere.planet_radius_m;
  desc.precision = cloud->precision;
  desc.progress = b->plan->desc.progress;
  desc.progress_user = b->plan->desc.progress_user;
  neph_context *context = b->scene->context;
  const neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, b->plan->desc.frame);
  if (!path) return neph_cloud_bake(context, &at_frame, &desc, out_volume);
  return neph_cloud_bake_file(context, &at_frame, &desc, "density", path);
}

static neph_result load(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume **out_volume) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = cloud->grid;
  desc.precision = cloud->precision;
  desc.policy = cloud->policy;
  desc.progress = b->plan->desc.progress;
  desc.progress_user = b->plan->desc.progress_user;
  return neph_volume_load(b->scene->context, path, &desc, out_volume);
}

/* A cloud of one frame: read when it is on disk, else baked, to disk where the scene names a file. */
static neph_result obtain(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume **out_volume) {
  np_cloud_source source;
  neph_result result = np_plan_find_source(b->scene, cloud, path, b->plan->desc.frame, &source);
  if (result) return result;
  if (!path) return bake(b, cloud, NULL, out_volume);
  if (source == NP_CLOUD_SOURCE_REBAKE)
    np_log(b->scene->context, NEPH_LOG_WARNING, "%s: was baked from other parameters than the scene's, is baked anew",
           path);
  if (source != NP_CLOUD_SOURCE_FILE) result = bake(b, cloud, path, NULL);
  return result ? result : load(b, cloud, path, out_volume);
}

/* The first file on disk of a numbered pattern; NULL when there is none or no memory. */
static char *find_first_frame(neph_context *context, const char *pattern) {
  char *wild = np_alloc_text(context, pattern), *first = NULL;
  if (!wild) return NULL;
  char *digits = strrchr(wild, '#');
  for (; digits >= wild && *digits == '#'; digits--) *digits = '?';
  glob_t found = {0};
  if (glob(wild, 0, NULL, &found) == 0) first = np_alloc_text(context, found.gl_pathv[0]);
  globfree(&found);
  np_alloc_free(context, wild);
  return first;
}

/* The volume that an optical depth refers to: the first frame on disk, whatever frame is rendered. */
static neph_result obtain_reference(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume *volume,
                                    neph_volume **out_reference) {
  *out_reference = neph_volume_retain(volume);
  if (cloud->density_unit != NP_DENSITY_OPTICAL_DEPTH || !cloud->vdb || !strchr(cloud->vdb, '#')) return NEPH_OK;
  char *first = find_first_frame(b->scene->context, cloud->vdb);
  neph_result result = NEPH_OK;
  if (first && strcmp(first, path) != 0) {
    neph_volume_release(*out_reference);
    *out_reference = NULL;
    result = load(b, cloud, first, out_reference);
  }
  np_alloc_free(b->scene->context, first);
  return result;
}

static void include_bounds(np_assembly *a, const np_placement *placement) {
  a->clouds_min =
      np_dvec3_make(fmin(a->clouds_min.x, placement->bounds_min.x), fmin(a->clouds_min.y, placement->bounds_min.y),
                    fmin(a->clouds_min.z, placement->bounds_min.z));
  a->clouds_max =
      np_dvec3_make(fmax(a->clouds_max.x, placement->bounds_max.x), fmax(a->clouds_max.y, placement->bounds_max.y),
                    fmax(a->clouds_max.z, placement->bounds_max.z));
}

static neph_result load_phase(const build *b, unsigned index) {
  const np_scene_phase *source = &b->scene->clouds[index].phase_source;
  if (source->kind != NP_PHASE_TABLE) return NEPH_OK;
  np_phase_table *table = &b->assembly->phase_tables[index];
  neph_result result = np_phase_table_load(b->scene->context, source->table, table);
  if (!result) b->assembly->placed[index].phase = np_phase_tabulated(table);
  return result;
}

static neph_result build_cloud(const build *b, unsigned index) {
  const np_scene_cloud *cloud = &b->scene->clouds[index];
  np_assembly *a = b->assembly;
  char *path = cloud->vdb ? np_file_frame_name(a->context, cloud->vdb, b->plan->desc.frame) : NULL;
  if (cloud->vdb && !path) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_volume *reference = NULL;
  np_placement placement;
  neph_result result = obtain(b, cloud, path, &a->volumes[index]);
  if (!result) result = obtain_reference(b, cloud, path, a->volumes[index], &reference);
  np_monitor_set_stage(b->monitor, "placing clouds");
  if (!result) result = np_placement_make(cloud, a->volumes[index], reference, b->monitor, &placement);
  if (!result) {
    a->placed[index] = placement.view;
    include_bounds(a, &placement);
    result = load_phase(b, index);
  }
  neph_volume_release(reference);
  np_alloc_free(a->context, path);
  return result;
}

static neph_result build_clouds(const build *b) {
  np_assembly *a = b->assembly;
  const unsigned count = b->scene->cloud_count;
  a->clouds_min = np_dvec3_make(DBL_MAX, DBL_MAX, DBL_MAX);
  a->clouds_max = np_dvec3_make(-DBL_MAX, -DBL_MAX, -DBL_MAX);
  if (count > NP_VIEW_VOLUMES_MAX)
    return np_fail(a->context, NEPH_ERROR_BAD_SCENE, "the scene has %u clouds, must be at most %d", count,
                   NP_VIEW_VOLUMES_MAX);
  a->volumes = np_alloc(a->context, count, sizeof *a->volumes);
  a->placed = np_alloc(a->context, count, sizeof *a->placed);
  a->phase_tables = np_alloc(a->context, count, sizeof *a->phase_tables);
  if (!a->volumes || !a->placed || !a->phase_tables) return NEPH_ERROR_OUT_OF_MEMORY;
  a->volume_count = count;
  for (unsigned i = 0; i < count; i++) {
    neph_result result = build_cloud(b, i);
    if (result) return result;
  }
  return NEPH_OK;
}

static neph_result build_terrain(const build *b) {
  const np_scene_terrain *terrain = &b->scene->terrain;
  neph_terrain_desc desc = terrain->desc;
  desc.planet_radius_m = b->scene->atmosphere.planet_radius_m;
  desc.has_place = b->scene->has_place;
  desc.latitude_rad = b->scene->latitude_rad;
  desc.longitude_rad = b->scene->longitude_rad;
  desc.progress = b->plan->desc.progress;
  desc.progress_user = b->plan->desc.progress_user;
  neph_terrain **out = &b->assembly->terrain;
  if (terrain->kind == NP_TERRAIN_RIDGES)
    return neph_terrain_create_ridges(b->scene->context, &terrain->ridges, &desc, out);
  return neph_terrain_load(b->scene->context, terrain->heightfield, &desc, out);
}

static neph_result find_sun(build *b) {
  double latitude = b->scene->latitude_rad, longitude = b->scene->longitude_rad;
  if (!b->scene->has_place && b->assembly->terrain)
    (void)np_terrain_get_place(b->assembly->terrain, &latitude, &longitude);
  return np_scene_sun_direction(b->scene, latitude, longitude, b->to_sun);
}

/* ---- What depends on wavelength ---- */

typedef struct packet_build {
  const build *b;
  np_packet *packet;
} packet_build;

/* Of the sphere: the terrain's, unless it was given. */
static const double *get_ground_albedo(const neph_scene *scene) {
  const bool is_terrain = !scene->has_ground_albedo && scene->terrain.kind != NP_TERRAIN_NONE;
  return is_terrain ? scene->terrain.desc.ground_albedo : scene->atmosphere.ground_albedo;
}

static neph_result build_atmosphere(const packet_build *p) {
  const neph_scene *scene = p->b->scene;
  neph_atmosphere_desc desc = scene->atmosphere;
  np_band_set_convert(&p->packet->bands, NP_BAND_LINEAR, get_ground_albedo(scene), desc.ground_albedo);
  neph_atmosphere_layer *layers = np_alloc(scene->context, desc.layer_count, sizeof *layers);
  if (!layers) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < desc.layer_count; i++)
    layers[i] = np_band_set_convert_layer(&p->packet->bands, &scene->atmosphere.layers[i]);
  desc.layers = layers;
  np_monitor_set_stage(p->b->monitor, "building the atmosphere");
  neph_result result = neph_atmosphere_create(scene->context, &desc, &p->packet->atmosphere);
  np_alloc_free(scene->context, layers);
  return result;
}

static neph_result build_sky(const packet_build *p, np_dvec3 observer, neph_sky **out_sky) {
  const np_scene_sun *sun = &p->b->scene->sun;
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  memcpy(desc.sun_direction, p->b->to_sun, sizeof desc.sun_direction);
  np_band_set_convert(&p->packet->bands, NP_BAND_SUN, sun->irradiance_w_m2_nm, desc.sun_irradiance_w_m2_nm);
  desc.sun_angular_radius_rad = sun->angular_radius_rad;
  desc.observer_m[0] = observer.x;
  desc.observer_m[1] = observer.y;
  desc.observer_m[2] = observer.z;
  return neph_sky_create(p->packet->atmosphere, &desc, out_sky);
}

static neph_result build_skies(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  neph_result result = NEPH_OK;
  if (needs(p->b->plan, NP_STAGE_CAMERA_SKY)) result = build_sky(p, a->camera.origin, &p->packet->camera_sky);
  if (!result && needs(p->b->plan, NP_STAGE_CLOUD_SKY)) {
    const np_dvec3 middle = np_dvec3_scale(np_dvec3_add(a->clouds_min, a->clouds_max), 0.5);
    result = build_sky(p, middle, &p->packet->cloud_sky);
  }
  return result;
}

static np_spectrum convert(const packet_build *p, np_band_rule rule, const double reference[NP_BAND_COUNT]) {
  double values[NP_BAND_COUNT];
  np_band_set_convert(&p->packet->bands, rule, reference, values);
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

static neph_result place_clouds(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  if (!a->volume_count) return NEPH_OK;
  p->packet->placed = np_alloc(a->context, a->volume_count, sizeof *a->placed);
  if (!p->packet->placed) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(p->packet->placed, a->placed, a->volume_count * sizeof *a->placed);
  for (unsigned i = 0; i < a->volume_count; i++)
    p->packet->placed[i].albedo = convert(p, NP_BAND_LINEAR, p->b->scene->clouds[i].albedo);
  return NEPH_OK;
}

static void fill_view(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  const neph_scene *scene = p->b->scene;
  np_packet *packet = p->packet;
  const double *to_sun = p->b->to_sun;
  packet->view = (np_scene_view){
      .volume_count = a->volume_count,
      .volumes = packet->placed,
      .to_sun = np_vec3_make((float)to_sun[0], (float)to_sun[1], (float)to_sun[2]),
      .sun_angular_radius_rad = (float)scene->sun.angular_radius_rad,
      .sun_irradiance = convert(p, NP_BAND_SUN, scene->sun.irradiance_w_m2_nm),
      .atmosphere = packet->atmosphere,
      .camera_sky = packet->camera_sky,
      .cloud_sky = packet->cloud_sky,
      .environment_radiance = convert(p, NP_BAND_LINEAR, scene->environment.radiance_w_m2_sr_nm),
      .is_environment_upper_only = scene->environment.is_upper_only,
      .has_planet = scene->environment.has_planet,
      .planet_radius_m = scene->atmosphere.planet_radius_m,
      .terrain = a->terrain,
      .terrain_albedo = convert(p, NP_BAND_LINEAR, scene->terrain.desc.ground_albedo),
      .ground_albedo = convert(p, NP_BAND_LINEAR, get_ground_albedo(scene)),
  };
  if (a->terrain) np_terrain_get_bounds(a->terrain, &packet->view.terrain_min, &packet->view.terrain_max);
}

static neph_result build_multi_scatter(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  np_packet *packet = p->packet;
  np_multi_scatter_desc desc = NP_MULTI_SCATTER_DESC_DEFAULT;
  desc.cells.bounds_min = a->clouds_min;
  desc.cells.bounds_max = a->clouds_max;
  neph_result result = np_multi_scatter_build(a->context, &packet->view, &desc, p->b->monitor, &packet->multi_scatter);
  if (!result) packet->view.multi_scatter = &packet->multi_scatter;
  return result;
}

static neph_result build_packet(const packet_build *p) {
  const np_plan *plan = p->b->plan;
  neph_result result = NEPH_OK;
  if (needs(plan, NP_STAGE_ATMOSPHERE)) result = build_atmosphere(p);
  if (!result) result = build_skies(p);
  if (!result) result = place_clouds(p);
  if (result) return result;
  fill_view(p);
  return needs(plan, NP_STAGE_ORDINATES) ? build_multi_scatter(p) : NEPH_OK;
}

/* The bands of each packet, and their weights in the picture's colours. */
static void choose_bands(const np_plan *plan, np_packet *packets) {
  if (plan->packet_count == 1) {
    packets->bands = np_band_set_reference();
    for (int c = 0; c < 3; c++) packets->color_weight[c][c] = 1.0f;
    return;
  }
  np_wavelengths wavelengths;
  np_wavelengths_choose(plan->wavelength_count, &wavelengths);
  for (unsigned i = 0; i < plan->packet_count; i++) {
    packets[i].bands = np_band_set_choose(&wavelengths, i);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
      double rgb[3];
      np_color_space_weigh(plan->color_space, wavelengths.xyz_nm[np_band_set_get_index(&wavelengths, i, b)], rgb);
      for (int c = 0; c < 3; c++) packets[i].color_weight[c][b] = (float)rgb[c];
    }
  }
}

static neph_result build_packets(const build *b) {
  np_assembly *a = b->assembly;
  const unsigned count = b->plan->packet_count;
  a->packets = np_alloc(a->context, count, sizeof *a->packets);
  if (!a->packets) return NEPH_ERROR_OUT_OF_MEMORY;
  choose_bands(b->plan, a->packets);
  neph_result result = NEPH_OK;
  for (; !result && a->packet_count < count; a->packet_count++)
    result = build_packet(&(packet_build){b, &a->packets[a->packet_count]});
  return result;
}

neph_result np_assembly_build(const neph_scene *scene, const np_plan *plan, np_monitor *monitor,
                              np_assembly *out_assembly) {
  *out_assembly = (np_assembly){.context = scene->context};
  build b = {.scene = scene, .plan = plan, .monitor = monitor, .assembly = out_assembly};
  neph_result result = np_camera_init(scene, plan->desc.width, plan->desc.height, &out_assembly->camera);
  if (!result && needs(plan, NP_STAGE_TERRAIN)) result = build_terrain(&b);
  if (!result) result = find_sun(&b);
  if (!result && needs(plan, NP_STAGE_VOLUMES)) result = build_clouds(&b);
  if (!result) result = build_packets(&b);
  if (result) np_assembly_clear(out_assembly);
  return result;
}

static void clear_packet(neph_context *context, np_packet *packet) {
  np_multi_scatter_clear(&packet->multi_scatter);
  np_alloc_free(context, packet->placed);
  neph_sky_destroy(packet->cloud_sky);
  neph_sky_destroy(packet->camera_sky);
  neph_atmosphere_release(packet->atmosphere);
}

void np_assembly_clear(np_assembly *assembly) {
  for (unsigned i = 0; i < assembly->packet_count; i++) clear_packet(assembly->context, &assembly->packets[i]);
  np_alloc_free(assembly->context, assembly->packets);
  for (unsigned i = 0; i < assembly->volume_count; i++) {
    neph_volume_release(assembly->volumes[i]);
    np_phase_table_clear(&assembly->phase_tables[i]);
  }
  np_alloc_free(assembly->context, assembly->phase_tables);
  np_alloc_free(assembly->context, assembly->volumes);
  np_alloc_free(assembly->context, assembly->placed);
  neph_terrain_release(assembly->terrain);
  *assembly = (np_assembly){0};
}
