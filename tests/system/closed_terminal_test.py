"""A recording whose terminal is closed, or that is interrupted twice at once, ends in order."""
import os
import signal
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import SCENE, check, info, wait_for
from terminal import Terminal

APART_S = 0.002  # signals that come at once are one


def recording(directory):
    """A terminal with a recording of a minute that has begun, and its trial."""
    path = os.path.join(directory, "trial.bin")
    terminal = Terminal("acquire", "--sensor", f"scene:{SCENE}", "--duration", "60s", "-o", path)
    wait_for("a trial", lambda: os.path.exists(path) and os.path.getsize(path) > 4096)
    return terminal, path


def check_whole(path):
    """The trial was closed by its recorder."""
    trial = info(path)
    check(trial["closed"] and trial["rows"] > 0, trial)


def closed(directory):
    """The kernel and the shell both tell of it."""
    terminal, path = recording(directory)
    os.close(terminal.master)
    os.close(terminal.slave)
    for _ in range(2):
        terminal.kill(signal.SIGHUP)
        time.sleep(APART_S)
    status = wait_for("the end", lambda: (lambda done: done if done[0] else None)(os.waitpid(terminal.pid, os.WNOHANG)))
    terminal.status = os.waitstatus_to_exitcode(status[1])
    check(terminal.status == 129, terminal.status)
    check_whole(path)


def twice(directory):
    """`timeout -s INT` signals the process and its group."""
    for number, expected in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)):
        with tempfile.TemporaryDirectory(dir=directory) as folder:
            terminal, path = recording(folder)
            terminal.kill(number)
            time.sleep(APART_S)
            os.killpg(terminal.pid, number)
            check(terminal.end() == expected, (terminal.status, terminal.text))
            terminal.close()
            check_whole(path)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        {part.__name__: part for part in (closed, twice)}[sys.argv[1]](scratch)
