# SPDX-License-Identifier: Apache-2.0
"""Page of results of the I3RC from answers of nephos probe i3rc: by path, by fewer paths, by march (i3rc.sh)."""
import csv
import sys

HEAD = """<!-- SPDX-License-Identifier: Apache-2.0 -->
# Results: I3RC

The step cloud (case 1) and the Landsat cloud (case 3) of the Intercomparison of 3D Radiation Codes, phase 1, by both
integrators, beside the consensus of the participants. Experiments, quantities and columns are explained in
[cli.md](../cli.md#probe-i3rc). CASE1 and CASE3 are folders with the inputs and the results of either case. `i3rc.sh`
prints this page.

σ is √(se² + e²): the standard error of the paths, and the noise e of the consensus's mean, which its files do not state
and which third differences of its columns estimate (too large where the field is rough, as in case 3). Differences
between the codes of the consensus are not in it. The march has no standard error that covers its bias: its rows give
the difference in per cent.
"""


PATH_COMMANDS = """    nephos probe i3rc CASE1 --target-error 0.002 --paths 1500000
    nephos probe i3rc CASE3 --target-error 0.003 --paths 2000000
"""

MARCH_COMMANDS = """    nephos probe i3rc CASE1 --integrator march --target-error 0.003 --paths 200000
    nephos probe i3rc CASE3 --integrator march --target-error 0.003 --paths 200000
"""


def read(path):
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file)]


def judge(rows):
    sigmas = [abs(float(row["sigmas"])) for row in rows]
    return "%d of %d domain means lie within 2 σ, the farthest at %.1f σ; the largest standard error is %.2f %%." % (
        sum(s <= 2 for s in sigmas), len(sigmas), max(sigmas),
        max(100 * float(row["se"]) / float(row["value"]) for row in rows))


def print_table(rows, header, cells):
    print("| " + " | ".join(header) + " |")
    print("|" + " --- |" * len(header))
    for row in rows:
        print("| " + " | ".join(cells(row)) + " |")
    print()


def number(row, key, digits):
    return "%.*f" % (digits, float(row[key]))


def main():
    path, fewer, march = (read(file) for file in sys.argv[1:4])
    print(HEAD)
    compared = [row for row in path if row["consensus"]]
    print("## Path\n\n%s\nColumns differ by what noise makes of them where `rms` over `noise` is 1.\n" % judge(compared))
    print("Case 1 by fewer paths (`--target-error 0.003 --paths 2000000`):\n%s\n" %
          judge([row for row in fewer if row["consensus"]]))
    print(PATH_COMMANDS)
    print_table(compared,
                ["case", "experiment", "quantity", "path", "se", "consensus", "e", "σ", "%", "rms / noise of columns"],
                lambda r: [r["case"], r["experiment"], r["quantity"], number(r, "value", 5), number(r, "se", 5),
                           number(r, "consensus", 5), number(r, "consensus_se", 5), "%+.2f" % float(r["sigmas"]),
                           "%+.2f" % float(r["percent"]),
                           "%.2f (%.4f / %.4f)" % (float(r["column_rms"]) / float(r["column_noise"]),
                                                   float(r["column_rms"]), float(r["column_noise"]))])
    print("Absorptance without a consensus, and the balance H = 1 − R − T − A, by the same command:\n")
    print(PATH_COMMANDS)
    print_table([row for row in path if not row["consensus"]], ["case", "experiment", "quantity", "path", "se"],
                lambda r: [r["case"], r["experiment"], r["quantity"], number(r, "value", 5), number(r, "se", 5)])
    compared = [row for row in march if row["consensus"]]
    percents = [float(row["percent"]) for row in compared]
    print("## March\n\nDomain means differ by %+.1f to %+.1f %%.\n" % (min(percents), max(percents)))
    print(MARCH_COMMANDS)
    print_table(compared, ["case", "experiment", "quantity", "march", "consensus", "%", "rms of columns"],
                lambda r: [r["case"], r["experiment"], r["quantity"], number(r, "value", 5), number(r, "consensus", 5),
                           "%+.2f" % float(r["percent"]), number(r, "column_rms", 4)])


main()
