"""A daemon on a small disk (a tmpfs in a namespace of its own; skipped where that is not allowed):
its trials are closed before the disk is full, and it goes on once there is room."""
import errno
import os
import subprocess
import sys
import tempfile

from daemon_run import Daemon, Head, Tcp, check_consecutive, numbered_rows

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, info, skip, wait_for

RESERVE_BYTES = 2 << 20


def free_bytes(directory):
    disk = os.statvfs(directory)
    return disk.f_bavail * disk.f_frsize


def take_room(file, leave):
    """Takes the disk's room but `leave` bytes in one step; true where no more than that is left.
    The daemon writes meanwhile: what it takes between the question and the step is asked again."""
    size = free_bytes(os.path.dirname(file.name)) - leave
    if size > 0:
        try:
            os.posix_fallocate(file.fileno(), os.fstat(file.fileno()).st_size, size)
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
    return free_bytes(os.path.dirname(file.name)) <= leave


def fill(path, leave):
    """Takes all of the disk's room but `leave` bytes."""
    with open(path, "wb") as file:
        wait_for("a full disk", lambda: take_room(file, leave))


def check_file(path, closed=True):
    """It is read, and holds the head's lines without a hole."""
    shown = info(path)
    check(shown["closed"] or not closed, f"{path} is not closed")
    check_consecutive([number for _, number in numbered_rows(path)], path)
    return shown


def room_ends(daemon, hog):
    """The reserve is reached: closed with a remark, and the next file says why it begins."""
    daemon.wait_for_readings(500)
    first, = daemon.files()
    fill(hog, RESERVE_BYTES - 65536)
    waiting = daemon.wait_for_state("waiting for disk")
    check(waiting["disk_waits"] == 1 and waiting["file"] is None, f"waits as {waiting}")
    shown = check_file(first)
    remark = shown["events"][-1]["text"]
    check("bytes are free" in remark, f"closed with the remark {remark!r}")
    check(shown["rows"] == waiting["readings"], f"{shown['rows']} of {waiting['readings']} rows")
    os.unlink(hog)
    daemon.wait_for_state("recording")
    daemon.wait_for_readings(500)
    check(len(daemon.files()) == 2, f"{daemon.files()}")
    second = info(daemon.files()[1])
    print("after the pause:", second["notes"])
    check("the disk had no room" in str(second["notes"]), "the next file does not say why")
    check(first in str(second), "the next file does not name the one before")


def no_byte_left(daemon, hog):
    """Another program takes the reserve too: what was written is read, and it tries again."""
    fill(hog, 0)
    state = daemon.wait_for_state("waiting for disk")
    print("no byte left:", state["last_error"])
    check_file(daemon.files()[1], closed=False)
    os.unlink(hog)
    daemon.wait_for_state("recording")
    daemon.wait_for_readings(500)
    daemon.end()
    for path in daemon.files():
        check_file(path, closed=path != daemon.files()[1])


def inside(directory):
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "none", directory], check=True)
    head = Head(Tcp(resets=False))
    head.plug()
    daemon = Daemon(directory, head.plug_point.port,
                    f"flush_s = 0.05\nreserve_bytes = {RESERVE_BYTES}")
    try:
        hog = os.path.join(directory, "hog")
        wait_for("a status", daemon.status)
        room_ends(daemon, hog)
        no_byte_left(daemon, hog)
    finally:
        daemon.kill()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        inside(sys.argv[1])
        sys.exit()
    if subprocess.run(["unshare", "-rm", "true"], capture_output=True).returncode != 0:
        skip("no namespace for a small disk (unshare -rm)")
    with tempfile.TemporaryDirectory() as directory:
        sys.exit(subprocess.run(["unshare", "-rm", sys.executable, __file__, directory]).returncode)
