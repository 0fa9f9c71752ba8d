"""A program at a pseudo terminal, for tests: keys are typed, and what its screen shows is read."""
import fcntl
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import time

from programs import DEADLINE_S, check, program

# a screen that is drawn as a whole, from the first line to the end of the screen
FRAME = re.compile(r"\x1b\[H(.*?)\x1b\[J", re.DOTALL)


class Terminal:
    """`haptometer WORDS` at a terminal of its own; all times are of time.monotonic()."""

    def __init__(self, *words, columns=200, lines=30, env=None):
        self.master, self.slave = pty.openpty()
        self.resize(columns, lines)
        self.before = termios.tcgetattr(self.slave)
        self.text, self.frames, self.bells = "", 0, []
        self.screen, self.screen_at = "", 0.0
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self.master)
            self._login()
            os.execve(program("haptometer"), ["haptometer", *words], {**os.environ, "TERM": "xterm", **(env or {})})
        self.status = None

    def _login(self):
        os.setsid()
        fcntl.ioctl(self.slave, termios.TIOCSCTTY, 0)
        for number in range(3):
            os.dup2(self.slave, number)

    def resize(self, columns, lines):
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))

    def read(self, seconds=0.05):
        """Takes what the program has written; waits at most so long for its next bytes."""
        if not select.select([self.master], [], [], seconds)[0]:
            return
        try:
            data = os.read(self.master, 65536)
        except OSError:
            return
        now = time.monotonic()
        self.bells += [now] * data.count(b"\a")
        self.text += data.decode(errors="replace")
        for frame in FRAME.finditer(self.text):
            self.screen = re.sub(r"\x1b\[K|\a|\r", "", frame[1])
            self.screen_at = now
            self.frames += 1
            end = frame.end()
        if FRAME.search(self.text):
            self.text = self.text[end:]

    def wait_for(self, pattern, seconds=30):
        """The match of the pattern in a screen that is drawn from now on, or is there."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            found = re.search(pattern, self.screen)
            if found:
                return found
            self.read()
        sys.exit(f"FAILED: {pattern!r} does not come within {seconds} s; the screen is\n{self.screen}")

    def type(self, keys):
        os.write(self.master, keys.encode())

    def kill(self, number):
        os.kill(self.pid, number)

    def end(self, seconds=30):
        """Its exit status, or minus the signal that ended it."""
        deadline = time.monotonic() + seconds
        while self.status is None and time.monotonic() < deadline:
            self.read()
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.status = os.waitstatus_to_exitcode(status)
        if self.status is None:
            self.kill(signal.SIGKILL)
            self.status = os.waitpid(self.pid, 0)[1]
            sys.exit(f"FAILED: the program does not end within {seconds} s; the screen is\n{self.screen}")
        for _ in range(3):
            self.read()
        return self.status

    def check_restored(self):
        """Settings, cursor and screen are those of before."""
        check(termios.tcgetattr(self.slave) == self.before, "the settings of the terminal are not restored")
        check(self.text.rfind("\x1b[?1049l") > self.text.rfind("\x1b[?1049h"), "the alternate screen is left")

    def close(self):
        if self.status is None:
            self.kill(signal.SIGKILL)
            os.waitpid(self.pid, 0)
        for descriptor in (self.master, self.slave):
            try:
                os.close(descriptor)
            except OSError:
                pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
