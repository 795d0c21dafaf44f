"""Reports as pages: well-formed, whole without a network, no script, ids that do not collide.

Usage: pages_test.py REPORT_SAMPLES
"""
import collections
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree


def check_references(root):
    ids = collections.Counter(e.get("id") for e in root.iter() if e.get("id"))
    for name, count in ids.items():
        if count > 1:
            yield f"id {name} is given {count} times"
    for element in root.iter():
        for key, value in element.attrib.items():
            targets = [value] if key == "href" else re.findall(r"url\(([^)]*)\)", value)
            for target in targets:
                if not target.startswith("#") or target[1:] not in ids:
                    yield f"{key}={value} leads out of the page or nowhere"
            if key == "src" or key.startswith("on"):
                yield f"attribute {key}={value}"


def check_charts(root):
    for svg in root.iter("svg"):
        if not svg.get("viewBox") or svg.get("width") or svg.get("height"):
            yield "a chart that does not scale"
        if not svg.get("aria-label"):
            yield "a chart without words"
        texts = " ".join("".join(t.itertext()) for t in svg.iter("text"))
        if texts.count("[") + texts.count("…") < 2:
            yield f"a chart with an axis that has no unit: {texts}"


def check_tables(root):
    parents = {child: parent for parent in root.iter() for child in parent}
    for table in root.iter("table"):
        if parents[table].get("class") != "table":
            yield "a table that cannot scroll within the page"


def check_page(path):
    text = path.read_text(encoding="utf-8")
    root = ElementTree.fromstring(text)
    for element in root.iter():
        if element.tag in ("script", "link", "img", "iframe", "object", "base", "form", "a"):
            yield f"element <{element.tag}>"
    if re.search(r"https?:|@import", text):
        yield "refers to the network"
    yield from check_references(root)
    yield from check_charts(root)
    yield from check_tables(root)


def main():
    problems = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], folder], check=True, cwd=folder)
        pages = sorted(pathlib.Path(folder).glob("*.html"))
        for page in pages:
            problems += [f"{page.name}: {problem}" for problem in check_page(page)]
        for name, expected in (("explained", 7), ("bias", 1)):
            text = (pathlib.Path(folder) / f"{name}.html").read_text(encoding="utf-8")
            charts = text.count("<svg")
            if charts != expected:
                problems.append(f"{name}.html: {charts} charts, {expected} expected; is gnuplot "
                                "installed?")
    print("\n".join(problems) or f"pages: {len(pages)} reports are whole")
    sys.exit(bool(problems))


main()
