"""What a service manager and a second daemon meet: the notify socket, the watchdog, SIGTERM, the
status socket, rotation."""
import ctypes
import os
import pty
import signal
import socket
import subprocess
import sys
import tempfile
import time

from daemon_run import Daemon, Head, Terminal, check_consecutive, numbered_rows

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, check, info, program, run, skip, wait_for

PROGRAM = program("haptometer")

WATCHDOG_S = 1


class ServiceManager:
    """The socket that NOTIFY_SOCKET names, and what was said there."""

    def __init__(self, directory, is_abstract=False):
        self.path = f"@haptometer-test-{os.getpid()}" if is_abstract else os.path.join(directory, "notify")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.path.replace("@", "\0") if is_abstract else self.path)

    def environment(self):
        return {"NOTIFY_SOCKET": self.path, "WATCHDOG_USEC": str(WATCHDOG_S * 1000000)}

    def hear(self, within_s):
        """The next message's assignments; None when none comes in time."""
        self.socket.settimeout(max(within_s, 0.001))
        try:
            return self.socket.recv(4096).decode().split("\n")
        except TimeoutError:
            return None

    def wait_for(self, prefix):
        """The next assignment that begins like this."""
        deadline = time.monotonic() + DEADLINE_S
        while time.monotonic() < deadline:
            for assignment in self.hear(deadline - time.monotonic()) or []:
                if assignment.startswith(prefix):
                    return assignment
        sys.exit(f"FAILED: {prefix} is not said within {DEADLINE_S} s")

    def says_alive(self, within_s):
        """Whether WATCHDOG=1 comes in time."""
        deadline = time.monotonic() + within_s
        while time.monotonic() < deadline:
            if "WATCHDOG=1" in (self.hear(deadline - time.monotonic()) or []):
                return True
        return False


class StoppedThread:
    """A thread of a child that stands still, the others run on (ptrace)."""

    SEIZE, INTERRUPT, DETACH = 0x4206, 0x4207, 17

    def __init__(self, thread):
        self.thread = thread
        self.libc = ctypes.CDLL(None, use_errno=True)
        self.libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]

    def _ptrace(self, request):
        return self.libc.ptrace(request, self.thread, None, None) == 0

    def __enter__(self):
        if not self._ptrace(self.SEIZE):
            return False
        check(self._ptrace(self.INTERRUPT), "PTRACE_INTERRUPT")
        os.waitpid(self.thread, 0x40000000)  # __WALL
        return True

    def __exit__(self, *_):
        self._ptrace(self.DETACH)


def notify(directory):
    """READY with an absent device; STATUS; WATCHDOG; STOPPING."""
    manager = ServiceManager(directory)
    head = Head(Terminal(directory))
    daemon = Daemon(directory, head.plug_point.port, "", manager.environment())
    try:
        manager.wait_for("READY=1")
        status = manager.wait_for("STATUS=")
        check(status == "STATUS=0 of 1 recording; head: waiting for device", status)
        head.plug()
        manager.wait_for("STATUS=1 of 1 recording")
        for _ in range(2):
            manager.wait_for("WATCHDOG=1")
        daemon.end()
        manager.wait_for("STOPPING=1")
        check(all(info(path)["closed"] for path in daemon.files()), "a trial is not closed")
    finally:
        daemon.kill()


def abstract(directory):
    """A manager whose socket has a name and no path; a watchdog that is meant for another process."""
    manager = ServiceManager(directory, is_abstract=True)
    head = Head(Terminal(directory))
    for_another = {**manager.environment(), "WATCHDOG_PID": "1"}
    daemon = Daemon(directory, head.plug_point.port, "", for_another)
    try:
        manager.wait_for("READY=1")
        check(not manager.says_alive(1.5 * WATCHDOG_S), "it says to be alive, and was not asked")
        daemon.end()
        manager.wait_for("STOPPING=1")
    finally:
        daemon.kill()


def watchdog(directory):
    """Each thread of the recording is missed when it stands still; the first is the one that tells."""
    manager = ServiceManager(directory)
    head = Head(Terminal(directory))
    head.plug()
    daemon = Daemon(directory, head.plug_point.port, "", manager.environment())
    try:
        daemon.wait_for_state("recording")
        manager.wait_for("WATCHDOG=1")
        threads = sorted(int(name) for name in os.listdir(f"/proc/{daemon.process.pid}/task"))
        check(len(threads) == 3, f"threads {threads}")
        for thread in threads[1:]:
            with StoppedThread(thread) as stopped:
                if not stopped:
                    skip("ptrace is not allowed here")
                time.sleep(2 * WATCHDOG_S)  # what is still said has been
                while manager.hear(0):
                    pass
                check(not manager.says_alive(1.5 * WATCHDOG_S), "it says to be alive, and is not")
            check(manager.says_alive(DEADLINE_S), "it goes on and does not say so")
            print("a thread that stands still is noticed")
        daemon.end()
    finally:
        daemon.kill()


def status(directory):
    """A killed daemon's socket is replaced, a live one's is refused; a wrong file has status 2."""
    head = Head(Terminal(directory))
    head.plug()
    daemon = Daemon(directory, head.plug_point.port, "[labels]\nrig = 'A'")
    other = None
    try:
        shown = daemon.wait_for_state("recording")
        check(shown["file"] in daemon.files(), f"writes {shown['file']}")
        text = subprocess.run([PROGRAM, "acquire", "--status", daemon.config], capture_output=True,
                              text=True)
        check(text.returncode == 0 and "1 of 1 recording" in text.stdout and " recording  " in text.stdout, str(text))
        check(shown["file"] in text.stdout, text.stdout)

        second = subprocess.run([PROGRAM, "acquire", "--daemon", daemon.config],
                                capture_output=True, text=True, timeout=DEADLINE_S)
        check(second.returncode == 1 and "another daemon answers there" in second.stderr,
              f"a second daemon: {second}")
        # one that asks and does not listen does not stop it
        deaf = socket.socket(socket.AF_UNIX)
        deaf.connect(daemon.socket)
        daemon.wait_for_readings(100)
        deaf.close()

        daemon.kill()
        check(os.path.exists(daemon.socket), "the killed daemon took its socket along")
        asked = subprocess.run([PROGRAM, "acquire", "--status", daemon.socket], capture_output=True)
        check(asked.returncode == 3, f"a dead daemon's status: {asked}")
        other = Daemon(directory, head.plug_point.port, "")
        other.wait_for_state("recording")
        other.end()
    finally:
        daemon.kill()
        if other:
            other.kill()


def answers_at_its_default(directory, *words):
    """Without the key `socket`: what `acquire --status WORDS` says of the only daemon."""
    config = os.path.join(directory, "rig.toml")
    with open(config, "w") as file:
        file.write(f"directory = '{directory}'\n[[sensor]]\nname = 'a'\nport = '/dev/none'\n")
    environment = {**os.environ, "XDG_RUNTIME_DIR": directory}
    run("acquire", "--status", config, status=3, env=environment)
    with subprocess.Popen([PROGRAM, "acquire", "--daemon", config], env=environment,
                          stderr=subprocess.DEVNULL) as daemon:
        try:
            wait_for("a socket", lambda: os.path.exists(f"{directory}/haptometer/rig.sock"))
            said = run("acquire", "--status", *words, env=environment).stdout
        finally:
            daemon.send_signal(signal.SIGTERM)
    check(daemon.returncode == 0, f"ends with {daemon.returncode}")
    return said


def default_socket(directory):
    """It is below $XDG_RUNTIME_DIR, and the file leads there."""
    said = answers_at_its_default(directory, os.path.join(directory, "rig.toml"))
    check("recording; a: " in said, f"the file does not lead to the socket: {said}")


def only_daemon(directory):
    """The only daemon needs no name."""
    if os.path.isdir("/run/haptometer"):
        skip("the system's own daemons are found first (/run/haptometer)")
    said = answers_at_its_default(directory)
    check("recording; a: " in said, f"the only daemon is not found: {said}")


def refused(directory):
    """What the sensor does not have is said once, with status 2."""
    daemon = Daemon(directory, "/dev/null", "")
    with open(daemon.config, "a") as file:
        file.write("[[sensor]]\nname = 'il'\nport = '/dev/zero'\nbaud = 1234\n")
    daemon.kill()
    ended = subprocess.run([PROGRAM, "acquire", "--daemon", daemon.config], capture_output=True,
                           text=True, timeout=DEADLINE_S)
    check(ended.returncode == 2 and "has no 1234 baud" in ended.stderr, str(ended))


def check_chain(files):
    """Every line is in one of the files, and each names the one before."""
    check_consecutive([number for path in files for _, number in numbered_rows(path)], "all files")
    for before, after in zip(files, files[1:]):
        check(info(before)["closed"], f"{before} is not closed")
        check(before in str(info(after)), f"{after} does not name {before}")


def rotation(directory):
    """By size: no line is lost between the files."""
    head = Head(Terminal(directory), lines_per_s=4000)
    head.plug()
    daemon = Daemon(directory, head.plug_point.port, "rotate_bytes = 65536\nflush_s = 0.1")
    try:
        wait_for("four files", lambda: daemon.status() and len(daemon.files()) >= 4)
        daemon.end()
    finally:
        daemon.kill()
    check_chain(daemon.files())


def hang_up(directory):
    """SIGHUP begins a new file; no line is lost between them."""
    head = Head(Terminal(directory))
    head.plug()
    daemon = Daemon(directory, head.plug_point.port, "flush_s = 0.1")
    try:
        for files in (1, 2, 3):
            daemon.wait_for_state("recording")
            daemon.wait_for_readings(200)
            check(len(daemon.files()) == files, f"{daemon.files()}")
            daemon.process.send_signal(signal.SIGHUP)
            wait_for("a new file", lambda: len(daemon.files()) == files + 1)
        daemon.end()
    finally:
        daemon.kill()
    check_chain(daemon.files())


def at_a_terminal(directory):
    """SIGHUP is the closed terminal of a daemon that was started at one: it ends, and frees the port."""
    head = Head(Terminal(directory))
    head.plug()
    master, slave = pty.openpty()
    daemon = Daemon(directory, head.plug_point.port, "flush_s = 0.1", stdin=slave)
    try:
        daemon.wait_for_state("recording")
        daemon.wait_for_readings(200)
        daemon.process.send_signal(signal.SIGHUP)
        status = daemon.process.wait(DEADLINE_S)
        check(status == 0, f"SIGHUP ends it with {status}: {daemon.said()}")
    finally:
        daemon.kill()
        os.close(master)
        os.close(slave)
    check(len(daemon.files()) == 1 and info(daemon.files()[0])["closed"], daemon.files())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        {part.__name__: part for part in (abstract, at_a_terminal, default_socket, hang_up, notify, only_daemon, refused,
                                          rotation, status, watchdog)}[sys.argv[1]](scratch)
