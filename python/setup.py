"""The wheel: the package as the build makes it, in build/release or in the folder that HAPTOMETER_BUILD names.

HAPTOMETER_ROOT is the folder of the sources, where this file is a copy elsewhere.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

ROOT = pathlib.Path(os.environ.get("HAPTOMETER_ROOT", pathlib.Path(__file__).resolve().parents[1]))
BUILD = pathlib.Path(os.environ.get("HAPTOMETER_BUILD", ROOT / "build/release")).absolute()
VERSION = re.search(r"project\(haptometer VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]


class BuildPackage(build_py):
    def run(self):
        if not (BUILD / "build.ninja").exists():
            subprocess.run(["cmake", "--preset", "release", "-B", BUILD, f"-DPython3_EXECUTABLE={sys.executable}"],
                           cwd=ROOT, check=True)
        subprocess.run(["cmake", "--build", BUILD, "--target", "haptometer_python"], check=True)
        shutil.copytree(BUILD / "python/haptometer", pathlib.Path(self.build_lib) / "haptometer", dirs_exist_ok=True,
                        ignore=shutil.ignore_patterns("__pycache__"))


class BinaryDistribution(Distribution):
    def has_ext_modules(self):
        return True


setup(version=VERSION, packages=["haptometer"], cmdclass={"build_py": BuildPackage}, distclass=BinaryDistribution)
