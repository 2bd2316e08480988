/* SPDX-License-Identifier: Apache-2.0 */
#include "render/channels.h"

#include <stdio.h>
#include <string.h>

/* ---- What a sample adds ---- */

static float sum_components(const np_channels *c, unsigned components, unsigned band,
                            const np_integrator_sample *sample) {
  float sum = 0.0f;
  for (unsigned i = 0; i < NP_COMPONENT_ALL; i++)
    if (components & 1u << i) sum += sample->component[i].band[band];
  return sum * c->scale;
}

static float compute_cloud_alpha(const np_integrator_sample *sample) { return 1.0f - sample->transmittance; }

static float compute_alpha(np_scene_alpha alpha, const np_integrator_sample *sample) {
  if (alpha == NP_ALPHA_SCENE) return 1.0f;
  return alpha == NP_ALPHA_CLOUDS_AND_GROUND && sample->is_ground_behind ? 1.0f : compute_cloud_alpha(sample);
}

static float read_light(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)ray;
  return sum_components(c, channel->kind.components, channel->part, sample);
}

/* The same without the air before the ground. */
static float read_before_ground(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                                const np_integrator_sample *sample) {
  return read_light(c, channel, ray, sample) - sum_components(c, 1u << NP_COMPONENT_GROUND_AIR, channel->part, sample);
}

static float read_alpha(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)c, (void)ray;
  return compute_alpha((np_scene_alpha)channel->kind.alpha, sample);
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
  (void)c, (void)channel, (void)ray;
  return sample->opaque_distance;
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

/* ---- What becomes of the sum ---- */

static double finish_mean(const np_channels *c, const np_channel *channel, const double *sums,
                          const np_pixel_facts *facts) {
  (void)c;
  return sums[channel->index] / facts->spread.count;
}

static double divide_by_opacity(const np_channels *c, const np_channel *channel, const double *sums,
                                double where_none) {
  const double opaque = sums[c->opaque];
  return opaque > 0.0 ? sums[channel->index] / opaque : where_none;
}

/* Over what is not transparent; where nothing is there is no albedo and no place. */
static double finish_opaque(const np_channels *c, const np_channel *channel, const double *sums,
                            const np_pixel_facts *facts) {
  (void)facts;
  return divide_by_opacity(c, channel, sums, 0.0);
}

/* The same of a distance: where nothing is opaque all is infinitely far. */
static double finish_opaque_distance(const np_channels *c, const np_channel *channel, const double *sums,
                                     const np_pixel_facts *facts) {
  (void)facts;
  return divide_by_opacity(c, channel, sums, HUGE_VAL);
}

/* Where nothing is opaque nothing is in shadow. */
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

/* ---- Which there are ---- */

#define LIGHTS(some)                                                                                                   \
  { .read = read_light, .finish = finish_mean, .components = (some) }
#define LIGHT(component) LIGHTS(1u << (component))
#define BEFORE_GROUND(some)                                                                                            \
  { .read = read_before_ground, .finish = finish_mean, .components = (some) }
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
    [NP_AOV_INDEX_TRANSMITTANCE] = {.read = read_transmittance, .finish = finish_mean},
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
    [NP_AOV_INDEX_OPTICAL_DEPTH] = {.read = read_optical_depth, .finish = finish_mean},
};

static const np_channel_kind cloud_alpha = {.read = read_alpha, .finish = finish_mean, .alpha = NP_ALPHA_CLOUDS},
                             clouds_in_air = BEFORE_GROUND(NP_COMPONENTS_OF_CLOUDS | 1u << NP_COMPONENT_AIR),
                             opacity = {.read = read_opacity, .finish = finish_mean};

/* A sum; a channel of the picture too where it has a name. */
static void add(np_channels *c, const char *name, np_channel_kind kind, unsigned part) {
  const unsigned index = c->sum_count++;
  c->channel[index] = (np_channel){.kind = kind, .part = part, .index = index};
  if (!name) return;
  (void)snprintf(c->channel[index].name, sizeof c->channel[index].name, "%s", name);
  c->count = c->sum_count;
}

static np_channel_kind choose_kind(const np_channels *c, const np_scene_output *output, np_aov_index aov) {
  np_channel_kind kind = aov_kinds[aov];
  if (aov == NP_AOV_INDEX_CLOUDS && output->cloud_air == NP_CLOUD_AIR_KEPT) kind = clouds_in_air;
  kind.components &= c->beauty | ~(unsigned)NP_COMPONENTS_OF_BEAUTY;
  return kind;
}

static void add_aov(np_channels *c, const np_scene_output *output, np_aov_index aov) {
  const np_aov_row *row = &np_aov_rows[aov];
  const np_channel_kind kind = choose_kind(c, output, aov);
  char name[NP_CHANNEL_NAME_MAX];
  if (!*row->parts) add(c, row->name, kind, 0);
  for (unsigned part = 0; part < strlen(row->parts); part++) {
    (void)snprintf(name, sizeof name, "%s.%c", row->name, row->parts[part]);
    add(c, name, row->parts[part] == 'A' ? cloud_alpha : kind, part);
  }
}

/* What means are divided by. */
static void add_divisor(np_channels *c) {
  bool is_asked = false;
  for (unsigned i = 0; i < c->count; i++) is_asked = is_asked || c->channel[i].kind.is_over_opacity;
  c->opaque = is_asked ? c->sum_count : NP_CHANNEL_NONE;
  if (is_asked) add(c, NULL, opacity, 0);
}

/* What A covers: without its background, a picture is no more of the scene than clouds and ground. */
static np_channel_kind choose_alpha(const np_scene_output *output) {
  const bool is_whole = output->alpha == NP_ALPHA_SCENE && output->has_background;
  const np_scene_alpha alpha =
      output->alpha == NP_ALPHA_SCENE && !is_whole ? NP_ALPHA_CLOUDS_AND_GROUND : output->alpha;
  return (np_channel_kind){.read = read_alpha, .finish = finish_mean, .alpha = alpha};
}

void np_channels_choose(const np_plan *plan, const np_scene_output *output, np_channels *out) {
  static const char *const colors[] = {"R", "G", "B"};
  *out = (np_channels){.scale = (float)output->scale, .beauty = NP_COMPONENTS_OF_BEAUTY};
  if (!output->has_background) out->beauty &= ~(1u << NP_COMPONENT_BACKGROUND);
  for (unsigned band = 0; plan->has_beauty && band < NP_BAND_COUNT; band++)
    add(out, colors[band], (np_channel_kind)LIGHTS(out->beauty), band);
  add(out, "A", choose_alpha(output), 0);
  add(out, "Z", (np_channel_kind){.finish = finish_depth}, 0);
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (plan->aovs & ~(unsigned)NP_AOV_DEPTH & 1u << i) add_aov(out, output, (np_aov_index)i);
  add_divisor(out);
}

void np_channels_read(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                      float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->sum_count; i++) {
    const np_channel *channel = &channels->channel[i];
    out_values[i] = channel->kind.read ? channel->kind.read(channels, channel, ray, sample) : 0.0f;
  }
}

void np_channels_finish(const np_channels *channels, const double *sums, const np_pixel_facts *facts,
                        float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->count; i++) {
    const np_channel *channel = &channels->channel[i];
    out_values[i] = (float)channel->kind.finish(channels, channel, sums, facts);
  }
}

void np_spread_add(const np_channels *channels, const np_integrator_sample *sample, np_spread *spread) {
  spread->count++;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    const double x = (double)sum_components(channels, channels->beauty, b, sample), distance = x - spread->mean[b];
    spread->mean[b] += distance / spread->count;
    spread->squares[b] += distance * (x - spread->mean[b]);
  }
}

double np_spread_variance(const np_spread *spread, unsigned band) {
  return spread->count < 2 ? 0.0 : spread->squares[band] / spread->count / (spread->count - 1);
}
