/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/channel_mattes.h"

#include "core/text.h"
#include "image/cryptomatte.h"

static unsigned count_mattes(const neph_scene *scene) { return scene->cloud_count + 1; }

static const char *get_name(const neph_scene *scene, unsigned matte) {
  return matte < scene->cloud_count ? scene->clouds[matte].name : NP_GROUND_MATTE;
}

/* ---- Mattes ---- */

static float read_matte(const np_channels *c, const np_channel *channel, const np_camera_ray *ray,
                        const np_integrator_sample *sample) {
  if (channel->part + 1 < c->matte_count) return ray->layers->cloud_opacity[channel->part];
  return sample->is_ground_behind && !c->is_ground_held_out ? sample->transmittance : 0.0f;
}

static const np_channel_kind matte = {.read = read_matte, .finish = np_channel_finish_mean};

static void add_sums(np_channels *c, const neph_scene *scene, bool are_shown) {
  char name[NP_CHANNEL_NAME_MAX];
  c->mattes = c->sum_count;
  c->matte_count = count_mattes(scene);
  for (unsigned i = 0; i < c->matte_count; i++) {
    np_print(name, sizeof name, "matte.%s", get_name(scene, i));
    np_channels_add(c, are_shown ? name : NULL, matte, i);
  }
}

void np_channels_add_mattes(np_channels *c, const neph_scene *scene) { add_sums(c, scene, true); }

/* ---- Cryptomatte ---- */

/* Number of the matte with the given rank: mattes are sorted by descending coverage, then by number. */
static unsigned search_rank(const np_channels *c, const double *sums, unsigned rank) {
  unsigned best = 0;
  for (unsigned i = 0; i < c->matte_count; i++) {
    unsigned before = 0;
    for (unsigned k = 0; k < c->matte_count; k++)
      before += sums[c->mattes + k] > sums[c->mattes + i] || (sums[c->mattes + k] == sums[c->mattes + i] && k < i);
    if (before == rank) best = i;
  }
  return best;
}

double np_channel_finish_rank(const np_channels *c, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts) {
  const unsigned rank = channel->part / 2, best = search_rank(c, sums, rank);
  const double coverage = rank < c->matte_count ? sums[c->mattes + best] / facts->spread.count : 0.0;
  if (!(coverage > 0.0)) return 0.0;
  return channel->part % 2 ? coverage : (double)c->matte_ids[best];
}

void np_channels_add_cryptomatte(np_channels *c) {
  char name[NP_CHANNEL_NAME_MAX];
  for (unsigned i = 0; i < NP_CRYPTOMATTE_CHANNELS; i++) {
    np_cryptomatte_name_channel(i, name, sizeof name);
    np_channels_add(c, name, (np_channel_kind){.finish = np_channel_finish_rank}, i);
  }
}

void np_channels_add_cryptomatte_sums(np_channels *c, const neph_scene *scene) {
  if (c->matte_count == 0) add_sums(c, scene, false);
  for (unsigned i = 0; i < c->matte_count; i++) c->matte_ids[i] = np_cryptomatte_get_id(get_name(scene, i));
}

neph_result np_channels_write_manifest(const neph_scene *scene, neph_image *image) {
  const char *names[NP_INSTANCES_MAX + 1];
  for (unsigned i = 0; i < count_mattes(scene); i++) names[i] = get_name(scene, i);
  return np_cryptomatte_write_header(image, names, count_mattes(scene));
}
