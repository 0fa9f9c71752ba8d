"""A running `acquire --daemon`, and streaming heads that can be pulled out and put back."""
import json
import os
import pty
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import tty

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, check, program, rows, wait_for

PROGRAM = program("haptometer")
STEP_M = 1e-7  # of the lines that are sent: +00.0001 mm


class Terminal:
    """The device's end of a pseudo-terminal behind a link: when it goes, the host reads EIO."""

    def __init__(self, directory):
        self.port = os.path.join(directory, "device")

    def plug(self):
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        os.symlink(os.ttyname(self.slave), self.port)

    def unplug(self):
        os.unlink(self.port)
        os.close(self.master)
        os.close(self.slave)

    def send(self, data):
        os.write(self.master, data)


class Tcp:
    """A listening socket. It goes with a reset, or with an orderly end: readable, and 0 bytes."""

    def __init__(self, resets):
        self.resets = resets
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = probe.getsockname()
        self.port = "%s:%d" % self.address
        self.host = None

    def plug(self):
        self.listener = socket.socket()
        self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.listener.bind(self.address)
        self.listener.listen(1)
        self.listener.setblocking(False)

    def unplug(self):
        self.listener.close()
        if self.host and self.resets:
            self.host.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        if self.host:
            self.host.close()
        self.host = None

    def send(self, data):
        if self.host is None:
            self.host, _ = self.listener.accept()
            self.host.setblocking(False)
            self.host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            self.host.send(data)
        except BlockingIOError:  # it does not read in time
            pass
        except OSError:  # it has hung up; the next one is waited for
            self.host.close()
            self.host = None


class Head:
    """Sends numbered lines without being asked, as long as it is plugged in."""

    def __init__(self, plug, lines_per_s=1000):
        self.plug_point = plug
        self.lines_per_s = lines_per_s
        self.lock = threading.Lock()
        self.plugged = False
        self.sent = 0
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        count = self.lines_per_s // 100
        while True:
            time.sleep(0.01)
            lines = "".join("+%02d.%04d\r" % divmod((self.sent + i) % 1000000, 10000)
                            for i in range(count))
            with self.lock:
                if not self.plugged:
                    continue
                try:
                    self.plug_point.send(lines.encode())
                except OSError:  # nobody reads
                    continue
            self.sent += count

    def plug(self):
        with self.lock:
            self.plug_point.plug()
            self.plugged = True

    def unplug(self):
        with self.lock:
            self.plug_point.unplug()
            self.plugged = False


class Daemon:
    """`acquire --daemon` on one sensor called `head`; `keys` go into its file."""

    def __init__(self, directory, port, keys, environment=None, sensor='sensor = "stream"', stdin=None):
        self.directory = directory
        self.trials = os.path.join(directory, "trials")
        os.makedirs(self.trials, exist_ok=True)
        self.socket = os.path.join(directory, "status.sock")
        self.config = os.path.join(directory, "daemon.toml")
        with open(self.config, "w") as file:
            file.write(f'directory = "{self.trials}"\nsocket = "{self.socket}"\n{keys}\n'
                       f'[[sensor]]\nname = "head"\n{sensor}\nport = "{port}"\n')
        self.log = open(os.path.join(directory, "log"), "w+")
        self.process = subprocess.Popen([PROGRAM, "acquire", "--daemon", self.config],
                                        stderr=self.log, stdin=subprocess.DEVNULL if stdin is None else stdin,
                                        stdout=subprocess.DEVNULL,
                                        env={**os.environ, **(environment or {})})

    def status(self):
        """The sensor's part of `acquire --status --json`, or None before there is one."""
        check(self.process.poll() is None, "the daemon has ended: " + self.said())
        asked = subprocess.run([PROGRAM, "acquire", "--status", self.socket, "--json"],
                               capture_output=True, timeout=DEADLINE_S)
        return json.loads(asked.stdout)["sensors"][0] if asked.returncode == 0 else None

    def wait_for_state(self, state):
        return wait_for(f"state {state}",
                        lambda: (lambda s: s if s and s["state"] == state else None)(self.status()))

    def wait_for_readings(self, more):
        """Until so many readings have come since now."""
        start = (wait_for("a status", self.status))["readings"]
        return wait_for(f"{more} readings", lambda: self.status()["readings"] >= start + more)

    def cpu_s(self):
        """Processor time of the process so far."""
        with open(f"/proc/{self.process.pid}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self):
        """SIGTERM: status 0, and no socket left."""
        self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(DEADLINE_S)
        check(status == 0, f"SIGTERM ends it with {status}: {self.said()}")
        check(not os.path.exists(self.socket), "its socket is left behind")

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def files(self):
        """The trials in the order of their making."""
        paths = [os.path.join(self.trials, name) for name in os.listdir(self.trials)]
        return sorted(paths, key=lambda path: os.stat(path).st_ctime_ns)


def numbered_rows(path):
    """(time in s, number of the line) of every measurement of a trial."""
    return [(float(row["time_s"]), round(float(row["displacement_m"]) / STEP_M))
            for row in rows(path) if row["displacement_m"] not in ("", "nan")]


def check_consecutive(numbers, where):
    """Each line's number follows the last one's."""
    for before, after in zip(numbers, numbers[1:]):
        check(after == before + 1, f"{where}: line {after} follows line {before}")
