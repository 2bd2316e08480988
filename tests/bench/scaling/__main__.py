# SPDX-License-Identifier: Apache-2.0
"""Speed-up with the number of threads, from the log of a run on one thread (scaling.sh)."""
import collections
import heapq
import json
import os
import subprocess
import sys
import tempfile
import time

LATENCY_S = {1: 0.0, 2: 10e-6, 4: 15e-6, 8: 25e-6, 16: 50e-6, 64: 150e-6}


def simulate(loop, threads):
    """Seconds of a loop on so many threads: pieces go in order to the thread that is free first."""
    free = [0.0] * min(threads, len(loop["pieces"]))
    ends = []
    waits = loop.get("waits")
    for piece, seconds in enumerate(loop["pieces"]):
        begin = heapq.heappop(free)
        if waits:
            begin = max([begin] + [ends[other] for other in waits[piece]])
            ends.append(begin + seconds)
        heapq.heappush(free, begin + seconds)
    return max(free, default=0.0)


class Log:
    """Loops of a run, and the CPU seconds of its calling thread between them."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as lines:
            records = [json.loads(line) for line in lines]
        self.loops, self.end = records[:-1], records[-1]
        for loop in self.loops:
            loop["pieces"] = [1e-6 * us for us in loop["pieces_us"]]
            loop["seconds"] = sum(loop["pieces"])
        self.serial_s = sum(record["before_s"] for record in records)
        self.work_s = self.serial_s + sum(loop["seconds"] for loop in self.loops)

    def simulate(self, threads):
        loops = sum(simulate(loop, threads) for loop in self.loops)
        return self.serial_s + loops + LATENCY_S[threads] * len(self.loops)

    def group(self, key):
        """Loops by a key, in the order of first mention."""
        groups = collections.OrderedDict()
        for loop in self.loops:
            groups.setdefault(key(loop), []).append(loop)
        return groups


def compute_excess(loops, threads):
    """Seconds beyond an even share of the work, the calling thread's before each loop included."""
    return sum(loop["before_s"] + simulate(loop, threads) - loop["seconds"] / threads for loop in loops)


def print_row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def print_totals(log, measured):
    print_row("threads", *LATENCY_S)
    print_row(*["---"] * (len(LATENCY_S) + 1))
    times = {threads: log.simulate(threads) for threads in LATENCY_S}
    print_row("simulated s", *(f"{times[threads]:.2f}" for threads in LATENCY_S))
    print_row("speed-up", *(f"{times[1] / times[threads]:.1f}" for threads in LATENCY_S))
    print_row("measured s", *(f"{measured[threads]:.2f}" if threads in measured else "" for threads in LATENCY_S))


def print_groups(title, groups, minimum_s):
    print_row(title, "loops", "pieces", "work s", "longest ms", "serial ms", "excess at 16, ms", "at 64")
    print_row(*["---"] * 8)
    order = sorted(groups.items(), key=lambda item: -compute_excess(item[1], 16))
    for name, loops in order:
        excess = compute_excess(loops, 16)
        if excess < minimum_s:
            continue
        print_row(name, len(loops), sum(len(loop["pieces"]) for loop in loops),
                  f"{sum(loop['seconds'] for loop in loops):.2f}",
                  f"{1e3 * max(max(loop['pieces']) for loop in loops):.1f}",
                  f"{1e3 * sum(loop['before_s'] for loop in loops):.0f}", f"{1e3 * excess:.0f}",
                  f"{1e3 * compute_excess(loops, 64):.0f}")


def name_loop(loop):
    return f"{loop['work']} < {loop['caller']}"


def run(nephos, verb, arguments, folder, *options):
    outputs = ["out.exr", "out.png"] if verb == "render" else ["out.vdb"]
    command = [nephos, verb, *arguments, "--quiet", *options]
    for name in outputs:
        command += ["-o", os.path.join(folder, name)]
    begin = time.monotonic()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - begin


def main():
    if len(sys.argv) < 4 or sys.argv[2] not in ("render", "bake"):
        sys.exit("usage: sh scaling.sh NEPHOS render|bake FILE [ARGUMENT...]")
    nephos, verb, arguments = sys.argv[1], sys.argv[2], sys.argv[3:]
    runs = int(os.environ.get("RUNS", "3"))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "loops.json")
        run(nephos, verb, arguments, folder, "--threads", "1", "--loop-log", path)
        log = Log(path)
        measured = {threads: min(run(nephos, verb, arguments, folder, "--threads", str(threads)) for _ in range(runs))
                    for threads in (1, 2) if runs}
    print(f"{log.work_s:.2f} s of work, of which {log.serial_s:.2f} s in the calling thread; "
          f"process {log.end['process_s']:.2f} CPU s; {len(log.loops)} loops\n")
    print_totals(log, measured)
    print()
    print_groups("stage", log.group(lambda loop: loop["stage"] or "none"), 0.001)
    print()
    print_groups("loop", log.group(name_loop), 0.004)
    print(f"\nserial after the last loop: {1e3 * log.end['before_s']:.0f} ms")


main()
