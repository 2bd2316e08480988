/* SPDX-License-Identifier: Apache-2.0 */
#include "render/channels.h"

static void add(np_channels *c, const char *name, np_channel_source source, unsigned part) {
  c->channel[c->count++] = (np_channel){.name = name, .source = source, .part = part};
}

static void add_triple(np_channels *c, const char *const names[3], np_channel_source source) {
  for (unsigned part = 0; part < 3; part++) add(c, names[part], source, part);
}

static void add_components(np_channels *c, const char *const names[NP_BAND_COUNT], unsigned components) {
  add_triple(c, names, NP_CHANNEL_COMPONENTS);
  for (unsigned b = 1; b <= NP_BAND_COUNT; b++) c->channel[c->count - b].components = components;
}

static void add_light(np_channels *c, unsigned aovs) {
  static const struct {
    np_aov aov;
    np_component component;
    const char *names[NP_BAND_COUNT];
  } layers[] = {
      {NP_AOV_BACKGROUND, NP_COMPONENT_BACKGROUND, {"background.R", "background.G", "background.B"}},
      {NP_AOV_TERRAIN, NP_COMPONENT_TERRAIN, {"terrain.R", "terrain.G", "terrain.B"}},
      {NP_AOV_AIR, NP_COMPONENT_AIR, {"air.R", "air.G", "air.B"}},
      {NP_AOV_SUN, NP_COMPONENT_SUN, {"sun.R", "sun.G", "sun.B"}},
      {NP_AOV_SKY, NP_COMPONENT_SKY, {"sky.R", "sky.G", "sky.B"}},
      {NP_AOV_GROUND, NP_COMPONENT_GROUND, {"ground.R", "ground.G", "ground.B"}},
      {NP_AOV_MULTIPLE, NP_COMPONENT_MULTIPLE, {"multiple.R", "multiple.G", "multiple.B"}},
      {NP_AOV_EMISSION, NP_COMPONENT_EMISSION, {"emission.R", "emission.G", "emission.B"}},
  };
  for (size_t i = 0; i < sizeof layers / sizeof *layers; i++)
    if (aovs & layers[i].aov) add_components(c, layers[i].names, c->beauty & 1u << layers[i].component);
}

void np_channels_choose(const np_plan *plan, bool has_background, float scale, np_channels *out) {
  static const char *const beauty[] = {"R", "G", "B"}, *const albedo[] = {"albedo.R", "albedo.G", "albedo.B"};
  static const char *const position[] = {"position.X", "position.Y", "position.Z"};
  static const char *const variance[] = {"variance.R", "variance.G", "variance.B"};
  static const char *const error[] = {"standard_error.R", "standard_error.G", "standard_error.B"};
  const unsigned all = (1u << NP_COMPONENT_COUNT) - 1u, aovs = plan->aovs;
  *out = (np_channels){.scale = scale, .beauty = has_background ? all : all & ~(1u << NP_COMPONENT_BACKGROUND)};
  if (plan->has_beauty) add_components(out, beauty, out->beauty);
  out->alpha = out->count;
  add(out, "A", NP_CHANNEL_ALPHA, 0);
  add(out, "Z", NP_CHANNEL_DEPTH, 0);
  add_light(out, aovs);
  if (aovs & NP_AOV_TRANSMITTANCE) add(out, "transmittance", NP_CHANNEL_TRANSMITTANCE, 0);
  if (aovs & NP_AOV_ALBEDO) add_triple(out, albedo, NP_CHANNEL_ALBEDO);
  if (aovs & NP_AOV_STANDARD_ERROR) add_triple(out, error, NP_CHANNEL_STANDARD_ERROR);
  if (aovs & NP_AOV_VARIANCE) add_triple(out, variance, NP_CHANNEL_VARIANCE);
  if (aovs & NP_AOV_SAMPLE_COUNT) add(out, "sample_count", NP_CHANNEL_SAMPLE_COUNT, 0);
  if (aovs & NP_AOV_DISTANCE) add(out, "distance", NP_CHANNEL_DISTANCE, 0);
  if (aovs & NP_AOV_MEAN_DISTANCE) add(out, "mean_distance", NP_CHANNEL_MEAN_DISTANCE, 0);
  if (aovs & NP_AOV_POSITION) add_triple(out, position, NP_CHANNEL_POSITION);
}

static float sum_components(const np_channels *c, unsigned components, unsigned band,
                            const np_integrator_sample *sample) {
  float sum = 0.0f;
  for (unsigned i = 0; i < NP_COMPONENT_COUNT; i++)
    if (components & 1u << i) sum += sample->component[i].band[band];
  return sum * c->scale;
}

static float find_alpha(const np_integrator_sample *sample) {
  return sample->is_ground_behind ? 1.0f : 1.0f - sample->transmittance;
}

static float find_position(const np_camera_ray *ray, const np_integrator_sample *sample, unsigned axis) {
  const double origin[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
  const float direction[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
  return (float)(origin[axis] * (double)find_alpha(sample)) + direction[axis] * sample->opaque_distance;
}

static float read_channel(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                          const np_integrator_sample *sample) {
  switch (channel->source) {
  case NP_CHANNEL_COMPONENTS:
    return sum_components(c, channel->components, channel->part, sample);
  case NP_CHANNEL_ALPHA:
    return find_alpha(sample);
  case NP_CHANNEL_TRANSMITTANCE:
    return sample->transmittance;
  case NP_CHANNEL_ALBEDO:
    return sample->opaque_albedo.band[channel->part];
  case NP_CHANNEL_MEAN_DISTANCE:
    return sample->opaque_distance;
  case NP_CHANNEL_POSITION:
    return find_position(ray, sample, channel->part);
  case NP_CHANNEL_DEPTH:
  case NP_CHANNEL_DISTANCE:
  case NP_CHANNEL_VARIANCE:
  case NP_CHANNEL_STANDARD_ERROR:
  case NP_CHANNEL_SAMPLE_COUNT:
    break;
  }
  return 0.0f;
}

void np_channels_read(const np_channels *channels, const np_camera_ray *ray, const np_integrator_sample *sample,
                      float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->count; i++)
    out_values[i] = read_channel(channels, &channels->channel[i], ray, sample);
}

/* Where nothing is opaque there is no albedo and no place, and all is infinitely far. */
static double finish_channel(const np_channel *channel, double sum, double opaque, const np_pixel_facts *facts) {
  switch (channel->source) {
  case NP_CHANNEL_ALBEDO:
  case NP_CHANNEL_POSITION:
    return opaque > 0.0 ? sum / opaque : 0.0;
  case NP_CHANNEL_MEAN_DISTANCE:
    return opaque > 0.0 ? sum / opaque : HUGE_VAL;
  case NP_CHANNEL_DEPTH:
    return facts->depth;
  case NP_CHANNEL_DISTANCE:
    return facts->distance;
  case NP_CHANNEL_VARIANCE:
    return np_spread_variance(&facts->spread, channel->part);
  case NP_CHANNEL_STANDARD_ERROR:
    return sqrt(np_spread_variance(&facts->spread, channel->part));
  case NP_CHANNEL_SAMPLE_COUNT:
    return facts->spread.count;
  case NP_CHANNEL_COMPONENTS:
  case NP_CHANNEL_ALPHA:
  case NP_CHANNEL_TRANSMITTANCE:
    break;
  }
  return sum / facts->spread.count;
}

void np_channels_finish(const np_channels *channels, const double *sums, const np_pixel_facts *facts,
                        float out_values[NP_CHANNELS_MAX]) {
  for (unsigned i = 0; i < channels->count; i++)
    out_values[i] = (float)finish_channel(&channels->channel[i], sums[i], sums[channels->alpha], facts);
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
