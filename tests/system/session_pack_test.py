"""`session pack` and `session verify` of a simulated session: the archive is a ZIP that Python reads and whose files
`sha256sum -c` checks; a byte that is flipped in any of its files is named with its place; files that are missing, added,
hostile or compressed are named; the study is computed again; nothing is ever written over, and a full disk leaves nothing.
"""
import hashlib
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, SCENE, check, program, run, wait_for


def read(path):
    with open(path, "rb") as file:
        return file.read()


def write(path, content):
    with open(path, "wb") as file:
        file.write(content)


def verify(path, status=0):
    """The answer of `session verify --json`, and the changes as {part: kind}."""
    answer = json.loads(run("session", "verify", path, "--json", status=status).stdout)
    return answer, {one["part"]: one["kind"] for one in answer["changes"]}


def record(folder):
    run("session", "new", folder, "--subjects", "2", "--conditions", "stock,cone", "--duration", "0.6s", "--",
        "--sensor", f"scene:{SCENE}", "--speed", "max")
    for _ in range(4):
        run("session", "next", folder)
    run("session", "reject", folder, "--reason", "finger slipped")
    run("session", "redo", folder)
    write(f"{folder}/notes.txt", b"cold room\n")
    write(f"{folder}/empty.txt", b"")
    write(f"{folder}/.hidden", b"x")
    os.symlink("/etc/passwd", f"{folder}/link")


def packed(folder, archive):
    """What stands in the archive, and what is refused."""
    before = {name: read(f"{folder}/trials/{name}") for name in os.listdir(f"{folder}/trials")}
    said = json.loads(run("session", "pack", folder, "-o", archive, "--json").stdout)
    check(said["archive_sha256"] == hashlib.sha256(read(archive)).hexdigest() and said["bytes"] == os.path.getsize(archive), said)
    check({one["subject"] for one in said["findings"]} == {".hidden", "link"}, said["findings"])
    with zipfile.ZipFile(archive) as file:
        check(file.testzip() is None, "Python finds no error in it")
        names = file.namelist()
        check(names[0] == "SHA256SUMS" and len(names) == said["packed_files"] + 1, names)
        check({"session.toml", "log.csv", "notes.txt", "empty.txt", "study/results.json", "study/report.html",
               "study/long.csv", "study/wide.csv", "study/methods.md"} <= set(names), names)
        for name, content in before.items():
            check(file.read(f"trials/{name}") == content, name)
        report = file.read("study/report.html").decode()
        for words in ("finger slipped", "recorded", "simulated", "haptometer 0.", "excluded trials"):
            check(words in report, words)
        with tempfile.TemporaryDirectory() as unpacked:
            file.extractall(unpacked)
            subprocess.run(["sha256sum", "--quiet", "--strict", "-c", "SHA256SUMS"], cwd=unpacked, check=True)
    content = read(archive)
    check("name another file" in run("session", "pack", folder, "-o", "x" * 300 + ".zip", status=2).stderr, "too long")
    check("never replaced" in run("session", "pack", folder, "-o", archive, status=2).stderr, "it is not replaced")
    check(read(archive) == content, "and stays as it is")
    check("lies in the folder" in run("session", "pack", folder, "-o", f"{folder}/a.zip", status=2).stderr, "inside")
    run("session", "pack", f"{folder}/trials", "-o", f"{archive}.other", status=3)
    return names


def intact(archive):
    answer, changes = verify(archive)
    check(answer["intact"] and changes == {} and answer["unchanged"] == answer["packed_files"], answer)
    check(answer["session_name"] == "day1" and answer["study_again"]["recomputed"], answer)
    check(answer["study_again"]["equal"] > 100 and answer["study_again"]["different"] == 0, answer["study_again"])
    check("are equal, 0 differ" in run("session", "verify", archive).stdout, "equal values are said")


def flipped(archive, directory):
    """A byte in the middle of each file, of each header and of the directory."""
    content = read(archive)
    damaged = f"{directory}/damaged.zip"
    with zipfile.ZipFile(archive) as file:
        entries = [(one.filename, one.header_offset, one.file_size) for one in file.infolist()]
        directory_at = file.start_dir
    places = [("directory of the archive", directory_at + 7, None), ("directory of the archive", len(content) - 1, None)]
    for name, header_at, size in entries:
        places.append((f"header of {name}", header_at + 5, None))
        if size > 0:
            places.append((name, header_at + 30 + len(name) + size // 2, size // 2))
    for part, at, in_file in places:
        write(damaged, content[:at] + bytes([content[at] ^ 0x55]) + content[at + 1:])
        answer, _ = verify(damaged, status=3)
        check(len(answer["changes"]) == 1 and answer["changes"][0]["part"] == part, (part, answer["changes"]))
        words = answer["changes"][0]["text"]
        place = at if in_file is None else in_file
        check(re.match(rf"byte {place} of .* was 0x{content[at]:02x} and is 0x{content[at] ^ 0x55:02x}$", words), words)
        needed = in_file is not None and part != "SHA256SUMS" and (part == "study/results.json" or not part.startswith("study/"))
        check(answer["study_again"]["recomputed"] != needed, (part, answer["study_again"]))
    for bytes_left in (100, 5000, directory_at, len(content) - 1):
        write(damaged, content[:bytes_left])
        if bytes_left > 4000:
            answer, _ = verify(damaged, status=3)
            check(answer["changes"][0]["kind"] == "cut-short", answer["changes"][0])
        else:
            check("cut short" in run("session", "verify", damaged, status=3).stderr, "cut in its list")


def repacked(archive, directory, change=lambda files: None, add=(), method=zipfile.ZIP_STORED):
    """The archive as another program writes it, with other files."""
    with zipfile.ZipFile(archive) as file:
        files = {name: file.read(name) for name in file.namelist()}
    change(files)
    out = f"{directory}/repacked.zip"
    with zipfile.ZipFile(out, "w", method) as file:
        for name, content in files.items():
            file.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_STORED if name == "SHA256SUMS" else method)
        for info, content in add:
            file.writestr(info, content)
    return out


def hostile(archive, names, directory):
    trial = next(name for name in names if name.endswith(".bin"))
    _, changes = verify(repacked(archive, directory, lambda files: files.pop(trial)), status=3)
    check(changes.get(trial) == "file-missing", changes)
    link = zipfile.ZipInfo("trials/link")
    link.external_attr = 0o120777 << 16
    evil = [("more.txt", b"x"), ("../x", b"x"), ("/etc/x", b"x"), (link, b"/etc/passwd"), ("folder/", b"")]
    _, changes = verify(repacked(archive, directory, add=evil), status=3)
    check(changes == {"more.txt": "file-added", "../x": "unsafe-name", "/etc/x": "unsafe-name", "trials/link": "no-file",
                      "folder/": "no-file"}, changes)

    def leads_out(files):
        files["SHA256SUMS"] = files["SHA256SUMS"].replace(b"  notes.txt", b"  ../notes.t")
    check("damaged list" in run("session", "verify", repacked(archive, directory, leads_out), status=3).stderr, "../ in the list")
    # a bomb: 256 MiB of zeros in 256 KiB; nothing is inflated
    bomb = [(zipfile.ZipInfo("bomb.bin"), b"\0" * (1 << 28))]
    bomb[0][0].compress_type = zipfile.ZIP_DEFLATED
    out = repacked(archive, directory, add=bomb, method=zipfile.ZIP_DEFLATED)
    began = time.monotonic()
    _, changes = verify(out, status=3)
    check(changes["bomb.bin"] == "file-added" and changes[trial] == "compressed", changes)
    check(time.monotonic() - began < 30, "a bomb takes no time")
    for nonsense in (b"PK", b"x" * 1000, read(SCENE)):
        write(f"{directory}/none.zip", nonsense)
        check("no archive of session pack" in run("session", "verify", f"{directory}/none.zip", status=3).stderr, "")


def another_value(archive, directory):
    """Results that the trials do not give, with hashes that are right: the value is named."""
    def forge(files):
        old = files["study/results.json"]
        results = json.loads(old)
        results["conditions"][0]["mean_m"] *= 1.01
        new = json.dumps(results).encode()
        sums = files["SHA256SUMS"].decode().splitlines()
        at = next(k for k, line in enumerate(sums) if line.endswith("  study/results.json"))
        sums[at - 1] = f"# {len(new)} bytes, CRC-32 {zlib.crc32(new):08x}"
        sums[at] = f"{hashlib.sha256(new).hexdigest()}  study/results.json"
        text = "\n".join(sums[:-1]) + "\n"
        files["SHA256SUMS"] = (text + f"# end, CRC-32 of the lines above {zlib.crc32(text.encode()):08x}\n").encode()
        files["study/results.json"] = new
    answer, _ = verify(repacked(archive, directory, forge), status=3)
    check(answer["study_again"]["different"] == 1, answer["study_again"])
    check(answer["study_again"]["differences"][0]["text"].startswith("/conditions/0/mean_m was "), answer["study_again"])


def full_disk(folder, directory):
    """One line, status 1, and no part is left; so is TMPDIR full while it is verified."""
    before = set(os.listdir(directory))

    def limit(size=200_000):
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    done = subprocess.run([program("haptometer"), "session", "pack", folder, "-o", f"{directory}/full.zip"],
                          capture_output=True, text=True, preexec_fn=limit, timeout=DEADLINE_S)
    check(done.returncode == 1 and done.stderr.count("\n") == 1 and "cannot be written" in done.stderr, done)
    check(set(os.listdir(directory)) == before, os.listdir(directory))
    done = subprocess.run([program("haptometer"), "session", "verify", f"{directory}/day1.zip"], capture_output=True,
                          text=True, preexec_fn=lambda: limit(20_000), timeout=DEADLINE_S,
                          env={**os.environ, "TMPDIR": directory})
    check(done.returncode == 1 and done.stderr.count("\n") == 1 and "TMPDIR" in done.stderr, done)
    check(set(os.listdir(directory)) == before, os.listdir(directory))


def interrupted(directory):
    """Ctrl-C while a session is packed or verified: status 130 (SIGTERM: 143), and nothing half made is left."""
    folder, archive, temporary = f"{directory}/long", f"{directory}/long.zip", f"{directory}/temporary"
    run("session", "new", folder, "--subjects", "4", "--conditions", "a,b", "--duration", "20s", "--", "--sensor",
        f"scene:{SCENE}", "--speed", "max")
    for _ in range(8):
        run("session", "next", folder)
    os.mkdir(temporary)
    before = set(os.listdir(directory))

    def stopped(words, number, begun):
        process = subprocess.Popen([program("haptometer"), "session", *words], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, env={**os.environ, "TMPDIR": temporary})
        wait_for(f"{words} begins", begun)
        process.send_signal(number)
        check(process.wait(timeout=DEADLINE_S) == 128 + number, (words, process.returncode))
        check(os.listdir(temporary) == [] and set(os.listdir(directory)) == before, os.listdir(temporary))
    began = time.monotonic()
    stopped(["pack", folder, "-o", archive], signal.SIGINT, lambda: time.monotonic() > began + 0.1)
    run("session", "pack", folder, "-o", archive)
    before.add("long.zip")
    for number in (signal.SIGINT, signal.SIGTERM):
        stopped(["verify", archive], number, lambda: os.listdir(temporary))


def lost(folder, directory):
    """A trial that is missing, or of which a part is damaged: named everywhere, and no longer counted."""
    for kind, spoil in (("trial-missing", os.remove), ("trial-damaged", lambda path: os.truncate(path, 20_000)),
                        ("trial-missing", lambda path: os.truncate(path, 50))):
        copy, archive = f"{directory}/spoilt/day1", f"{directory}/spoilt/{kind}.zip"
        shutil.copytree(folder, copy, symlinks=True)
        before = json.loads(run("session", "status", copy, "--json").stdout)
        name = next(one["file"] for one in before["attempts"] if one["verdict"] == "GOOD")
        spoil(f"{copy}/trials/{name}")
        after = json.loads(run("session", "status", copy, "--json").stdout)
        check(after["good"] == before["good"] - 1 and after["done"] == before["done"] - 1, after)
        check(after["trials_lost"] == 1, after)
        said = run("session", "pack", copy, "-o", archive, "--json", status=3)
        found = [(one["kind"], one["subject"]) for one in json.loads(said.stdout)["findings"] if one["severity"] == "doubt"]
        check(found == [(kind, name)], found)
        with zipfile.ZipFile(archive) as file:
            check(name in file.read("study/report.html").decode(), "the packed report names it")
        os.remove(archive)
        check(f"doubt: {name}: " in run("session", "pack", copy, "-o", archive, status=3).stdout, "in the text too")
        shutil.rmtree(f"{directory}/spoilt")


def recording(directory):
    """A session in which a recording runs is refused."""
    folder = f"{directory}/day2"
    run("session", "new", folder, "--subjects", "1", "--conditions", "a", "--duration", "5s", "--", "--sensor",
        f"scene:{SCENE}")
    process = subprocess.Popen([program("haptometer"), "session", "next", folder], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    wait_for("the trial", lambda: os.listdir(f"{folder}/trials"))
    said = run("session", "pack", folder, "-o", f"{directory}/day2.zip", status=1).stderr
    check("in use by another command of this session" in said, said)
    process.wait(timeout=DEADLINE_S)
    check(not os.path.exists(f"{directory}/day2.zip"), "no archive")
    # without a study: nothing was recorded
    empty = f"{directory}/day3"
    run("session", "new", empty, "--subjects", "1", "--conditions", "a", "--duration", "1s", "--", "--sensor", f"scene:{SCENE}")
    said = json.loads(run("session", "pack", empty, "-o", f"{directory}/day3.zip", "--json").stdout)
    check([one["kind"] for one in said["findings"]] == ["no-study"], said)
    check(not verify(f"{directory}/day3.zip")[0]["study_again"]["recomputed"], "no study")


def main():
    with tempfile.TemporaryDirectory() as directory:
        folder, archive = f"{directory}/day1", f"{directory}/day1.zip"
        record(folder)
        names = packed(folder, archive)
        intact(archive)
        # elsewhere, without the session
        os.rename(folder, f"{directory}/moved")
        intact(archive)
        flipped(archive, directory)
        hostile(archive, names, directory)
        another_value(archive, directory)
        lost(f"{directory}/moved", directory)
        full_disk(f"{directory}/moved", directory)
        interrupted(directory)
        recording(directory)


if __name__ == "__main__":
    main()
