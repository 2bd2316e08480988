/* SPDX-License-Identifier: Apache-2.0 */
/* Values of pixels that were not rendered, and of those that were and have a history. */
#include <assert.h>
#include <string.h>

#include "frame/reconstruction.h"

static size_t get_pixel_count(const np_reconstruction *r) { return (size_t)r->width * r->height; }

static void set_values(const np_reconstruction *r, size_t index, const float *values, float count) {
  for (unsigned c = 0; c < r->next.channel_count; c++) r->next.values[c * get_pixel_count(r) + index] = values[c];
  r->next.counts[index] = count;
}

static void get_rendered(const np_frame *f, size_t index, float *out_values) {
  for (unsigned c = 0; c < f->channels.count; c++) out_values[c] = f->planes[c][index];
}

/* ---- Likeness ---- */

/* Differences at which a neighbour's weight falls to 1/e: of relative distance and of opacity. */
static const float distance_scale = 0.05f, opacity_scale = 0.2f;

/* Similarity of two pixels by their guides, 0 to 1. */
static float compare_guides(const np_pixel_guide *to, const np_pixel_guide *from) {
  const bool is_cloud = np_pixel_guide_is_cloud(to);
  const float far =
      np_pixel_guide_compare(is_cloud ? to->cloud_m : to->behind_m, is_cloud ? from->cloud_m : from->behind_m);
  const float distance = far / distance_scale, opacity = (to->opacity - from->opacity) / opacity_scale;
  assert(to->opacity >= 0.0f && from->opacity >= 0.0f);
  if (!np_pixel_guide_has_same_around(from, to)) return 0.0f;
  return expf(-fminf(distance * distance + opacity * opacity, 60.0f));
}

static float tent(float x) { return fmaxf(1.0f - fabsf(x), 0.0f); }

/* ---- Clipping ---- */

/* Luma and differences of R, G and B (Malvar and Sullivan 2003, YCoCg), and coverage. */
static unsigned get_axes(const np_reconstruction *r, const float *values, float out[NP_HISTORY_AXES]) {
  if (!r->has_beauty) return out[0] = values[0], 1;
  out[0] = 0.25f * values[0] + 0.5f * values[1] + 0.25f * values[2];
  out[1] = 0.5f * (values[0] - values[2]);
  out[2] = 0.5f * values[1] - 0.25f * (values[0] + values[2]);
  out[3] = values[3];
  return NP_HISTORY_AXES;
}

enum { AROUND = 9 };

/* Rendered pixels near a pixel, with the weights of their similarity. */
typedef struct around {
  unsigned count;
  size_t index[AROUND];
  float weight[AROUND], sum;
} around;

/* Lists the rendered pixels of the square that holds a pixel, and of the eight squares around it. */
static void list_around(const np_reconstruction *r, unsigned x, unsigned y, around *out) {
  const np_pixel_lattice *lattice = &r->update;
  const np_pixel_guide *guides = r->next.guides;
  *out = (around){.count = 0};
  for (int k = 0; k < AROUND; k++) {
    const int across = ((int)(x / lattice->edge) + k % 3 - 1) * (int)lattice->edge + (int)lattice->at[0];
    const int down = ((int)(y / lattice->edge) + k / 3 - 1) * (int)lattice->edge + (int)lattice->at[1];
    if (across < 0 || down < 0 || across >= (int)r->width || down >= (int)r->height) continue;
    const size_t index = (size_t)down * r->width + (size_t)across;
    const float weight = compare_guides(&guides[(size_t)y * r->width + x], &guides[index]);
    out->index[out->count] = index;
    out->weight[out->count++] = weight;
    out->sum += weight;
  }
}

/* Deviations from the mean that history may have. */
static const float deviations = 1.5f;

/* Mean of one axis over rendered pixels, and most that history may be away from it. */
static float compute_mean(const around *near, float axes[AROUND][NP_HISTORY_AXES], unsigned axis, float *out_most) {
  float mean = 0.0f, square = 0.0f;
  for (unsigned i = 0; i < near->count; i++) mean += near->weight[i] / near->sum * axes[i][axis];
  for (unsigned i = 0; i < near->count; i++)
    square += near->weight[i] / near->sum * (axes[i][axis] - mean) * (axes[i][axis] - mean);
  *out_most = deviations * sqrtf(square);
  return mean;
}

/* Largest factor in [0, 1] on the history's difference from the mean that keeps it within the neighbours' deviation. */
static float compute_share(const np_frame *f, const float *history, const around *near) {
  float axes[AROUND][NP_HISTORY_AXES], own[NP_HISTORY_AXES], values[NP_HISTORY_AXES], share = 1.0f, most;
  const unsigned axis_count = get_axes(f->reconstruction, history, own);
  for (unsigned i = 0; i < near->count; i++) {
    for (unsigned c = 0; c < axis_count; c++) values[c] = f->planes[c][near->index[i]];
    (void)get_axes(f->reconstruction, values, axes[i]);
  }
  for (unsigned a = 0; a < axis_count; a++) {
    const float away = fabsf(own[a] - compute_mean(near, axes, a, &most));
    if (away > most) share = fminf(share, most / away);
  }
  return share;
}

/* Weight of alike pixels below which their deviation is not known. */
static const float around_min = 3.0f;

/* Moves the history towards the mean of rendered neighbours, all channels by one share, so that layers still sum to the
 * picture. */
static void clip(const np_frame *f, const around *near, float *history) {
  if (near->sum < around_min) return;
  const float share = compute_share(f, history, near);
  if (share >= 1.0f) return;
  for (unsigned c = 0; c < f->channels.count; c++) {
    float mean = 0.0f;
    for (unsigned i = 0; i < near->count; i++) mean += near->weight[i] / near->sum * f->planes[c][near->index[i]];
    history[c] = mean + share * (history[c] - mean);
  }
}

/* ---- Changes ---- */

/* Share of the change of rendered pixels that those around them take over: a third follows light and clouds best, for
 * edges of shadows are at other places than their neighbours'. */
static const float change_gain = 0.33f;

/* Weight of alike pixels up to which it is less. */
static const float change_weight = 0.5f;

static const np_reprojected *get_place(const np_reconstruction *r, size_t index) {
  return r->places && !r->is_cut && r->places[index].is_seen ? &r->places[index] : NULL;
}

static np_reprojection make_reprojection(const np_reconstruction *r) {
  return np_reprojection_make(r->before, &r->next.camera, r->next.guides, r->min, r->width, r->height);
}

void np_reconstruction_compare_row(const np_frame *f, unsigned y) {
  const np_reconstruction *r = f->reconstruction;
  const np_reprojection reprojection = make_reprojection(r);
  float history[NP_CHANNELS_MAX], count;
  for (unsigned x = r->update.at[0]; x < r->width && y % r->update.edge == r->update.at[1]; x += r->update.edge) {
    const size_t index = (size_t)y * r->width + x;
    const np_reprojected *place = get_place(r, index);
    if (!place) continue;
    np_reprojection_sample(&reprojection, place, history, &count);
    for (unsigned c = 0; c < r->next.channel_count; c++)
      r->changes[c * get_pixel_count(r) + index] = f->planes[c][index] - history[c];
  }
}

/* Adds to the history a share of the mean change of similar rendered neighbours. */
static void add_changes(const np_reconstruction *r, unsigned x, unsigned y, const around *near, float *history) {
  float weights[AROUND], sum = 0.0f;
  for (unsigned i = 0; i < near->count; i++) {
    const size_t index = near->index[i];
    const float edge = (float)r->update.edge;
    const float across = ((float)(index % r->width) - (float)x) / edge;
    const float down = ((float)(index / r->width) - (float)y) / edge;
    weights[i] = get_place(r, index) ? near->weight[i] * tent(across) * tent(down) : 0.0f;
    sum += weights[i];
  }
  for (unsigned i = 0; i < near->count; i++)
    for (unsigned c = 0; c < r->next.channel_count && weights[i] > 0.0f; c++)
      history[c] +=
          change_gain * weights[i] / fmaxf(sum, change_weight) * r->changes[c * get_pixel_count(r) + near->index[i]];
}

/* ---- History ---- */

static void average(const np_reconstruction *r, const float *history, float *count, float *rendered) {
  const float weight = fmaxf(1.0f / (*count + 1.0f), (float)r->weight_min);
  for (unsigned c = 0; c < r->next.channel_count && weight < 1.0f; c++)
    rendered[c] = history[c] + weight * (rendered[c] - history[c]);
  *count += 1.0f;
}

static void blend_pixel(const np_frame *f, const np_reprojection *reprojection, unsigned x, unsigned y) {
  const np_reconstruction *r = f->reconstruction;
  const size_t index = (size_t)y * r->width + x;
  const np_reprojected *place = get_place(r, index);
  float history[NP_CHANNELS_MAX], values[NP_CHANNELS_MAX], count = 0.0f;
  if (place) {
    np_reprojection_sample(reprojection, place, history, &count);
    if (r->changes) {
      around near;
      list_around(r, x, y, &near);
      add_changes(r, x, y, &near, history);
      clip(f, &near, history);
    }
  }
  if (!np_reconstruction_is_rendered(r, index)) {
    set_values(r, index, history, count);
    return;
  }
  get_rendered(f, index, values);
  if (place)
    average(r, history, &count, values);
  else
    count = 1.0f;
  set_values(r, index, values, count);
}

void np_reconstruction_blend_row(const np_frame *f, unsigned y) {
  const np_reconstruction *r = f->reconstruction;
  np_reprojection reprojection = {.width = r->width};
  if (r->before) reprojection = make_reprojection(r);
  for (unsigned x = 0; x < r->width; x++)
    if (r->sources[(size_t)y * r->width + x] != NP_PIXEL_INTERPOLATED) blend_pixel(f, &reprojection, x, y);
}

/* ---- Interpolation ---- */

/* Bilinear weight of a pixel of the resolution's lattice at an offset in pixels. */
static float get_weight(const np_reconstruction *r, int across, int down) {
  const float edge = (float)r->resolution.edge;
  return tent((float)across / edge) * tent((float)down / edge);
}

/* Sum of the weights of similar neighbours below which a pixel is rendered instead of interpolated. */
static const float alike_min = 0.05f;

/* Weight of the alike neighbours of a pixel: of the resolution's lattice, or all that have values, which are added up.
 */
static float sum_alike(const np_reconstruction *r, unsigned x, unsigned y, bool is_of_lattice, float *values) {
  const int reach = (int)r->resolution.edge - 1;
  const np_pixel_guide *guides = r->next.guides, *guide = &guides[(size_t)y * r->width + x];
  float sum = 0.0f;
  for (int k = 0; k < (2 * reach + 1) * (2 * reach + 1); k++) {
    const int across = k % (2 * reach + 1) - reach, down = k / (2 * reach + 1) - reach;
    const int column = (int)x + across, row = (int)y + down;
    if (column < 0 || row < 0 || column >= (int)r->width || row >= (int)r->height) continue;
    const size_t near = (size_t)row * r->width + (size_t)column;
    if (is_of_lattice ? !np_pixel_lattice_has(&r->resolution, (unsigned)column, (unsigned)row)
                      : r->sources[near] == NP_PIXEL_INTERPOLATED)
      continue;
    const float weight = get_weight(r, across, down) * compare_guides(guide, &guides[near]);
    for (unsigned c = 0; c < r->next.channel_count && !is_of_lattice && weight > 0.0f; c++)
      values[c] += weight * r->next.values[c * get_pixel_count(r) + near];
    sum += weight;
  }
  return sum;
}

bool np_reconstruction_has_alike(const np_reconstruction *r, unsigned x, unsigned y) {
  return sum_alike(r, x, y, true, NULL) >= alike_min;
}

static void interpolate_pixel(const np_reconstruction *r, unsigned x, unsigned y) {
  float values[NP_CHANNELS_MAX] = {0};
  const float sum = sum_alike(r, x, y, false, values);
  for (unsigned c = 0; c < r->next.channel_count; c++) values[c] /= sum;
  set_values(r, (size_t)y * r->width + x, values, 0.0f);
}

void np_reconstruction_interpolate_row(const np_frame *f, unsigned y) {
  const np_reconstruction *r = f->reconstruction;
  for (unsigned x = 0; x < r->width; x++)
    if (r->sources[(size_t)y * r->width + x] == NP_PIXEL_INTERPOLATED) interpolate_pixel(r, x, y);
}
