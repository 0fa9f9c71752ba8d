#!/usr/bin/env python3
"""Which sources can be read as one: no name that one keeps to itself means something else to another.

    source_groups.py FILE...   prints each file with the number of its group

Headers cost a compiler more than the files that read them, and a group walks them once: the sanitizers'
build compiles groups (cmake/Targets.cmake), and tidy reads them (tidy-groups). Run from the tree's root.
"""
import functools
import os
import re
import sys

LARGEST_GROUP = 16  # of what is compiled: two are in memory at once
# A name that nothing qualifies, so that another file's name of that kind would be found instead.
BARE_NAME = re.compile(r"(?<![\w:.>])[A-Za-z_]\w*")
# What a file keeps to itself: its unnamed namespaces (whose lines are not indented), its macros, its
# test cases, and the function that a program has once.
UNNAMED = re.compile(r"^namespace \{$(.*?)^\}  // namespace$", re.MULTILINE | re.DOTALL)
KEPT = re.compile(r"^(?![\s/}#]|TEST|namespace |using [\w:]+;|static_assert|[A-Z_]+\()"
                  r"[^(={;\[]*?[\s*&](\w+) ?[(={;\[]", re.MULTILINE)
KEPT_TYPE = re.compile(r"^(?:template .*)?(?:struct|(?:enum )?class) (\w+)", re.MULTILINE)
KEPT_ELSEWHERE = re.compile(r"^#define (\w+)|^\w.* (main|LLVMFuzzerTestOneInput)\(", re.MULTILINE)
TEST_CASE = re.compile(r"^TEST\w*\((\w+),\s*(\w+)\)", re.MULTILINE)
USING = re.compile(r"^ *using ([\w:]*::(\w+));$", re.MULTILINE)
INCLUDE = re.compile(r"^#include .*$", re.MULTILINE)
QUOTED = re.compile(r'^#include "(.*)"', re.MULTILINE)


@functools.cache
def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


@functools.cache
def headers(path):
    """The tree's own headers that a file reads, at any depth."""
    found = set()
    for name in QUOTED.findall(read(path)):
        header = os.path.abspath(name)  # all but the consumer's are named from the tree's root
        found |= {header} | headers(header)
    return frozenset(found)


@functools.cache
def declared(path):
    """What a header declares in its namespaces, whose lines are not indented."""
    text = read(path)
    return frozenset(KEPT.findall(text) + KEPT_TYPE.findall(text))


@functools.cache
def words(path):
    return frozenset(BARE_NAME.findall(read(path)))


class Source:
    def __init__(self, path, can_rename=False):
        text = read(path)
        self.path = path
        self.headers = headers(path)
        self.kept = {name for part in UNNAMED.findall(text)
                     for name in KEPT.findall(part) + KEPT_TYPE.findall(part)}
        self.kept |= {name for names in KEPT_ELSEWHERE.findall(text) for name in names if name}
        self.renamed = self.renamable(text) if can_rename else frozenset()
        self.kept -= self.renamed
        self.kept |= {f"{suite}_{case}" for suite, case in TEST_CASE.findall(text)}
        self.own = {name: path for name in self.kept}
        self.own |= {name: of for of, name in USING.findall(text)}
        # rooms' headers agree with each other; tests' belong to programs of their own
        for header in self.headers:
            if os.path.relpath(header).startswith("tests/"):
                self.own |= {name: header for name in declared(header)}
        self.names = set(BARE_NAME.findall(text)) | set(self.own)

    def renamable(self, text):
        """What the file keeps and never qualifies, and no header of it says, too."""
        said = frozenset().union(*map(words, self.headers))
        return frozenset(name for name in self.kept - said
                         if not re.search(rf"(?:\.|->|::){name}\b", text))

    def text(self, number):
        """The file's, what is renamable numbered."""
        return BARE_NAME.sub(lambda found: f"{found[0]}_{number}" if found[0] in self.renamed
                             else found[0], read(self.path))

    def hides_from(self, other):
        return (any(name in other.names and other.own.get(name) != meaning
                    for name, meaning in self.own.items())
                or any(not declared(header).isdisjoint(self.own)
                       for header in other.headers - self.headers))

    def agrees_with(self, other):
        return not self.hides_from(other) and not other.hides_from(self)


def grouped(files, largest=LARGEST_GROUP, can_rename=False):
    """Groups of sources out of pairs of a path and its kind; each group is of one kind. A caller that can
    rename what a file keeps to itself takes a member's text(number) for the file's."""
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
