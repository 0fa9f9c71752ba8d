"""What `analyze` answers on some 80 classes of records of which the drive is known.

  /usr/bin/python3 tests/long/drive_classes.py [--program PATH] [--seeds N] [--class NAME ...]

Each class of drive_catalog.py draws N records (200), each recipe of drive_recipes.py the exact one
and five of its kind; `analyze --json` answers, and each answer is judged against the drive alone:

  holds     the 95 % interval contains the RMS of the drive over the window that is reported
  misses    it does not
  SILENT    it misses by more than 5 % of the truth, status 0 and no doubt (silently wrong)
  refused   no number; in the classes marked `hard` an analyst with the picture may do the same
  on        a number although there is no drive

Bars: no SILENT; 93 % of all answered intervals hold; in each class so many that a true share of
95 % falls short once in 200 000 (176 of 200); every recipe holds, or is refused where it may be;
2 % refused where an analyst would answer; without a drive two answers of 1000. A wide interval is
no merit: the median half-width is printed, and how many are wider than 20 %.

--self-check runs no program: it compares the truth with SciPy's sosfiltfilt of the drive.
"""
import argparse
import dataclasses
import itertools
import json
import math
import multiprocessing
import os
import subprocess
import sys
import tempfile
import zlib

import numpy as np
from scipy.signal import butter, sosfiltfilt

from drive_catalog import CLASSES
from drive_record import band_gain, default_band, write_record
from drive_recipes import RECIPES

BATCH = 10
TIMEOUT_S = 600
ALL = {**CLASSES, **RECIPES}


def made(name, seed):
    """The record of a class and a seed, the same in every run and selection."""
    return ALL[name](np.random.default_rng([seed, zlib.crc32(name.encode())]), seed)


def has_drive(record):
    return bool(record.drive) or bool(record.truth)


# Asking the program


def answers(program, paths, options):
    """Status and trials by path; one process a file where a batch does not answer all."""
    command = [program, "--json", "--threads", "1", *paths, *options]
    try:
        done = subprocess.run(command, capture_output=True, timeout=TIMEOUT_S, text=True)
        document = json.loads(done.stdout)
        trials = {trial["file"]: trial for trial in document["trials"]}
        if done.returncode in (0, 3) and set(trials) == set(paths):
            for trial in trials.values():
                trial["findings"] = [finding for finding in document["findings"]
                                     if finding["subject"] in (None, trial["file"])
                                     or len(paths) == 1]
            return trials
        problem = f"status {done.returncode}: {done.stderr.strip()[-200:]}"
    except (json.JSONDecodeError, subprocess.TimeoutExpired) as error:
        problem = str(error)
    if len(paths) == 1:
        return {paths[0]: {"problem": problem}}
    return dict(itertools.chain.from_iterable(
        answers(program, [path], options).items() for path in paths))


# Judging


@dataclasses.dataclass
class Verdict:
    name: str
    seed: int
    kind: str  # holds, misses, SILENT, refused, on, off, FAILED
    truth: float = math.nan
    number: float = math.nan
    error: float = math.nan  # relative
    half_width: float = math.nan  # of the interval, relative to the truth
    doubts: tuple = ()
    must_answer: bool = True
    remark: str = ""


def judged(verdict, truth, number, interval, doubts):
    """Holds, misses or SILENT of a number with its interval."""
    low, high = interval
    verdict.truth, verdict.number, verdict.doubts = truth, number, doubts
    verdict.error = abs(number / truth - 1)
    verdict.half_width = (high - low) / 2 / truth
    inside = low <= truth <= high
    silent = not inside and not doubts and verdict.error > 0.05
    verdict.kind = "holds" if inside else "SILENT" if silent else "misses"


def judge_band(verdict, record, trial, doubts):
    window, band = trial["window_s"], trial["band"]
    low = trial.get("band_rms_at_least_m")
    if trial["band_rms_m"] is None and low is None or window is None:
        return
    # who does not read of the corner takes the number for the vibration before the filter
    silent_corner = record.truth.get("corner") and not any(
        "corner" in finding["kind"] for finding in trial["findings"])
    truth = record.truth_rms_m(window, trial.get("excluded_s"), None if silent_corner else band)
    verdict.remark = f"window {window[0]:.3f}-{window[1]:.3f} s"
    if low is not None:  # only a lower limit is stated: it is judged, and is no answer
        verdict.remark += f", at least {low * 1e6:.4g} um"
        if low > truth * (1 + 1e-4):
            judged(verdict, truth, low, (low, math.inf), doubts)
        return
    if truth == 0:
        verdict.kind, verdict.number, verdict.doubts = "on", trial["band_rms_m"], doubts
        return
    judged(verdict, truth, trial["band_rms_m"], trial["band_rms_interval_95_m"], doubts)


def judge_sweep(verdict, record, trial, doubts):
    found = trial.get("resonance")
    if not found or found.get("quality_factor") is None:
        return
    judged(verdict, record.truth["q"], found["quality_factor"],
           found["quality_factor_interval_95"], doubts)


def judge_known_tone(verdict, record, trial, doubts):
    tone = trial.get("known_tone")
    if not tone:
        return
    number, u = tone["amplitude_m"], tone["standard_uncertainty_m"]
    judged(verdict, record.truth["amplitude_m"], number, (number - 1.96 * u, number + 1.96 * u),
           doubts)


def judge(name, seed, record, trial):
    verdict = Verdict(name, seed, "refused", must_answer=record.must_answer)
    if "problem" in trial:
        verdict.kind, verdict.remark = "FAILED", trial["problem"]
        return verdict
    doubts = tuple(f["kind"] for f in trial["findings"] if f["severity"] == "doubt")
    verdict.remark = "; ".join(trial["reasons"])[:150]
    if "amplitude_m" in record.truth:
        judge_known_tone(verdict, record, trial, doubts)
    elif "q" in record.truth:
        judge_sweep(verdict, record, trial, doubts)
    elif not trial["answered"]:
        verdict.kind = "refused" if record.drive else "off"
    elif record.drive:
        judge_band(verdict, record, trial, doubts)
    else:
        verdict.kind = "on" if trial["band_rms_m"] is not None else "off"
        verdict.number, verdict.doubts = trial["band_rms_m"] or math.nan, doubts
    return verdict


def run_batch(job):
    """Makes, writes, asks and judges the records of one class and some seeds."""
    name, seeds, program, keep = job
    with tempfile.TemporaryDirectory() as directory:
        asked = []
        for seed in seeds:
            record = made(name, seed)
            path = os.path.join(directory, f"{name}-{seed}." + ("csv" if record.csv else "bin"))
            write_record(record, path)
            options = list(record.options)
            if record.floor is not None:
                off = os.path.join(directory, f"off-{seed}.bin")
                write_record(record.floor, off)
                options += ["--floor", off]
            asked.append((path, record, options, seed))
        verdicts = []
        # records of the same options share a process
        for options, group in itertools.groupby(asked, key=lambda item: item[2]):
            group = list(group)
            trials = answers(program, [item[0] for item in group], options)
            for path, record, _, seed in group:
                verdicts.append(judge(name, seed, record, trials[path]))
                if keep and verdicts[-1].kind not in ("holds", "off"):
                    os.makedirs(keep, exist_ok=True)
                    write_record(record, os.path.join(keep, os.path.basename(path)))
        return verdicts


# The truth against SciPy


def filtered(x, rate_hz, band):
    """SciPy's zero-phase Butterworth of the same corners."""
    low, high = (math.tan(math.pi * band[key] / rate_hz) for key in ("lower_hz", "upper_hz"))
    width = (high - low) / (math.sqrt(2) - 1) ** (1 / (2 * band["order"]))
    middle = math.sqrt(width ** 2 / 4 + low * high)
    corners = [rate_hz / math.pi * math.atan(end)
               for end in (middle - width / 2, middle + width / 2)]
    sections = butter(band["order"], corners, "bandpass", output="sos", fs=rate_hz)
    return sosfiltfilt(sections, x, padlen=min(x.size - 1, int(rate_hz)))


def check_truth(job):
    """Relative differences of the truth: from the filtered drive, from the filtered record."""
    name, seed = job
    record = made(name, seed)
    if not record.drive or record.oracle_s is None or "amplitude_m" in record.truth:
        return name, seed, math.nan, math.nan
    low, high = (min(max(end, 0.0), record.times_s[-1]) for end in record.oracle_s)
    trim = min(0.3, (high - low) / 4)
    # whole periods of the strongest tone, as a window of the program has
    f = record.drive[0].frequency_hz(np.array([(low + high) / 2]))[0]
    low, high = low + trim, high - trim
    high = low + max(1, math.floor((high - low) * f)) / f
    band = default_band()
    truth = record.truth_rms_m((low, high), band=band)
    # the drive goes on beyond the record, so that no transient of the ends is compared
    lead = int(0.5 * record.rate_hz)
    count = int(round(record.times_s[-1] * record.rate_hz)) + 1
    t = (np.arange(-lead, count + lead)) / record.rate_hz
    drive = filtered(sum(c.displacement_m(t) for c in record.drive), record.rate_hz, band)
    inside = (t >= low) & (t < high)
    rms = math.sqrt(np.mean(drive[inside] ** 2))
    x = np.interp(t[lead:-lead], record.times_s[~np.isnan(record.displacement_m)],
                  record.displacement_m[~np.isnan(record.displacement_m)])
    whole = filtered(x - x.mean(), record.rate_hz, band)[inside[lead:-lead]]
    noisy = math.sqrt(np.mean(whole ** 2))
    return name, seed, abs(rms / truth - 1), noisy / math.hypot(truth, record.noise_rms_m) - 1


def self_check(jobs, pool):
    """The largest difference of each class, and the median one of the record with all parts."""
    rows = {}
    for name, seed, difference, whole in pool.imap(check_truth, jobs, 8):
        if not math.isnan(difference):
            rows.setdefault(name, []).append((difference, seed, whole))
    print(f"{'class':24} {'truth':>9} {'seed':>5}   record less truth and noise (median)")
    worst = 0.0
    for name, found in rows.items():
        difference, seed, _ = max(found)
        worst = max(worst, difference)
        print(f"{name:24} {difference:9.1e} {seed:5}   {np.median([w for *_, w in found]):+.1e}")
    return worst


# Report


def quantile(values, share):
    values = [v for v in values if not math.isnan(v)]
    return f"{100 * np.quantile(values, share):.3g}" if values else "-"


def report_class(name, verdicts):
    kinds = [v.kind for v in verdicts]
    answered = [v for v in verdicts if v.kind in ("holds", "misses", "SILENT", "on")]
    silent = [v for v in answered if not v.doubts]
    wide = sum(v.half_width > 0.2 for v in answered)
    hard = "" if verdicts[0].must_answer else " hard"
    print(f"{name:24} {len(verdicts):4} {len(answered):4} {kinds.count('holds'):5} "
          f"{kinds.count('misses'):5} {kinds.count('SILENT'):6} {kinds.count('on'):3} "
          f"{kinds.count('refused'):5} {kinds.count('FAILED'):4} "
          f"{len(answered) - len(silent):5} "
          f"{quantile([v.error for v in answered], 1):>8} "
          f"{quantile([v.half_width for v in answered], 0.5):>8} {wide:4}{hard}", flush=True)


HEADER = (f"{'class':24} {'n':>4} {'answ':>4} {'holds':>5} {'miss':>5} {'SILENT':>6} {'on':>3} "
          f"{'refus':>5} {'FAIL':>4} {'doubt':>5} {'err % <':>8} {'+-% med':>8} {'wide':>4}")


def enough(count):
    """So many of count as a true share of 0.95 falls short of once in 200 000; 176 of 200."""
    return math.floor(0.95 * count - 4.55 * math.sqrt(count * 0.95 * 0.05))


def share_line(text, count, total, bar, at_least):
    share = count / total if total else (1.0 if at_least else 0.0)
    ok = share >= bar if at_least else share <= bar
    print(f"{text}: {count} of {total} ({100 * share:.2f} %), bar {100 * bar:g} %: "
          f"{'ok' if ok else 'MISSED'}")
    return ok


def totals(by_class):
    """The bars over all classes; whether all are met."""
    flat = itertools.chain.from_iterable(by_class.values())
    drive = [v for v in flat if not is_off(v.name)]
    answered = [v for v in drive if v.kind in ("holds", "misses", "SILENT")]
    clear = [v for v in drive if v.must_answer]
    quiet = [v for name, found in by_class.items() for v in found if is_off(name)]
    short = [name for name, found in by_class.items()
             if sum(v.kind == "holds" for v in found)
             < enough(sum(v.kind in ("holds", "misses", "SILENT") for v in found))]
    bad = [f"{v.name} {v.seed}" for v in drive if v.name in RECIPES
           and (v.kind in ("misses", "SILENT") or v.must_answer and v.kind == "refused")]
    wrong = sum(v.kind == "SILENT" for v in drive)
    failed = sum(v.kind == "FAILED" for v in drive + quiet)
    print()
    ok = [share_line("intervals hold", sum(v.kind == "holds" for v in answered), len(answered),
                     0.93, True),
          share_line("refused where an analyst would answer",
                     sum(v.kind == "refused" for v in clear), len(clear), 0.02, False),
          share_line("answered without a drive", sum(v.kind == "on" for v in quiet), len(quiet),
                     0.002, False)]
    print(f"silently wrong: {wrong}, bar 0: {'MISSED' if wrong else 'ok'}")
    print(f"no answer, crash or timeout: {failed}, bar 0: {'MISSED' if failed else 'ok'}")
    print(f"classes short of 176 of 200: {', '.join(short) or 'none'}")
    print(f"recipes that miss, or are refused without reason: {', '.join(bad) or 'none'}")
    return all(ok) and not wrong and not failed and not short and not bad


def is_off(name):
    return name.startswith("off-") or name == "recipe-4"


def show_worst(by_class):
    bad = [v for found in by_class.values() for v in found if v.kind in ("SILENT", "FAILED")]
    bad.sort(key=lambda v: -np.nan_to_num(v.error, nan=math.inf))
    for v in bad[:40]:
        print(f"  {v.kind} {v.name} seed {v.seed}: {v.number * 1e6:.5g} um for "
              f"{v.truth * 1e6:.5g} um, {v.remark}")


def run(jobs, pool, written):
    by_class = {}
    print(HEADER)
    for verdicts in pool.imap(run_batch, jobs):
        name = verdicts[0].name
        if by_class and name not in by_class:
            last = next(reversed(by_class))
            report_class(last, by_class[last])
        by_class.setdefault(name, []).extend(verdicts)
    report_class(name, by_class[name])
    show_worst(by_class)
    if written:
        with open(written, "w", encoding="ascii") as file:
            for v in itertools.chain.from_iterable(by_class.values()):
                file.write(json.dumps(dataclasses.asdict(v)) + "\n")
    return totals(by_class)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default="build/release/bin/analyze")
    parser.add_argument("--seeds", type=int, default=200, help="records a class")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--class", dest="names", action="append", metavar="NAME",
                        help="only classes whose name begins so; may be given again")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", metavar="DIR", help="writes the records that do not hold")
    parser.add_argument("--verdicts", metavar="FILE.jsonl", help="writes every verdict")
    parser.add_argument("--list", action="store_true", help="lists the classes")
    parser.add_argument("--self-check", action="store_true",
                        help="compares the truth with SciPy and runs no program")
    return parser.parse_args()


def seeds_of(name, options):
    if name in RECIPES:  # the exact one and five of its kind, whatever is asked of the classes
        return range(6)
    return range(options.first, options.first + options.seeds)


def main():
    options = arguments()
    names = [name for name in ALL
             if not options.names or any(name.startswith(part) for part in options.names)]
    if options.list:
        print("\n".join(names))
        return 0
    with multiprocessing.Pool(options.jobs) as pool:
        if options.self_check:
            worst = self_check([(name, seed) for name in names
                                for seed in seeds_of(name, options)], pool)
            print(f"largest difference {worst:.1e}, bar 0.001")
            return 0 if worst < 0.001 else 1  # a sample at each end of 0.2 s of 5 kHz
        jobs = [(name, seeds[at:at + BATCH], options.program, options.keep) for name in names
                for seeds in [seeds_of(name, options)] for at in range(0, len(seeds), BATCH)]
        return 0 if run(jobs, pool, options.verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
