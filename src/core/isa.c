/* SPDX-License-Identifier: Apache-2.0 */
/* Instruction-set levels of the x86-64 psABI (section 3.1.1, table 3.1), from the processor's CPUID and, as wider
 * registers must be saved, from the operating system. */
#include "core/isa.h"

#include <cpuid.h>

typedef struct cpu_features {
  unsigned leaf1_ecx, leaf7_ebx, extended_ecx;
  uint64_t saved_state; /* XCR0: register files that the operating system saves */
} cpu_features;

/* Value of XCR0. Call it only when CPUID says that the operating system has enabled XSAVE. */
static uint64_t read_xcr0(void) {
  uint32_t low, high;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return (uint64_t)high << 32 | low;
}

static cpu_features read_features(void) {
  cpu_features features = {0, 0, 0, 0};
  unsigned eax, ebx, ecx, edx;
  if (__get_cpuid(1, &eax, &ebx, &ecx, &edx)) features.leaf1_ecx = ecx;
  if (__get_cpuid_count(7, 0, &eax, &ebx, &ecx, &edx)) features.leaf7_ebx = ebx;
  if (__get_cpuid(0x80000001u, &eax, &ebx, &ecx, &edx)) features.extended_ecx = ecx;
  if (features.leaf1_ecx & bit_OSXSAVE) features.saved_state = read_xcr0();
  return features;
}

static bool has_all(uint64_t bits, uint64_t wanted) { return (bits & wanted) == wanted; }

static bool has_v3(const cpu_features *features) {
  const unsigned leaf1 = bit_SSE3 | bit_SSSE3 | bit_SSE4_1 | bit_SSE4_2 | bit_POPCNT | bit_CMPXCHG16B | bit_AVX |
                         bit_F16C | bit_FMA | bit_MOVBE | bit_OSXSAVE;
  const unsigned leaf7 = bit_AVX2 | bit_BMI | bit_BMI2;
  const unsigned extended = bit_LAHF_LM | bit_LZCNT;
  const uint64_t xmm_and_ymm = 0x6;
  return has_all(features->leaf1_ecx, leaf1) && has_all(features->leaf7_ebx, leaf7) &&
         has_all(features->extended_ecx, extended) && has_all(features->saved_state, xmm_and_ymm);
}

static bool has_v4(const cpu_features *features) {
  const unsigned leaf7 = bit_AVX512F | bit_AVX512BW | bit_AVX512CD | bit_AVX512DQ | bit_AVX512VL;
  const uint64_t masks_and_zmm = 0xe0;
  return has_v3(features) && has_all(features->leaf7_ebx, leaf7) && has_all(features->saved_state, masks_and_zmm);
}

neph_isa np_isa_detect(void) {
  const cpu_features features = read_features();
  if (has_v4(&features)) return NEPH_ISA_X86_64_V4;
  if (has_v3(&features)) return NEPH_ISA_X86_64_V3;
  return NEPH_ISA_X86_64;
}

const char *neph_isa_get_name(neph_isa isa) {
  switch (isa) {
  case NEPH_ISA_X86_64: return "x86-64";
  case NEPH_ISA_X86_64_V3: return "x86-64-v3";
  case NEPH_ISA_X86_64_V4: return "x86-64-v4";
  }
  return "unknown";
}
