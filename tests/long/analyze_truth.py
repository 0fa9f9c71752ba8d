"""What `analyze` answers where the true vibration is known.

  /usr/bin/python3 tests/long/analyze_truth.py [PROGRAMS] [SEEDS]

Writes CSV trials of a tone on 30 mm of offset and 0.3 mm of tremor, with each of three troubles and
with all their combinations: a drive that is on for 16 of 18 s, a sensor that averages 16 samples of
0.33 ms, and white noise of 5.9 um RMS in the band. Each level from 5 to 45 um RMS is tried with
SEEDS seeds (3). Asked of every answer: the true RMS lies within the stated 95 % interval in at
least 95 % of all (less 3 standard deviations of that count), and above 15 um the RMS is within
2 % of the truth (16 s of this noise leave 16 um a standard uncertainty of 0.5 %, so that 2 % are
four of them). Where the drive is never off, a drive-off trial of the same sensor is given by --floor. NumPy makes the trials; it
knows nothing of the program.
"""
import itertools
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

PROGRAMS = sys.argv[1] if len(sys.argv) > 1 else "build/release/bin"
SEEDS = int(sys.argv[2]) if len(sys.argv) > 2 else 3
LEVELS_UM = (5, 9, 16, 30, 45)
FLOOR_UM = 5.9
SAMPLING_S = 0.33e-3
AVERAGES = 16
DURATION_S = 18.0
BAND_HZ = 480.0


def readings(rms_um, frequency_hz, gated, averaged, floor, seed):
    """Rate, displacement in m, and what the file says of the sensor."""
    random = np.random.default_rng(seed)
    rate_hz = 1 / SAMPLING_S if averaged else 10000.0
    lead = AVERAGES if averaged else 0
    count = int(DURATION_S * rate_hz)
    t = (np.arange(count + lead) - lead) / rate_hz
    on = ((t >= 1) & (t < 17)) if gated else np.ones_like(t, dtype=bool)
    phase = random.uniform(0, 2 * np.pi)
    tone = math.sqrt(2) * rms_um * 1e-6 * np.sin(2 * np.pi * frequency_hz * t + phase) * on
    slow = 30e-3 + 0.3e-3 * np.sin(2 * np.pi * 8.3 * t + random.uniform(0, 6))
    x = tone + slow
    if averaged:
        x = np.convolve(x, np.ones(AVERAGES) / AVERAGES, "valid")[1:]
        t = t[lead:]
    if floor:  # of the readings, white up to half their rate
        x = x + random.normal(0, FLOOR_UM * 1e-6 * math.sqrt(rate_hz / 2 / BAND_HZ), x.size)
    return rate_hz, x[:count]


def write(path, rate_hz, x, averaged):
    with open(path, "w") as file:
        file.write(f"# sampling_s = {SAMPLING_S if averaged else 1 / rate_hz:.12g}\n"
                   f"# averages = {AVERAGES if averaged else 1}\n"
                   "time_s,displacement_m\n")
        np.savetxt(file, np.column_stack([np.arange(x.size) / rate_hz, x]), "%.12g", ",")


def analysed(path, off):
    floor = ["--floor", off] if off else []
    done = subprocess.run([os.path.join(PROGRAMS, "haptometer"), "analyze", "--json", path, *floor],
                          capture_output=True, timeout=60, text=True)
    return json.loads(done.stdout)["trials"][0]


def main():
    tried = covered = 0
    worst = {}
    missed = []
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "trial.csv")
        cases = itertools.product((False, True), repeat=3)
        for (gated, averaged, floor), rms_um, seed in itertools.product(
                cases, LEVELS_UM, range(SEEDS)):
            # through 16 averages of 0.33 ms 100 Hz comes with 0.60, 225 Hz with 0.15
            frequency_hz = 97.3 if averaged else 225.0
            rate_hz, x = readings(rms_um, frequency_hz, gated, averaged, floor,
                                  [seed, rms_um, gated, averaged, floor])
            write(path, rate_hz, x, averaged)
            off = None
            if floor and not gated:
                off = os.path.join(directory, "off.csv")
                write(off, *readings(0, frequency_hz, False, averaged, True, [seed, 1]), averaged)
            trial = analysed(path, off)
            case = (gated, averaged, floor)
            if not trial["answered"]:
                missed.append((case, rms_um, trial["reasons"]))
                continue
            got_um = trial["band_rms_m"] * 1e6
            low_um, high_um = (1e6 * end for end in trial["band_rms_interval_95_m"])
            tried += 1
            covered += low_um <= rms_um <= high_um
            if rms_um >= 15:
                off = abs(got_um / rms_um - 1)
                worst[case] = max(worst.get(case, 0), off)
    print(f"{covered} of {tried} intervals hold the truth; {len(missed)} not answered")
    for case, rms_um, reasons in missed[:10]:
        print("  not answered:", case, rms_um, "um", reasons)
    for case, off in worst.items():
        names = [n for n, is_on in zip(("gated", "averaged", "floor"), case) if is_on]
        print(f"  {'+'.join(names) or 'plain':24} above 15 um within {off:.2%}")
    enough = 0.95 * tried - 3 * math.sqrt(0.95 * 0.05 * tried)
    ok = covered >= enough and max(worst.values(), default=1) <= 0.02 and not missed
    print("ok" if ok else "FAILED")
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
