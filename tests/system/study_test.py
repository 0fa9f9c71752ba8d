#!/usr/bin/env python3
"""The real program on the generated study (fixtures/generate/study.py): the truths lie within the
intervals, and its t is what the wide table gives by hand."""

import csv
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

PROGRAM = pathlib.Path(os.environ["HAPTOMETER_PROGRAMS"]) / "haptometer"
SCRIPT = "fixtures/generate/study.py"


def run(*words, status=0):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done


def holds(interval, truth):
    return interval[0] <= truth <= interval[1]


def t_by_hand(rows, treatment, control):
    differences = [float(row[f"{treatment}_mean_m"]) - float(row[f"{control}_mean_m"]) for row in rows]
    n = len(differences)
    mean = math.fsum(differences) / n
    variance = math.fsum((d - mean) ** 2 for d in differences) / (n - 1)
    return mean / math.sqrt(variance / n)


def check_trials(folder):
    wide = folder / "wide.csv"
    printed = run("study", folder / "study.toml", "--json", "--wide", wide).stdout
    study = json.loads(printed)
    assert len(study["trials"]) == 96 and all(trial["answered"] for trial in study["trials"])
    assert study["missing"] == [] and study["outlying"] == [], study["outlying"]
    rows = list(csv.DictReader(line for line in wide.open() if not line.startswith("#")))
    assert len(rows) == 8
    for contrast, truth in zip(study["contrasts"], (3.26, 4.25), strict=True):
        assert contrast["n"] == 8 and contrast["df"] == 7
        assert holds(contrast["ratio_interval_95"], truth), contrast
        assert abs(contrast["ratio"] / truth - 1) < 0.04, contrast     # 5 % scatter over 48 trials
        assert contrast["p_holm"] < 0.001
        by_hand = t_by_hand(rows, contrast["treatment"], contrast["control"])
        assert abs(contrast["t"] / by_hand - 1) < 1e-9, (contrast["t"], by_hand)
        assert holds(contrast["effect_interval_95"], contrast["hedges_g"])
    # as many threads as there are: the same again, but for command and time
    again = json.loads(run("study", folder / "study.toml", "--json").stdout)
    inputs = [document.pop("provenance")["inputs"] for document in (study, again)]
    assert again == study and inputs[0] == inputs[1] and len(inputs[0]) == 97
    (folder / "results.json").write_text(printed)
    run("study", folder / "study.toml", "--verify", folder / "results.json")


def check_a_folder(folder):
    """sweep.csv lies among the trials and is none."""
    study = json.loads(run("study", folder, "--pattern", "s{subject}_{condition}_{repeat}", "--json").stdout)
    assert len(study["trials"]) == 96
    ignored = {pathlib.Path(one["subject"]).name for one in study["findings"] if one["kind"] == "table-ignored"}
    assert ignored == {"sweep.csv", "wide.csv"}, ignored


def check_a_gap(folder):
    """Without one cell the others are answered; a trial that is not answered is named."""
    for repeat in (1, 2, 3):
        (folder / f"s3_ia1_{repeat}.csv").unlink()
    short = folder / "s5_cone_1.csv"
    short.write_text("\n".join(short.read_text().splitlines()[:60]) + "\n")
    done = run("study", folder / "study.toml", "--methods", folder / "methods.md", status=3)
    assert "subject 3 in ia1: 0 of 3 trials" in done.stdout
    assert "subject 5 in cone: 2 of 3 trials" in done.stdout
    assert re.findall(r"^ +subjects +(\d)$", done.stdout, re.M) == ["7", "8"], done.stdout
    assert "s5_cone_1.csv: no value" in (folder / "methods.md").read_text()


def check_matching():
    document = json.loads(run("study", "matching", "fixtures/matching.csv", "--json",
                              "--contrast", "ia1:stock", "--contrast", "ia2:cone").stdout)
    truths = {"stock": 1.0, "cone": 1.0, "ia1": 0.65, "ia2": 0.68}
    for condition in document["conditions"]:
        truth = truths[condition["name"]]
        overall = condition["overall"]
        assert holds(overall["ratio_interval_95"], truth), condition
        assert holds(overall["power_saving_interval_95"], 1 - truth**2), condition
        assert holds(condition["started_high_over_low"]["ratio_interval_95"], 1.05**2), condition
        for level in condition["levels"]:
            assert (level["p_holm"] < 0.05) == (truth < 1), level
    for contrast, truth in zip(document["contrasts"], (0.65, 0.68), strict=True):
        assert holds(contrast["overall"]["ratio_interval_95"], truth), contrast
        assert holds(contrast["overall"]["power_saving_interval_95"], 1 - truth**2), contrast
        assert contrast["overall"]["p_holm"] < 0.001 and len(contrast["levels"]) == 5, contrast


def check_linearity(folder):
    document = json.loads(run("study", "linearity", folder / "sweep.csv", "--json").stdout)
    for line, slope in zip(document["lines"], (8e-6, 9.5e-6), strict=True):
        assert holds(line["slope_interval_95_m_per_v"], slope), line
        assert holds(line["curvature_interval_95_m_per_v2"], 0) and line["curvature_p"] > 0.05, line
        assert line["r_squared"] > 0.999 and line["floor_m"] == 1.5e-6


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([sys.executable, SCRIPT, folder], check=True)
        check_trials(folder)
        check_linearity(folder)
        check_a_folder(folder)
        check_a_gap(folder)
    check_matching()
    return 0


if __name__ == "__main__":
    sys.exit(main())
