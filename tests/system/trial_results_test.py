#!/usr/bin/env python3
"""Results of trials that were computed before: the cache, shards, their merging, and what damages them.

The oracle is the same command without any of it: numbers, findings and tables have to be equal.
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
from programs import check, program, run

SCRIPT = "fixtures/generate/study.py"
OFF = {"HAPTOMETER_CACHE": "off"}


def environment(**words):
    return {**os.environ, **words}


def answered(*words, status=0, **variables):
    """A document without its provenance, and what is said on stderr."""
    done = run(*words, "--json", status=status, env=environment(**variables))
    document = json.loads(done.stdout)
    document.pop("provenance")
    return document, done.stderr


def check_cache(trials, cache):
    plain, said = answered("study", trials, **OFF)
    check("earlier" not in said, said)
    on = {"HAPTOMETER_CACHE": str(cache)}
    first, said = answered("study", trials, **on)
    check(first == plain and "earlier" not in said, "a first run with a cache is a run without one")
    again, said = answered("study", trials, **on)
    check(again == plain, "what a cache knows is what was computed")
    check("96 of 96 trials are known" in said, said)
    _, said = answered("study", trials, "--no-cache", **on)
    check("known" not in said, said)
    # provenance states the checksum of each input, as without a cache
    inputs = [json.loads(run("study", trials, "--json", env=environment(**which)).stdout)["provenance"]["inputs"]
              for which in (OFF, on)]
    check(inputs[0] == inputs[1] and all(one["sha256"] for one in inputs[1]), "inputs of the provenance")
    # another question, other options of reading: none of it is known
    _, said = answered("study", trials, "--band", "30-500Hz", **on)
    check("known" not in said, said)
    # labels that are read from the files' names: the same bytes in another cell of the study
    for pattern in ("{subject}_{condition}_{repeat}", "{condition}_{subject}_{repeat}"):
        words = ("study", trials, "--pattern", pattern)
        check(answered(*words, **on)[0] == answered(*words, **OFF)[0], pattern)
    # a trial that is new, one that moved, one that was touched, one that changed
    paths = sorted(trials.glob("*.csv"))
    extra = trials / "new.csv"
    extra.write_text(paths[0].read_text().replace("label.repeat = ", "label.repeat = 9"))
    _, said = answered("study", trials, **on)
    check("96 of 97 trials are known" in said, said)
    extra.unlink()
    os.utime(paths[1])
    _, said = answered("study", trials, **on)
    check("96 of 96 trials are known" in said, said)
    check_changed_behind(trials, paths[2], on, plain)


def check_changed_behind(trials, path, on, plain):
    """A byte that changes while size, time and inode stay: found by --verify alone."""
    state, text = path.stat(), path.read_bytes()
    digit = text.rindex(b"1")
    with path.open("r+b") as file:
        file.seek(digit)
        file.write(b"2")
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))
    check(path.stat().st_ino == state.st_ino and path.stat().st_size == state.st_size, "the same file")
    known, said = answered("study", trials, **on)
    check(known == plain and "96 of 96" in said, "nothing but the bytes tells that it changed")
    verified, said = answered("study", trials, "--verify", status=1, **on)
    check(path.name in said and "has changed since it was analysed" in said, said)
    check(verified == answered("study", trials, **OFF)[0], "it is analysed again")
    path.write_bytes(text)


def check_shards(trials, folder):
    whole, _ = answered("study", trials, **OFF)
    parts = [folder / f"part{k}.results" for k in (1, 2, 3)]
    for k, part in enumerate(parts, 1):
        shard, _ = answered("study", trials, "--shard", f"{k}/3", "-o", part)
        check(shard["trials"] == 96 and shard["computed"] == 32 and shard["kept"] == 0, shard)
    merged, _ = answered("study", trials, "--merge", *parts)
    check(merged == whole, "merged shards are one run")
    wide = [folder / "whole.csv", folder / "merged.csv"]
    run("study", trials, "--wide", wide[0], env=environment(**OFF))
    run("study", trials, "--wide", wide[1], "--merge", *parts)
    rows = [[line for line in path.read_text().splitlines() if not line.startswith("#")] for path in wide]
    check(rows[0] == rows[1], "so are their tables")
    # one that is missing is named; existing parts are not replaced
    said = run("study", trials, "--merge", *parts[:2], status=3).stderr
    check("has no result" in said, said)
    run("study", trials, "--shard", "1/3", "-o", parts[0], status=2)
    said = run("study", trials, "--merge", *parts, "--band", "30-500Hz", status=2).stderr
    check("band = 20" in said and "band = 30" in said, said)
    return parts, whole


def check_damage(trials, parts, whole):
    draw = random.Random(5)
    text = parts[1].read_bytes()
    for damage in range(6):
        if damage < 3:  # the writer was killed amid a record
            parts[1].write_bytes(text[:draw.randrange(2000, len(text))])
        else:           # a bit of a record is another
            at = draw.randrange(2000, len(text))
            parts[1].write_bytes(text[:at] + bytes([text[at] ^ 1 << draw.randrange(8)]) + text[at + 1:])
        said = run("study", trials, "--merge", *parts, status=3).stderr
        check("--resume" in said or "has no result" in said, said)
        shard, _ = answered("study", trials, "--shard", "2/3", "-o", parts[1], "--resume")
        check(shard["kept"] + shard["computed"] == 32 and 0 < shard["computed"] < 32, shard)
        check(answered("study", trials, "--merge", *parts)[0] == whole, "nothing is left of the damage")
    # results of another program
    head, rest = text.split(b"\n", 2)[:2], text.split(b"\n", 2)[2]
    parts[1].write_bytes(b"\n".join([head[0], head[1].replace(b"haptometer 0", b"haptometer 9"), rest]))
    said = run("study", trials, "--merge", *parts, status=2).stderr
    check("haptometer 9" in said and "haptometer 0" in said and "--allow-mixed" in said, said)
    check(answered("study", trials, "--merge", *parts, "--allow-mixed")[0] == whole, "unless it is allowed")
    parts[1].write_bytes(text)


def check_killed(trials, folder, whole):
    """A shard that is killed again and again is whole in the end, and every trial is computed once."""
    part = folder / "killed.results"
    draw, computed = random.Random(7), 0
    for _ in range(40):
        process = subprocess.Popen([program("haptometer"), "study", trials, "--shard", "1/1", "-o", part,
                                    "--resume", "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        time.sleep(draw.uniform(0.02, 0.25))
        process.send_signal(signal.SIGKILL)
        output = process.communicate()[0]
        if process.returncode == 0:
            break
    shard = json.loads(output) if process.returncode == 0 else answered(
        "study", trials, "--shard", "1/1", "-o", part, "--resume")[0]
    check(shard["kept"] + shard["computed"] == 96, shard)
    check(answered("study", trials, "--merge", part)[0] == whole, "a killed shard, continued, is one run")


def check_analyze(trials, folder):
    whole, _ = answered("analyze", trials, **OFF)
    cache = {"HAPTOMETER_CACHE": str(folder / "cache")}
    check(answered("analyze", trials, **cache)[0] == whole, "a first run")
    again, said = answered("analyze", trials, **cache)
    check(again == whole and "96 of 96 trials are known" in said, said)
    homeless = {"HAPTOMETER_CACHE": "", "XDG_CACHE_HOME": "", "HOME": str(folder / "missing")}
    check(answered("analyze", trials, **homeless)[0] == whole and not (folder / "missing").exists(),
          "no home is made for the cache")
    # but for the line with version and time
    texts = [[line for line in run("analyze", trials, "--all", env=environment(**which)).stdout.splitlines()
              if not line.startswith("  haptometer 0.")] for which in (OFF, cache)]
    check(texts[0] == texts[1], "the text with all numbers")
    tables = [folder / "one.csv", folder / "two.csv"]
    for table, which in zip(tables, (OFF, cache), strict=True):
        run("analyze", trials, "--table", table, env=environment(**which))
    rows = [[line for line in path.read_text().splitlines() if not line.startswith("#")] for path in tables]
    check(rows[0] == rows[1] and len(rows[0]) == 97, "the table")
    parts = [folder / f"a{k}.results" for k in (1, 2)]
    for k, part in enumerate(parts, 1):
        run("analyze", trials, "--shard", f"{k}/2", "-o", part)
    check(answered("analyze", trials, "--merge", *parts)[0] == whole, "shards of analyze")
    # files that are named one by one are analysed each time
    _, said = answered("analyze", *sorted(trials.glob("*.csv"))[:3], **cache)
    check("known" not in said, said)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        trials = folder / "trials"
        subprocess.run([sys.executable, "-B", SCRIPT, trials], check=True, stdout=subprocess.DEVNULL)
        for other in ("study.toml", "sweep.csv"):
            shutil.move(trials / other, folder / other)
        check_cache(trials, folder / "known")
        parts, whole = check_shards(trials, folder)
        check_damage(trials, parts, whole)
        check_killed(trials, folder, whole)
        check_analyze(trials, folder)


if __name__ == "__main__":
    main()
