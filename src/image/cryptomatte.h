/* SPDX-License-Identifier: Apache-2.0 */
/* Names, identifiers and header of a Cryptomatte (Friedman and Jones 2015; Psyop's specification 1.2): objects by the
 * hash of their names, in pairs of identifier and coverage ranked by coverage. */
#ifndef NP_IMAGE_CRYPTOMATTE_H
#define NP_IMAGE_CRYPTOMATTE_H

#include "image/image_private.h"

/* Ranks of a pixel, two in each layer's R, G, B and A. */
enum { NP_CRYPTOMATTE_RANKS = 6, NP_CRYPTOMATTE_CHANNELS = 2 * NP_CRYPTOMATTE_RANKS };

/* Name of the matte, the prefix of its channels before the number of the layer: "CryptoObject00.R". */
extern const char np_cryptomatte_name[];

/* Name of the ground's matte; other mattes have the names of clouds. */
#define NP_GROUND_MATTE "ground"

/* MurmurHash3_x86_32 with seed 0 (Appleby 2011, public domain). */
uint32_t np_murmur_hash(const char *text);

/* The identifier of a name: its hash as the bits of a float that is neither subnormal nor infinite nor NaN. */
float np_cryptomatte_get_id(const char *name);

/* Prints the name of a channel. */
void np_cryptomatte_name_channel(unsigned channel, char *out, size_t size);

/* Writes the attributes that describe the channels, and the manifest of the names. */
neph_result np_cryptomatte_write_header(neph_image *image, const char *const *names, unsigned count);

#endif
