# SPDX-License-Identifier: Apache-2.0
"""Fits constants of the model of cost: seconds of a unit to stages, bytes of a unit to whole pictures.

The relative errors of all predictions and the logarithms of all constants over those of the present table are least
together, so that a constant that few measurements tell of stays where it is. Refitting from a fitted table lets such
constants drift: a fit begins from the table of the last commit.
"""

import re

import numpy
from scipy.optimize import least_squares

ROW = re.compile(r'  X\((\w+), "([^"]+)", ([^,]+), ([^)]+)\)( \\)?')

CALIBRATION_ROW = re.compile(r"  X\((\d+, \w+, \w+), ([^)]+)\)( \\)?")

# Units whose bytes are exact, or whose memory is measured apart.
EXACT = ("bytes", "bytes of samples", "program", "OpenVDB", "voxels with detail", "noises of detail")

HOLD = 0.25  # weight of a constant's logarithm beside the relative error of a measurement
SECONDS_LEAST = 0.05  # time of a stage that counts
QUIET = 0.8  # CPU time on a machine with nothing else to do over that on one whose cores are shared


def read_table(path):
    with open(path) as file:
        lines = file.read().splitlines()
    rows = {}
    for line in lines:
        match = ROW.fullmatch(line)
        if match and not match[1].isdigit():
            rows[match[2]] = [match[1], float(match[3]), float(match[4])]
    return lines, rows


def write_table(path, lines, rows, calibration):
    out, calibration = [], list(calibration)
    for line in lines:
        match, calibrated = ROW.fullmatch(line), CALIBRATION_ROW.fullmatch(line)
        if match and match[2] in rows:
            name, seconds, size = rows[match[2]]
            line = f'  X({name}, "{match[2]}", {seconds:.3g}, {size:.3g}){match[5] or ""}'
        elif calibrated:
            line = f"  X({calibrated[1]}, {calibration.pop(0):.3g}){calibrated[3] or ''}"
        out.append(line)
    with open(path, "w") as file:
        file.write("\n".join(out) + "\n")


def fit(start, cases, measured, fixed):
    """Constants of units that make the sums over the units of each case come near its measured value; `fixed` is added
    to each sum."""
    names = [name for name in start if start[name] > 0.0 and any(case.get(name) for case in cases)]
    counts = numpy.array([[case.get(name, 0.0) for name in names] for case in cases])
    first = numpy.array([start[name] for name in names])
    measured, fixed = numpy.array(measured), numpy.array(fixed)

    def compute_residuals(logs):
        errors = numpy.log((counts @ (first * numpy.exp(logs)) + fixed) / measured)
        return numpy.concatenate([errors, HOLD * logs])

    found = least_squares(compute_residuals, numpy.zeros(len(names)), loss="soft_l1", f_scale=0.3)
    return {name: value for name, value in zip(names, first * numpy.exp(found.x))}


def list_stages(found):
    """Units and measured seconds of each stage that counts."""
    for case in found:
        for stage, predicted in case["predicted"]["stages"].items():
            seconds = case["stages"].get(stage, 0.0)
            if seconds >= SECONDS_LEAST and predicted["units"]:
                yield stage, predicted["units"], QUIET * seconds


def sum_units(case):
    sums = dict(case["predicted"]["units"])
    for stage in case["predicted"]["stages"].values():
        for name, count in stage["units"].items():
            sums[name] = sums.get(name, 0.0) + count
    return sums


def fit_table(path, found, calibration):
    lines, rows = read_table(path)
    stages = list(list_stages(found))
    seconds = {}
    for stage in sorted({stage for stage, _, _ in stages}):
        own = [(units, measured) for name, units, measured in stages if name == stage]
        start = {unit: row[1] for unit, row in rows.items()}
        seconds.update(fit(start, [units for units, _ in own], [s for _, s in own], numpy.zeros(len(own))))
    sums = [sum_units(case) for case in found]
    exact = [sum(rows[name][2] * case.get(name, 0.0) for name in EXACT) for case in sums]
    start = {unit: row[2] for unit, row in rows.items() if unit not in EXACT}
    size = fit(start, sums, [case["bytes"] for case in found], exact)
    for unit, row in rows.items():
        row[1], row[2] = seconds.get(unit, row[1]), size.get(unit, row[2])
    write_table(path, lines, rows, [QUIET * seconds for seconds in calibration])
