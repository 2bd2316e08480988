/* SPDX-License-Identifier: Apache-2.0 */
/* IEEE binary16: conversion by F16C where the compilation level has it, by integer arithmetic elsewhere, with the same
 * bits out of both: round to nearest even, subnormal halves kept, overflow to infinity, NaN stays NaN. */
#ifndef NP_CORE_HALF_H
#define NP_CORE_HALF_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <nephos/context.h>

#if defined(__F16C__)
#include <immintrin.h>
#endif

static inline float np_half_to_float(uint16_t half) {
#if defined(__F16C__)
  return _cvtsh_ss(half);
#else
  uint32_t sign = (uint32_t)(half & 0x8000u) << 16, magnitude = half & 0x7fffu, bits;
  if (magnitude >= 0x7c00u) {
    bits = sign | 0x7f800000u | (magnitude & 0x3ffu) << 13;
  } else if (magnitude >= 0x400u) {
    bits = sign | ((magnitude << 13) + ((127u - 15u) << 23));
  } else {
    /* Subnormal: magnitude · 2⁻²⁴, exact in a normal float. */
    float value = (float)magnitude * 0x1p-24f;
    memcpy(&bits, &value, sizeof bits);
    bits |= sign;
  }
  float result;
  memcpy(&result, &bits, sizeof result);
  return result;
#endif
}

static inline uint16_t np_half_from_float(float value) {
#if defined(__F16C__)
  return (uint16_t)_cvtss_sh(value, _MM_FROUND_TO_NEAREST_INT);
#else
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return (uint16_t)(sign | 0x7e00u | (magnitude >> 13 & 0x1ffu));
  if (magnitude >= 0x477ff000u) return (uint16_t)(sign | 0x7c00u); /* ≥ 65520 rounds to infinity */
  if (magnitude >= 0x38800000u) {
    uint32_t rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
    return (uint16_t)(sign | ((rounded - ((127u - 15u) << 23)) >> 13));
  }
  if (magnitude < 0x33000000u) return (uint16_t)sign; /* less than half of the least subnormal */
  uint32_t shift = 126u - (magnitude >> 23), mantissa = (magnitude & 0x7fffffu) | 0x800000u;
  uint32_t kept = mantissa >> shift, rest = mantissa & ((1u << shift) - 1u), middle = 1u << (shift - 1u);
  if (rest > middle || (rest == middle && (kept & 1u))) kept++;
  return (uint16_t)(sign | kept);
#endif
}

/* Encodes values times a factor as halves, by the kernel of an instruction-set level. */
void np_half_encode(neph_isa isa, const float *values, size_t count, float factor, uint16_t *out_halves);

void np_half_encode_v1(const float *values, size_t count, float factor, uint16_t *out_halves);
void np_half_encode_v3(const float *values, size_t count, float factor, uint16_t *out_halves);
void np_half_encode_v4(const float *values, size_t count, float factor, uint16_t *out_halves);

#endif
