"""How fast the explorer's own JavaScript solves: posing, nested iteration, cycles and certificate, by node.

    python benchmarks/explorer.py [--loads 40] [--scenes hexagon 129]

Prints for each scene of the page the least and the median time of a solve to a certified bound of 1e-9 of the largest
deflection, over loads from a tenth to 95 % of the slider's end, after as many solves that let node compile.
"""

from __future__ import annotations

import argparse
import json
import subprocess

from contactqp.explorer.presets import presets
from contactqp.explorer.scripts import NUMERICS, script

HARNESS = """
const { records, loads } = JSON.parse(require("fs").readFileSync(0, "utf8"));
for (const record of records) {
  const scene = unpackScene(record), support = [...scene.supports.keys()][0], { load, tension } = record, found = [];
  for (let k = 0; k < 2 * loads; k++) {
    const share = 0.1 + (0.85 * (k % loads)) / loads, begun = performance.now();
    const wish = { support, load: load.least + share * (load.most - load.least), tension: tension.value };
    const problem = problemOf(scene, { ...wish, lift: 0, relief: 1 });
    const answer = solveContact(problem, parabolaBarrier(problem.lattice), 1e-9);
    if (!answer.certified) throw new Error(`${scene.name} at ${wish.load}: not certified`);
    if (k >= loads) found.push(performance.now() - begun);
  }
  found.sort((a, b) => a - b);
  const [least, median] = [found[0], found[loads >> 1]].map((time) => time.toFixed(1).padStart(7));
  console.log(`${scene.name.padEnd(30)} ${String(scene.lattice.nodes.length).padStart(6)} ${least} ${median}`);
}
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--loads", type=int, default=40)
    parser.add_argument("--scenes", nargs="*", default=[""], help="parts of names")
    arguments = parser.parse_args()
    chosen = [scene for scene in presets() if any(part in scene.name for part in arguments.scenes)]
    print(f"{'scene':30} {'nodes':>6} {'least':>7} {'median':>7}  (ms)", flush=True)
    told = json.dumps({"records": [scene.record() for scene in chosen], "loads": arguments.loads})
    code = f'"use strict";\n{script(*NUMERICS, "scene")}\n{HARNESS}'
    subprocess.run(["node", "-e", code], input=told, text=True, check=True)


if __name__ == "__main__":
    main()
