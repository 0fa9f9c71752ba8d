#!/usr/bin/env python3
"""Groups sources that a compiler can read as one text: no name that is private to one file of a group
means something else in another.

    source_groups.py FILE...   prints a line per file: the number of its group, and the file

Headers cost a compiler more than the files that include them, and a group reads them once.
cmake/Targets.cmake compiles such groups, tidy-groups hands them to clang-tidy. Run it from the tree's root.
"""
import functools
import os
import re
import sys

LARGEST_GROUP = 16  # limits memory: two groups are compiled at once
# A name without qualification: as one text, it could find another file's name instead.
BARE_NAME = re.compile(r"(?<![\w:.>])[A-Za-z_]\w*")
# What is private to a file: its unnamed namespaces, its macros, its entry point, its test cases. Lines
# inside namespaces are not indented, so a declaration begins in the first column.
UNNAMED = re.compile(r"^namespace \{$(.*?)^\}  // namespace$", re.MULTILINE | re.DOTALL)
DECLARED = re.compile(r"^(?![\s/}#]|namespace |using [\w:]+;|static_assert|[A-Z_]+\()"
                      r"[^(={;\[]*?[\s*&](\w+) ?[(={;\[]", re.MULTILINE)
DECLARED_TYPE = re.compile(r"^(?:template .*)?(?:struct|(?:enum )?class) (\w+)(?= final|<| ?[:{;])", re.MULTILINE)
MACRO_OR_ENTRY = re.compile(r"^#define (\w+)|^\w.* (main|LLVMFuzzer\w+)\(", re.MULTILINE)
TEST_CASE = re.compile(r"^TEST\w*\((\w+),\s*(\w+)\)", re.MULTILINE)
USING_ENUM = re.compile(r"^using enum ([\w:]+);$", re.MULTILINE)
USING = re.compile(r"^ *using ([\w:]*::(\w+));$", re.MULTILINE)
INCLUDE = re.compile(r"^#include .*$", re.MULTILINE)
QUOTED = re.compile(r'^#include "(.*)"', re.MULTILINE)


@functools.cache
def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


@functools.cache
def headers(path):
    """The tree's own headers that a file includes, at any depth."""
    found = set()
    for name in QUOTED.findall(read(path)):
        header = os.path.abspath(name)  # includes name them from the tree's root
        found |= {header} | headers(header)
    return frozenset(found)


def declared_in(text):
    """The names that lines in the first column declare."""
    return frozenset(DECLARED.findall(text) + DECLARED_TYPE.findall(text))


@functools.cache
def declared(path):
    return declared_in(read(path))


@functools.cache
def bare_names(path):
    return frozenset(BARE_NAME.findall(read(path)))


class Source:
    def __init__(self, path, can_rename=False):
        text = read(path)
        self.path = path
        self.headers = headers(path)
        private = {name for part in UNNAMED.findall(text) for name in declared_in(part)}
        private |= {name for names in MACRO_OR_ENTRY.findall(text) for name in names if name}
        self.renamed = self.renamable(private, text) if can_rename else frozenset()
        private -= self.renamed
        private |= {f"{suite}_{case}" for suite, case in TEST_CASE.findall(text)}
        # each name that means something of its own here, with what tells this meaning from another
        self.meanings = {name: path for name in private}
        self.meanings |= {name: target for target, name in USING.findall(text)}
        # enumerators of two enums may clash, so that files agree only on the same one
        self.meanings |= {"using enum": target for target in USING_ENUM.findall(text)}
        # the rooms' headers agree with each other; headers of tests are written for one program each
        for header in self.headers:
            if os.path.relpath(header).startswith("tests/"):
                self.meanings |= {name: header for name in declared(header)}
        self.names = bare_names(path) | set(self.meanings)

    def renamable(self, private, text):
        """The private names that the file never qualifies and none of its headers uses. Only main() may end
        without a return, and GoogleTest looks for PrintTo(): these keep their names."""
        used = frozenset({"main", "PrintTo"}).union(*map(bare_names, self.headers))
        return frozenset(name for name in private - used
                         if not re.search(rf"(?:\.|->|::){name}\b", text))

    def text(self, number):
        """The file's text, with `number` appended to each renamed name."""
        return BARE_NAME.sub(lambda found: f"{found[0]}_{number}" if found[0] in self.renamed
                             else found[0], read(self.path))

    def hides_from(self, other):
        """Whether a name of this file would mean something else in the other file or in its headers."""
        return (any(name in other.names and other.meanings.get(name) != meaning
                    for name, meaning in self.meanings.items())
                or any(not declared(header).isdisjoint(self.meanings)
                       for header in other.headers - self.headers))

    def agrees_with(self, other):
        return not self.hides_from(other) and not other.hides_from(self)


def grouped(files, largest=LARGEST_GROUP, can_rename=False):
    """Groups, each a pair of a kind and its sources, out of pairs of a path and its kind. With
    `can_rename` private names may clash: the caller takes each member's text(number) for its file."""
    groups = []
    for path, kind in files:
        source = Source(path, can_rename)
        for group_kind, members in groups:
            if (group_kind == kind and len(members) < largest
                    and all(source.agrees_with(member) for member in members)):
                members.append(source)
                break
        else:
            groups.append((kind, [source]))
    return groups


def main():
    for number, (_, members) in enumerate(grouped((path, None) for path in sys.argv[1:])):
        for member in members:
            print(number, member.path)


if __name__ == "__main__":
    main()
