"""The Debian packages, from the tree to a root in which nothing is left: packages.py [--built] [--checked]

Builds them (--built: takes those in build/packages; --checked: runs the tests of the tree on the way), and then:
lintian finds no error and no warning; in a clean root made by mmdebstrap, piuparts installs, removes and purges them,
and autopkgtest runs packaging/debian/tests. Where that root cannot be made, the packages are unpacked into a folder,
and only the main job is run, from the files there. Needs root, and the network for the clean root.
"""
import argparse
import glob
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = ROOT / "build/packages"
CLEAN = PACKAGES / "root"
NAMES = ["haptometer", "haptometer-doc", "libhaptometer-dev", "python3-haptometer"]
RELEASE = "bookworm"


def run(what, *words, log=None, **options):
    """Runs a command with its output in a log; what it takes is printed."""
    log = log or PACKAGES / f"{what.replace(', ', '-').replace(' ', '-')}.log"
    begin = time.monotonic()
    with open(log, "w") as file:
        status = subprocess.run([str(word) for word in words], stdout=file, stderr=subprocess.STDOUT, cwd=ROOT,
                                **options).returncode
    took = f"{time.monotonic() - begin:6.0f} s"
    print(f"{what:<28}{'done' if status == 0 else 'FAILED':<8}{took}   {log.relative_to(ROOT)}", flush=True)
    return status == 0


def build(checked):
    (ROOT / "build").mkdir(exist_ok=True)
    # the script empties the folder of the other logs
    return run("build", "tools/build-packages", log=ROOT / "build/packages.log",
               env=os.environ | {"DEB_BUILD_OPTIONS": "" if checked else "nocheck"})


def packages():
    """The files of the packages whose debugging symbols are apart."""
    found = [path for name in NAMES for path in glob.glob(f"{PACKAGES}/{name}_*.deb")]
    if len(found) != len(NAMES):
        sys.exit(f"packages are missing: {found}")
    return found


def examined():
    changes, = glob.glob(f"{PACKAGES}/*.changes")
    return run("lintian", "lintian", "--allow-root", "--fail-on", "error,warning", changes)


def has_clean_root():
    shutil.rmtree(CLEAN, ignore_errors=True)
    # systemd, which every machine has and the packages need, leaves files of its own when it is purged
    return os.getuid() == 0 and shutil.which("mmdebstrap") and run(
        "clean root", "mmdebstrap", "--variant=minbase", "--include=systemd", RELEASE, CLEAN)


def in_clean_root():
    source = PACKAGES / "installed-tests"
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(ROOT / "packaging/debian", source / "debian")
    shutil.copytree(ROOT / "tests/package/consumer", source / "tests/package/consumer")
    gone = run("install, remove, purge", "piuparts", "--existing-chroot", CLEAN, "--distribution", RELEASE,
               "--keep-sources-list", "--no-eatmydata", "--no-upgrade-test", *packages())
    # terminals for the emulator; the mounts end with the process
    mounted = (f'mount -t proc proc "{CLEAN}/proc" && '
               f'mount -t devpts -o newinstance,ptmxmode=0666 pts "{CLEAN}/dev/pts" && '
               f'mount --bind "{CLEAN}/dev/pts/ptmx" "{CLEAN}/dev/ptmx" && exec "$@"')
    used = run("tests of the installed", "unshare", "--mount", "sh", "-c", mounted, "sh",
               "autopkgtest", "-U", "-B", *packages(), f"{source}/", "--", "chroot", CLEAN)
    return gone and used


def unpacked():
    print("no clean root could be made: the packages are unpacked, not installed, and only the main job is run")
    shutil.rmtree(CLEAN, ignore_errors=True)
    for package in packages():
        subprocess.run(["dpkg-deb", "-x", package, CLEAN], check=True)
    return run("main job", "packaging/debian/tests/main-job", env=os.environ | {"INSTALLED_ROOT": str(CLEAN)})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--built", action="store_true")
    parser.add_argument("--checked", action="store_true")
    given = parser.parse_args()
    if not given.built and not build(given.checked):
        sys.exit(1)
    passed = [examined(), in_clean_root() if has_clean_root() else unpacked()]
    for package in packages():
        print(f"{os.path.basename(package):<48}{os.path.getsize(package) / 1e6:8.1f} MB")
    sys.exit(0 if all(passed) else 1)


if __name__ == "__main__":
    main()
