#!/usr/bin/env python3
"""clang-tidy over the sources that changed, or over all of them with --all.

    tests/repository/tidy.py BUILD_FOLDER [--all]

Changed is what differs from the commit GYROBENCH_TIDY_BASE; where it is not set, from where this branch left
origin/main; and in a clone of main itself, what the last commits changed. Of a changed header its own source is looked
at. A build folder whose rooms are compiled together does as well: each source gets the command of its unit."""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAST_COMMITS = 10
# A source takes some 15 s: more than this would make a test run long. All of them are for the target `tidy`.
MOST_SOURCES = 24


def git(*arguments):
    """Lines; none where git refuses, as of a commit that is not known."""
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True).stdout.splitlines()


def base_commit():
    wanted = os.environ.get("GYROBENCH_TIDY_BASE")
    if wanted:
        if not git("rev-parse", "--verify", "--quiet", wanted + "^{commit}"):
            sys.exit(f"tidy: GYROBENCH_TIDY_BASE names no commit of this repository: {wanted}")
        return wanted
    branched = git("merge-base", "HEAD", "origin/main")
    if branched and branched != git("rev-parse", "HEAD"):
        return branched[0]
    return git("rev-list", "--first-parent", f"--max-count={LAST_COMMITS + 1}", "HEAD")[-1]


def changed_sources(sources):
    """The newest changes first."""
    base = base_commit()
    names = git("diff", "--name-only", "HEAD") + git("log", "--name-only", "--format=", f"{base}..HEAD")
    names = [name[:-2] + ".cc" if name.endswith(".h") else name for name in names]
    return [name for name in dict.fromkeys(names) if name in sources]


def commands(build):
    """Of each source of the repository, its compile command without what is said to the compiler about warnings."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        unit = pathlib.Path(entry["file"])
        inside = [unit]
        if re.fullmatch(r"unity_\d+_cxx\.cxx", unit.name):
            inside = [pathlib.Path(name) for name in re.findall(r'#include "([^"]+)"', unit.read_text())]
        for source in inside:
            if not source.is_relative_to(ROOT) or source.is_relative_to(build):
                continue
            command = re.sub(r"(?<= )-W\S+ ?", "", entry["command"]).replace(str(unit), str(source))
            name = str(source.relative_to(ROOT))
            found[name] = {"directory": entry["directory"], "command": command, "file": str(source)}
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="a configured and built folder")
    parser.add_argument("--all", action="store_true", help="every source, not only what changed")
    options = parser.parse_args()
    build = options.build.resolve()
    if shutil.which("clang-tidy") is None:
        print("skipped: clang-tidy is not installed")
        return 77
    if not (build / "compile_commands.json").is_file():
        print(f"tidy: {options.build} has no compile_commands.json: configure it first (cmake --preset dev)")
        return 1
    if not options.all and not (ROOT / ".git").exists():
        print("skipped: not a clone")
        return 77
    known = commands(build)
    wanted = sorted(known) if options.all else changed_sources(known)
    left_out = [] if options.all else wanted[MOST_SOURCES:]
    wanted = wanted if options.all else wanted[:MOST_SOURCES]
    if not wanted:
        print("tidy: no source has changed")
        return 0
    with tempfile.TemporaryDirectory(prefix="gyrobench-tidy-") as folder:
        (pathlib.Path(folder) / "compile_commands.json").write_text(json.dumps(list(known.values())))

        def look_at(name):
            return name, subprocess.run(["clang-tidy", "--quiet", "-p", folder, str(ROOT / name)], cwd=ROOT,
                                        capture_output=True, text=True)

        faults = 0
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for name, done in pool.map(look_at, wanted):
                if done.returncode == 0:
                    continue
                faults += 1
                print(f"{name}\n{done.stdout.strip() or done.stderr.strip()}\n", flush=True)
    print(f"tidy: {len(wanted)} sources, {faults} with findings" if faults else
          f"tidy: {len(wanted)} sources, nothing found")
    if left_out:
        print(f"tidy: {len(left_out)} more have changed; the target `tidy` looks at all sources")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
