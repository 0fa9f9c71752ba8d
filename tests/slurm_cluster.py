"""A Slurm of one or more nodes on this machine's loopback, in a folder of its own, without systemd, for tests.

    with Cluster(folder, nodes=2) as cluster:
        subprocess.run(["sbatch", ...], env=cluster.environment)

Needs root and Debian's slurm-wlm and munge: is_possible(). Every process that it starts ends with it.
"""
import os
import pathlib
import signal
import socket
import subprocess
import time

WAIT_S = 60


def is_possible():
    programs = ("slurmctld", "slurmd", "munged", "sbatch")
    found = subprocess.run(["sh", "-c", " && ".join(f"command -v {name}" for name in programs)], capture_output=True)
    return found.returncode == 0 and os.geteuid() == 0


def free_ports(count):
    """Ports of loopback that nothing listens on now."""
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def ended(pid):
    """Whether the process is gone or a zombie."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


class Cluster:
    def __init__(self, folder, nodes=1, cpus=2):
        self.folder = pathlib.Path(folder)
        self.nodes = [f"n{number}" for number in range(1, nodes + 1)]
        self.cpus = cpus
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}

    def __enter__(self):
        for name in ("state", "log"):
            (self.folder / name).mkdir(parents=True)
        self.folder.chmod(0o755)
        self.write_configuration()
        self.start_munge()
        self.start_controller()
        for node in self.nodes:
            self.start_node(node)
        self.wait(lambda: self.states().count("idle") == len(self.nodes), "the nodes are idle")
        return self

    def __exit__(self, *_):
        self.run("scancel", "--user=root")
        for name in [*(f"slurmd.{node}" for node in self.nodes), "slurmctld", "munged"]:
            self.stop(name, signal.SIGTERM)
        for pid in self.steps():
            kill_all(pid)

    def write_configuration(self):
        controller, *ports = free_ports(1 + len(self.nodes))
        host, here = socket.gethostname().split(".")[0], self.folder
        lines = [
            "ClusterName=test", f"SlurmctldHost={host}(127.0.0.1)", "SlurmUser=root", "SlurmdUser=root",
            "AuthType=auth/munge", f"AuthInfo=socket={here}/munge.sock", "CredType=cred/munge",
            "CommunicationParameters=NoInAddrAny,NoCtldInAddrAny", f"SlurmctldPort={controller}",
            f"StateSaveLocation={here}/state", f"SlurmdSpoolDir={here}/spool.%n", f"SlurmctldPidFile={here}/slurmctld.pid",
            f"SlurmdPidFile={here}/slurmd.%n.pid", f"SlurmctldLogFile={here}/log/slurmctld.log",
            f"SlurmdLogFile={here}/log/slurmd.%n.log", "ProctrackType=proctrack/linuxproc", "TaskPlugin=task/none",
            "JobAcctGatherType=jobacct_gather/none", "AccountingStorageType=accounting_storage/none", "MpiDefault=none",
            "SelectType=select/cons_tres", "SelectTypeParameters=CR_Core",
            "SchedulerParameters=sched_min_interval=0,batch_sched_delay=0,requeue_delay=1,sched_interval=1,bf_interval=1",
            "ReturnToService=2", "SlurmdTimeout=10", "KillWait=2", "MinJobAge=3600"]
        lines += [f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={self.cpus} RealMemory=1000"
                  for node, port in zip(self.nodes, ports, strict=True)]
        lines.append(f"PartitionName=main Nodes={','.join(self.nodes)} Default=YES MaxTime=INFINITE State=UP")
        (here / "slurm.conf").write_text("\n".join(lines) + "\n")

    def start_munge(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        subprocess.run(["munged", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.sock",
                        f"--pid-file={self.folder}/munged.pid", f"--log-file={self.folder}/log/munged.log",
                        f"--seed-file={self.folder}/munge.seed", "--num-threads=2"], check=True, timeout=WAIT_S)

    def start_controller(self):
        self.run("slurmctld", check=True)

    def start_node(self, node):
        self.run("slurmd", "-N", node, check=True)

    def pid_of(self, name):
        try:
            return int((self.folder / f"{name}.pid").read_text())
        except (FileNotFoundError, ValueError):
            return None

    def stop(self, name, how):
        """Ends a daemon that was started here, and what runs below it where it is killed."""
        pid = self.pid_of(name)
        if pid is None or ended(pid):
            return
        os.kill(pid, how)
        self.wait(lambda: ended(pid), f"{name} ends")

    def lose(self, node):
        """The node and all that runs on it are gone from one moment to the next."""
        steps = self.steps_on(node)
        self.stop(f"slurmd.{node}", signal.SIGKILL)
        for pid in steps:
            kill_all(pid)
        return len(steps)

    def steps(self):
        """Processes that watch over the jobs of this cluster."""
        listed = subprocess.run(["pgrep", "-f", "^slurmstepd: "], capture_output=True, text=True).stdout.split()
        return [int(pid) for pid in listed if f"SLURM_CONF={self.folder}/".encode() in environment_of(pid)]

    def steps_on(self, node):
        return [pid for pid in self.steps() if self.is_on(pid, node)]

    def is_on(self, pid, node):
        """Whether a step is of that node: its job knows the name."""
        return any(f"SLURMD_NODENAME={node}\0".encode() in environment_of(child) for child in children_of(pid))

    def run(self, *words, check=False):
        done = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=WAIT_S, check=check)
        return done.stdout

    def states(self):
        return self.run("sinfo", "-h", "-N", "-o", "%t").split()

    def queue(self):
        """Jobs that are not over."""
        return self.run("squeue", "-h", "-r", "-o", "%i %T").splitlines()

    def wait(self, condition, what, longest_s=WAIT_S):
        deadline = time.monotonic() + longest_s
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"{what}: not within {longest_s} s\n{self.queue()}\n{self.logs()}")
            time.sleep(0.05)

    def wait_for_jobs(self, longest_s):
        self.wait(lambda: not self.queue(), "no job is left", longest_s)

    def logs(self):
        return "\n".join(path.read_text(errors="replace")[-2000:] for path in sorted((self.folder / "log").iterdir()))


def children_of(pid):
    listed = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True).stdout.split()
    return [child for one in listed for child in (*children_of(int(one)), int(one))]


def environment_of(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/environ").read_bytes() + b"\0"
    except OSError:
        return b""


def kill_all(pid):
    """A process and all below it."""
    for one in (*children_of(pid), pid):
        kill(one)


def kill(pid):
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
