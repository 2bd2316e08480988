#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_circles.py BUILD_DIR: no circle among the object files of the libraries and the program, by the symbols that
nm lists. The row of a verb (cli_verb_…) counts for nothing: the table of verbs names all of them, and help prints it.
"""
import collections
import pathlib
import subprocess
import sys

# Circles that are still there, each by all files that may be in it: no other file may join, and an entry without a
# circle fails.
ALLOWED = {}
IGNORED = 'cli_verb_'


def read_uses(build):
    """The files whose symbols each file uses, by the symbols."""
    objects = [o for folder in ('src', 'cli') for o in sorted((build / folder).rglob('*.o'))]
    out = subprocess.run(['nm', '-A', '-P', '-g', *objects], check=True, capture_output=True, text=True).stdout
    definer, users = {}, []
    for line in out.splitlines():
        place, symbol, kind = line.split()[:3]
        module, file = pathlib.Path(place.rstrip(':')).relative_to(build).as_posix().split('/CMakeFiles/')
        unit = module + '/' + file.split('.dir/')[1].rsplit('.', 2)[0]
        if kind in 'Uvw':
            users.append((unit, symbol))
        elif kind not in 'VW' and not symbol.startswith(IGNORED):
            definer[symbol] = unit
    uses = collections.defaultdict(lambda: collections.defaultdict(set))
    for unit, symbol in users:
        if definer.get(symbol, unit) != unit:
            uses[unit][definer[symbol]].add(symbol)
    return uses


def list_circles(uses):
    """Strongly connected components of more than one file: those that reach each other."""
    def reach(first):
        seen, waiting = set(), [first]
        while waiting:
            new = set(uses[waiting.pop()]) - seen
            seen |= new
            waiting += new
        return seen
    reached = {unit: reach(unit) for unit in list(uses)}
    circles = {frozenset(other for other in seen if unit in reached.get(other, ()))
               for unit, seen in reached.items() if unit in seen}
    return sorted(sorted(circle) for circle in circles)


def main():
    uses, failures = read_uses(pathlib.Path(sys.argv[1]).resolve()), []
    entries = [(frozenset(f'{room}/{name}' for name in names.split()), names)
               for room, lists in ALLOWED.items() for names in lists]
    circles = list_circles(uses)
    for circle in circles:
        if not any(files.issuperset(circle) for files, _ in entries):
            failures.append(f'a circle of {len(circle)} files, each of which reaches all others:')
            failures += [f'  {a} uses {", ".join(sorted(uses[a][b]))} of {b}'
                         for a in circle for b in circle if b in uses[a]]
    failures += [f'"{names}" are in no circle any more: take them out of ALLOWED in tests/hygiene/check_circles.py'
                 for files, names in entries if not any(files.issuperset(circle) for circle in circles)]
    if failures:
        sys.exit('\n'.join(failures))


main()
