# SPDX-License-Identifier: Apache-2.0
"""The page of a population: docs/results/population.md."""

import numpy

QUANTILES = (0.03, 0.16, 0.5, 0.84, 0.97)


def compute_ratio(a, b):
    """How many times the larger of two positive numbers is the smaller."""
    return max(a, b) / max(min(a, b), 1e-12)


def count_share(rows, test):
    return sum(map(test, rows)) / len(rows) if rows else 0.0


def print_table(out, head, rows):
    print("| " + " | ".join(head) + " |", file=out)
    print("| " + " | ".join("---" for _ in head) + " |", file=out)
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |", file=out)
    print(file=out)


def list_quantiles(values):
    return [f"{100 * q:+.1f}" for q in numpy.quantile(values, QUANTILES)]


def print_bias(results, out):
    bias = numpy.concatenate([numpy.reshape(r["bias"], (-1, 3)) for r in results])
    head = ["regions", "number"] + [f"{100 * q:.0f} %" for q in QUANTILES]
    rows = [[f"all, {band}", len(bias)] + list_quantiles(bias[:, b]) for b, band in enumerate("RGB")]
    for kind in sorted({kind for r in results for kind in r["kinds"]}):
        own = [numpy.reshape(r["bias"], (-1, 3)) for r in results if kind in r["kinds"]]
        values = numpy.concatenate(own)
        if len(values):
            rows.append([kind, len(values)] + list_quantiles(values))
    print("Quantiles of march/path - 1 in resolved regions, %; by kind over all bands.\n", file=out)
    print_table(out, head, rows)
    return numpy.abs(bias).max(1)


def is_error_right(r):
    """Whether some error between the bounds of the true one is within 1.5 of the stated."""
    noise2 = max(r["true_error"] ** 2 - r["true_bias"] ** 2, 0.0)
    least, most = ((bound ** 2 + noise2) ** 0.5 for bound in r["bias_bounds"])
    return least / 1.5 <= r["stated_error"] <= 1.5 * most


def print_criteria(results, worst, out):
    noise = [pair for r in results for pair in r["path_noise"]]
    shares = [
        ["regions within 6 %", f"{100 * numpy.mean(worst <= 0.06):.1f} %", "97 %"],
        ["regions beyond 15 %", int((worst > 0.15).sum()), "0"],
        ["scenes with 85 % of their regions resolved",
         f"{100 * count_share(results, lambda r: len(r['bias']) >= 0.85 * r['seen']):.0f} %", ""],
        ["stated error within 1.5 of the true one, as far as it is known",
         f"{100 * count_share(results, is_error_right):.0f} %", "85 %"],
        ["stated bias below half of a true one beyond 3 σ",
         sum(r["stated_bias"] < 0.5 * r["bias_bounds"][0] for r in results), "0"],
        ["noise stated by path within 1.5 of what the picture shows",
         f"{100 * count_share(noise, lambda pair: compute_ratio(*pair) <= 1.5):.0f} % of {len(noise)}", "92 %"],
        ["predicted seconds within 2",
         f"{100 * count_share(results, lambda r: compute_ratio(r['seconds'], r['predicted_seconds']) <= 2):.0f} %",
         "85 %"],
        ["predicted memory within 1.3",
         f"{100 * count_share(results, lambda r: compute_ratio(r['bytes'], r['predicted_bytes']) <= 1.3):.0f} %",
         "85 %"],
        ["pixels that are not finite or negative", sum(r["bad"] for r in results), "0"],
    ]
    print_table(out, ["figure", "measured", "asked"], shares)


def print_scenes(results, out):
    rows = [[r["name"], ", ".join(r["kinds"]), f"{len(r['bias'])} of {r['seen']}",
             f"{100 * r['true_bias']:.1f} ({100 * r['bias_bounds'][0]:.1f} to {100 * r['bias_bounds'][1]:.1f})",
             f"{100 * r['stated_bias']:.1f}", f"{100 * r['true_error']:.1f}", f"{100 * r['stated_error']:.1f}",
             f"{r['seconds']:.1f}", f"{r['predicted_seconds']:.1f}", f"{r['bytes'] / 1e6:.0f}",
             f"{r['predicted_bytes'] / 1e6:.0f}"] for r in results]
    print("Bias, with bounds of three deviations, and error of a pixel in %, CPU seconds on one thread, memory in MB.\n",
          file=out)
    print_table(out, ["scene", "kinds", "resolved", "bias", "stated", "error", "stated", "seconds", "predicted", "memory",
                      "predicted"], rows)


def print_worst(results, columns, out):
    regions = []
    for r in results:
        for place, bias, error in zip(r["place"], r["bias"], r["error"]):
            regions.append((max(map(abs, bias)), r["name"], place, bias, max(error)))
    rows = [[name, f"{place % columns}, {place // columns}", " / ".join(f"{100 * b:+.1f}" for b in bias), f"{100 * error:.1f}"]
            for _, name, place, bias, error in sorted(regions, reverse=True)[:12]]
    print("The twelve worst regions: column and row of 8 × 9 pixels, bias in R / G / B and the reference's standard "
          "error, %.\n", file=out)
    print_table(out, ["scene", "region", "bias", "±"], rows)


def print_page(results, refused, options, out):
    print("# A population of drawn scenes\n", file=out)
    print(f"`sh tests/bench/population.sh build/release/bin/nephos --seed {options.seed} --count {options.count}` draws "
          f"scenes\nfrom a Sobol sequence, renders 64 × 36 pixels by the march at final quality and by path with four "
          "seeds, and\ncompares regions of 8 × 9 pixels. A region is resolved where the reference's standard error is "
          "below 2 %.\n"
          "`--folder DIR` keeps scenes and pictures.\n", file=out)
    if not results:
        print("No scene was measured.", file=out)
        return
    worst = print_bias(results, out)
    print_criteria(results, worst, out)
    print_worst(results, int(options.resolution.split("x")[0]) // 8, out)
    print_scenes(results, out)
    for name, message in refused:
        print(f"Refused: {name}: {message}", file=out)
