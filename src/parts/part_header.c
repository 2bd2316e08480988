/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_header.h"

#include <limits.h>
#include <stddef.h>
#include <string.h>

void np_part_header_set_display(np_part_header *header, const np_image_header *image) {
  for (int k = 0; k < 2; k++) {
    header->display_min[k] = image->display_min[k];
    header->display_max[k] = image->display_max[k] == INT_MAX ? INT_MAX : image->display_max[k] + 1;
  }
}

unsigned np_part_header_count_reals(const np_part_header *header) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  const unsigned sets = header->is_complete ? 1 : np_film_list_nodes(header->sample_begin, header->sample_end, nodes);
  return NP_PART_RECORD_NUMBERS + sets * np_channels_count_numbers(&header->channels);
}

void np_part_record_begin(const np_part_header *header, np_film_accumulator *accumulator) {
  np_film_accumulator_begin_moments(accumulator, header->channels.sum_count + NP_PIXEL_SUMS_OWN, NP_BAND_COUNT,
                                    header->sample_begin);
}

bool np_part_record_add(const np_part_header *header, const double *record, np_film_accumulator *accumulator) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  const unsigned count = np_film_list_nodes(header->sample_begin, header->sample_end, nodes);
  const double *numbers = record + NP_PART_RECORD_NUMBERS;
  for (unsigned n = 0; n < count; n++, numbers += np_channels_count_numbers(&header->channels)) {
    nodes[n].sums = numbers;
    if (!np_film_accumulator_add_node(accumulator, &nodes[n])) return false;
  }
  return true;
}

/* ---- Whether two are of one picture: the hash alone says so, but for forged files ---- */

/* Members that are compared bit by bit; none of them has padding. */
#define MEMBER(name, member)                                                                                           \
  { name, offsetof(np_part_header, member), sizeof(((np_part_header *)0)->member) }

static const struct {
  const char *name;
  size_t at, size;
} members[] = {
    MEMBER("whole window", whole_min),
    MEMBER("whole window", whole_max),
    MEMBER("display window", display_min),
    MEMBER("display window", display_max),
    MEMBER("samples", sample_count),
    MEMBER("pixel type", pixel_type),
    MEMBER("scatterings", scattering_max),
    MEMBER("target error", target_error),
    MEMBER("dim", dim),
    MEMBER("lost share", lost_share),
    MEMBER("channels: number", channels.count),
    MEMBER("channels: number of sums", channels.sum_count),
    MEMBER("channels: opacity", channels.opaque),
    MEMBER("channels: first matte", channels.mattes),
    MEMBER("channels: number of mattes", channels.matte_count),
    MEMBER("channels: matte identifiers", channels.matte_ids),
    MEMBER("channels: scale", channels.scale),
};

static const char *compare_channel(const np_channel *a, const np_channel *b) {
  if (strcmp(a->name, b->name) != 0) return "channels: name";
  if (a->kind.finish != b->kind.finish) return "channels: rule";
  if (a->part != b->part) return "channels: part";
  return a->index != b->index ? "channels: sum" : NULL;
}

const char *np_part_header_compare(const np_part_header *a, const np_part_header *b) {
  for (size_t i = 0; i < sizeof members / sizeof *members; i++)
    if (memcmp((const char *)a + members[i].at, (const char *)b + members[i].at, members[i].size) != 0)
      return members[i].name;
  const char *field = NULL;
  for (unsigned i = 0; i < a->channels.count && !field; i++)
    field = compare_channel(&a->channels.channel[i], &b->channels.channel[i]);
  return field;
}
