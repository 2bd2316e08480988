# SPDX-License-Identifier: Apache-2.0
"""The page of predicted costs: docs/results/costs.md."""

SECONDS_LEAST = 1.0  # time of pictures that count
SHARE_LEAST = 0.9  # of the pictures whose prediction is to be within its factor


def compute_ratio(case, key):
    return case["predicted"][key] / max(case[key], 1e-9)


def count_within(found, key, factor):
    """Pictures of a second and more whose prediction is within a factor, and all of them."""
    ratios = [compute_ratio(case, key) for case in found if case["seconds"] >= SECONDS_LEAST]
    return sum(1.0 / factor <= ratio <= factor for ratio in ratios), len(ratios)


def print_page(found, options, out):
    fitted = [case for case in found if case["is_fitted"]]
    others = [case for case in found if not case["is_fitted"]]
    print(f"""<!-- SPDX-License-Identifier: Apache-2.0 -->
# Results: predicted costs

Time and memory that a plan predicts (`--explain`), by the factors of the machine (`nephos report --calibrate`), against
the CPU seconds and the peak of resident memory of the picture. The constants of `src/plan/cost_table.h` are fitted to
the drawn scenes; the other scenes are the test. Pictures below {SECONDS_LEAST:g} s are listed and not counted.

    sh tests/bench/costs.sh NEPHOS --seed {options.seed} --count {options.count} --scenes SCENES --files FILES \\
        --folder OUT --page docs/results/costs.md --check

| pictures | time within 2 | memory within 1.3 |
| --- | --- | --- |""", file=out)
    for name, cases in (("drawn", fitted), ("others", others)):
        counts = [count_within(cases, key, factor) for key, factor in (("seconds", 2.0), ("bytes", 1.3))]
        print(f"| {name} | " + " | ".join(f"{a} of {b}" for a, b in counts) + " |", file=out)
    print("\n| picture | predicted, CPU s | measured | ratio | predicted, MB | measured | ratio |", file=out)
    print("| --- | --- | --- | --- | --- | --- | --- |", file=out)
    for case in found:
        p = case["predicted"]
        print(f"| {case['name']} | {p['seconds']:.2f} | {case['seconds']:.2f} | {compute_ratio(case, 'seconds'):.2f} | "
              f"{1e-6 * p['bytes']:.0f} | {1e-6 * case['bytes']:.0f} | {compute_ratio(case, 'bytes'):.2f} |", file=out)
