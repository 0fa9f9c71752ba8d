"""Sources that fall silent before the end of a recording, with the connection still open: the status is 1, the trial
is kept with the doubt and is interrupted; one that talks on to the end is neither."""
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, check, info, program

LENGTH_S = 2.0
SILENT_FROM_S = 0.6


def stream(connection, end_s):
    """A line each 2 ms."""
    begin = time.monotonic()
    count = 0
    while time.monotonic() < begin + end_s:
        connection.sendall(b"+%02d.%04d\r" % (count // 10000, count % 10000))
        count += 1
        time.sleep(0.002)


def unit(connection, end_s):
    """A DL-RS1A that answers from the first request on."""
    end = None
    while True:
        request = connection.recv(100)
        if not request:
            return
        end = end or time.monotonic() + end_s
        if time.monotonic() > end:
            continue
        if request.startswith(b"M0"):
            connection.sendall(b"M0,+00.123\r\n")
        else:
            connection.sendall(b"MS,04,+00.123\r\n" if request.startswith(b"MS") else b"ER,SR,22\r\n")


def over_tcp(peer, end_s, words, trial):
    """What acquire ends with and prints of `peer`, which talks for `end_s`; its connection stays open."""
    done = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:
        def serve():
            connection, _ = server.accept()
            with connection:
                try:
                    peer(connection, end_s)
                except OSError:
                    pass  # acquire has ended
                done.wait(DEADLINE_S)

        threading.Thread(target=serve, daemon=True).start()
        port = f"127.0.0.1:{server.getsockname()[1]}"
        result = subprocess.run([program("haptometer"), "acquire", *words, "--port", port, "--duration",
                                 f"{LENGTH_S}s", "-o", trial, "--json"], capture_output=True, timeout=DEADLINE_S)
        done.set()
    return result.returncode, result.stdout


def piped(end_s, trial):
    """The same of a program that writes 1000 rows a second."""
    with subprocess.Popen([program("haptometer"), "acquire", "--sensor", "pipe", "--format", "text", "--rate", "1kHz",
                           "--channels", "displacement:mm", "--duration", f"{LENGTH_S}s", "-o", trial, "--json"],
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as acquire:
        begin = time.monotonic()
        rows = 0
        try:
            while acquire.poll() is None and rows < 1000 * end_s:
                due = int(1000 * (time.monotonic() - begin))
                acquire.stdin.write(b"0.5\n" * (due - rows))
                acquire.stdin.flush()
                rows = due
                time.sleep(0.01)
        except BrokenPipeError:
            pass  # it has ended
        # standard input stays open
        answer = acquire.stdout.read()
        acquire.wait(DEADLINE_S)
        try:
            acquire.stdin.close()
        except BrokenPipeError:
            pass
    return acquire.returncode, answer


def examine(name, talk):
    with tempfile.TemporaryDirectory() as directory:
        silent = os.path.join(directory, "silent.bin")
        status, answer = talk(SILENT_FROM_S, silent)
        document = json.loads(answer)
        check(status == 1, f"{name}: status {status}")
        check(document["interrupted"], f"{name} is not interrupted")
        found = [at for at in document["findings"] if at["kind"] == "fell-silent"]
        check(len(found) == 1 and found[0]["severity"] == "doubt", f"{name}: {document['findings']}")
        numbers = found[0]["numbers"]
        check(numbers["length_s"] == LENGTH_S and 0.2 < numbers["last_reading_s"] < 1, f"{name}: {numbers}")
        kept = info(silent)
        check("interrupted" in kept["data_source"], f"{name}: {kept['data_source']}")
        check(any(at["kind"] == "doubted-at-recording" for at in kept["findings"]), f"{name}: {kept['findings']}")

        status, answer = talk(100, os.path.join(directory, "whole.bin"))
        document = json.loads(answer)
        check(status == 0 and not document["interrupted"], f"{name} to the end: {status}, {document['findings']}")


def main():
    examine("stream", lambda end_s, trial: over_tcp(stream, end_s, ["--sensor", "stream"], trial))
    examine("unit", lambda end_s, trial: over_tcp(unit, end_s, ["--sensor", "keyence-il", "--baud", "38400"], trial))
    examine("pipe", piped)


if __name__ == "__main__":
    main()
