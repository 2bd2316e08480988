/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that the header of a part keeps: each field alone, and beside the others. Checksums guard against damage, not
 * against forgery: nothing is allocated or divided by a field before it is checked here. Each
 * function returns false and notes the fault, with the field, its value and the values that are allowed. */
#ifndef NP_PARTS_PART_RULES_H
#define NP_PARTS_PART_RULES_H

#include "parts/part_fault.h"
#include "parts/part_header.h"

/* Numbers of channels and of their sums, before the channels are read. */
bool np_part_rules_check_sums(const np_channels *channels, np_part_fault *fault);

/* Flags in the bytes of a np_image_header. */
bool np_part_rules_check_flags(const unsigned char *bytes, np_part_fault *fault);

/* All fields of a header, which has its display window but no image yet. */
bool np_part_rules_check(const np_part_header *header, np_part_fault *fault);

/* The place of a part in its picture alone: windows, columns, tile and rows, and a picture of `channel_count`. */
bool np_part_rules_check_place(const np_part_header *header, unsigned channel_count, np_part_fault *fault);

/* Windows and matrices of the image. */
bool np_part_rules_check_image(const np_part_header *header, const np_image_header *image, np_part_fault *fault);

bool np_part_rules_check_attribute_count(uint32_t count, np_part_fault *fault);

/* An attribute before it is set. */
bool np_part_rules_check_attribute(const neph_image *image, uint32_t type, double number, const char *name,
                                   np_part_fault *fault);

/* Whether a text is a scene's hash, of 32 digits. */
bool np_part_rules_check_hash(const char *hash, np_part_fault *fault);

/* The record of a pixel that is rendered: a number of samples that the header allows, counts and squares that are not
 * negative. */
bool np_part_rules_check_record(const np_part_header *header, const double *record, np_part_fault *fault);

#endif
