/* SPDX-License-Identifier: Apache-2.0 */
/* Prints src/integrate/blue_noise_table.c: blue noise by void and cluster (Ulichney 1993, "The void-and-cluster method
 * for dither array generation"), on a torus.
 *
 * Every pixel gets a rank. An initial pattern of a tenth of the pixels is evened out by moving its tightest cluster
 * into its largest void until nothing moves; ranks below it follow by removing clusters, ranks above it by filling
 * voids. One energy field, a Gaussian of σ = 1.9 around every set pixel, gives clusters and voids in all phases. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "core/random.h"
#include "integrate/blue_noise_table.h"

enum { EDGE = NP_BLUE_NOISE_EDGE, COUNT = EDGE * EDGE, INITIAL = COUNT / 10, REACH = 9 };

typedef struct pattern {
  bool is_set[COUNT];
  float energy[COUNT];
  float kernel[2 * REACH + 1];
} pattern;

static void pattern_toggle(pattern *p, int pixel) {
  const float sign = p->is_set[pixel] ? -1.0f : 1.0f;
  const int x = pixel % EDGE, y = pixel / EDGE;
  p->is_set[pixel] = !p->is_set[pixel];
  for (int j = -REACH; j <= REACH; j++)
    for (int i = -REACH; i <= REACH; i++)
      p->energy[(y + j + EDGE) % EDGE * EDGE + (x + i + EDGE) % EDGE] +=
          sign * p->kernel[i + REACH] * p->kernel[j + REACH];
}

/* The set pixel with the most neighbours, or the clear one with the fewest. */
static int search_pixel(const pattern *p, bool is_set) {
  int best = -1;
  for (int i = 0; i < COUNT; i++) {
    if (p->is_set[i] != is_set) continue;
    if (best < 0 || (is_set ? p->energy[i] > p->energy[best] : p->energy[i] < p->energy[best])) best = i;
  }
  return best;
}

static void pattern_start(pattern *p) {
  memset(p, 0, sizeof *p);
  for (int i = -REACH; i <= REACH; i++) p->kernel[i + REACH] = expf((float)(-i * i) / (2.0f * 1.9f * 1.9f));
  np_random random = np_random_start(0, 0, 0, 0, 0);
  for (int set = 0; set < INITIAL;) {
    const int pixel = (int)(np_random_float(&random) * COUNT);
    if (p->is_set[pixel]) continue;
    pattern_toggle(p, pixel);
    set++;
  }
  for (int round = 0; round < COUNT; round++) {
    const int cluster = search_pixel(p, true);
    pattern_toggle(p, cluster);
    const int hole = search_pixel(p, false);
    pattern_toggle(p, hole);
    if (hole == cluster) break;
  }
}

static void rank_pixels(int out_ranks[COUNT]) {
  pattern p, initial;
  pattern_start(&initial);
  p = initial;
  for (int rank = INITIAL - 1; rank >= 0; rank--) {
    const int pixel = search_pixel(&p, true);
    out_ranks[pixel] = rank;
    pattern_toggle(&p, pixel);
  }
  p = initial;
  for (int rank = INITIAL; rank < COUNT; rank++) {
    const int pixel = search_pixel(&p, false);
    out_ranks[pixel] = rank;
    pattern_toggle(&p, pixel);
  }
}

int main(void) {
  int ranks[COUNT];
  rank_pixels(ranks);
  printf("/* SPDX-License-Identifier: Apache-2.0 */\n"
         "/* Ranks of a tile of blue noise, row by row. Printed by a benchmark:\n"
         " *\n"
         " *   bench_blue_noise >src/integrate/blue_noise_table.c\n"
         " */\n"
         "#include \"integrate/blue_noise_table.h\"\n\n"
         "/* clang-format off */\n\n"
         "const uint16_t np_blue_noise_ranks[NP_BLUE_NOISE_EDGE * NP_BLUE_NOISE_EDGE] = {");
  for (int i = 0; i < COUNT; i++) printf("%s%d,", i % 20 ? " " : "\n  ", ranks[i]);
  printf("\n};\n");
  return 0;
}
