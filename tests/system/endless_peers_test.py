"""Peers that never fall silent, at memory speed: acquire ends by its duration and by SIGTERM, in little memory.

A peer answers as its device does until the recording has begun, and then sends bytes that end no line and no
frame, or frames that nobody asked for, as fast as the port takes them. Or it sends them from the first moment on.

Usage: endless_peers_test.py [NAME...], the names of combinations; all without. Internally:
endless_peers_test.py --peer TRANSPORT PROTOCOL PAYLOAD BYTES_BEFORE
"""
import os
import random
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import tty

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, program, wait_for

RUNS_AT_ONCE = 2
# a run that does not end is killed; the exact times are printed
LONGEST_S = 60
# the ring of waiting rows holds 64 MB, the program some 20; a line kept for ever would soon be far more
MOST_MEMORY_KIB = 200_000
# the address sanitizer keeps what is freed, 256 MB of it by default, and counts itself; 1 GB is beyond both
SANITIZED_MEMORY_KIB = 1_000_000
BLOCK = 1 << 16
PAYLOADS = ("empty", "endless", "foreign", "random", "nul")

# name: transport, protocol, what ends a line, options of acquire
COMBINATIONS = {
    "il-pty": ("pty", "il", b"\r\n", ["--sensor", "keyence-il"]),
    "il-tcp": ("tcp", "il", b"\r\n", ["--sensor", "keyence-il"]),
    "en1-tcp": ("tcp", "en1", b"\r\n", ["--sensor", "keyence-en1", "--decimals", "3"]),
    "lkg-pty": ("pty", "lkg", b"\r", ["--sensor", "keyence-lkg", "--baud", "115200"]),
    "lkg-tcp": ("tcp", "lkg", b"\r", ["--sensor", "keyence-lkg", "--baud", "115200"]),
    "stream-pty": ("pty", "stream", b"\r", ["--sensor", "stream"]),
    "stream-tcp": ("tcp", "stream", b"\r", ["--sensor", "stream"]),
    "numbered-tcp": ("tcp", "numbered", b"\r",
                     ["--sensor", "stream", "--format", "000,+00.0000,mm,CR"]),
    "rtu-pty": ("pty", "rtu", b"", ["--sensor", "modbus", "--profile", "wt53r"]),
    "modbus-tcp": ("tcp", "mbap", b"", ["--sensor", "modbus", "--profile", "wt53r"]),
    "pipe-f64": ("pipe", "f64", b"", ["--format", "f64"]),
    "pipe-f32": ("pipe", "f32", b"", ["--format", "f32"]),
    "pipe-i16": ("pipe", "i16", b"", ["--format", "i16"]),
    "pipe-text": ("pipe", "text", b"\n", ["--format", "text"]),
}


# --- the peer -----------------------------------------------------------------------------------------------

def crc(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return struct.pack("<H", value)


def modbus_reply(protocol, request):
    """To a request for registers: each holds 500."""
    head, pdu = (request[:6], request[6:]) if protocol == "mbap" else (b"", request)
    count = struct.unpack(">H", pdu[4:6])[0]
    body = bytes([pdu[0], pdu[1], 2 * count]) + struct.pack(">H", 500) * count
    if protocol == "rtu":
        return body + crc(body)
    return head[:4] + struct.pack(">H", len(body)) + body


def line_reply(protocol, command):
    if protocol == "lkg":
        return command + b",+01.2345\r"
    value = b"+00.018" if protocol == "il" else b"+000000018"
    if command in (b"M0", b"MS"):
        return command + (b",04," if command == b"MS" else b",") + value + b"\r\n"
    return b"ER," + command[:2] + (b",22\r\n" if protocol == "il" else b",016\r\n")


def free_running(protocol):
    """What is sent unasked, a second of it."""
    if protocol == "stream":
        return b"+01.2345\r" * 2000
    if protocol == "numbered":
        return b"".join(b"%03d,+01.2345\r" % (i % 1000) for i in range(2000))
    one = {"f64": struct.pack("<d", 1e-6), "f32": struct.pack("<f", 1e-6), "i16": b"\x01\x00", "text": b"1e-6\n"}
    return one[protocol] * 1000


def foreign(protocol):
    """Sound, but to another question."""
    frames = {"il": b"DR,04,+00.018\r\n", "en1": b"SR,01,037,+000000003\r\n", "lkg": b"G1,+01.2345\r",
              "stream": b"+01.2345\r", "numbered": b"007,+01.2345\r", "text": b"1e-6\n", "f64": b"\0" * 8,
              "f32": b"\0" * 4, "i16": b"\0\0"}
    if protocol == "rtu":
        return bytes([9, 3, 2, 1, 244]) + crc(bytes([9, 3, 2, 1, 244]))
    if protocol == "mbap":
        return struct.pack(">HHHBBBH", 60000, 0, 5, 80, 3, 2, 500)
    return frames[protocol]


def flood_of(protocol, payload, end):
    block = {"empty": end or b"\0", "endless": b"+", "foreign": foreign(protocol), "nul": b"\0",
             "random": random.Random(7).randbytes(BLOCK)}[payload]
    return block * max(1, BLOCK // len(block))


class Port:
    def __init__(self, transport):
        if transport == "pty":
            self.descriptor, slave = os.openpty()
            tty.setraw(slave)
            print(os.ttyname(slave), flush=True)
        elif transport == "tcp":
            listener = socket.create_server(("127.0.0.1", 0))
            print("127.0.0.1:%d" % listener.getsockname()[1], flush=True)
            self.connection = listener.accept()[0]
            self.descriptor = self.connection.detach()
        else:
            self.descriptor = sys.stdout.fileno()
        os.set_blocking(self.descriptor, False)

    def read(self):
        try:
            return os.read(self.descriptor, 4096)
        except BlockingIOError:
            return b""

    def write(self, data):
        while data:
            select.select([], [self.descriptor], [])
            try:
                data = data[os.write(self.descriptor, data):]
            except BlockingIOError:
                pass


def serve_politely(port, protocol, replies):
    heard = b""
    while replies > 0:
        select.select([port.descriptor], [], [])
        heard += port.read()
        size = {"rtu": 8, "mbap": 12}.get(protocol)
        end = b"\r" if protocol == "lkg" else b"\r\n"
        while size and len(heard) >= size or not size and end in heard:
            if size:
                port.write(modbus_reply(protocol, heard[:size]))
                heard = heard[size:]
            else:
                command, heard = heard.split(end, 1)
                port.write(line_reply(protocol, command))
            replies -= 1


def run_peer(transport, protocol, payload, end, replies):
    port = Port(transport)
    asked = protocol in ("il", "en1", "lkg", "rtu", "mbap")
    if replies and asked:
        serve_politely(port, protocol, replies)
    elif replies:
        for _ in range(3):
            port.write(free_running(protocol))
            time.sleep(0.1)
    block = flood_of(protocol, payload, end)
    while True:
        if transport != "pipe":
            port.read()
        port.write(block)


# --- acquire -------------------------------------------------------------------------------------------------

def start(name, payload, replies, duration, trial):
    transport, protocol, _, options = COMBINATIONS[name]
    peer = subprocess.Popen([sys.executable, os.path.abspath(__file__), "--peer", name, payload, str(replies)],
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    command = [program("haptometer"), "acquire", "-o", trial, *options]
    if transport == "pipe":
        command += ["--sensor", "pipe", "--rate", "1kHz"]
        if protocol == "i16":
            calibration = trial + ".toml"
            with open(calibration, "w", encoding="utf-8") as file:
                file.write("[displacement]\nscale_m_per_v = 1e-3\nv_per_count = 1e-4\n")
            command += ["--channels", "displacement", "--calibration", calibration]
        else:
            command += ["--channels", "displacement:m"]
    else:
        command += ["--port", peer.stdout.readline().decode().strip()]
    if duration:
        command += ["--duration", duration]
    acquire = subprocess.Popen(command, stdin=peer.stdout if transport == "pipe" else subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    return peer, acquire


def wait(acquire):
    """Status, peak memory in KiB, and how long it took."""
    begin = time.monotonic()
    killer = threading.Timer(LONGEST_S, os.kill, (acquire.pid, signal.SIGKILL))
    killer.start()
    _, status, usage = os.wait4(acquire.pid, 0)
    killer.cancel()
    acquire.returncode = os.waitstatus_to_exitcode(status)
    return acquire.returncode, usage.ru_maxrss, time.monotonic() - begin


def catches_sigterm(pid):
    """Before that, SIGTERM ends a process as the system does; or the process has ended by itself."""
    with open(f"/proc/{pid}/status", encoding="ascii", errors="replace") as file:
        text = file.read()
    caught = re.search(r"^SigCgt:\s*([0-9a-f]+)", text, re.MULTILINE)
    ended = re.search(r"^State:\s*Z", text, re.MULTILINE)
    return ended or caught and int(caught.group(1), 16) >> (signal.SIGTERM - 1) & 1


def is_sanitized():
    with open(program("haptometer"), "rb") as file:
        return b"__asan_init" in file.read()


def run_case(case, results):
    name, payload, replies, ending = case
    with tempfile.TemporaryDirectory() as directory:
        trial = os.path.join(directory, "t.bin")
        peer, acquire = start(name, payload, replies, "1s" if ending == "duration" else "", trial)
        said = []
        reader = threading.Thread(target=lambda: said.append(acquire.stderr.read().decode(errors="replace")))
        reader.start()
        if ending == "SIGTERM":
            wait_for(f"the recording of {case}", lambda: catches_sigterm(acquire.pid))
            time.sleep(1)
            os.kill(acquire.pid, signal.SIGTERM)  # Popen's own way may collect its status
        status, memory_kib, took_s = wait(acquire)
        reader.join()
        peer.kill()
        peer.wait()
        peer.stdout.close()
        acquire.stderr.close()
        results.append((case, status, memory_kib, took_s, said[0]))


def faults_of(result, most_memory_kib):
    case, status, memory_kib, took_s, said = result
    if status < 0:
        yield f"{case} ended by signal {-status} after {took_s:.0f} s: {said}"
    # what cannot be recorded is said before; what is ended by a signal says so
    elif status not in (0, 1, 3, 143):
        yield f"{case}: status {status}: {said}"
    if memory_kib >= most_memory_kib:
        yield f"{case}: {memory_kib} KiB"


def main(names):
    cases = []
    for name in names:
        for i, payload in enumerate(PAYLOADS):
            cases.append((name, payload, 12, "duration" if i % 2 else "SIGTERM"))
        cases.append((name, "empty", 12, "duration"))
        cases.append((name, "empty", 0, "SIGTERM"))
        cases.append((name, "endless", 0, "SIGTERM"))
    most_memory_kib = SANITIZED_MEMORY_KIB if is_sanitized() else MOST_MEMORY_KIB
    results = []
    waiting = list(cases)

    def work():
        while waiting:
            run_case(waiting.pop(), results)

    workers = [threading.Thread(target=work) for _ in range(RUNS_AT_ONCE)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    faults = [fault for result in sorted(results) for fault in faults_of(result, most_memory_kib)]
    check(not faults, "\n".join(faults))
    for case, status, memory_kib, took_s, _ in sorted(results):
        print(*case, "status", status, f"{memory_kib / 1024:.0f} MB {took_s:.2f} s", flush=True)
    check(len(results) == len(cases), f"{len(results)} of {len(cases)} ended")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--peer"]:
        transport, protocol, end, _ = COMBINATIONS[sys.argv[2]]
        try:
            run_peer(transport, protocol, sys.argv[3], end, int(sys.argv[4]))
        except OSError:
            pass  # acquire has ended
    else:
        main(sys.argv[1:] or list(COMBINATIONS))
