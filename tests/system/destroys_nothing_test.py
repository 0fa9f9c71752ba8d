"""No command destroys a file: every option that writes, of every verb, against recordings, inputs, files of
other kinds, links, neighbours, full disks and places where nothing may be written.

The options are read from `--help-all` of every verb; one that names a file and is neither in WRITES nor in READS
fails the test. Disks are filled in a namespace of their own (unshare -rm) where that is permitted, and by
RLIMIT_FSIZE and /dev/full always.

Usage: destroys_nothing_test.py [--only TEXT], of the options whose verb and name hold TEXT. It calls itself with
--disks DIRECTORY inside the namespace.
"""
import fcntl
import hashlib
import math
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import DEADLINE_S, check, program, run

HAPTOMETER = program("haptometer")
FIXTURES = os.path.abspath("fixtures")

# options that name a file or folder to read; emulate --link, --campaign and session pack, which replaces nothing
# (session_pack_test.py), are tested apart
READS = {
    "acquire": {"--sensor", "--port", "--calibration", "--profile", "--daemon", "--status"},
    "analyze": {"--floor", "--calibration", "--merge", "--campaign"},
    "calibrate": {"--reference", "--check"},
    "fit-adapter": {"--calibration"},
    "trial info": {"--calibration"},
    "trial plot": {"--calibration"},
    "trial export": {"--calibration"},
    "study": {"--floor", "--verify", "--calibration", "--merge", "--campaign"},
    "fit-lra": {"--open", "--load", "--actuator"},
    "fit-impedance": {"--actuator"},
    "plan-drop-test": {"--actuator"},
    "cost": {"--actuator", "--scene"},
    "fit-skin": {"--actuator"},
    "sweep": {"--merge", "--campaign"},
    "session pack": {"-o", "--output"},
    "emulate": {"--scene", "--trial", "--profile", "--link", "--analog", "--calibration"},
}
PLACEHOLDER_OF_FILE = re.compile(r"FILE|DIR|PATH|TABLES|SOCKET|^PORT$|\.(csv|toml|html|json|md|svg|h5|bin|results)")


class Option:
    """An option that writes: `words` are its command's but for the option, `inputs` what that reads."""

    def __init__(self, verb, name, words, inputs, endings, makes="picture", can_overwrite=False, status=0):
        self.verb, self.name, self.words, self.inputs = verb, name, words, inputs
        self.endings, self.makes, self.can_overwrite, self.status = endings, makes, can_overwrite, status

    def command(self, out, overwrite=False):
        more = ["--overwrite"] if overwrite and self.can_overwrite else []
        return [*self.verb.split(), *self.words, self.name, out, *more]

    def __str__(self):
        return f"{self.verb} {self.name}"


ANALYZE = ("analyze", ["t.bin", "--floor", "floor.bin"], ["t.bin", "floor.bin"])
STUDY = ("study", ["study.toml"], ["study.toml", "trials/s1_a.bin", "floor.bin"])
COMPARED = ("study compare", ["study.toml", "scene.toml"],
            ["study.toml", "trials/s1_a.bin", "floor.bin", "scene.toml", "actuator.toml"])
FIT = ("fit-lra", ["drops.toml"], ["drops.toml", "impulse.csv"])
SKIN = ("fit-skin", ["skin.csv", "--actuator", "actuator.toml"], ["skin.csv", "actuator.toml"])
IMPEDANCE = ("fit-impedance", ["z.csv", "--actuator", "actuator.toml"], ["z.csv", "actuator.toml"])
SIMULATE = ("simulate", ["scene.toml", "--duration", "0.1s"], ["scene.toml", "actuator.toml"])
SWEEP = ("sweep", ["scene.toml", "--vary", "drive.frequency_hz=200,225,250"], ["scene.toml", "actuator.toml"])
PICTURES = [".svg", ".png", ".pdf"]


def of(question, name, endings, makes="picture", can_overwrite=False, more=(), status=0):
    verb, words, inputs = question
    return Option(verb, name, [*words, *more], inputs, endings, makes, can_overwrite, status)


WRITES = [
    Option("acquire", "-o,--output", ["--sensor", "replay", "--port", "t.bin", "--speed", "max"], ["t.bin"], [".bin"],
           "recording", True),
    Option("acquire", "--report", ["--list-sensors"], [],
           [".html"], "page"),
    Option("trial export", "-o,--output", ["t.bin"], ["t.bin"], [".csv", ".h5", ".npy", ".wav", ".mat"], "export", True),
    Option("trial info", "--report", ["t.bin"], ["t.bin"], [".html"], "page"),
    Option("trial plot", "-o,--output,--plot", ["t.bin"], ["t.bin"], [".png"]),
    of(ANALYZE, "--plot", [".svg"]),
    of(ANALYZE, "--report", [".html"], "page"),
    of(ANALYZE, "--table", [".csv"], "table", True),
    of(ANALYZE, "--spectrum", [".csv", ".svg"], "table", True),
    of(ANALYZE, "--spectrogram", [".csv", ".pdf"], "table", True),
    of(ANALYZE, "--response", [".csv"], "table", True),
    of(ANALYZE, "-o,--output", [".results"], "results", True, ["--shard", "1/1"]),
    of(STUDY, "-o,--output", [".results"], "results", True, ["--shard", "1/1"]),
    of(STUDY, "--table", [".csv"], "table", True),
    of(STUDY, "--wide", [".csv"], "table", True),
    of(STUDY, "--methods", [".md"], "text", True),
    of(STUDY, "--plot", [".svg"], can_overwrite=True),
    of(STUDY, "--report", [".html"], "page", True),
    of(COMPARED, "--table", [".csv"], "table", True, status=3),
    of(COMPARED, "--plot", [".svg"], can_overwrite=True, status=3),
    of(COMPARED, "--report", [".html"], "page", True, status=3),
    Option("study matching", "--plot", ["matching.csv"], ["matching.csv"], [".svg"]),
    Option("study matching", "--report", ["matching.csv"], ["matching.csv"], [".html"], "page"),
    Option("study linearity", "--plot", ["linearity.csv"], ["linearity.csv"], [".pdf"]),
    Option("study linearity", "--report", ["linearity.csv"], ["linearity.csv"], [".html"], "page"),
    of(FIT, "--save", [".toml"], "actuator", True),
    of(FIT, "--plot", PICTURES, can_overwrite=True),
    of(FIT, "--report", [".html"], "page", True),
    of(SKIN, "--plot", [".svg"]),
    of(SKIN, "--report", [".html"], "page"),
    of(IMPEDANCE, "--save", [".toml"], "actuator", True),
    of(IMPEDANCE, "--plot", [".svg"], can_overwrite=True),
    of(IMPEDANCE, "--report", [".html"], "page", True),
    Option("fit-adapter", "--report", ["tap.csv", "--mass", "4.6g"], ["tap.csv"], [".html"], "page"),
    Option("calibrate", "-o,--output", ["pairs.csv"], ["pairs.csv"], [".toml"], "calibration", True),
    Option("calibrate", "--plot", ["pairs.csv"], ["pairs.csv"], [".svg"]),
    Option("calibrate", "--report", ["pairs.csv"], ["pairs.csv"], [".html"], "page"),
    Option("cost", "--report", ["km", "--actuator", "actuator.toml"], ["actuator.toml"], [".html"], "page"),
    Option("plan-drop-test", "--report", ["--actuator", "actuator.toml"], ["actuator.toml"], [".html"], "page"),
    of(SIMULATE, "-o,--output", [".bin"], "recording", True),
    of(SIMULATE, "--waveforms", [".csv", ".h5", ".bin"], "export", True),
    of(SIMULATE, "--plot", [".svg"], can_overwrite=True),
    of(SIMULATE, "--report", [".html"], "page", True),
    of(SWEEP, "-o,--output", [".csv"], "table", True),
    of(SWEEP, "--plot", [".svg"], can_overwrite=True),
    Option("tune", "--plot", ["scene.toml", "--springs", "8200"], ["scene.toml", "actuator.toml"], [".svg"]),
    Option("tune", "--report", ["scene.toml", "--springs", "8200"], ["scene.toml", "actuator.toml"], [".html"], "page"),
    Option("compare", "--plot", ["t.bin", "scene.toml"], ["t.bin", "scene.toml", "actuator.toml"], [".svg"]),
    Option("compare", "--report", ["t.bin", "scene.toml"], ["t.bin", "scene.toml", "actuator.toml"], [".html"],
           "page"),
    Option("reproduce", "--figures", [], [], [], "folder"),
    Option("reproduce", "--report", [], [], [".html"], "page"),
]
for one in WRITES:
    one.names = one.name.split(",")
    one.name = one.names[-1]
    if one.verb == "analyze" and one.name == "--response":
        # a steady trial is no sweep: status 3, with the points that it has
        one.words, one.inputs, one.status = ["t.bin", "--sweep"], ["t.bin"], 3
    if one.verb == "sweep" and one.name == "--plot":
        one.words = [*one.words, "-o", "table_of_plot.csv"]
        one.can_overwrite = False


def help_of(words):
    return run(*words, "--help-all").stdout


def verbs():
    """Every verb, those of two words too."""
    names = re.findall(r"^  (\S+) +\S", run("--help").stdout, re.M)
    two = [word for name in names for word in re.findall(rf"^ +haptometer ({name} [a-z]+)\b", help_of([name]), re.M)]
    two = [word for word in two if f"haptometer {word}" in help_of(word.split()).split("Options")[0]]
    return sorted({*names, *two} - {"trial", "session"})


def check_all_options_are_known():
    for verb in verbs():
        known = {name for option in WRITES if option.verb == verb for name in option.names}
        known |= READS.get(verb, set())
        # a name of an option with what stands for its value, on the same line or alone
        for names, placeholder in re.findall(r"^  (-[-\w,]+) ([^\s]+(?: \.\.\.)?)", help_of(verb.split()), re.M):
            if not PLACEHOLDER_OF_FILE.search(placeholder):
                continue
            check(set(names.split(",")) & known, f"{verb} {names} {placeholder} is in neither table of this test")
    for option in WRITES:
        text = help_of(option.verb.split())
        check(all(name in text for name in option.names), f"{option} is an option")


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def skin_table():
    """Amplitudes of a known actuator's case on a skin of 700 N/m and 1 N s/m, 1 mA."""
    lines = ["frequency_hz,displacement_amplitude_um,current_amplitude_ma"]
    for frequency in range(40, 400, 15):
        s = 2j * math.pi * frequency
        spring = 2800 + 0.0322 * s
        # [case, mover] on the skin, a force of 1 N/A between them
        a, b, d = 0.6e-3 * s * s + 700 + s + spring, -spring, 1.4e-3 * s * s + spring
        force = 1e-3
        case = (-force * d - b * force) / (a * d - b * b)
        lines.append(f"{frequency},{abs(case) * 1e6:.6f},1")
    return "\n".join(lines) + "\n"


def impedance_table():
    """The known actuator's impedance, its case held."""
    lines = ["frequency_hz,impedance_ohm,phase_deg"]
    for frequency in range(100, 400, 5):
        s = 2j * math.pi * frequency
        z = 27 + 130e-6 * s + s / (1.4e-3 * s * s + 0.0322 * s + 2800)
        lines.append(f"{frequency},{abs(z):.6f},{math.degrees(math.atan2(z.imag, z.real)):.6f}")
    return "\n".join(lines) + "\n"


def tap_table():
    """The ring-down of 214 Hz after a tap, with a step of rounding."""
    rows = [f"{n / 2000:.4f},{1e-4 * math.exp(-n / 300) * math.cos(2 * math.pi * 214 * n / 2000):.8f}\n"
            for n in range(1500)]
    return "time_s,displacement_m\n" + "".join(rows)


def make_inputs(directory):
    """What the commands read, small and quick."""
    os.chdir(directory)
    write("actuator.toml", 'moving_mass_kg = "1.4e-3 kg"\ncase_mass_kg = "0.6e-3 kg"\nresistance_ohm = "27 ohm"\n'
          'inductance_h = "130e-6 H"\nstiffness_n_per_m = "2800 N/m"\ndamping_n_s_per_m = "0.0322 N s/m"\n'
          'force_constant_n_per_a = "1 N/A"\n')
    scene = ('[actuator]\nfile = "actuator.toml"\n[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n'
             '[drive]\nkind = "sine"\namplitude_v = AMPLITUDE\nfrequency_hz = 225\n'
             '[sensor]\nkind = "stream"\ntarget = "skin"\nseed = SEED\n')
    write("scene.toml", scene.replace("AMPLITUDE", "5").replace("SEED", "1"))
    os.mkdir("trials")
    trials = [("t.bin", 5, 1), ("floor.bin", 0.001, 2), ("other.bin", 4, 3)]
    trials += [(f"trials/s{s}_{c}.bin", a + 0.1 * s + 0.03 * ((s * 7) % 3), 10 * s + a)
               for s in (1, 2, 3) for c, a in (("a", 5), ("b", 4))]
    for name, amplitude, seed in trials:
        write("one.toml", scene.replace("AMPLITUDE", str(amplitude)).replace("SEED", str(seed)))
        run("simulate", "one.toml", "--duration", "0.6s", "-o", name)
    write("study.toml", 'pattern = "{subject}_{condition}"\nfloor = "floor.bin"\n[[trials]]\nfiles = "trials/*.bin"\n')
    write("matching.csv", open(os.path.join(FIXTURES, "matching.csv"), encoding="utf-8").read())
    write("impulse.csv", open(os.path.join(FIXTURES, "impulse.csv"), encoding="utf-8").read())
    write("drops.toml", 'moving_mass_kg = "1.4 g"\ncase_mass_kg = "0.6 g"\nresistance_ohm = "27 ohm"\n'
          'inductance_h = "130e-6 H"\n[[drop]]\nfile = "impulse.csv"\n')
    write("linearity.csv", "drive_v,rms_m\n" + "".join(f"{v},{v * 1.1e-6 + 1e-8 * (v % 2)}\n" for v in range(1, 8)))
    write("skin.csv", skin_table())
    write("z.csv", impedance_table())
    write("tap.csv", tap_table())
    write("pairs.csv", "displacement_mm,voltage_v\n" + "".join(f"{n},{n + 1e-3 * (n % 3)}\n" for n in range(-4, 5)))
    write("note.txt", "precious words\n")


def digests(directory="."):
    """Of every file: kind, permissions and content; of every link: where it leads."""
    found = {}
    for folder, _, names in os.walk(directory):
        for name in names:
            path = os.path.join(folder, name)
            if os.path.islink(path):
                found[path] = os.readlink(path)
            elif os.path.isfile(path):
                with open(path, "rb") as file:
                    found[path] = hashlib.sha256(file.read()).hexdigest()
            else:
                found[path] = "special"
    return found


def attempt(command, status, what, limit_bytes=None):
    """Runs a command that must end with one of `status` and lose nothing; its stderr."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))
    before = digests()
    # without a function to run in it a process starts faster
    done = subprocess.run([HAPTOMETER, *command], capture_output=True, text=True, timeout=DEADLINE_S,
                          preexec_fn=None if limit_bytes is None else limit, check=False)
    text = f"{what}: {' '.join(command)}: status {done.returncode}: {done.stderr}"
    check(done.returncode in (status if isinstance(status, tuple) else (status,)), text)
    after = digests()
    for path, digest in before.items():
        check(after.get(path) == digest, f"{path} is lost. {text}")
    return done.stderr, sorted(after.keys() - before.keys())


def refused(option, target, what, status=2):
    """Nothing is lost and nothing is made, with --overwrite too."""
    for overwrite in (False, True) if option.can_overwrite else (False,):
        _, new = attempt(option.command(target, overwrite), status, f"{option} over {what}")
        check(not new, f"{option} over {what} makes {new}")


def targets_of(option, ending):
    """Files of other kinds and inputs under names that the option takes: (path, what)."""
    def under(source, name):
        path = name + ending
        if not os.path.lexists(path):
            os.link(source, path)
        return path
    for source in option.inputs:
        yield under(source, "input_" + re.sub(r"\W", "_", source)), f"its input {source}"
    for source in ("other.bin", "scene.toml", "drops.toml", "note.txt", "linearity.csv"):
        is_own = source == "other.bin" and (option.makes == "recording" or (option.makes, ending) == ("export", ".bin"))
        if source not in option.inputs and not is_own:
            yield under(source, "other_" + re.sub(r"\W", "_", source)), source
    link = "link_to_input" + ending
    if not os.path.lexists(link):
        os.symlink("other.bin" if option.makes != "recording" else "scene.toml", link)
    if (option.makes, ending) != ("export", ".bin"):
        yield link, "a link to a file of another kind"


def clear(*names):
    for name in names:
        if os.path.lexists(name):
            os.remove(name)


def check_other_files(option):
    for ending in option.endings:
        made = []
        for path, what in targets_of(option, ending):
            made.append(path)
            refused(option, path, what)
        # a recording of its own kind needs --overwrite
        if option.makes == "recording":
            attempt(option.command("other.bin"), 2, f"{option} without --overwrite")
        os.symlink("nowhere" + ending, "dangling" + ending)
        refused(option, "dangling" + ending, "a link to nothing")
        refused(option, "none/out" + ending, "a missing directory")
        clear(*made, "dangling" + ending)


def check_neighbours(option, ending):
    """A new file, beside the names that a writer could take for its own."""
    out = "out" + ending
    write(out + ".part", "precious")
    os.symlink("note.txt", out + ".new")
    os.symlink("note.txt", f"{out}.{os.getpid()}.part")
    stderr, new = attempt(option.command(out), option.status, f"{option} anew")
    check(new == ["./" + out], f"{option} makes {new}: {stderr}")
    clear(out + ".part", out + ".new", f"{out}.{os.getpid()}.part")
    return out


def check_failing_writes(option, out, ending):
    """A limit on files and a full device; `out` is one that the option made."""
    if option.verb != "acquire":  # a recorder keeps what it recorded so far
        stderr, new = attempt(option.command(out, True), 1, f"{option} beyond the limit", limit_bytes=60)
        check(not new, f"{option} beyond the limit leaves {new}")
        check(stderr.count("\n") >= 1, f"{option} says what failed: {stderr}")
        _, new = attempt(option.command("fresh" + ending), 1, f"{option} beyond the limit, anew", limit_bytes=60)
        check(not new, f"{option} beyond the limit leaves {new}")
    if ending == ".h5":  # libhdf5 writes parts at once and others when it closes
        size = os.path.getsize(out)
        for part in (size // 4, size // 2, size - 1):
            _, new = attempt(option.command(out, True), 1, f"{option} beyond {part} bytes", limit_bytes=part)
            check(not new, f"{option} beyond {part} bytes leaves {new}")
    os.symlink("/dev/full", "full" + ending)
    by_library = ending in (".h5", ".mat") or (option.verb, option.name) == ("sweep", "--output")
    attempt(option.command("full" + ending), 2 if by_library else 1, f"{option} to /dev/full")
    clear("full" + ending)
    os.mkfifo("pipe" + ending)
    stderr, _ = attempt(option.command("pipe" + ending), 2, f"{option} to a pipe without a reader")
    check("is a pipe that no program reads; start its reader first" in stderr, f"{option} to a pipe: {stderr}")
    clear("pipe" + ending)
    if not option.makes == "recording":
        attempt(option.command("/proc/out" + ending), 1, f"{option} where no file can be made")


def check_option(option):
    check_other_files(option)
    for ending in option.endings:
        clear("table_of_plot.csv")
        if option.verb == "sweep" and option.name == "--plot":
            run(*SWEEP[0].split(), *SWEEP[1], "-o", "table_of_plot.csv")
            option.words = [*SWEEP[1], "-o", "table_of_plot.csv", "--resume"]
        out = check_neighbours(option, ending)
        check_failing_writes(option, out, ending)
        clear(out)


def check_reproduce():
    """Figures and report at once: each run takes seconds."""
    os.mkdir("figures")
    _, new = attempt(["reproduce", "--figures", "figures", "--report", "page.html"], 0, "reproduce")
    figures = [name for name in new if name.startswith("./figures/")]
    check(len(figures) >= 6 and "./page.html" in new and len(new) == len(figures) + 1, f"reproduce makes {new}")
    _, new = attempt(["reproduce", "--figures", "figures"], 1, "reproduce beyond the limit", limit_bytes=60)
    check(not new, f"reproduce leaves {new}")
    first = min(figures)
    os.remove(first)
    os.link("other.bin", first)
    attempt(["reproduce", "--figures", "figures"], 2, "reproduce over a recording")
    refused(Option("reproduce", "--report", [], [], [".html"]), "note.txt", "a note")


def check_two_of_one_name():
    stderr, _ = attempt(["analyze", "t.bin", "--plot", "both.svg", "--spectrum", "./both.svg"], 2, "one file for two")
    check("--plot" in stderr and "--spectrum" in stderr, stderr)


def check_pipes():
    """A pipe that is read gets the file's bytes; none continues a table."""
    for command in (["trial", "export", "t.bin", "-o"], [*WRITES[0].verb.split(), *WRITES[0].words, "-o"]):
        os.mkfifo("pipe.csv")
        reader = os.open("pipe.csv", os.O_RDONLY | os.O_NONBLOCK)
        fcntl.fcntl(reader, fcntl.F_SETPIPE_SZ, 1 << 20)  # room for the whole file
        attempt([*command, "pipe.csv"], 0, "to a pipe")
        check(len(os.read(reader, 1 << 20)) > 5000, f"{command} into a pipe")
        os.close(reader)
        clear("pipe.csv")
    os.mkfifo("pipe.csv")
    stderr, _ = attempt([SWEEP[0], *SWEEP[1], "-o", "pipe.csv", "--resume"], 2, "a table in a pipe")
    check("pipe.csv: exists and is not a file" in stderr, stderr)
    clear("pipe.csv")


def check_links():
    """emulate --link replaces links to terminals only."""
    os.symlink("t.bin", "to_a_recording")
    emulate = ["emulate", "--scene", "scene.toml", "--duration", "0.05s", "--link"]
    for name in ("t.bin", "scene.toml", "note.txt", "to_a_recording", "trials"):
        attempt([*emulate, name], 1, "emulate over " + name)
    os.symlink("t.bin", "run.part")
    os.symlink("/dev/pts/no_such", "run")
    write("run.new", "precious")
    before = digests()
    run(*emulate, "run")
    after = digests()
    check(before.items() - after.items() <= {("./run", "/dev/pts/no_such")}, "only the link is replaced")
    check(after.keys() <= before.keys(), f"nothing is left: {after.keys() - before.keys()}")
    clear("run.new", "run.part", "to_a_recording")


def check_sessions():
    """session new makes a new folder or fills an empty one, and writes over nothing."""
    words = ["--subjects", "1", "--conditions", "a", "--duration", "0.5s", "--", "--sensor", "scene:scene.toml"]
    for name in ("trials", "t.bin", "note.txt"):
        attempt(["session", "new", name, *words], 2, "a session in " + name)
    for word in ("next", "redo", "floor", "status"):
        attempt(["session", word, "trials"], 3, f"session {word} in a folder that is none")


def check_campaigns():
    """A campaign makes a new folder, and writes over nothing."""
    os.symlink("no_such_campaign", "dangling")
    os.mkdir("an_empty_folder")
    commands = [[*verb.split(), *words, "--slurm", "2", "--campaign"] for verb, words, _ in (ANALYZE, STUDY, SWEEP)]
    # a sweep names its table, which is made by the merging
    commands[-1][-3:-3] = ["-o", "table.csv"]
    commands.append(["campaign", "plan"])
    for command in commands:
        for name in ("trials", "an_empty_folder", "t.bin", "note.txt", "dangling", "none/campaign"):
            words = [*command, name] + (["--", "true"] if command[0] == "campaign" else [])
            _, new = attempt(words, (1, 2), f"{command[0]} in {name}")
            check(not new, f"a campaign in {name} makes {new}")
    clear("dangling")
    os.rmdir("an_empty_folder")


def check_standard_output():
    """All verbs print; a full device is an error, a reader that goes away is none."""
    printing = [["--help"], ["--version"], ["analyze", "t.bin"], ["analyze", "t.bin", "--json"], ["tune", "--version"],
                ["trial", "info", "t.bin"], ["trial", "export", "t.bin"], ["fit-lra", "impulse.csv"],
                ["simulate", "scene.toml"], ["study", "trials", "--pattern", "{subject}_{condition}"],
                ["sweep", "--help-all"], ["fit-skin", "skin.csv", "--actuator", "actuator.toml"],
                ["study", "matching", "matching.csv"], ["acquire", "--list-sensors"], ["emulate", "--help"]]
    for command in printing:
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([HAPTOMETER, *command], stdout=full, stderr=subprocess.PIPE, text=True,
                                  timeout=DEADLINE_S, check=False)
        said = [line for line in done.stderr.splitlines() if "No space left on device" in line]
        check(done.returncode == 1 and len(said) == 1, f"{command} to /dev/full: {done.returncode} {done.stderr}")
        for restore in (True, False):  # SIGPIPE as the shell leaves it, or ignored
            # the reader is gone before the command begins, however quick that is
            reader, writer = os.pipe()
            os.close(reader)
            done = subprocess.Popen([HAPTOMETER, *command], stdout=writer, stderr=subprocess.PIPE,
                                    restore_signals=restore)
            os.close(writer)
            error = done.stderr.read().decode()
            status = done.wait(DEADLINE_S)
            check(status in (141, -signal.SIGPIPE) and "standard output" not in error and "Broken" not in error,
                  f"{command} without a reader: {status} {error}")
    # closed from the start: a file made meanwhile does not get the words
    done = subprocess.run(["sh", "-c", '"$0" trial export t.bin -o closed.csv >&- && "$0" trial info t.bin >&-',
                           HAPTOMETER], capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    check(done.returncode == 1 and "standard output" in done.stderr, f"closed: {done.returncode} {done.stderr}")
    check(open("closed.csv", encoding="utf-8").read() == run("trial", "export", "t.bin").stdout, "what was exported")
    clear("closed.csv")


def fill(directory):
    path = os.path.join(directory, "filler")
    with open(path, "wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            pass


def check_disks(directory):
    """Inside a namespace whose `directory`/disk is a small disk of its own."""
    os.chdir(directory)
    disk = "disk"
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", disk], check=True)
    options = [option for option in WRITES if option.verb not in ("acquire", "reproduce")]
    for number, option in enumerate(options):
        for ending in option.endings:
            out = f"{disk}/{number}{ending}"
            more = ["--overwrite"] if option.verb == "sweep" and option.name == "--plot" else []
            done = subprocess.run([HAPTOMETER, *option.command(out), *more], capture_output=True, text=True,
                                  timeout=DEADLINE_S, check=False)
            check(done.returncode == option.status, f"{option}: {done.stderr}")
    fill(disk)
    for again in ("full", "read-only"):
        for number, option in enumerate(options):
            for ending in option.endings:
                more = ["--overwrite"] if option.verb == "sweep" and option.name == "--plot" else []
                stderr, new = attempt([*option.command(f"{disk}/{number}{ending}", True), *more], 1,
                                      f"{option} on a {again} disk") if not more else ("", [])
                check(not new, f"{option} on a {again} disk leaves {new}: {stderr}")
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)


def main():
    if sys.argv[1:2] == ["--disks"]:
        check_disks(sys.argv[2])
        return
    check_all_options_are_known()
    with tempfile.TemporaryDirectory() as directory:
        make_inputs(directory)
        only = sys.argv[2] if sys.argv[1:2] == ["--only"] else ""
        for option in WRITES:
            if option.verb != "reproduce" and only in str(option):
                check_option(option)
        if only:
            return
        check_two_of_one_name()
        check_pipes()
        check_links()
        check_sessions()
        check_campaigns()
        check_standard_output()
        check_reproduce()
        os.mkdir("disk")
        inside = subprocess.run(["unshare", "-rm", "true"], capture_output=True, check=False)
        if inside.returncode != 0:
            print("not tried: a full tmpfs, because this system permits no mounts in a namespace of one's own; "
                  "limits on files and /dev/full stand in for it")
            return
        done = subprocess.run(["unshare", "-rm", sys.executable, TEST, "--disks", directory], check=False)
        check(done.returncode == 0, "on full and read-only disks")


TEST = os.path.abspath(__file__)
if __name__ == "__main__":
    main()
