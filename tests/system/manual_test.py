"""The manual pages of a build (FOLDER): every option that --help-all shows stands in the page of its verb with its
text, every example as it is typed; groff, man and lexgrog take them without a warning. `haptometer help VERB`."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, ".."), os.path.join(HERE, "../../packaging")]
from man_pages import LONG
from programs import DEADLINE_S, check, run, skip

OWN = ("acquire", "analyze", "fit-lra")
COLUMN = 30  # where --help has its texts
NEEDS_ESCAPE = re.compile(r"(?<!\\)-|(?<!\(rs)\\(?![-&fe]|\((?:rs|aq|ga|ha|ti|dq)|\[u)|['`^~\"]")


def quiet(*words, env=None):
    """Standard output of a program that has to end well and say nothing on standard error."""
    done = subprocess.run(words, capture_output=True, text=True, timeout=DEADLINE_S, env=env)
    check(done.returncode == 0 and not done.stderr, f"{words}: {done.returncode}: {done.stdout[:500]}{done.stderr}")
    return done.stdout


def commands():
    """Verbs, and their parts as their help lists them."""
    for verb in re.findall(r"^  ([a-z][a-z-]+) ", run("--help").stdout, re.MULTILINE):
        text = run(verb, "--help-all").stdout
        parts = re.findall(rf"^  haptometer {verb} ([a-z]+)  ", text, re.MULTILINE)
        if not parts:
            yield (verb,)
            parts = re.findall(rf"\b{verb} ([a-z]+)\b", text.splitlines()[0].partition("--help of")[2])
        yield from ((verb, part) for part in parts)


def one_line(text):
    return " ".join(text.split())


def options_of_help(text):
    """Names, placeholder and text of each option that --help-all shows."""
    lines = text.splitlines()
    for at, line in enumerate(lines):
        if line.startswith("  -"):
            # the text stands in a column of its own, or in the next line
            below = lines[at + 1].startswith(" " * COLUMN)
            tag, meaning = (line, lines[at + 1]) if below else (line[:COLUMN], line[COLUMN:])
            names, _, placeholder = tag.strip().partition(" ")
            check(tag.endswith(" ") or below, f"where does the text begin in {line}")
            yield names.split(","), placeholder, meaning.strip()


def section(text, title):
    """What stands below a heading of a page that is laid out."""
    found = re.search(rf"^{re.escape(title)}$\n(.*?)(?=^\S|\Z)", text, re.MULTILINE | re.DOTALL)
    check(found, f"no section {title}")
    return found[1]


def value_is_said(tag, placeholder, where):
    """The placeholder stands behind the names; of many choices the page says NAME, and lists them."""
    shown = placeholder.split(" ...")[0]
    if f"{tag} {shown}" in where.replace(" [" + shown, " " + shown):
        return True
    return len(placeholder) > LONG and f"{tag} NAME" in where and ": " + shown.replace("|", ", ") in where


def check_options(place, command, text, page):
    """The text is that of a verb or of a part, without other parts."""
    help_text = run(*command, "--help-all").stdout
    said, common = one_line(text), one_line(section(page, "COMMON OPTIONS"))
    count = 0
    for names, placeholder, meaning in options_of_help(help_text):
        tag = ", ".join(names)
        where = common if names[-1] in ("--help", "--help-all", "--version", "--json") else said
        check(re.search(rf"(?:^| ){re.escape(tag)}(?: |$)", where), f"{place}: {tag} is missing")
        check(not placeholder or value_is_said(tag, placeholder, where), f"{place}: {tag} {placeholder} is missing")
        # the page may have more in the brackets, and the choices before them
        for part in re.sub(r"\]$", "", meaning).split(" ["):
            check(one_line(part) in where, f"{place}: {names[-1]}: '{part}' is missing")
        count += 1
    check(count >= 4, f"{place}: {count} options in the help")
    check("... ..." not in help_text, f"{place}: doubled dots")
    has_own = len(command) > 1 or "\nEXAMPLES\n" not in page
    examples = re.sub(r" \\\n +", " ", text if has_own else section(page, "EXAMPLES"))
    for example in help_text.partition("Examples:\n")[2].splitlines():
        check(example.strip() in [line.strip() for line in examples.splitlines()], f"{place}: no example {example}")
    synopsis = one_line(section(page, "SYNOPSIS"))
    usage = re.search(r"^Usage: (.*)$", help_text, re.MULTILINE)[1].replace("[OPTIONS]", "[OPTION]...")
    check(usage in synopsis, f"{place}: the synopsis lacks '{usage}'")
    return count


def laid_out(page):
    """A page as plain text in long lines."""
    return quiet("groff", "-man", "-Tascii", "-P-cbou", "-rLL=400n", "-rHY=0", str(page))


def check_roff(page):
    for device in ("utf8", "ps"):
        check(not quiet("groff", "-ww", "-man", "-T" + device, "-z", str(page)), page)
    for number, text in enumerate(page.read_text().splitlines(), 1):
        if not re.match(r"\.(\\\"|TH|so)", text):
            wrong = NEEDS_ESCAPE.search(re.sub(r"^\.(?:SH|SS) ", "", text))
            check(not wrong, f"{page.name}:{number}: {wrong and wrong[0]!r} is not escaped in {text}")


def check_as_installed(folder):
    """man finds each page, a program's own page leads to that of the verb, and whatis has its line. On 80 columns each
    line fits, no word is hyphenated, and no option is broken from its value."""
    if shutil.which("man") is None:
        skip("no man")
    with tempfile.TemporaryDirectory() as place:
        shutil.copytree(folder, os.path.join(place, "man1"))
        env = {**os.environ, "MANPATH": place, "LC_ALL": "C.UTF-8", "MANWIDTH": "80"}
        for page in sorted(folder.iterdir()):
            text = quiet("man", "--warnings", "-E", "UTF-8", "-P", "cat", page.stem, env=env)
            check(text.startswith("HAPTOMETER"), f"man {page.stem}: {text[:100]}")
            broken = re.search(r" -[^ =]+ \\\n +[^- ].*", text)
            check(not broken, f"man {page.stem}: a value is not behind its option: {broken and broken[0]}")
            for line in text.splitlines():
                check(len(line) <= 80, f"man {page.stem}: {len(line)} columns: {line}")
                check("\u2010" not in line, f"man {page.stem}: a word is broken in {line}")
            if page.stem not in OWN:
                said = quiet("lexgrog", os.path.join(place, "man1", page.name), env=env)
                check(f'"{page.stem} - ' in said, said)


def check_exit_status(laid):
    """Statuses and meanings are those of the table on what all verbs have alike."""
    with open("docs/reference/common.md", encoding="utf-8") as file:
        text = file.read()
    rows = re.findall(r"^\| ([0-9, ]+) \| (.*) \|$", text, re.MULTILINE)
    check(len(rows) > 4, rows)
    said = " ".join(f"{status} {meaning}" for status, meaning in rows).replace("`", "").replace("\\|", "|")
    behind = re.search(r"^With several files .*$", text, re.MULTILINE)[0]
    for stem, page in laid.items():
        found = one_line(section(page, "EXIT STATUS"))
        check(found == f"{said} {behind}", f"{stem}: exit status: {found}, not {said} {behind}")


def without_parts(page, parts):
    """What a page says before the sections of a verb's parts."""
    starts = [page.index(f"\n{part.upper()}\n") for part in parts]
    return page[:min(starts, default=len(page))]


def check_pages(folder):
    count = 0
    laid = {page.stem: laid_out(page) for page in folder.iterdir() if page.stem not in OWN}
    tried = list(commands())
    check(len(tried) > 35, tried)
    for command in tried:
        page = laid["haptometer-" + command[0]]
        is_part = len(command) > 1
        parts = [" ".join(other) for other in tried if len(other) > 1 and other[0] == command[0]]
        text = section(page, " ".join(command).upper()) if is_part else without_parts(page, parts)
        count += check_options(" ".join(command), command, text, page)
    verbs = {command[0] for command in tried}
    check(set(laid) == {"haptometer", *("haptometer-" + verb for verb in verbs)}, sorted(laid))
    for verb in verbs:
        check(f"haptometer-{verb}(1)" in section(laid["haptometer"], "VERBS"), verb)
    for name in OWN:
        check((folder / f"{name}.1").read_text() == f".so man1/haptometer-{name}.1\n", name)
        check(re.search(rf"^ +{name} \[OPTION\]", laid["haptometer-" + name], re.MULTILINE), f"synopsis of {name}")
    for names in (r"-h, --help\n", r"--version\n"):
        check(re.search("^ +" + names, section(laid["haptometer"], "OPTIONS"), re.MULTILINE), names)
    check("haptometer-acquire(1)" in section(laid["haptometer-session"], "SEE ALSO"), "session names no acquire")
    check_exit_status(laid)
    print(f"{len(tried)} commands, {count} options")


def check_help():
    """`help VERB` shows what --help shows; an unknown word is an error with the nearest one."""
    for words in (["analyze"], ["trial", "info"], ["session"], ["study"]):
        check(run("help", *words).stdout == run(*words, "--help").stdout, f"help {words}")
    check("did you mean analyze?" in run("help", "analyse", status=2).stderr, "help analyse")
    check("did you mean trial info?" in run("help", "trial", "inf", status=2).stderr, "help trial inf")
    for words in (["help"], ["help", "help"]):
        check(run(*words).stdout == run("--help").stdout, words)
    for words, said in ((["analyze", "info"], "info: is not a part of analyze; see haptometer help analyze"),
                        (["study", "nonsense"], "nonsense: is not a part of study"),
                        (["trial", "info", "extra"], "extra: is one word too many; write haptometer help trial info"),
                        (["--json"], "--json: is an option, and help takes a verb"),
                        (["-h"], "-h: is an option"), (["--version"], "--version: is an option")):
        error = run("help", *words, status=2).stderr
        check(said in error and not re.search("did you mean s", error), f"help {words}: {error}")


def main():
    check_help()
    if shutil.which("groff") is None:
        skip("no groff")
    folder = pathlib.Path(sys.argv[1])
    pages = sorted(folder.iterdir())
    check(len(pages) > 15, f"{len(pages)} pages in {folder}")
    for page in pages:
        if page.stem not in OWN:
            check_roff(page)
    check_pages(folder)
    check_as_installed(folder)


if __name__ == "__main__":
    main()
