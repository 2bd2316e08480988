/* SPDX-License-Identifier: Apache-2.0 */
/* Kernels by instruction set. A kernel file is compiled once per level (see nephos_add_kernels in src/CMakeLists.txt)
 * with NP_KERNEL_LEVEL set; it wraps its public names in NP_KERNEL so that the copies can live side by side. A module's
 * dispatcher lists the three tables in an array of NP_ISA_COUNT and picks the one at context->isa. */
#ifndef NP_CORE_ISA_H
#define NP_CORE_ISA_H

#include "core/context_private.h"

#define NP_KERNEL_JOIN_(name, level) name##_##level
#define NP_KERNEL_JOIN(name, level) NP_KERNEL_JOIN_(name, level)
#define NP_KERNEL(name) NP_KERNEL_JOIN(name, NP_KERNEL_LEVEL) /* expands to name_v1, name_v3, name_v4 */

enum { NP_ISA_COUNT = 3 };

/* The highest level that both the machine and its operating system support. */
neph_isa np_isa_detect(void);

#endif
