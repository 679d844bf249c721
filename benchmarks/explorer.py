"""How fast the explorer's own JavaScript solves: posing, nested iteration, cycles and certificate, by node.

    contactqp bench run benchmarks/explorer.py

The time of a line is that of a run of node, with all its solves; what counts are the least and the median milliseconds
of a solve to a certified bound of 1e-9 of the largest deflection, over loads from a tenth to 95 % of the slider's end,
after as many solves that let node compile.
"""

from __future__ import annotations

import json
import subprocess
from typing import Any

from contactqp.benchmark import Phase, Spec
from contactqp.explorer.presets import presets
from contactqp.explorer.scenes import Scene
from contactqp.explorer.scripts import NUMERICS, script

LOADS = 40

HARNESS = """
const { record, loads } = JSON.parse(require("fs").readFileSync(0, "utf8"));
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
const nodes = scene.lattice.nodes.length;
console.log(JSON.stringify({ nodes, "least ms": found[0], "median ms": found[loads >> 1] }));
"""


def scene(part: str) -> Scene:
    return next(scene for scene in presets() if part in scene.name)


def by_node(case: Scene) -> dict[str, Any]:
    told = json.dumps({"record": case.record(), "loads": LOADS})
    code = f'"use strict";\n{script(*NUMERICS, "scene")}\n{HARNESS}'
    done = subprocess.run(["node", "-e", code], input=told, text=True, check=True, capture_output=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


SPECS = (
    Spec(
        "explorer",
        "solves of the explorer's scenes by its JavaScript",
        scene,
        ("hexagon", "disk", "rectangle", "cable", "square"),
        {"node": Phase(by_node, needs=("node",), once=True)},
        point="scene, by a part of its name",
        smoke="cable",
    ),
)
