"""Doxygen reads the public headers without a warning, and does warn of a mistake: reference_test.py DOXYFILE"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from programs import check, skip

LEAST_HEADERS = 200  # there are 212


def doxygen(settings, folder):
    """Its exit status and its warnings, its pages being written to a folder."""
    done = subprocess.run(["doxygen", "-"], input=f'{settings}\nOUTPUT_DIRECTORY = "{folder}"\n',
                          capture_output=True, text=True)
    return done.returncode, done.stderr


def main(path):
    if shutil.which("doxygen") is None:
        skip("no doxygen")
    with open(path) as file:
        settings = file.read()
    headers = re.findall(r'"(\S+\.h)"', settings)
    check(len(headers) >= LEAST_HEADERS, f"{len(headers)} headers")
    with tempfile.TemporaryDirectory() as folder:
        status, warnings = doxygen(settings, folder)
        check(status == 0 and not warnings, warnings)
        pages = sum(name.endswith(".html") for name in os.listdir(os.path.join(folder, "reference")))
        check(pages > len(headers), f"{pages} pages")

        wrong = os.path.join(folder, "wrong.h")
        with open(wrong, "w") as file:
            file.write("/// @param absent is no parameter\nint Answer(int given);\n")
        status, warnings = doxygen(f'{settings}\nINPUT = "{wrong}"', folder)
        check(status != 0 and "absent" in warnings, f"a mistake remains unseen: {status}, {warnings}")
    print(len(headers), "headers,", pages, "pages")


if __name__ == "__main__":
    main(sys.argv[1])
