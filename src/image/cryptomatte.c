/* SPDX-License-Identifier: Apache-2.0 */
#include "image/cryptomatte.h"

#include <string.h>

#include "core/alloc.h"
#include "core/json.h"
#include "core/text.h"

const char np_cryptomatte_name[] = "CryptoObject";

/* ---- Hashes ---- */

static uint32_t rotate(uint32_t x, int bits) { return x << bits | x >> (32 - bits); }

static uint32_t scramble(uint32_t block) { return rotate(block * 0xcc9e2d51u, 15) * 0x1b873593u; }

static uint32_t read_block(const unsigned char *bytes, size_t count) {
  uint32_t block = 0;
  for (size_t i = 0; i < count; i++) block |= (uint32_t)bytes[i] << 8 * i;
  return block;
}

uint32_t np_murmur_hash(const char *text) {
  const unsigned char *bytes = (const unsigned char *)text;
  const size_t length = strlen(text), whole = length & ~(size_t)3;
  uint32_t h = 0;
  for (size_t i = 0; i < whole; i += 4) h = rotate(h ^ scramble(read_block(bytes + i, 4)), 13) * 5u + 0xe6546b64u;
  h ^= scramble(read_block(bytes + whole, length - whole));
  h ^= (uint32_t)length;
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  return h ^ h >> 16;
}

/* Exponents 0 and 255, of subnormal, infinite and NaN, are excluded. */
float np_cryptomatte_get_id(const char *name) {
  uint32_t hash = np_murmur_hash(name);
  const uint32_t exponent = hash >> 23 & 255u;
  if (exponent == 0 || exponent == 255) hash ^= 1u << 23;
  float id;
  memcpy(&id, &hash, sizeof id);
  return id;
}

void np_cryptomatte_name_channel(unsigned channel, char *out, size_t size) {
  np_print(out, size, "%s%02u.%c", np_cryptomatte_name, channel / 4, "RGBA"[channel % 4]);
}

/* ---- Header ---- */

static neph_result set_attribute(neph_image *image, const char *name, const char *value) {
  char key[64], hash[9];
  np_print(hash, sizeof hash, "%08x", np_murmur_hash(np_cryptomatte_name));
  np_print(key, sizeof key, "cryptomatte/%.7s/%s", hash, name);
  return neph_image_set_attribute(image, key, value);
}

/* Removes the indentation; line breaks within texts are escaped already. */
static void write_on_one_line(char *text) {
  char *out = text;
  while (*text) {
    if (*text == '\n')
      text += 1 + strspn(text + 1, " ");
    else
      *out++ = *text++;
  }
  *out = '\0';
}

static neph_result write_manifest(neph_image *image, const char *const *names, unsigned count) {
  char *text = NULL;
  np_json *json = np_json_create(image->context);
  for (unsigned i = 0; i < count; i++) {
    const float id = np_cryptomatte_get_id(names[i]);
    uint32_t bits;
    char hex[9];
    memcpy(&bits, &id, sizeof bits);
    np_print(hex, sizeof hex, "%08x", bits);
    np_json_put_text(json, names[i], hex);
  }
  neph_result result = np_json_finish(json, &text);
  if (!result) write_on_one_line(text);
  if (!result) result = set_attribute(image, "manifest", text);
  np_alloc_free(image->context, text);
  return result;
}

neph_result np_cryptomatte_write_header(neph_image *image, const char *const *names, unsigned count) {
  neph_result result = set_attribute(image, "name", np_cryptomatte_name);
  if (!result) result = set_attribute(image, "hash", "MurmurHash3_32");
  if (!result) result = set_attribute(image, "conversion", "uint32_to_float32");
  return result ? result : write_manifest(image, names, count);
}
