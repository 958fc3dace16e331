"""A program in a separate process that answers one request per line, so that a crash or a timeout is also an
answer."""

import json
import os
import select
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent


class Servant:
    """Starts a script of this folder at its first request, and again after it ended."""

    def __init__(self, script, timeout=120.0):
        self.script, self.timeout, self.process = script, timeout, None

    def ask(self, request):
        """The answer; {"died": why} if the process ended or did not answer in time."""
        if self.process is None:
            self.process = subprocess.Popen(
                [sys.executable, str(HERE / self.script)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        try:
            self.process.stdin.write(json.dumps(request).encode() + b"\n")
            self.process.stdin.flush()
            line = self.line()
        except BrokenPipeError:
            line = b""
        if line is None:
            self.stop()
            return {"died": f"no answer within {self.timeout:.0f} s"}
        if not line.endswith(b"\n"):
            code = self.process.wait()
            self.stop()
            return {"died": f"signal {-code}" if code < 0 else f"exit code {code}"}
        return json.loads(line)

    def line(self):
        """The next line; less if the process ends first, None after the time limit."""
        end, text, out = time.monotonic() + self.timeout, b"", self.process.stdout.fileno()
        while not text.endswith(b"\n"):
            ready, _, _ = select.select([out], [], [], max(0.0, end - time.monotonic()))
            if not ready:
                return None
            part = os.read(out, 1 << 20)
            if not part:
                break
            text += part
        return text

    def stop(self):
        """Ends the process."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process.stdin.close()
            self.process.stdout.close()
            self.process = None


def serve(answer):
    """Answers every line of standard input with `answer(request)`, a dictionary.

    Output of the libraries, also from C++, goes to a file and becomes the field "said" of the answer.
    """
    channel = os.fdopen(os.dup(1), "w")
    with tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
        for line in sys.stdin:
            said.seek(0)
            said.truncate()
            result = answer(json.loads(line))
            sys.stdout.flush()
            sys.stderr.flush()
            said.seek(0)
            result["said"] = said.read(20000).decode("utf-8", "replace")
            channel.write(json.dumps(result) + "\n")
            channel.flush()
