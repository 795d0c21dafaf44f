#!/usr/bin/env python3
"""clang-tidy over the sources that changed, or over all of them with --all.

    tests/repository/tidy.py BUILD_FOLDER [--all] [--jobs N]

Changed is what differs from the commit GYROBENCH_TIDY_BASE; where it is not set, from where this branch left
origin/main; and in a clone of main itself, what the last commits changed; and what was never added. Of a changed header
its own source is looked at, or else one that includes it; a header that no source includes is a fault. Of a source that
this build does not compile, as a benchmark, nothing is known: that is said, and the test is skipped. A shallow clone without the commits that are asked for knows
of no change that was committed: that is said, and the test is skipped. A build folder whose rooms are compiled together
does as well: each source gets the command of its unit."""
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
# Its headers are of C sources, which avr-gcc and the host's compiler look at with their warnings as errors.
IN_C = "firmware/"
# A source takes some 15 s: more than this would make a test run long. All of them are for the target `tidy`.
MOST_SOURCES = 10


def git(*arguments):
    """Lines; none where git refuses, as of a commit that is not known."""
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True).stdout.splitlines()


def base_commit():
    """None in a shallow clone that ends before it."""
    wanted = os.environ.get("GYROBENCH_TIDY_BASE")
    if wanted:
        if not git("rev-parse", "--verify", "--quiet", wanted + "^{commit}"):
            sys.exit(f"tidy: GYROBENCH_TIDY_BASE names no commit of this repository: {wanted}")
        return wanted
    branched = git("merge-base", "HEAD", "origin/main")
    if branched and branched != git("rev-parse", "HEAD"):
        return branched[0]
    last = git("rev-list", "--first-parent", f"--max-count={LAST_COMMITS + 1}", "HEAD")
    # A shallow clone shows its first commit as if that had added every file.
    if len(last) <= LAST_COMMITS and git("rev-parse", "--is-shallow-repository") == ["true"]:
        return None
    return last[-1]


def changed_names(base):
    """The newest changes first."""
    names = git("ls-files", "--others", "--exclude-standard") + git("diff", "--name-only", "HEAD")
    if base:
        # --cc: also what a merge changed by itself; the difference: also what it took from one side alone.
        names += git("log", "--cc", "--name-only", "--format=", f"{base}..HEAD")
        names += git("diff", "--name-only", base, "HEAD")
    return list(dict.fromkeys(names))


def includes_of(sources):
    """Of each header, the files that include it: sources first."""
    found = {}
    names = sorted(sources) + git("ls-files", "--cached", "--others", "--exclude-standard", "*.h")
    for name in names:
        if (ROOT / name).is_file():
            for header in re.findall(r'^#include "([^"]+)"', (ROOT / name).read_text(encoding="utf-8"), re.M):
                found.setdefault(header, []).append(name)
    return found


def source_that_shows(header, sources, includers):
    """Its own source; else one that includes it, by way of as few headers as can be; None where no source does."""
    own = header[:-2] + ".cc"
    if own in sources:
        return own
    level, seen = [header], {header}
    while level:
        level = [name for one in level for name in includers.get(one, []) if name not in seen]
        seen.update(level)
        for name in level:
            if name in sources:
                return name
    return None


def sources_to_look_at(names, sources):
    """And those of the names that no source of the build shows: headers that no source at all includes, and the rest."""
    every = set(git("ls-files", "--cached", "--others", "--exclude-standard", "*.cc")) | set(sources)
    includers, wanted, unused, not_built = includes_of(every), [], [], []
    for name in names:
        if not name.endswith((".h", ".cc")) or name.startswith(IN_C) or not (ROOT / name).is_file():
            continue
        source = source_that_shows(name, sources, includers) if name.endswith(".h") else name
        if source in sources:
            wanted.append(source)
        elif name.endswith(".h") and source_that_shows(name, every, includers) is None:
            unused.append(name)
        else:
            not_built.append(name)
    return list(dict.fromkeys(wanted)), unused, not_built


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
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="sources at once; all cores unless given")
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
    wanted, left_out, unused, not_built, no_history = sorted(known), [], [], [], False
    if not options.all:
        base = base_commit()
        no_history = base is None
        wanted, unused, not_built = sources_to_look_at(changed_names(base), known)
        wanted, left_out = wanted[:MOST_SOURCES], wanted[MOST_SOURCES:]
        if unused:
            print(f"tidy: no source includes {', '.join(unused)}, so that nobody looks at it: include or remove it")
        if not_built:
            print(f"skipped: {options.build} compiles no source that shows {', '.join(not_built)}: configure it with what "
                  "they belong to (-DGYROBENCH_BENCHMARKS=ON ...)")
    if no_history:
        print("skipped: a shallow clone without the commits since which sources changed: `git fetch --unshallow`, or "
              "name one that is here, GYROBENCH_TIDY_BASE=COMMIT" +
              (". What is not committed is looked at all the same" if wanted else ""))
    without_fault = 77 if no_history or not_built else 0
    if not wanted:
        if not (no_history or not_built or unused):
            print("tidy: no source has changed")
        return 1 if unused else without_fault
    with tempfile.TemporaryDirectory(prefix="gyrobench-tidy-") as folder:
        (pathlib.Path(folder) / "compile_commands.json").write_text(json.dumps(list(known.values())))

        def look_at(name):
            return name, subprocess.run(["clang-tidy", "--quiet", "-p", folder, str(ROOT / name)], cwd=ROOT,
                                        capture_output=True, text=True)

        faults = 0
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for name, done in pool.map(look_at, wanted):
                if done.returncode == 0:
                    continue
                faults += 1
                print(f"{name}\n{done.stdout.strip() or done.stderr.strip()}\n", flush=True)
    print(f"tidy: {len(wanted)} sources, {faults} with findings" if faults else
          f"tidy: {len(wanted)} sources, nothing found")
    if left_out:
        print(f"tidy: {len(left_out)} more have changed; the target `tidy` looks at all sources")
    return 1 if faults or unused else without_fault


if __name__ == "__main__":
    sys.exit(main())
