#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_inputs.py SOURCE_DIR CC: a maker's inputs have the results that stage_needs.h names for its stage and its own,
and the compiler refuses every other."""
import pathlib
import re
import subprocess
import sys


def read_table(text, prefix):
    """Bodies of the macros PREFIX_STAGE(X), by stage."""
    joined = text.replace('\\\n', ' ')
    return dict(re.findall(rf'^#define {prefix}_([A-Z_]+)\(X\)(.*)$', joined, re.M))


def main():
    root, cc = pathlib.Path(sys.argv[1]), sys.argv[2]
    inputs = (root / 'src/stages/stage_inputs.h').read_text()
    needs = {stage: re.findall(r'X\((\w+)\)', body)
             for stage, body in read_table((root / 'src/plan/stage_needs.h').read_text(), 'NP_NEEDS').items()}
    members = {stage: re.findall(r'X\([^,]+,\s*(\w+),', body)
               for stage, body in read_table(inputs, 'NP_RESULT').items()}
    stages = dict(re.findall(r'X\((\w+), ([A-Z_]+)\)', inputs.split('#define NP_INPUTS_OF_STAGES(X)')[1].split('/* c')[0]))
    lines, expected = ['#include "stages/stage_inputs.h"'], set()
    for name, stage in stages.items():
        allowed = needs[stage] + [stage]
        for other, names in members.items():
            for member in names:
                lines.append(f'const void *read_{name}_{member}(const np_{name}_inputs *in);'
                             f' const void *read_{name}_{member}(const np_{name}_inputs *in) {{ return in->{member}; }}')
                if other not in allowed:
                    expected.add(len(lines))
    flags = ['-std=c11', '-D_GNU_SOURCE', f'-I{root}/include', f'-I{root}/src', '-fsyntax-only', '-x', 'c', '-']
    run = subprocess.run([cc, *flags], input='\n'.join(lines) + '\n', capture_output=True, text=True, check=False)
    refused = {int(n) for n in re.findall(r'^<stdin>:(\d+):\d+: error', run.stderr, re.M)}
    for line in sorted(refused ^ expected):
        print(('is refused: ' if line in refused else 'is readable, and stage_needs.h does not name it: ') + lines[line - 1])
    print(f'{len(stages)} stages: {len(lines) - 1 - len(expected)} members, {len(expected)} refused')
    return refused != expected or not expected or len(stages) < 20


sys.exit(main())
