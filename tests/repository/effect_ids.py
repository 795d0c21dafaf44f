#!/usr/bin/env python3
"""An effect is one file: no other file of the product asks for an effect by its id.

The ids are those that the files of calibration/effects/catalogue/ give. Exit status 1 with file and line of each other
place that has one as a string."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CATALOGUE = ROOT / "calibration" / "effects" / "catalogue"
ROOMS = ["calibration", "cli", "daemon", "export", "presentation", "procedures"]
STRING = re.compile(r"\"((?:[^\"\\\\]|\\\\.)*)\"|'((?:[^'\\\\]|\\\\.)*)'")
ID = re.compile(r"(?:bias|scale|angle|bandwidth|time)\.[a-z_0-9]+")


def literals(path):
    """Ids within strings; in examples of the command line they may stand."""
    comment = "--" if path.suffix == ".lua" else "//"
    for number, line in enumerate(path.read_text().splitlines(), 1):
        for match in STRING.finditer(line.split(comment)[0]):
            text = match[1] or match[2] or ""
            if line.startswith("#include") or text.startswith("gyrobench "):
                continue
            # A script's help may speak of an effect.
            found = ID.findall(text) if path.suffix != ".lua" else ID.findall(text) if ID.fullmatch(text) else []
            yield from ((number, name) for name in found)


def is_asked_for(found, ids):
    return any(name.startswith(found) for name in ids)


def main():
    ids = {name for path in CATALOGUE.glob("*.cc") for _, name in literals(path)}
    if len(ids) < 20:
        sys.exit(f"{CATALOGUE}: {len(ids)} ids found, expected the whole catalogue")
    files = [path for room in ROOMS for end in ("*.h", "*.cc", "*.lua") for path in (ROOT / room).rglob(end)]
    others = [f"{path.relative_to(ROOT)}:{number}: asks for \"{name}\"; say what the effect is like in its own file "
              f"under {CATALOGUE.relative_to(ROOT)}, and ask for that"
              for path in sorted(files) if CATALOGUE not in path.parents
              for number, name in literals(path) if is_asked_for(name, ids)]
    print("\n".join(others) if others else f"{len(ids)} effects, each spoken of by its own file alone")
    sys.exit(1 if others else 0)


if __name__ == "__main__":
    main()
