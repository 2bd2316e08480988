/* SPDX-License-Identifier: Apache-2.0 */
#include "render/channels.h"

#include <stdio.h>
#include <string.h>

/* ---- What a sample adds ---- */

static float sum_components(const np_channels *c, unsigned components, unsigned band,
                            const np_integrator_sample *sample) {
  float sum = 0.0f;
  for (unsigned i = 0; i < NP_COMPONENT_COUNT; i++)
    if (components & 1u << i) sum += sample->component[i].band[band];
  return sum * c->scale;
}

static float compute_alpha(const np_integrator_sample *sample) {
  return sample->is_ground_behind ? 1.0f : 1.0f - sample->transmittance;
}

static float read_light(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)ray;
  return sum_components(c, channel->kind.components, channel->part, sample);
}

static float read_alpha(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  (void)c, (void)channel, (void)ray;
  return compute_alpha(sample);
}

static float read_transmittance(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                                const np_integrator_sample *sample) {
  (void)c, (void)channel, (void)ray;
  return sample->transmittance;
}

static float read_albedo(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                         const np_integrator_sample *sample) {
  (void)c, (void)ray;
  return sample->opaque_albedo.band[channel->part];
}

static float read_distance(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                           const np_integrator_sample *sample) {
  (void)c, (void)channel;
  return (float)(ray->begin_m * (double)compute_alpha(sample)) + sample->opaque_distance;
}

static float read_position(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                           const np_integrator_sample *sample) {
  (void)c;
  const double origin[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
  const float direction[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
  const unsigned axis = channel->part;
  return (float)(origin[axis] * (double)compute_alpha(sample)) + direction[axis] * sample->opaque_distance;
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

static double finish_mean(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)channel, (void)opaque;
  return sum / facts->spread.count;
}

/* Over what is not transparent; where nothing is there is no albedo and no place. */
static double finish_opaque(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)channel, (void)facts;
  return opaque > 0.0 ? sum / opaque : 0.0;
}

/* The same of a distance: where nothing is opaque all is infinitely far. */
static double finish_opaque_distance(const np_channel *channel, double sum, double opaque,
                                     const np_pixel_facts *facts) {
  (void)channel, (void)facts;
  return opaque > 0.0 ? sum / opaque : HUGE_VAL;
}

/* A pixel without anything opaque has no shadow. */
static double finish_opaque_share(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)channel, (void)facts;
  return opaque > 0.0 ? sum / opaque : 1.0;
}

static double finish_depth(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)channel, (void)sum, (void)opaque;
  return facts->depth;
}

static double finish_distance(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)channel, (void)sum, (void)opaque;
  return facts->distance;
}

static double finish_variance(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)sum, (void)opaque;
  return np_spread_variance(&facts->spread, channel->part);
}

static double finish_error(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  return sqrt(finish_variance(channel, sum, opaque, facts));
}

static double finish_count(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  (void)channel, (void)sum, (void)opaque;
  return facts->spread.count;
}

/* ---- Which there are ---- */

#define LIGHT(component)                                                                                               \
  { read_light, finish_mean, 1u << (component) }

static const np_channel_kind aov_kinds[NP_AOV_COUNT] = {
    [NP_AOV_INDEX_BACKGROUND] = LIGHT(NP_COMPONENT_BACKGROUND),
    [NP_AOV_INDEX_TERRAIN] = LIGHT(NP_COMPONENT_TERRAIN),
    [NP_AOV_INDEX_AIR] = LIGHT(NP_COMPONENT_AIR),
    [NP_AOV_INDEX_SUN] = LIGHT(NP_COMPONENT_SUN),
    [NP_AOV_INDEX_SKY] = LIGHT(NP_COMPONENT_SKY),
    [NP_AOV_INDEX_GROUND] = LIGHT(NP_COMPONENT_GROUND),
    [NP_AOV_INDEX_MULTIPLE] = LIGHT(NP_COMPONENT_MULTIPLE),
    [NP_AOV_INDEX_EMISSION] = LIGHT(NP_COMPONENT_EMISSION),
    [NP_AOV_INDEX_TRANSMITTANCE] = {read_transmittance, finish_mean, 0},
    [NP_AOV_INDEX_DISTANCE] = {NULL, finish_distance, 0},
    [NP_AOV_INDEX_STANDARD_ERROR] = {NULL, finish_error, 0},
    [NP_AOV_INDEX_VARIANCE] = {NULL, finish_variance, 0},
    [NP_AOV_INDEX_SAMPLE_COUNT] = {NULL, finish_count, 0},
    [NP_AOV_INDEX_ALBEDO] = {read_albedo, finish_opaque, 0},
    [NP_AOV_INDEX_MEAN_DISTANCE] = {read_distance, finish_opaque_distance, 0},
    [NP_AOV_INDEX_POSITION] = {read_position, finish_opaque, 0},
    [NP_AOV_INDEX_NORMAL] = {read_normal, finish_opaque, 0},
    [NP_AOV_INDEX_SHADOW] = {read_sun_share, finish_opaque_share, 0},
};

static void add(np_channels *c, const char *name, np_channel_kind kind, unsigned part) {
  np_channel *channel = &c->channel[c->count++];
  *channel = (np_channel){.kind = kind, .part = part};
  (void)snprintf(channel->name, sizeof channel->name, "%s", name);
}

static void add_aov(np_channels *c, np_aov_index aov) {
  const np_aov_row *row = &np_aov_rows[aov];
  np_channel_kind kind = aov_kinds[aov];
  kind.components &= c->beauty;
  char name[NP_CHANNEL_NAME_MAX];
  if (!*row->parts) add(c, row->name, kind, 0);
  for (unsigned part = 0; part < strlen(row->parts); part++) {
    (void)snprintf(name, sizeof name, "%s.%c", row->name, row->parts[part]);
    add(c, name, kind, part);
  }
}

void np_channels_choose(const np_plan *plan, bool has_background, float scale, np_channels *out) {
  static const char *const colors[] = {"R", "G", "B"};
  const unsigned all = (1u << NP_COMPONENT_COUNT) - 1u;
  *out = (np_channels){.scale = scale, .beauty = has_background ? all : all & ~(1u << NP_COMPONENT_BACKGROUND)};
  for (unsigned band = 0; plan->has_beauty && band < NP_BAND_COUNT; band++)
    add(out, colors[band], (np_channel_kind){read_light, finish_mean, out->beauty}, band);
  out->alpha = out->count;
  add(out, "A", (np_channel_kind){read_alpha, finish_mean, 0}, 0);
  add(out, "Z", (np_channel_kind){NULL, finish_depth, 0}, 0);
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (plan->aovs & ~(unsigned)NP_AOV_DEPTH & 1u << i) add_aov(out, (np_aov_index)i);
}

void np_channels_read(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                      float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->count; i++) {
    const np_channel *channel = &channels->channel[i];
    out_values[i] = channel->kind.read ? channel->kind.read(channels, channel, ray, sample) : 0.0f;
  }
}

void np_channels_finish(const np_channels *channels, const double *sums, const np_pixel_facts *facts,
                        float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->count; i++) {
    const np_channel *channel = &channels->channel[i];
    out_values[i] = (float)channel->kind.finish(channel, sums[i], sums[channels->alpha], facts);
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
