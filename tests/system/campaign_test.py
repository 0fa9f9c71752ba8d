#!/usr/bin/env python3
"""Campaigns: long work in chunks, planned by --slurm, run by hand, by GNU parallel and by a Slurm of one node.

    campaign_test.py          without Slurm; the parts with GNU parallel where it is installed
    campaign_test.py slurm    an array of jobs with its merging on a Slurm of this machine, where it is installed

The oracle is one run without any of it: tables and documents have to be equal.
"""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import slurm_cluster
from programs import DEADLINE_S, check, program, run, skip, wait_for

ROOT = pathlib.Path.cwd()
SWEEP = ["sweep", str(ROOT / "fixtures/lra_stops.toml"), "--vary", "drive.frequency_hz=100Hz:400Hz:61"]

# a program that is no verb, with the options that a campaign gives it: sums of squares
COUNTER = """
import json, sys
words = sys.argv[1:]
if "--merge" in words:
    print(sum(json.load(open(path)) for path in words[words.index("--merge") + 1:]))
else:
    own, of = map(int, words[words.index("--shard") + 1].split("/"))
    json.dump(sum(n * n for n in range(own - 1, 1000, of)), open(words[words.index("-o") + 1], "w"))
"""


def without_sbatch():
    """An environment in which sbatch is not found, whether it is installed or not."""
    folder = pathlib.Path(tempfile.mkdtemp(dir="."))
    for name in ("sh", "timeout", "perl", "ps", "cat", "bash", "env", "mktemp", "parallel", "pgrep"):
        if found := shutil.which(name):
            (folder / name).symlink_to(found)
    return {**os.environ, "PATH": str(folder.resolve())}


def rows(path):
    """A table without its provenance."""
    return [line for line in pathlib.Path(path).read_text().splitlines() if not line.startswith("# provenance")]


def document(*words, status=0, env=None):
    """A document without its provenance."""
    found = json.loads(run(*words, "--json", status=status, env=env).stdout)
    found.pop("provenance")
    return found


def chunk(folder, number, status=0):
    return run("campaign", "run", folder, str(number), status=status)


def merged(folder, table, whole):
    run("campaign", "merge", folder)
    check(rows(table) == whole, f"{table} is the table of one run")
    os.remove(table)


def check_planning(env):
    run(*SWEEP, "-o", "one.csv")
    planned = document(*SWEEP, "-o", "many.csv", "--slurm", "2", "--job-time", "20ms", env=env)
    check(planned["chunks"] > 4 and planned["jobs"] == 2, planned)
    check([found["kind"] for found in planned["findings"]] == ["not-submitted"], planned)
    check(planned["array_command"].startswith("sbatch "), planned)
    run(*SWEEP, "-o", "many.csv", "--slurm", "2", status=2)
    run(*SWEEP, "-o", "one.csv", "--slurm", "2", status=2)
    check(not pathlib.Path("one.csv.campaign").exists(), "a table that exists is refused before the plan")
    for wrong in ("0", str(planned["chunks"] + 1), "x"):
        chunk("many.csv.campaign", wrong, status=2)
    run("campaign", "status", ".", status=3)
    return planned["chunks"]


def done(folder, number):
    """The file of a chunk that is done."""
    found = list(pathlib.Path(folder, "chunks").glob(f"{number}of*-*"))
    check(len(found) == 1, f"chunk {number}: {found}")
    return found[0]


def check_damage(count):
    """Chunks in any order, twice, killed, cut and changed."""
    folder, whole = "many.csv.campaign", rows("one.csv")
    run("campaign", "merge", folder, status=3)
    for number in range(count, 0, -1):
        chunk(folder, number)
    status = document("campaign", "status", folder)
    check(status["chunks_done"] == count and status["left_s"] == 0, status)
    merged(folder, "many.csv", whole)
    draw = random.Random(5)
    for damage in ("changed", "cut", "removed"):
        number = draw.randrange(1, count + 1)
        path = done(folder, number)
        data = bytearray(path.read_bytes())
        data[draw.randrange(len(data))] ^= 1
        {"changed": lambda: path.write_bytes(data), "cut": lambda: path.write_bytes(data[:len(data) // 2]),
         "removed": path.unlink}[damage]()
        said = run("campaign", "merge", folder, status=3).stderr
        check(f"damaged: {number};" in said, said)
        check(document("campaign", "status", folder, "--verify")["chunks_done"] == count - 1, damage)
        chunk(folder, number)
        merged(folder, "many.csv", whole)


def check_attempts(count):
    """Two runs of a chunk at the same time count once; what a killed one leaves is continued."""
    folder = pathlib.Path("many.csv.campaign")
    for path in folder.glob("chunks/1of*"):
        path.unlink()
    both = [subprocess.Popen([program("haptometer"), "campaign", "run", folder, "1"], stdout=subprocess.DEVNULL)
            for _ in range(2)]
    check([one.wait(DEADLINE_S) for one in both] == [0, 0], "both runs of a chunk")
    check(document("campaign", "status", folder, "--verify")["findings"] == [], "whoever finished it, it is whole")
    merged(folder, "many.csv", rows("one.csv"))
    # one that is killed leaves a part; a part that is no table is begun anew
    text = next(folder.glob("chunks/1of*-*")).read_text()
    for left in (text[:-20], "not a table\n"):
        for path in folder.glob("chunks/1of*"):
            path.unlink()
        (folder / f"chunks/1of{count}.elsewhere.1.csv").write_text(left)
        chunk(folder, 1)
        check(list(folder.glob("chunks/1of*")) == [done(folder, 1)], "what was left is gone")
        merged(folder, "many.csv", rows("one.csv"))


def check_interruption():
    """SIGTERM reaches the chunk's command, and what it had computed is continued."""
    many = ["sweep", str(ROOT / "fixtures/lra_adapter.toml"), "--vary", "drive.frequency_hz=100Hz:400Hz:60001"]
    run(*many, "-o", "long.csv.one")
    run(*many, "-o", "long.csv", "--slurm", "1", "--job-time", "1h")
    process = subprocess.Popen([program("haptometer"), "campaign", "run", "long.csv.campaign", "1"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    attempt = f"long.csv.campaign/chunks/1of1.{os.uname().nodename}.{process.pid}.csv"
    wait_for("rows", lambda: os.path.exists(attempt) and os.path.getsize(attempt) > 100_000)
    process.send_signal(signal.SIGTERM)
    check(process.wait(DEADLINE_S) == 143, f"an interrupted chunk ends with {process.returncode}")
    check(os.path.getsize(attempt) < os.path.getsize("long.csv.one"), "it was interrupted before its end")
    # killed while it continues that: what it had is not begun anew
    process = subprocess.Popen([program("haptometer"), "campaign", "run", "long.csv.campaign", "1"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    second = f"long.csv.campaign/chunks/1of1.{os.uname().nodename}.{process.pid}.csv"
    before = os.path.getsize(attempt)
    wait_for("more rows", lambda: os.path.exists(second) and os.path.getsize(second) > before + 50_000)
    child, = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
    os.kill(int(child), signal.SIGKILL)
    check(process.wait(DEADLINE_S) == 128 + 9, f"a killed chunk ends with {process.returncode}")
    check(os.path.getsize(second) > before, "what a killed command had written stays")
    chunk("long.csv.campaign", 1)
    merged("long.csv.campaign", "long.csv", rows("long.csv.one"))


def check_plans():
    """A plan of another user, one that is none, and one of a program of one's own."""
    run("campaign", "plan", "own", "--chunks", "7", "--ending", "json", "--", sys.executable, "-c", COUNTER)
    run("campaign", "plan", "own", "--", "x", status=2)
    run("campaign", "plan", "none", status=2)
    for number in range(1, 8):
        chunk("own", number)
    check(int(run("campaign", "merge", "own").stdout) == sum(n * n for n in range(1000)), "the sum")
    done("own", 3).write_text("")
    check(run("campaign", "status", "own").stdout.count("doubt"), "a chunk that is empty")
    for words in (["one", "--ending", "a/b"], [""], ["one", "--job-time", "1e300h"]):
        run("campaign", "plan", *words, "--", "./x", status=1 if words == [""] else 2)
    # a launcher that ignores the ends of children: a command that fails has failed
    run("campaign", "plan", "half", "--chunks", "1", "--", "sh", "-c", 'echo half >"$4"; exit 1', "sh")
    failed = subprocess.run(["env", "--ignore-signal=CHLD", program("haptometer"), "campaign", "run", "half", "1"],
                            capture_output=True, check=False)
    check(failed.returncode == 1, f"a failed chunk ends with {failed.returncode}")
    check(not list(pathlib.Path("half/chunks").glob("*-*s-*")), "half a chunk is not named as whole")
    # a program without words
    pathlib.Path("own.py").write_text(f"#!{sys.executable}\n{COUNTER}")
    os.chmod("own.py", 0o755)
    run("campaign", "plan", "bare", "--chunks", "2", "--ending", "json", "--", "./own.py")
    check(document("campaign", "resume", "bare", env=without_sbatch())["chunks_left"] == 2, "a program without words")
    for verb in ("run", "merge"):
        run("campaign", verb, "bare", *(["1"] if verb == "run" else []), "--json", status=2)
    text = pathlib.Path("own/plan.json").read_text()
    for wrong in ("{}", text.replace('"chunks": 7', '"chunks": 7000'), text.replace('"jobs": 1', '"jobs": 0'), text[:-40]):
        pathlib.Path("own/plan.json").write_text(wrong)
        run("campaign", "run", "own", "1", status=2)
    if os.geteuid() == 0:
        pathlib.Path("own/plan.json").write_text(text)
        os.chown("own/plan.json", 65534, 65534)
        check("another user" in run("campaign", "run", "own", "1", status=2).stderr, "a plan of another user")


def check_parallel(env):
    """The same plan by GNU parallel, by the command that is printed; a study."""
    if not shutil.which("parallel"):
        return
    whole = document("study", "trials")
    planned = document("study", "trials", "--slurm", "2", "--job-time", "20ms", env=env)
    check(planned["chunks"] > 1, planned)
    subprocess.run(planned["parallel_command"], shell=True, check=True, capture_output=True, timeout=DEADLINE_S)
    done = subprocess.run(planned["parallel_merge_command"] , shell=True, check=True, capture_output=True,
                          timeout=DEADLINE_S)
    plan = json.loads(pathlib.Path("trials.campaign/plan.json").read_text())
    check("--json" in plan["merge"], plan)
    answer = json.loads(done.stdout)
    answer.pop("provenance")
    check(answer == whole, "the study of a campaign is that of one run")


def check_outputs(env):
    """Names with blanks and quotes, a folder of one's own, a second merging, folders with a slash behind them, analyze."""
    folder = pathlib.Path("it's a \"place\"")
    folder.mkdir()
    shutil.copy(ROOT / "fixtures/lra_stops.toml", folder)
    os.chdir(folder)
    words = ["sweep", "lra_stops.toml", *SWEEP[2:]]
    planned = document(*words, "-om.csv", "--slurm=1", "--job-time=20ms", "--campaign", "my work", "--allow-mixed", env=env)
    check(planned["campaign"].endswith("/my work"), planned)
    if shutil.which("parallel"):
        subprocess.run(planned["parallel_command"], shell=True, check=True, capture_output=True, timeout=DEADLINE_S)
    for number in range(1, planned["chunks"] + 1):
        chunk("my work", number)
    run("campaign", "merge", "my work")
    check(rows("m.csv") == rows("../one.csv"), "the table of a folder with blanks and quotes")
    run("campaign", "merge", "my work", status=2)
    run("campaign", "merge", "my work", "--overwrite")
    plan = json.loads(pathlib.Path("my work/plan.json").read_text())
    check("--allow-mixed" in plan["merge"], plan)
    os.chdir("..")
    whole = document("analyze", "trials")
    document("analyze", "trials/", "--slurm", "2", "--campaign", "ana", env=env)
    for number in range(1, document("campaign", "status", "ana")["chunks"] + 1):
        chunk("ana", number)
    answer = json.loads(run("campaign", "merge", "ana").stdout)
    answer.pop("provenance")
    check(answer == whole, "the analysis of a campaign is that of one run")
    document("study", "trials/", "--slurm", "2", env=env)
    check(pathlib.Path("trials.campaign").is_dir(), "a slash behind the folder")
    shutil.rmtree("trials.campaign")


def check_submission(env):
    """Against programs in the place of sbatch and squeue: warnings, a second submission, a refusal of the merging."""
    folder = pathlib.Path(env["PATH"])

    def answers(name, text):
        (folder / name).unlink(missing_ok=True)
        (folder / name).write_text("#!/bin/sh\n" + text)
        os.chmod(folder / name, 0o755)

    run("campaign", "plan", "sub", "--chunks", "3", "--ending", "json", "--", sys.executable, "-c", COUNTER)
    answers("sbatch", f"echo \"$*\" >>{folder}/log\necho 'sbatch: charged to 7' >&2\necho 101\n")
    answers("squeue", "echo 101\n")
    check(document("campaign", "resume", "sub", env=env)["array_job"] == "101", "a warning is no number")
    check("--dependency=afterany:101 " in (folder / "log").read_text(), (folder / "log").read_text())
    again = document("campaign", "resume", "sub", env=env, status=3)
    check([found["kind"] for found in again["findings"]] == ["under-way"], again)
    answers("squeue", "exit 1\n")
    answers("sbatch", "case \"$*\" in *dependency*) echo 'no more' >&2; exit 1;; esac\necho 102\n")
    refused = document("campaign", "resume", "sub", env=env, status=3)
    check("array_command" not in refused and "afterany:102" in refused["merge_command"], refused)
    for name in ("sbatch", "squeue"):
        (folder / name).unlink()


def check_slurm():
    """An array of four jobs and its merging on one node: sweep and study."""
    if not slurm_cluster.is_possible():
        skip("no slurm-wlm and munge, or not root")
    run(*SWEEP, "-o", "one.csv")
    whole = document("study", "trials")
    with slurm_cluster.Cluster(pathlib.Path("slurm").resolve()) as cluster:
        begun = time.monotonic()
        run("campaign", "plan", "four", "--chunks", "4", "--jobs", "2", "--ending", "csv", "--", program("haptometer"),
            *SWEEP, "--threads", "1")
        plan = pathlib.Path("four/plan.json")
        words = json.loads(plan.read_text())
        words["merge"] = [program("haptometer"), "sweep", "-o", "many.csv"]
        plan.write_text(json.dumps(words))
        submitted = document("campaign", "resume", "four", env=cluster.environment)
        study = document("study", "trials", "--slurm", "2", "--job-time", "20ms", env=cluster.environment)
        check(study["chunks"] > 1, study)
        cluster.wait_for_jobs(DEADLINE_S)
        check(document("campaign", "status", "four")["chunks_done"] == 4, submitted)
        logs = sorted(path.name for path in pathlib.Path("four/logs").iterdir())
        check(logs == ["1.log", "2.log", "3.log", "4.log", "merge.log"], logs)
        check(rows("many.csv") == rows("one.csv"), "the table of an array of four is that of one run")
        answer = json.loads(pathlib.Path("trials.campaign/answer.txt").read_text())
        answer.pop("provenance")
        check(answer == whole, "the study of an array is that of one run")
        print(f"Slurm: {time.monotonic() - begun:.1f} s")


with tempfile.TemporaryDirectory() as place:
    subprocess.run([sys.executable, ROOT / "fixtures/generate/study.py", pathlib.Path(place, "trials")], check=True)
    os.environ["HAPTOMETER_PROGRAMS"] = os.path.dirname(program("haptometer"))
    os.chdir(place)
    for table in pathlib.Path("trials").glob("*.toml"):
        table.unlink()
    pathlib.Path("trials/sweep.csv").unlink(missing_ok=True)
    if sys.argv[1:] == ["slurm"]:
        check_slurm()
    else:
        bare = without_sbatch()
        count = check_planning(bare)
        check_damage(count)
        check_attempts(count)
        check_outputs(bare)
        check_submission(bare)
        check_plans()
        check_parallel(bare)
        os.environ["PATH"] = bare["PATH"]
        check_interruption()
    os.chdir(ROOT)
