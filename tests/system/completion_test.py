"""The completions of a build (SHELL FOLDER) in a real bash or zsh: words are typed at a terminal, Tab is pressed, and
what the shell offers or completes is compared with what --help-all lists. The program is never started for it."""
import fcntl
import os
import pathlib
import pty
import re
import select
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from manual_test import commands, options_of_help
from programs import check, run, skip

KEYS_S = 60  # for the answer to a Tab; a loaded machine takes seconds for the first one
FILES = ("a.toml", "b.toml", "one.csv", "two.csv", "t.bin", "page.html", "x.svg", "notes.txt", "F0001CH1.CSV", "d.h5", "v.lvm", "spaced/my file.csv",
         "sub/c.toml")
START = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], r"""
bind 'set bell-style none' 2>/dev/null; bind 'set enable-bracketed-paste off'; bind 'set show-all-if-ambiguous on'
bind 'set completion-display-width 0'; bind 'set completion-query-items 0'; bind 'set page-completions off'
bind -x '"\C-xl": printf "\nLINE<%s>\n" "$READLINE_LINE"'
source FOLDER/haptometer; cd WORK; PS1='> '; printf '%s\n' READY
"""),
    "zsh": (["zsh", "-f", "-i"], r"""
fpath=(FOLDER $fpath); autoload -Uz compinit; compinit -u -D; unset zle_bracketed_paste
setopt no_list_ambiguous no_auto_menu no_beep no_prompt_sp; LISTMAX=10000; bindkey -e
zstyle ':completion:*' verbose no; zstyle ':completion:*' list-prompt ''
show() { print -r -- $'\n'"LINE<$BUFFER>" >$TTY }; zle -N show; bindkey '^Xl' show
cd WORK; PS1='> '; print -r -- READY
"""),
}


class Shell:
    """An interactive shell at a terminal of its own, in a folder with FILES."""

    def __init__(self, name, completions, work):
        words, script = START[name]
        start = os.path.join(work, "..", "start")
        with open(start, "w") as file:
            file.write(script.replace("FOLDER", completions).replace("WORK", work))
        env = {"HOME": work, "TERM": "dumb", "PATH": os.path.join(work, "../bin") + ":" + os.environ["PATH"],
               "LC_ALL": "C.UTF-8", "INPUTRC": "/dev/null"}
        self.text, self.name = "", name
        self.pid, self.master = pty.fork()
        if self.pid == 0:
            os.execvpe(words[0], words, env)
        fcntl.ioctl(self.master, termios.TIOCSWINSZ, struct.pack("HHHH", 500, 300, 0, 0))
        self.type(f"source {start}\r")
        self.read_to(r"\nREADY")

    def type(self, keys):
        os.write(self.master, keys.encode())

    def read_to(self, pattern):
        """What the terminal shows up to the pattern, and the pattern's match."""
        deadline = time.monotonic() + KEYS_S
        while not (found := re.search(pattern, self.text)):
            check(time.monotonic() < deadline, f"{pattern} does not come; the terminal shows {self.text!r}")
            if select.select([self.master], [], [], 0.1)[0]:
                self.text += os.read(self.master, 65536).decode(errors="replace").replace("\r\n", "\n")
        before, self.text = self.text[:found.start()], self.text[found.end():]
        return before, found

    def tab(self, line):
        """What is offered for a line, and the line after the key."""
        self.type(line + "\t\x18l")
        before, found = self.read_to(r"\nLINE<(.*)>")
        self.type("\x15")
        # the first line is what was typed, the last one the prompt with it
        shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|[\r\a]", "\n", before)
        lists = [text for text in shown.split("\n") if line.strip() not in text and not text.startswith("> ")]
        return {word for text in lists for word in text.split()}, found[1]

    def end(self):
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.master)


def check_offers(shell, line, some, none=(), exactly=False):
    offered, after = shell.tab(line)
    missing, wrong = set(some) - offered, set(none) & offered
    check(not missing and not wrong, f"{line!r}: {missing} missing, {wrong} not wanted; offered {offered}, now {after!r}")
    check(not exactly or offered == set(some), f"{line!r}: offered {offered}, not {some}")


def check_completes(shell, line, expected):
    offered, after = shell.tab(line)
    check(after == expected, f"{line!r} becomes {after!r}, not {expected!r}; offered {offered}")


def check_every_option(shell):
    """All long options of --help-all are offered, and no other."""
    count = 0
    for command in commands():
        names = {name for names, _, _ in options_of_help(run(*command, "--help-all").stdout) for name in names
                 if name.startswith("--")}
        check_offers(shell, f"haptometer {' '.join(command)} --", names, exactly=True)
        count += len(names)
    check(count > 500, f"{count} options")
    return count


def check_words(shell):
    verbs = {command[0] for command in commands()}
    check_offers(shell, "haptometer ", verbs | {"help"}, exactly=True)
    check_offers(shell, "haptometer help ", verbs, exactly=True)
    check_offers(shell, "haptometer trial ", {"info", "label", "exclude", "include", "plot", "export"}, exactly=True)
    check_completes(shell, "haptometer help trial inf", "haptometer help trial info ")
    check_completes(shell, "haptometer ana", "haptometer analyze ")
    check_offers(shell, "haptometer analyze --corner ", {"whole", "each"}, exactly=True)
    check_completes(shell, "haptometer analyze --corner=w", "haptometer analyze --corner=whole ")
    check_completes(shell, "analyze --corner ea", "analyze --corner each ")
    check_offers(shell, "acquire --sensor ", {"keyence-il", "stream", "replay", "scene:"}, {"a.toml", "t.bin"})
    check_completes(shell, "acquire --profile baum", "acquire --profile baumer-om20 ")
    check_offers(shell, "haptometer cost ", {"skin-rms", "waveform", "band-rms", "kv", "bv", "km"}, exactly=True)
    check_completes(shell, "haptometer emulate --protocol dl", "haptometer emulate --protocol dl-rs1a ")
    check_offers(shell, "haptometer emulate --profile b", {"baumer-om20", "benewake-tf-i", "b.toml"}, exactly=True)
    check_offers(shell, "acquire --speed ", {"recorded", "max"}, exactly=True)
    # keys of a scene, behind which a value follows at once
    check_completes(shell, "haptometer sweep a.toml --vary drive.freq",
                    "haptometer sweep a.toml --vary drive.frequency_hz=")
    check_offers(shell, "haptometer compare --input skin.", {"skin.stiffness_n_per_m=", "skin.damping_n_s_per_m="})


def check_no_verb(shell):
    """Nothing is offered behind what is no verb or part."""
    for line in ("haptometer nonsense ", "haptometer trial nonsense "):
        check_offers(shell, line, set(), exactly=True)


def check_own_separator(shell):
    """What the user's shell takes for a separator of words changes nothing."""
    shell.type("IFS=,\r")
    check_completes(shell, "haptometer analyze --corner w", "haptometer analyze --corner whole ")
    check_offers(shell, "haptometer trial ", {"info", "label"}, {"--help"})
    shell.type("unset IFS\r" if shell.name == "bash" else "IFS=$' \\t\\n\\0'\r")


def check_options_once(shell):
    for line in ("haptometer analyze t.bin --hum keep --hu", "haptometer sweep -o a.csv --out",
                 "haptometer sweep --best=a --be", "haptometer trial plot --output x.svg --plo"):
        check_completes(shell, line, line)
    check_completes(shell, "haptometer sweep -o a.csv --over", "haptometer sweep -o a.csv --overwrite ")
    check_completes(shell, "acquire --label subject=3 --lab", "acquire --label subject=3 --label" + shell.after_option)
    # what stands behind -- is of acquire
    check_completes(shell, "haptometer session new d -- --tar", "haptometer session new d -- --tare ")
    check_offers(shell, "haptometer session new d -- --sensor ", {"keyence-il", "scene:"}, FILES)
    check_offers(shell, "haptometer session new d -- ", {"--sensor", "--tare"}, {"--subjects", *FILES})


def check_kinds(shell):
    """Files of the kinds that a command reads."""
    of_scene, of_trial = ({"a.toml", "b.toml"}, {"one.csv", "t.bin"}), ({"t.bin", "one.csv", "d.h5"}, {"a.toml", "x.svg"})
    for line in ("cost skin-rms --scene", "emulate --scene", "acquire --sensor scene:", "fit-skin --actuator",
                 "fit-lra --actuator", "plan-drop-test --actuator", "cost kv --actuator", "calibrate t.csv --check"):
        check_offers(shell, f"haptometer {line}" + ("" if line.endswith(":") else " "), *of_scene)
    for line in ("emulate --trial", "analyze --floor", "study --floor", "fit-adapter"):
        check_offers(shell, f"haptometer {line} ", *of_trial)
    check_offers(shell, "fit-lra ", {"one.csv", "t.bin", "a.toml"}, {"notes.txt", "x.svg"})
    for line in ("fit-impedance", "fit-skin", "calibrate"):
        check_offers(shell, f"haptometer {line} ", {"one.csv", "F0001CH1.CSV"}, {"t.bin", "a.toml"})


def check_files(shell):
    check_kinds(shell)
    check_offers(shell, "analyze ", {"t.bin", "one.csv", "two.csv", "d.h5", "v.lvm", "sub/"}, {"a.toml", "notes.txt", "--all"})
    check_completes(shell, "analyze notes", "analyze notes.txt ")  # no other file begins so
    check_offers(shell, "haptometer simulate ", {"a.toml", "b.toml", "sub/"}, {"t.bin", "one.csv"})
    check_completes(shell, "haptometer simulate sub/", "haptometer simulate sub/c.toml ")
    check_completes(shell, "haptometer simulate a.toml --report p", "haptometer simulate a.toml --report page.html ")
    check_completes(shell, "analyze t.bin --plot=x", "analyze t.bin --plot=x.svg ")
    check_offers(shell, "analyze t.bin --plot ", {"x.svg", "sub/", "spaced/"}, exactly=True)
    check_completes(shell, "analyze F", "analyze F0001CH1.CSV ")
    check_offers(shell, "haptometer simulate ", {"a.toml"}, {"F0001CH1.CSV"})
    if shell.name == "bash":  # zsh itself puts the value in place of a variable
        check_completes(shell, 'analyze "$HOME/t.', 'analyze "$HOME/t.bin" ')
    check_completes(shell, "analyze spaced/m", "analyze spaced/my\\ file.csv ")
    check_completes(shell, "acquire --sensor scene:a", "acquire --sensor scene:a.toml ")
    check_completes(shell, "haptometer study compare --condition cone=b",
                    "haptometer study compare --condition cone=b.toml ")
    check_offers(shell, "fit-lra --load 33ohm one.csv ", {"one.csv", "t.bin"})
    # tables, as many as there are, where the sweep itself would have a scene
    check_offers(shell, "haptometer sweep --merge one.csv ", {"two.csv"}, {"a.toml"})
    check_offers(shell, "fit-lra --load 33ohm one.csv two.csv ", {"one.csv", "t.bin"})
    check_offers(shell, "haptometer sweep --merge one.csv two.csv F0001CH1.CSV -o ", {"one.csv"}, {"a.toml"})
    check_options_behind_several(shell)
    check_offers(shell, "haptometer session status ", {"sub/", "spaced/"}, {"a.toml", "t.bin"})
    ports = [path.as_posix() for name in ("ttyUSB*", "ttyACM*") for path in pathlib.Path("/dev").glob(name)]
    if len(ports) > 1:
        check_offers(shell, "acquire --port ", ports)
    else:
        check_completes(shell, "acquire --port t.b", "acquire --port t.bin ")


def check_options_behind_several(shell):
    """An option behind one of several values has values of its own, and is offered itself."""
    check_offers(shell, "haptometer sweep --merge one.csv two.csv -o ", {"one.csv", "two.csv", "sub/"}, {"a.toml"})
    check_completes(shell, "haptometer sweep --merge one.csv two.csv --overw",
                    "haptometer sweep --merge one.csv two.csv --overwrite ")
    for own in ("fit-lra", "haptometer fit-lra"):
        for several in ("--load 33ohm one.csv two.csv", "--open one.csv two.csv"):
            check_offers(shell, f"{own} {several} --require ", {"Kv", "Bv", "Km"}, exactly=True)
            check_completes(shell, f"{own} {several} --format ro", f"{own} {several} --format rohde-schwarz ")


def main():
    name, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    if shutil.which(name) is None:
        skip(f"no {name}")
    for file in ("haptometer",) if name == "bash" else ("_haptometer",):
        done = subprocess.run([name, "-n", os.path.join(folder, file)], capture_output=True, text=True, timeout=KEYS_S)
        check(done.returncode == 0 and not done.stderr, done.stderr)
    with tempfile.TemporaryDirectory() as place:
        work = pathlib.Path(place, "work")
        for file in FILES:
            (work / file).parent.mkdir(parents=True, exist_ok=True)
            (work / file).touch()
        started = pathlib.Path(place, "started")
        for program in ("haptometer", "acquire", "analyze", "fit-lra"):
            path = pathlib.Path(place, "bin", program)
            path.parent.mkdir(exist_ok=True)
            path.write_text(f"#!/bin/sh\necho started >{started}\n")
            path.chmod(0o755)
        shell = Shell(name, folder, str(work))
        # zsh leaves the place where an equals sign may stand
        shell.after_option = " " if name == "bash" else "="
        try:
            check_words(shell)
            check_no_verb(shell)
            check_own_separator(shell)
            check_options_once(shell)
            check_files(shell)
            count = check_every_option(shell)
        finally:
            shell.end()
        check(not started.exists(), "a Tab started the program")
    print(f"{name}: {count} options")


if __name__ == "__main__":
    main()
