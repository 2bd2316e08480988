/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/channel_table.h"

#include <string.h>

#include "core/text.h"
#include "frame/channel_mattes.h"
#include "image/cryptomatte.h"

/* ---- Values of a sample ---- */

/* The covered share of a sample, less held-out clouds and ground. */
static float compute_alpha(const np_channels *c, np_scene_alpha alpha, const np_integrator_sample *sample) {
  const bool is_behind_shown =
      alpha == NP_ALPHA_SCENE || (alpha == NP_ALPHA_CLOUDS_AND_GROUND && sample->is_ground_behind);
  const bool is_held_out = sample->is_ground_behind && c->is_ground_held_out;
  return (is_behind_shown && !is_held_out ? 1.0f : 1.0f - sample->transmittance) - sample->held_out;
}

static float read_light(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)ray;
  return np_channels_sum_components(c, channel->kind.components, channel->part, sample);
}

/* Ground without the air before it. */
static float read_before_ground(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                                const np_integrator_sample *sample) {
  return read_light(c, channel, ray, sample) -
         np_channels_sum_components(c, 1u << NP_COMPONENT_GROUND_AIR, channel->part, sample);
}

static float read_group(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)sample;
  return ray->layers->group[channel->kind.group].band[channel->part] * c->scale;
}

static float read_motion(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                         const np_integrator_sample *sample) {
  (void)c, (void)sample;
  return ray->layers->motion[channel->part];
}

static float read_alpha(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)ray;
  return compute_alpha(c, (np_scene_alpha)channel->kind.alpha, sample);
}

static float read_transmittance(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                                const np_integrator_sample *sample) {
  (void)c, (void)channel, (void)ray;
  return sample->transmittance;
}

static float read_optical_depth(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                                const np_integrator_sample *sample) {
  (void)c, (void)channel, (void)ray;
  return sample->optical_depth;
}

static float read_opacity(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                          const np_integrator_sample *sample) {
  (void)c, (void)channel, (void)ray;
  return sample->opaque_weight;
}

static float read_albedo(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                         const np_integrator_sample *sample) {
  (void)c, (void)ray;
  return sample->opaque_albedo.band[channel->part];
}

static float read_distance(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                           const np_integrator_sample *sample) {
  (void)c, (void)channel;
  return (float)(ray->begin_m * (double)sample->opaque_weight) + sample->opaque_distance;
}

static float read_position(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                           const np_integrator_sample *sample) {
  (void)c;
  const double origin[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
  const float direction[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
  const unsigned axis = channel->part;
  return (float)(origin[axis] * (double)sample->opaque_weight) + direction[axis] * sample->opaque_distance;
}

static float read_normal(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                         const np_integrator_sample *sample) {
  (void)c, (void)ray;
  const float normal[3] = {sample->opaque_normal.x, sample->opaque_normal.y, sample->opaque_normal.z};
  return normal[channel->part];
}

static float read_sun_share(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                            const np_integrator_sample *sample) {
  (void)c, (void)channel, (void)ray;
  return sample->opaque_sun_share;
}

/* ---- Values of a pixel ---- */

/* Coverage less held-out coverage. A difference within the rounding of floats is set to 0. */
static double finish_coverage(const np_channels *c, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts) {
  const double mean = np_channel_finish_mean(c, channel, sums, facts);
  return fabs(mean) < 1e-6 ? fmax(mean, 0.0) : mean;
}

static double divide_by_opacity(const np_channels *c, const np_channel *channel, const double *sums,
                                double where_none) {
  const double opaque = sums[c->opaque];
  return opaque > 0.0 ? sums[channel->index] / opaque : where_none;
}

/* Mean over a pixel weighted by opacity; 0 without anything opaque, as for albedo and position. */
static double finish_opaque(const np_channels *c, const np_channel *channel, const double *sums,
                            const np_pixel_facts *facts) {
  (void)facts;
  return divide_by_opacity(c, channel, sums, 0.0);
}

/* Mean distance weighted by opacity; infinite for a pixel without anything opaque. */
static double finish_opaque_distance(const np_channels *c, const np_channel *channel, const double *sums,
                                     const np_pixel_facts *facts) {
  (void)facts;
  return divide_by_opacity(c, channel, sums, HUGE_VAL);
}

/* A pixel without anything opaque has no shadow. */
static double finish_opaque_share(const np_channels *c, const np_channel *channel, const double *sums,
                                  const np_pixel_facts *facts) {
  (void)facts;
  return divide_by_opacity(c, channel, sums, 1.0);
}

static double finish_depth(const np_channels *c, const np_channel *channel, const double *sums,
                           const np_pixel_facts *facts) {
  (void)c, (void)channel, (void)sums;
  return facts->depth;
}

static double finish_distance(const np_channels *c, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts) {
  (void)c, (void)channel, (void)sums;
  return facts->distance;
}

static double finish_variance(const np_channels *c, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts) {
  (void)c, (void)sums;
  return np_spread_variance(&facts->spread, channel->part);
}

static double finish_error(const np_channels *c, const np_channel *channel, const double *sums,
                           const np_pixel_facts *facts) {
  return sqrt(finish_variance(c, channel, sums, facts));
}

static double finish_count(const np_channels *c, const np_channel *channel, const double *sums,
                           const np_pixel_facts *facts) {
  (void)c, (void)channel, (void)sums;
  return facts->spread.count;
}

/* ---- Names of the rules ---- */

enum { ANY = NP_CHANNELS_MAX };

static const struct {
  const char *name;
  np_channel_finish_fn finish;
  np_channel_finish_needs needs;
} finishes[] = {{"mean", np_channel_finish_mean, {.part_count = ANY}},
                {"coverage", finish_coverage, {.part_count = ANY}},
                {"over opacity", finish_opaque, {.part_count = ANY, .opacity = true}},
                {"distance over opacity", finish_opaque_distance, {.part_count = ANY, .opacity = true}},
                {"share over opacity", finish_opaque_share, {.part_count = ANY, .opacity = true}},
                {"depth", finish_depth, {.part_count = ANY}},
                {"distance", finish_distance, {.part_count = ANY}},
                {"variance", finish_variance, {.part_count = NP_BAND_COUNT}},
                {"standard error", finish_error, {.part_count = NP_BAND_COUNT}},
                {"sample count", finish_count, {.part_count = ANY}},
                {"rank", np_channel_finish_rank, {.part_count = NP_CRYPTOMATTE_CHANNELS, .mattes = true}}};

enum { FINISH_COUNT = sizeof finishes / sizeof *finishes };

np_channel_finish_fn np_channel_finish_get(const char *name) {
  for (unsigned i = 0; i < FINISH_COUNT; i++)
    if (!strcmp(finishes[i].name, name)) return finishes[i].finish;
  return NULL;
}

const char *np_channel_finish_get_name(np_channel_finish_fn finish) {
  for (unsigned i = 0; i < FINISH_COUNT; i++)
    if (finishes[i].finish == finish) return finishes[i].name;
  return "";
}

np_channel_finish_needs np_channel_finish_get_needs(np_channel_finish_fn finish) {
  for (unsigned i = 0; i < FINISH_COUNT; i++)
    if (finishes[i].finish == finish) return finishes[i].needs;
  return (np_channel_finish_needs){.part_count = 0};
}

/* ---- Which there are ---- */

#define LIGHTS(some)                                                                                                   \
  { .read = read_light, .finish = np_channel_finish_mean, .components = (some) }
#define LIGHT(component) LIGHTS(1u << (component))
#define BEFORE_GROUND(some)                                                                                            \
  { .read = read_before_ground, .finish = np_channel_finish_mean, .components = (some) }
#define OPAQUE(what, as)                                                                                               \
  { .read = read_##what, .finish = finish_##as, .is_over_opacity = true }

static const np_channel_kind aov_kinds[NP_AOV_COUNT] = {
    [NP_AOV_INDEX_BACKGROUND] = LIGHT(NP_COMPONENT_BACKGROUND),
    [NP_AOV_INDEX_TERRAIN] = LIGHT(NP_COMPONENT_TERRAIN),
    [NP_AOV_INDEX_AIR] = LIGHT(NP_COMPONENT_AIR),
    [NP_AOV_INDEX_SUN] = LIGHT(NP_COMPONENT_SUN),
    [NP_AOV_INDEX_SKY] = LIGHT(NP_COMPONENT_SKY),
    [NP_AOV_INDEX_GROUND] = LIGHT(NP_COMPONENT_GROUND),
    [NP_AOV_INDEX_MULTIPLE] = LIGHT(NP_COMPONENT_MULTIPLE),
    [NP_AOV_INDEX_EMISSION] = LIGHT(NP_COMPONENT_EMISSION),
    [NP_AOV_INDEX_TRANSMITTANCE] = {.read = read_transmittance, .finish = np_channel_finish_mean},
    [NP_AOV_INDEX_DISTANCE] = {.finish = finish_distance},
    [NP_AOV_INDEX_STANDARD_ERROR] = {.finish = finish_error},
    [NP_AOV_INDEX_VARIANCE] = {.finish = finish_variance},
    [NP_AOV_INDEX_SAMPLE_COUNT] = {.finish = finish_count},
    [NP_AOV_INDEX_ALBEDO] = OPAQUE(albedo, opaque),
    [NP_AOV_INDEX_MEAN_DISTANCE] = OPAQUE(distance, opaque_distance),
    [NP_AOV_INDEX_POSITION] = OPAQUE(position, opaque),
    [NP_AOV_INDEX_NORMAL] = OPAQUE(normal, opaque),
    [NP_AOV_INDEX_SHADOW] = OPAQUE(sun_share, opaque_share),
    [NP_AOV_INDEX_CLOUDS] = LIGHTS(NP_COMPONENTS_OF_CLOUDS),
    [NP_AOV_INDEX_CLOUD_AIR] = BEFORE_GROUND(1u << NP_COMPONENT_AIR),
    [NP_AOV_INDEX_GROUND_AIR] = LIGHT(NP_COMPONENT_GROUND_AIR),
    [NP_AOV_INDEX_OPTICAL_DEPTH] = {.read = read_optical_depth, .finish = np_channel_finish_mean},
};

static const np_channel_kind cloud_alpha = {.read = read_alpha, .finish = finish_coverage, .alpha = NP_ALPHA_CLOUDS},
                             clouds_in_air = BEFORE_GROUND(NP_COMPONENTS_OF_CLOUDS | 1u << NP_COMPONENT_AIR),
                             opacity = {.read = read_opacity, .finish = np_channel_finish_mean};

static np_channel_kind choose_kind(const np_channels *c, const np_scene_output *output, np_aov_index aov) {
  np_channel_kind kind = aov_kinds[aov];
  if (aov == NP_AOV_INDEX_CLOUDS && output->cloud_air == NP_CLOUD_AIR_KEPT) kind = clouds_in_air;
  kind.components &= c->beauty | ~(unsigned)NP_COMPONENTS_OF_BEAUTY;
  return kind;
}

static void add_group(np_channels *c, const char *group, unsigned number) {
  char name[NP_CHANNEL_NAME_MAX];
  for (unsigned band = 0; band < NP_BAND_COUNT; band++) {
    np_print(name, sizeof name, "light_%s.%c", group, "RGB"[band]);
    np_channels_add(c, name, (np_channel_kind){.read = read_group, .finish = np_channel_finish_mean, .group = number},
                    band);
  }
}

/* Groups of lights, which add up to the picture. */
static void add_groups(np_channels *c, const np_plan *plan, const neph_scene *scene) {
  if (plan->decisions.has_sun) add_group(c, "sun", NP_LIGHT_GROUP_SUN);
  add_group(c, "sky", NP_LIGHT_GROUP_SKY);
  if (np_plan_needs(plan, NP_STAGE_MOON)) add_group(c, "moon", NP_LIGHT_GROUP_MOON);
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (scene->clouds[i].emission.is_enabled) add_group(c, scene->clouds[i].name, NP_LIGHT_GROUP_EMISSION + i);
}

/* Adds the motion vectors as layers of their own, under the names that compositors search for. */
static void add_motion(np_channels *c) {
  static const char *const names[] = {"forward.u", "forward.v", "backward.u", "backward.v"};
  for (unsigned i = 0; i < sizeof names / sizeof *names; i++)
    np_channels_add(c, names[i], (np_channel_kind){.read = read_motion, .finish = np_channel_finish_mean}, i);
}

static void add_aov(np_channels *c, const neph_scene *scene, np_aov_index aov) {
  if (aov == NP_AOV_INDEX_MATTES) np_channels_add_mattes(c, scene);
  if (aov == NP_AOV_INDEX_CRYPTOMATTE) np_channels_add_cryptomatte(c);
  if (aov == NP_AOV_INDEX_MOTION) add_motion(c);
  if (!aov_kinds[aov].finish) return;
  const np_aov_row *row = &np_aov_rows[aov];
  const np_channel_kind kind = choose_kind(c, &scene->output, aov);
  char name[NP_CHANNEL_NAME_MAX];
  if (!*row->parts) np_channels_add(c, row->name, kind, 0);
  for (unsigned part = 0; part < strlen(row->parts); part++) {
    np_print(name, sizeof name, "%s.%c", row->name, row->parts[part]);
    np_channels_add(c, name, row->parts[part] == 'A' ? cloud_alpha : kind, part);
  }
}

/* The sum by which means are divided. */
static void add_divisor(np_channels *c) {
  bool is_asked = false;
  for (unsigned i = 0; i < c->count; i++) is_asked = is_asked || c->channel[i].kind.is_over_opacity;
  c->opaque = is_asked ? c->sum_count : NP_CHANNEL_NONE;
  if (is_asked) np_channels_add(c, NULL, opacity, 0);
}

/* Chooses the alpha channel: a picture without a background shows only clouds and ground. */
static np_channel_kind choose_alpha(const np_scene_output *output) {
  const bool is_whole = output->alpha == NP_ALPHA_SCENE && output->has_background;
  const np_scene_alpha alpha =
      output->alpha == NP_ALPHA_SCENE && !is_whole ? NP_ALPHA_CLOUDS_AND_GROUND : output->alpha;
  return (np_channel_kind){.read = read_alpha, .finish = finish_coverage, .alpha = alpha};
}

void np_channels_choose(const np_plan *plan, const neph_scene *scene, np_channels *out) {
  const np_scene_output *output = &scene->output;
  static const char *const colors[] = {"R", "G", "B"};
  *out = (np_channels){.scale = (float)np_scene_get_scale(scene),
                       .beauty = NP_COMPONENTS_OF_BEAUTY,
                       .is_ground_held_out = scene->terrain.is_held_out};
  if (!output->has_background) out->beauty &= ~(1u << NP_COMPONENT_BACKGROUND);
  for (unsigned band = 0; plan->request.has_beauty && band < NP_BAND_COUNT; band++)
    np_channels_add(out, colors[band], (np_channel_kind)LIGHTS(out->beauty), band);
  np_channels_add(out, "A", choose_alpha(output), 0);
  np_channels_add(out, "Z", (np_channel_kind){.finish = finish_depth}, 0);
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (plan->request.aovs & ~(unsigned)NP_AOV_DEPTH & 1u << i) add_aov(out, scene, (np_aov_index)i);
  if (plan->request.has_light_groups) add_groups(out, plan, scene);
  if (plan->request.aovs & NP_AOV_CRYPTOMATTE) np_channels_add_cryptomatte_sums(out, scene);
  add_divisor(out);
}
