# SPDX-License-Identifier: Apache-2.0
"""Starts jobs with hostile names, and compares the arguments that tasks get with those that were given.

hostile.py PROGRAM: prints one line for each farm, or the first difference and ends with 1.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import yaml

PROGRAM = sys.argv[1].encode()
TEXTS = [b"a b", b"it's", b'"', b"$(touch INJECTED)", b"`touch INJECTED`", b"\\", b"a\\'; touch INJECTED; '", b"&;|<>()*?[x]~",
         b"TASK", b"#SBATCH --wrap=touch", b"{1} {2} {} {.} {%} {#}", b"{= system('touch INJECTED') =}", b":::", b"::::",
         b"#JOB# #IFRAME# #FRAME#", b"%A_%j", b"{{Session.WorkingDirectory}}", b"tab\there", b"\xff\xfe", b"{a,b}",
         "\u00e9\u2028- x\u2029\U0001f600".encode(), b"bell\x07", b"c1\xc2\x85x", b"-n", b"--", b"]]> &amp;",
         b"line\ntouch INJECTED\n", b"return\rx", b"!x", b"%x"]


def fail(message):
    print(message)
    sys.exit(1)


class Place:
    """A folder with stubs: `nephos` writes its arguments, `sbatch` runs the task that it is given."""

    def __init__(self, root, number, folder):
        self.root = os.path.join(root, b"%d" % number)
        self.folder = os.path.join(self.root, folder)
        self.bin = os.path.join(root, b"bin%d" % number)
        os.makedirs(self.folder)
        os.makedirs(self.bin)
        self.write_stub(b"nephos", b'printf "%s\\0" "$PWD" "$@" >>"$SEEN"\n')
        self.write_stub(b"sbatch", b"""for option; do case $option in --chdir=*) cd "${option#*=}" ;; esac; done
case $1$2 in *dependency*) cat >/dev/null ;; *) SLURM_ARRAY_TASK_ID=0 sh >&2 ;; esac
echo 1
""")
        self.seen = os.path.join(root, b"seen")
        self.environment = {b"PATH": self.bin + b":" + os.environb[b"PATH"], b"HOME": root, b"SEEN": self.seen,
                            b"LC_ALL": b"C.UTF-8"}

    def write_stub(self, name, text):
        path = os.path.join(self.bin, name)
        with open(path, "wb") as stub:
            stub.write(b"#!/bin/sh\n" + text)
        os.chmod(path, 0o755)

    def run(self, command, cwd=b"/"):
        if os.path.exists(self.seen):
            os.remove(self.seen)
        done = subprocess.run(command, cwd=cwd, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True)
        if done.returncode:
            fail(f"{command}: exit {done.returncode}: {done.stderr.decode(errors='replace')}")
        with open(self.seen, "rb") as seen:
            return seen.read().split(b"\0")[:-1]


def check_task(place, seen, options, scene):
    expected = [place.folder, b"render", os.path.join(place.folder, scene), b"--frames", b"1", *options]
    if seen[:len(expected)] != expected:
        fail(f"arguments are {seen}, must begin with {expected}")


def run_script(place, job, options, scene):
    script = os.path.join(place.root, b"job.sh")
    with open(script, "wb") as file:
        file.write(job)
    check_task(place, place.run([b"sh", script]), options, scene)


def run_parallel(place, job, options, scene):
    if shutil.which("parallel"):
        run_script(place, job, options, scene)


def run_opencue(place, job, options, scene):
    """A host writes the command to a script; one with containers has it within double quotes of another shell."""
    command = xml.etree.ElementTree.fromstring(job).find(".//cmd").text.replace("#FRAMESPEC#", "1").encode()
    if re.search(rb"#[A-Z]+#", command):
        fail(f"Cuebot replaces a part of {command}")
    check_task(place, place.run([b"sh", b"-c", command]), options, scene)
    outer = b'sh -c "' + command.replace(b'"', b'\\"') + b'"'
    check_task(place, place.run([b"sh", b"-c", outer]), options, scene)


def run_openjd(place, job, options, scene):
    template = yaml.safe_load(job)
    arguments = [text.encode() for text in template["steps"][0]["script"]["actions"]["onRun"]["args"]]
    default = template["parameterDefinitions"][0]["default"].encode()
    expected = [b"render", b"{{Param.Scene}}", b"--frames", b"{{Task.Param.Frames}}", *options, b"--checkpoint"]
    if len(template["steps"]) != 1 or os.path.normpath(default) != scene or arguments[:len(expected)] != expected:
        fail(f"the template is {template}")


FARMS = {b"slurm": run_script, b"parallel": run_parallel, b"opencue": run_opencue, b"openjd": run_openjd}


def print_job(place, farm, scene, options):
    return subprocess.run([PROGRAM, b"job", farm, b"--", scene, *options], cwd=place.folder, env=place.environment,
                          stdin=subprocess.DEVNULL, capture_output=True)


def check(root, number, farm, text):
    """The text is in the scene's name, in that of the working folder, and in options. Whether the farm holds it."""
    name = text.replace(b"/", b"_")
    place = Place(root, number, name)
    scene, options = name + b".yaml", [b"--cache", b"d" + name, b"--machine=" + name]
    with open(os.path.join(place.folder, scene), "wb") as file:
        file.write(b'atmosphere: none\nenvironment: {radiance: 1}\noutput: {image: "a.exr"}\n')
    done = print_job(place, farm, scene, options[:2])
    if done.returncode == 2 and not done.stdout and done.stderr.count(b"\n") == 1:
        return False
    if done.returncode:
        fail(f"{farm} {text}: exit {done.returncode}: {done.stderr}")
    FARMS[farm](place, done.stdout, options[:2], scene)
    for folder, _, files in os.walk(root):
        if b"INJECTED" in files:
            fail(f"{farm} {text}: is a command, in {folder}")
    return True


def main():
    with tempfile.TemporaryDirectory() as root:
        for i, farm in enumerate(FARMS):
            refused = [t for j, t in enumerate(TEXTS) if not check(os.fsencode(root), 100 * i + j, farm, t)]
            print(f"{farm.decode()}: {len(TEXTS) - len(refused)} texts as they are, refused:",
                  *(ascii(t.decode(errors="surrogateescape")) for t in refused))


main()
