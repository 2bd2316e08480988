# SPDX-License-Identifier: Apache-2.0
"""Compares predicted time and memory of pictures with measured ones, and fits the constants of the predictions."""

import argparse
import os
import sys
import tempfile

from fit import fit_table
from measure import measure, read_calibration
from page import SHARE_LEAST, count_within, print_page

CRITERIA = (("seconds", 2.0, "time"), ("bytes", 1.3, "memory"))


def check(found):
    """Exit status: 1 where fewer than nine of ten predictions of a quantity are within its factor."""
    status = 0
    for key, factor, name in CRITERIA:
        within, count = count_within(found, key, factor)
        print(f"{name} within {factor}: {within} of {count}", file=sys.stderr)
        if count == 0 or within < SHARE_LEAST * count:
            status = 1
    return status


def main():
    parser = argparse.ArgumentParser(prog="costs.sh")
    parser.add_argument("nephos")
    parser.add_argument("--seed", required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--scenes")
    parser.add_argument("--files")
    parser.add_argument("--folder", help="for scenes and measurements; a temporary one by default")
    parser.add_argument("--fit", metavar="TABLE", help="fits the constants and writes them to this file")
    parser.add_argument("--page")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        options.folder = options.folder or temporary
        os.makedirs(options.folder, exist_ok=True)
        found = list(measure(os.path.abspath(options.nephos), options))
        calibration = read_calibration(options.folder)
    if options.fit:
        fit_table(options.fit, [case for case in found if case["is_fitted"]], calibration)
    if options.page:
        with open(options.page, "w") as out:
            print_page(found, options, out)
    return check(found) if options.check else 0


sys.exit(main())
