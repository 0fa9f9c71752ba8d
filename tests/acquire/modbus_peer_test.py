"""acquire against python3-pymodbus (Debian), which shares no code with it: TCP by pymodbus's own server,
RTU by its framer, decoder and register store on a pseudo-terminal; every value compared exactly."""
import json
import os
import pty
import select
import signal
import struct
import sys
import tempfile
import threading
import time
import tty
import types

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import programs
from programs import check, skip

# pymodbus imports pyserial's modules even where no serial port is opened; Debian only suggests them
for name in ("serial", "serial_asyncio"):
    try:
        __import__(name)
    except ImportError:
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].create_serial_connection = None
try:
    from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
    from pymodbus.factory import ServerDecoder
    from pymodbus.server import StartTcpServer
    from pymodbus.transaction import ModbusRtuFramer
except ImportError as missing:
    skip(f"{missing}; install python3-pymodbus")

READINGS = 40

# float32 values that a sensor may send, two of which are none
FLOATS = [69.7426, 30.0, 30.000001, -1.5, 1e-30, float("nan"), float("inf"), 0.1]

PROFILE = """
name = "peer"
[wire]
transport = "{transport}"
baud = 115200
parity = "none"
slave = {slave}
[request]
function = {function}
address = 101
address_base = 1
count = 4
[value]
address = 102
type = "{type}"
order = "{order}"
unit = "mm"
"""


def words(text, order):
    """The registers of four bytes (most significant first) in an order of telegraf's names."""
    placed = bytes(text["ABCD".index(letter)] for letter in order)
    return list(struct.unpack(">HH", placed))


class Counting(ModbusSequentialDataBlock):
    """Registers of which 101 and 102 (from 0) hold the next value at each read of four."""

    def __init__(self, encode):
        super().__init__(0, [0] * 200)
        self.encode, self.reads = encode, 0

    def getValues(self, address, count=1):
        # pymodbus 3.0 adds one to the address of the wire
        if count == 4:
            self.values[102:104] = self.encode(self.reads)
            self.reads += 1
        return super().getValues(address, count)


def context(block, slave):
    store = ModbusSlaveContext(di=block, co=block, hr=block, ir=block)
    return ModbusServerContext(slaves={slave: store}, single=False)


class RtuPeer:
    def __init__(self, store):
        self.master, self.slave_end = pty.openpty()
        tty.setraw(self.slave_end)
        self.port = os.ttyname(self.slave_end)
        self.store, self.running = store, True
        self.framer = ModbusRtuFramer(ServerDecoder())
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()

    def serve(self):
        while self.running:
            if not select.select([self.master], [], [], 0.05)[0]:
                continue
            self.framer.processIncomingPacket(os.read(self.master, 512), self.answer, unit=[],
                                              single=True)

    def answer(self, request):
        if request.unit_id not in self.store.slaves():
            return
        reply = request.execute(self.store[request.unit_id])
        reply.transaction_id, reply.unit_id = request.transaction_id, request.unit_id
        os.write(self.master, self.framer.buildPacket(reply))

    def close(self):
        self.running = False
        self.thread.join()
        os.close(self.slave_end)
        os.close(self.master)


class TcpPeer:
    def __init__(self, store):
        import socket
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            number = free.getsockname()[1]
        self.port = f"127.0.0.1:{number}"
        self.thread = threading.Thread(
            target=StartTcpServer, kwargs={"context": store, "address": ("127.0.0.1", number)},
            daemon=True)  # its own stop does not end it while a socket lingers
        self.thread.start()
        for _ in range(200):
            try:
                socket.create_connection(("127.0.0.1", number), 1).close()
                return
            except OSError:
                time.sleep(0.05)
        sys.exit("FAILED: pymodbus does not listen")

    def close(self):
        pass


def record(port, profile, trial, *options):
    done = programs.run("acquire", "--sensor", "modbus", "--profile", profile, "--port", port, "-o",
                        trial, "--samples", str(READINGS), "--json", *options)
    return json.loads(done.stdout), programs.rows(trial)


def as_f32(number):
    return struct.unpack(">f", struct.pack(">f", number))[0]


def run(kind, value_type, order, directory):
    slave = 17
    if value_type == "f32":
        values = [as_f32(FLOATS[n % len(FLOATS)]) for n in range(READINGS + 1)]
        pack = lambda n: struct.pack(">f", values[n])
    elif value_type == "i32":
        values = [(-1) ** n * (n * 12_345_678 % 2 ** 31) for n in range(READINGS + 1)]
        pack = lambda n: struct.pack(">i", values[n])
    else:
        values = [(n * 123_456_789) % 2 ** 32 for n in range(READINGS + 1)]
        pack = lambda n: struct.pack(">I", values[n])
    block = Counting(lambda n: words(pack(min(n, READINGS)), order))
    store = context(block, slave)
    profile = f"{directory}/profile.toml"
    with open(profile, "w", encoding="utf-8") as file:
        file.write(PROFILE.format(transport=kind, slave=slave, function=4 if order == "CDAB" else 3,
                                  type=value_type, order=order))
    peer = (TcpPeer if kind == "tcp" else RtuPeer)(store)
    try:
        summary, rows = record(peer.port, profile, f"{directory}/{kind}{value_type}{order}.bin")
    finally:
        peer.close()
    check(summary["readings"] == READINGS and len(rows) == READINGS, f"{summary}")
    for number, row in enumerate(rows, start=1):  # read 0 was the start
        expected = values[number]
        where = f"{kind} {value_type} {order}, reading {number}: {row}, expected {expected}"
        if expected != expected or expected in (float("inf"), float("-inf")):
            check(row["status"] == "invalid", where)
            continue
        check(row.get("status") in (None, "", "ok"), where)
        # one product, as the file's reader makes it; both sides round to the nearest double
        check(float(row["displacement_m"]) == expected * 1e-3, where)
    print(f"{kind} {value_type} {order}: {READINGS} readings equal")


def wrong_slave(directory):
    """A slave that is not there is a message, not a hang."""
    peer = RtuPeer(context(Counting(lambda n: [0, 0]), 17))
    profile = f"{directory}/profile.toml"
    done = programs.run("acquire", "--sensor", "modbus", "--profile", profile, "--slave", "9", "--port",
                        peer.port, "-o", f"{directory}/none.bin", status=3)
    peer.close()
    check("nothing answers to slave 9" in done.stderr, done.stderr)


signal.alarm(240)
with tempfile.TemporaryDirectory() as temporary:
    for orders in ("CDAB", "ABCD", "BADC", "DCBA"):
        run("rtu", "f32", orders, temporary)
    run("rtu", "i32", "ABCD", temporary)
    wrong_slave(temporary)
    run("tcp", "f32", "CDAB", temporary)
    run("tcp", "u32", "DCBA", temporary)
sys.stdout.flush()
os._exit(0)
