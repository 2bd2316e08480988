# SPDX-License-Identifier: Apache-2.0
"""A running `nephos view`, and requests to it, for the tests beside this file."""
import atexit
import http.client
import json
import os
import signal
import subprocess
import threading
import time

# Mountains under a uniform sky: a picture takes a few hundredths of a second.
SCENE = """# A scene without air.
version: 1
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [64, 36]}
atmosphere: none
environment: {radiance: 0.1}   # uniform
terrain: {ridges: {samples: 129}}
"""


# Seconds for an answer: a sanitizer takes twenty times longer.
ANSWER_S = 200 if os.environ.get("NEPHOS_SANITIZE") else 10


class View:
    """The program, started on a scene, and its address."""

    def __init__(self, program, scene, *options):
        # A shell has jobs in its background ignore interrupts, and what these start.
        self.process = subprocess.Popen([program, "view", scene, "--threads", "2", *options], text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        atexit.register(self.process.kill) # a test that fails leaves no program behind
        self.url = self.process.stdout.readline().strip()
        assert self.url, self.process.stderr.read()
        self.base, self.token = self.url.split("/#")
        self.host, port = self.base.removeprefix("http://").rsplit(":", 1)
        self.port = int(port)
        self.messages = []
        self.reader = threading.Thread(target=lambda: self.messages.extend(self.process.stderr), daemon=True)
        self.reader.start()

    def request(self, path, body=None, method=None, headers=None, token=True, limit=ANSWER_S):
        """Status and body of an answer."""
        connection = http.client.HTTPConnection(self.host, self.port, timeout=limit)
        given = {"X-Nephos-Token": self.token} if token else {}
        given.update(headers or {})
        connection.request(method or ("GET" if body is None else "POST"), path, body, given)
        reply = connection.getresponse()
        answer = reply.read()
        connection.close()
        return reply.status, answer

    def post(self, path, body=""):
        """Status and JSON of an edit's answer."""
        status, answer = self.request(path, body)
        return status, json.loads(answer)

    def set(self, *lines, gesture=0):
        return self.post(f"/api/set?gesture={gesture}", "\n".join(lines))

    def values(self):
        return json.loads(self.request("/api/values")[1])["values"]

    def picture(self, after=0):
        """State, and the pixels, or none where they are those of the number `after`."""
        status, answer = self.request(f"/api/picture?after={after}")
        assert status == 200, answer
        state, pixels = answer.split(b"\n", 1)
        return json.loads(state), pixels

    def wait(self, holds, limit=20):
        """The first state for which `holds` returns true, and its pixels."""
        end = time.monotonic() + limit
        while time.monotonic() < end:
            state, pixels = self.picture()
            if holds(state):
                return state, pixels
            time.sleep(0.02)
        raise AssertionError(f"no such state in {limit} s: {state}")

    def wait_done(self, limit=20, after=-1):
        """The last picture of the last edit, of a number above `after`."""
        return self.wait(lambda s: s["stage"] == "done" and s["generation"] == s["wanted"] and s["number"] > after, limit)

    def wait_rest(self, limit, idle=120):
        """The same within `limit` CPU seconds of the program, however loaded the machine is; one that takes no CPU time
        for `idle` seconds is stuck."""
        end, before, moved = self.cpu_seconds() + limit, 0.0, time.monotonic()
        while True:
            state, pixels = self.picture()
            if state["stage"] == "done" and state["generation"] == state["wanted"]:
                return state, pixels
            now = self.cpu_seconds()
            if now > before:
                before, moved = now, time.monotonic()
            assert now < end and time.monotonic() < moved + idle, f"no rest in {limit} CPU s: {state}"
            time.sleep(0.05)

    def cpu_seconds(self):
        fields = open(f"/proc/{self.process.pid}/stat").read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def resident_bytes(self):
        return int(open(f"/proc/{self.process.pid}/statm").read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def end(self, number=signal.SIGINT):
        """Exit code, and seconds from the signal to the end."""
        start = time.monotonic()
        self.process.send_signal(number)
        code = self.process.wait(10)
        self.reader.join(2)
        return code, time.monotonic() - start


class Checks:
    """Named checks; each failure is printed."""

    def __init__(self):
        self.failures = 0

    def __call__(self, name, holds, shown=""):
        if not holds:
            self.failures += 1
            print("FAILED:", name, shown)
