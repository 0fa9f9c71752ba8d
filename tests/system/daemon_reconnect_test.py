"""Unplugs and replugs a daemon's sensor: terminal (EIO), orderly end (0 bytes), TCP reset.

Prints how long after the return the first reading comes and what the processor does while the
device is away (the product's bars: 1 s, 5 %); asserts only that the recording goes on.
"""
import os
import sys
import tempfile
import time

from daemon_run import Daemon, Head, Tcp, Terminal, numbered_rows

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import Emulator, check, info, wait_for

AWAY_S = 3


def longest_pause_s(path):
    times = [time_s for time_s, _ in numbered_rows(path)]
    return max(after - before for before, after in zip(times, times[1:]))


def replug(daemon, head):
    """One outage. Returns its length and the processor's share meanwhile."""
    daemon.wait_for_readings(200)
    head.unplug()
    begin = time.monotonic()
    time.sleep(0.2)
    cpu_s, cpu_begin = daemon.cpu_s(), time.monotonic()
    time.sleep(AWAY_S)
    share = (daemon.cpu_s() - cpu_s) / (time.monotonic() - cpu_begin)
    before = daemon.status()
    check(before["state"] == "away", f"unplugged, it is {before['state']}")
    head.plug()
    length_s = time.monotonic() - begin
    state = daemon.wait_for_state("recording")
    check(state["reconnects"] == before["reconnects"] + 1, f"{state['reconnects']} reconnects")
    daemon.wait_for_readings(200)
    return length_s, share


def run(kind):
    with tempfile.TemporaryDirectory() as directory:
        plug = Terminal(directory) if kind == "terminal" else Tcp(resets=kind == "reset")
        head = Head(plug)
        # it is not there at the start, either
        daemon = Daemon(directory, plug.port, "flush_s = 0.1",
                        sensor='sensor = "stream"\naverages = 16\nsampling_s = "0.33ms"')
        try:
            waiting = daemon.wait_for_state("waiting for device")
            check(waiting["last_error"], "waits for a device and does not say why")
            head.plug()
            daemon.wait_for_state("recording")
            for _ in range(2):
                length_s, share = replug(daemon, head)
                path, = daemon.files()
                resumed_s = longest_pause_s(path) - length_s
                print(f"{kind}: first reading {resumed_s:.3f} s after the return, "
                      f"processor {100 * share:.2f} % while away")
                check(share < 0.5, f"it spins while the device is away: {share}")
            daemon.end()
        finally:
            daemon.kill()

        # the trial tells it all
        path, = daemon.files()
        shown = info(path)
        check(shown["closed"], "the trial is not closed")
        # the averaging that the daemon's file states, so that amplitudes can be verified
        stated = [shown[key] for key in ("averages", "sampling_s")]
        check(stated == [16, 0.33e-3], f"averaging {stated}")
        texts = [(event["event"], event["text"]) for event in shown["events"]]
        lost = [text for kind, text in texts if text == "the connection was lost"]
        back = [text for kind, text in texts if kind == "reconnect"]
        check(len(lost) == 2 and len(back) == 2, f"events {texts}")
        check(len(shown["gaps"]) >= 2, f"gaps {shown['gaps']}")


def emulator():
    """A polled unit that drops off its line every 60 answers, and is back at once."""
    with tempfile.TemporaryDirectory() as directory:
        link = os.path.join(directory, "unit")
        with Emulator("--baud", "38400", "--fault", "disconnect:60", "--link", link):
            daemon = Daemon(directory, link, "flush_s = 0.1", sensor="baud = 38400")
            try:
                daemon.wait_for_state("recording")
                wait_for("three returns", lambda: daemon.status()["reconnects"] >= 3)
                daemon.end()
            finally:
                daemon.kill()
        path, = daemon.files()
        events = [event["event"] for event in info(path)["events"]]
        check(events.count("reconnect") >= 3, f"events {events}")
        statuses = info(path)["statuses"]
        check(statuses["ok"] + statuses["repeated"] == info(path)["rows"], f"rows {statuses}")


if __name__ == "__main__":
    if sys.argv[1] == "emulator":
        emulator()
    else:
        run(sys.argv[1])
