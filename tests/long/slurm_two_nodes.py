#!/usr/bin/env python3
"""Campaigns on a Slurm of two nodes on this machine's loopback, disturbed.

    tests/long/slurm_two_nodes.py build/release/bin [--only cost|sweep|study|coverage ...] [--seed N]

A sweep of a scene with stops, a study of 2000 trials and a coverage run (calibration_budget.py), each in chunks. While
they run a node is lost and comes back, the controller is killed and started again, jobs are killed and started again
at random; behind that a chunk's file is cut and a digit of another one is flipped. Then `campaign resume` until all is
merged. The bar: the merged answer is that of one run, and of the chunks that were done before a disturbance none but
the damaged ones was computed again. Also: what N chunks cost against one run, and the overhead of a chunk.

Needs root and the packages slurm-wlm and munge (tools/packages.txt, group oracles).
"""
import argparse
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
sys.path.insert(0, str(ROOT / "tests" / "long"))
import cached_study  # noqa: E402
import slurm_cluster  # noqa: E402
from programs import check, run  # noqa: E402

JOBS_S = 1200
STUDY_TRIALS, RIGS = 2000, 1000
SWEEP = ["sweep", str(ROOT / "fixtures/lra_stops.toml"), "--vary", "drive.frequency_hz=100Hz:400Hz:6001"]


def document(*words, env=None, status=0):
    found = json.loads(run(*words, "--json", env=env, status=status).stdout)
    found.pop("provenance")
    return found


def table(path):
    return [line for line in pathlib.Path(path).read_text().splitlines() if not line.startswith("# provenance")]


def done_chunks(folder):
    """The time at which each finished chunk was written, by its number."""
    return {path.name.partition("of")[0]: path.stat().st_mtime_ns for path in pathlib.Path(folder, "chunks").glob("[0-9]*-*")}


class Disturbances:
    """What happens to a campaign while it runs, and what it may not cost."""

    def __init__(self, cluster, folder, draw):
        self.cluster, self.folder, self.draw = cluster, folder, draw
        self.kept, self.damaged, self.lost, self.killed = {}, set(), 0, 0

    def wait_for_chunks(self, count):
        """Until so many chunks are done; remembers all that are."""
        self.cluster.wait(lambda: len(done_chunks(self.folder)) >= count, f"{count} chunks are done", JOBS_S)
        self.kept.update(done_chunks(self.folder))

    def lose_node(self):
        self.cluster.wait(lambda: self.cluster.steps_on("n2"), "a job is on the node")
        lost = self.cluster.lose("n2")
        check(lost > 0, "no job was on the node that is lost")
        self.lost += lost
        self.cluster.wait(lambda: any(state.startswith("down") for state in self.cluster.states()), "the node is down")
        self.cluster.start_node("n2")

    def restart_controller(self):
        self.cluster.stop("slurmctld", signal.SIGKILL)
        self.cluster.start_controller()

    def kill_jobs(self, count):
        def running_jobs():
            return [line.split()[0] for line in self.cluster.queue() if line.endswith("RUNNING") and "_" in line]

        self.cluster.wait(lambda: running_jobs() or not self.cluster.queue(), "a job is running", JOBS_S)
        running = running_jobs()
        for job in self.draw.sample(running, min(count, len(running))):
            self.cluster.run("scontrol", "requeue", job)
            self.killed += 1
        for pid in pids_below(self.folder)[:1]:
            slurm_cluster.kill(pid)
            self.killed += 1

    def damage(self):
        """A file that is cut, and one with a flipped digit."""
        files = sorted(pathlib.Path(self.folder, "chunks").glob("[0-9]*-*"))
        cut, flipped = self.draw.sample(files, 2)
        cut.write_bytes(cut.read_bytes()[:self.draw.randrange(1, cut.stat().st_size)])
        data = bytearray(flipped.read_bytes())
        places = [place for place, byte in enumerate(data) if chr(byte).isdigit()]
        data[self.draw.choice(places)] ^= 1
        flipped.write_bytes(data)
        self.damaged |= {path.name.partition("of")[0] for path in (cut, flipped)}

    def check_waste(self):
        now = done_chunks(self.folder)
        again = [name for name, when in self.kept.items() if now[name] != when and name not in self.damaged]
        check(not again, f"chunks {again} were done and are computed again")


def pids_below(folder):
    """Commands of chunks of this campaign that run now."""
    listed = subprocess.run(["pgrep", "-f", f"{os.path.abspath(folder)}/chunks/"], capture_output=True, text=True).stdout.split()
    return [int(pid) for pid in listed]


def disturb(cluster, folder, draw, chunks):
    events = Disturbances(cluster, folder, draw)
    for share, event in ((0.2, events.lose_node), (0.4, events.restart_controller), (0.6, lambda: events.kill_jobs(2)),
                         (0.8, lambda: events.kill_jobs(1))):
        events.wait_for_chunks(int(share * chunks))
        event()
    cluster.wait_for_jobs(JOBS_S)
    events.kept.update(done_chunks(folder))
    events.damage()
    for _ in range(5):
        left = document("campaign", "resume", folder, env=cluster.environment)["chunks_left"]
        cluster.wait_for_jobs(JOBS_S)
        if left == 0:
            break
    check(left == 0, f"{left} chunks are left after five resumes")
    check(events.killed > 0, "no job was killed")
    print(f"{events.lost} jobs lost with their node, {events.killed} killed", flush=True)
    events.check_waste()


def planned(words, folder, cluster, jobs=4, job_time="1s"):
    begun = document(*words, "--slurm", str(jobs), "--job-time", job_time, env=cluster.environment)
    check(begun["campaign"].endswith(folder), begun)
    return begun["chunks"]


def sweep(cluster, draw):
    run(*SWEEP, "-o", "one.csv")
    chunks = planned([*SWEEP, "-o", "many.csv"], "many.csv.campaign", cluster)
    disturb(cluster, "many.csv.campaign", draw, chunks)
    check(table("many.csv") == table("one.csv"), "the sweep is that of one run")
    return chunks


def study(cluster, draw):
    pathlib.Path("trials").mkdir()
    cached_study.write_trials(pathlib.Path("trials"), 0, STUDY_TRIALS, list(cached_study.bodies()))
    whole = document("study", "trials", "--no-cache")
    chunks = planned(["study", "trials"], "trials.campaign", cluster, job_time="200ms")
    disturb(cluster, "trials.campaign", draw, chunks)
    answer = json.loads(pathlib.Path("trials.campaign/answer.txt").read_text())
    answer.pop("provenance")
    check(answer == whole, "the study is that of one run")
    return chunks


def coverage(cluster, draw):
    command = [sys.executable, str(ROOT / "tests/long/calibration_budget.py"), os.environ["HAPTOMETER_PROGRAMS"], str(RIGS)]
    whole = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    run("campaign", "plan", "budget", "--chunks", "20", "--jobs", "4", "--ending", "json", "--", *command)
    document("campaign", "resume", "budget", env=cluster.environment)
    disturb(cluster, "budget", draw, 20)
    check(pathlib.Path("budget/answer.txt").read_text() == whole, "the coverage run is that of one run")
    return 20


def cost_of_chunks():
    """One run on one thread against its chunks one after the other; overhead of a chunk that is next to nothing."""
    words = [*SWEEP[:-1], "drive.frequency_hz=100Hz:400Hz:4001"]
    ratios = []
    for number in range(3):
        begun = time.monotonic()
        run(*words, "-o", f"a{number}.csv", "--threads", "1")
        whole_s = time.monotonic() - begun
        chunks = document(*words, "-o", f"b{number}.csv", "--slurm", "1", "--job-time", f"{whole_s / 4:.3f}s",
                          status=3)["chunks"]
        begun = time.monotonic()
        for chunk in range(1, chunks + 1):
            run("campaign", "run", f"b{number}.csv.campaign", str(chunk))
        chunks_s = time.monotonic() - begun
        ratios.append(whole_s / chunks_s)
        print(f"one run {whole_s:.2f} s, {chunks} chunks {chunks_s:.2f} s: throughput {ratios[-1]:.3f}, overhead of a "
              f"chunk {(chunks_s - whole_s) / chunks:.3f} s", flush=True)
    return sorted(ratios)[1]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("--only", nargs="+", default=["cost", "sweep", "study", "coverage"])
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.abspath(given.programs)
    check(slurm_cluster.is_possible(), "slurm-wlm and munge are needed, and root")
    draw = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        # a Slurm whose controller is not there
        os.environ["SLURM_CONF"] = str(pathlib.Path(folder, "none.conf"))
        if "cost" in given.only:
            print(f"median throughput of chunks against one run: {cost_of_chunks():.3f}", flush=True)
        for work in (one for one in (sweep, study, coverage) if one.__name__ in given.only):
            begun = time.monotonic()
            with slurm_cluster.Cluster(pathlib.Path(folder, work.__name__ + ".slurm"), nodes=2) as cluster:
                chunks = work(cluster, draw)
            print(f"{work.__name__}: {chunks} chunks, identical to one run, {time.monotonic() - begun:.0f} s", flush=True)
        os.chdir(ROOT)


if __name__ == "__main__":
    main()
