"""A room includes only what cmake/layers.txt lets it use, and rooms form no cycle."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def read_layers():
    layers = {}
    for line in (ROOT / "cmake/layers.txt").read_text().splitlines():
        if match := re.match(r"([a-z_]+):(.*)", line):
            layers[match[1]] = match[2].split()
    return layers


def find_cycle(layers):
    done = set()

    def visit(room, path):
        if room in path:
            return path[path.index(room):] + [room]
        if room in done:
            return None
        for used in layers.get(room, []):
            if cycle := visit(used, path + [room]):
                return cycle
        done.add(room)
        return None

    return next((cycle for room in layers if (cycle := visit(room, []))), None)


def main():
    layers = read_layers()
    problems = []
    if cycle := find_cycle(layers):
        problems.append("cmake/layers.txt: a cycle: " + " -> ".join(cycle))
    files = 0
    for room, allowed in layers.items():
        for path in sorted((ROOT / room).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            files += 1
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = re.match(r'#include "([a-z_]+)/', line)
                used = "msgs" if match and match[1] == "gyrobench" else match and match[1]
                if used and used in layers and used != room and used not in allowed:
                    problems.append(f"{path.relative_to(ROOT)}:{number}: room '{room}' may not use room "
                                    f"'{used}' (cmake/layers.txt allows: {' '.join(allowed) or 'none'})")
    print("\n".join(problems) or f"layers: {files} files keep to cmake/layers.txt")
    return 1 if problems or files == 0 else 0


sys.exit(main())
