# SPDX-License-Identifier: Apache-2.0
"""Wall and CPU time of two pictures one after the other and by two threads, each with a context of one thread.

    PYTHONPATH=build/release/python NEPHOS_LIBRARY=build/release/lib/libnephos.so \\
      python3 tests/python/bench_threads.py SCENE.yaml [SAMPLES]

On a machine with two idle cores the ratio of wall times is that of a perfect division, 2, less what one thread takes
of the other. The ratio of CPU times shows what threads cost each other, whatever else runs.
"""
import sys
import threading
import time

import nephos


def make(path):
    context = nephos.Context(thread_count=1)
    return nephos.Renderer(context), nephos.load(path, context=context)


def measure(work):
    wall, cpu = time.monotonic(), time.process_time()
    work()
    return time.monotonic() - wall, time.process_time() - cpu


def main(path, samples):
    pairs = [make(path) for _ in range(2)]

    def render(pair):
        pair[0].render(pair[1], samples=samples, resolution=(96, 54), integrator="path")

    def render_in_turn():
        for pair in pairs:
            render(pair)

    def render_in_threads():
        threads = [threading.Thread(target=render, args=(pair,)) for pair in pairs]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    render_in_turn()  # caches
    for _ in range(3):
        turn, both = measure(render_in_turn), measure(render_in_threads)
        print("in turn %.2f s (CPU %.2f), two threads %.2f s (CPU %.2f): wall ratio %.2f, CPU ratio %.2f"
              % (*turn, *both, turn[0] / both[0], both[1] / turn[1]))


if len(sys.argv) < 2:
    raise SystemExit(__doc__)
main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 32)
