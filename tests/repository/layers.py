"""A room includes only what cmake/layers.txt lets it use, rooms form no cycle, and the picture of them is true."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def read_layers():
    layers = {}
    for line in (ROOT / "cmake/layers.txt").read_text().splitlines():
        if match := re.match(r"([a-z_/]+):(.*)", line):
            layers[match[1]] = match[2].split()
    return layers


def room_of(path, layers):
    """The innermost room that a file, or what an #include names, is in; None where there is no such room."""
    folders = path.split("/")[:-1]
    return next((room for n in range(len(folders), 0, -1) if (room := "/".join(folders[:n])) in layers), None)


def may_use(used, room, allowed):
    """A room uses itself, what its line allows, and all of a room that is allowed as a whole."""
    return used == room or used in allowed or any(used.startswith(whole + "/") for whole in allowed)


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


def picture_problems(layers):
    """Arrows of docs/architecture.md against the table; `base`, which every room may use, is not drawn."""
    drawn = set(re.findall(r"^  ([a-z]+) --> ([a-z]+)$", (ROOT / "docs/architecture.md").read_text(), re.M))
    allowed = {(room, used) for room, line in layers.items() if "/" not in room
               for used in line if "/" not in used and used != "base"}
    return ([f"docs/architecture.md: no arrow from {a} to {b}, which cmake/layers.txt allows"
             for a, b in sorted(allowed - drawn)] +
            [f"docs/architecture.md: an arrow from {a} to {b}, which cmake/layers.txt does not allow"
             for a, b in sorted(drawn - allowed)])


def main():
    layers = read_layers()
    problems = picture_problems(layers)
    if cycle := find_cycle(layers):
        problems.append("cmake/layers.txt: a cycle: " + " -> ".join(cycle))
    files = 0
    for outer in [room for room in layers if "/" not in room]:
        for path in sorted((ROOT / outer).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            files += 1
            room = room_of(str(path.relative_to(ROOT)), layers)
            allowed = layers[room]
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = re.match(r'#include "([a-z_]+/[^"]*)"', line)
                used = room_of(re.sub("^gyrobench/", "msgs/", match[1]), layers) if match else None
                if used and not may_use(used, room, allowed):
                    problems.append(f"{path.relative_to(ROOT)}:{number}: room '{room}' may not use room "
                                    f"'{used}' (cmake/layers.txt allows: {' '.join(allowed) or 'none'})")
    print("\n".join(problems) or f"layers: {files} files keep to cmake/layers.txt")
    return 1 if problems or files == 0 else 0


sys.exit(main())
