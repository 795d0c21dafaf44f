"""Every ```sh block of the user's pages is run, in order, on a bench of its own.

Blocks that set up, build or test the tree itself (scripts/, cmake, ctest) are what runs this test.
"""
import os
import pathlib
import re
import subprocess
import unittest

from bench import BIN, DEADLINE_S, ROOT, Bench

PAGES = ["README.md", "docs/subscribe.md", "docs/control-api.md", "docs/trace.md", "docs/calibration.md",
         "docs/hold.md", "docs/configuration.md"]
NEED_A_RUN = {"docs/trace.md", "docs/calibration.md"}  # they show what one does after it
BUILDS = re.compile(r"^(scripts/|cmake |ctest |git )", re.M)


def blocks(page):
    path = ROOT / page
    text = path.read_text()
    return [block for block in re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S)
            if not BUILDS.search(block)]


class Documents(unittest.TestCase):
    def run_block(self, bench, page, block):
        # Where a page names the places of an installation, the test's own are used.
        block = block.replace("/run/gyrobench/control.sock", f"{bench.folder}/control.sock")
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", block], cwd=bench.folder, capture_output=True, text=True,
            stdin=subprocess.DEVNULL, timeout=DEADLINE_S,
            env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", "NO_COLOR": "1",
                 "GYROBENCH_CONFIG": str(bench.config), "PYTHONPATH": str(BIN.parent / "python")})
        self.assertEqual(done.returncode, 0, f"{page}:\n{block}\n{done.stdout}{done.stderr}")

    def test_there_is_something_to_run(self):
        self.assertTrue(all(blocks(page) for page in ("README.md", "docs/control-api.md")))

    def test_what_the_pages_show_works(self):
        for page in PAGES:
            with Bench() as bench:
                for name in ("config", "docs", "build", "procedures"):
                    if (ROOT / name).exists():
                        pathlib.Path(bench.folder / name).symlink_to(ROOT / name)
                if page in NEED_A_RUN:
                    bench.json("run", "scale", "-p", "turns=4", "-p", "initial_rest_s=10")
                for block in blocks(page):
                    with self.subTest(page=page, block=block):
                        self.run_block(bench, page, block)


if __name__ == "__main__":
    unittest.main()
