// Scenes: problems as the page holds them, and what the reader has made of one.

/**
 * @typedef {object} Slide
 * @property {number} value @property {number} least @property {number} most @property {string} label
 */

/**
 * A scene as Python writes it, see scenes.py; here its arrays are unpacked.
 * @typedef {object} Scene
 * @property {string} name
 * @property {number} left     x of the first column (length).
 * @property {number} bottom   y of the first row.
 * @property {number} spacing
 * @property {number} area     What a node stands for (area; of a cable, length).
 * @property {number} sign     1 where heights are positive downwards, -1 where upwards.
 * @property {Lattice} lattice With arms of tension 1.
 * @property {Slide} tension
 * @property {Slide} load
 * @property {{least: number, most: number}} lift
 * @property {Float64Array} pattern Nodal loads for a load of 1 (area), on the grid.
 * @property {Float64Array} frame  Depth of the frame (length), on the grid.
 * @property {Map<string, Float64Array>} supports Depths on the grid, Infinity where there is none.
 * @property {Object<string, string>} labels
 */

/**
 * @typedef {object} Wish
 * @property {string} support Name of the support.
 * @property {number} load
 * @property {number} tension
 * @property {number} lift    How far the support is raised (length).
 * @property {number} relief  Factor of the support's heights above and below its summit.
 */

/** @param {string} packed @returns {Uint8Array} */
function unpackBytes(packed) {
  return Uint8Array.from(atob(packed), (character) => character.charCodeAt(0));
}

/** @param {string|number} packed One number stands for all. @param {number} size @returns {Float64Array} */
function unpackNumbers(packed, size) {
  return typeof packed === "number" ? new Float64Array(size).fill(packed) : new Float64Array(unpackBytes(packed).buffer);
}

/** @param {any} record @returns {Scene} */
function unpackScene(record) {
  const lattice = makeLattice(record.rows, record.columns, unpackBytes(record.mask), ...record.arms);
  const numbers = (/** @type {string|number} */ packed) => unpackNumbers(packed, lattice.mask.length);
  const supports = new Map(Object.entries(record.supports).map(([name, packed]) => [name, numbers(packed)]));
  return { ...record, lattice, pattern: numbers(record.pattern), frame: numbers(record.frame), supports };
}

/**
 * The problem that the reader wishes: a support of other relief, raised, under another load and tension.
 * @param {Scene} scene @param {Wish} wish @returns {Problem}
 */
function problemOf(scene, wish) {
  const { across, along, nodes, mask } = scene.lattice;
  const lattice = { ...scene.lattice, across: across * wish.tension, along: along * wish.tension };
  const depth = scene.supports.get(wish.support);
  const summit = nodes.reduce((least, p) => Math.min(least, depth[p]), Infinity);
  const frame = meanOnFrame(scene);
  const load = new Float64Array(mask.length), height = Float64Array.from(scene.frame), floor = new Float64Array(mask.length);
  for (const p of nodes) {
    load[p] = wish.load * scene.pattern[p];
    const there = depth[p] < Infinity;
    height[p] = there ? summit + wish.relief * (depth[p] - summit) - wish.lift : frame;
    floor[p] = there ? 0 : -Infinity;
  }
  return poseProblem(lattice, load, height, floor, frame);
}

/** Mean depth of the frame, from which gaps are measured where there is no support. @param {Scene} scene */
function meanOnFrame({ frame, lattice }) {
  let sum = 0, count = 0;
  for (let p = 0; p < frame.length; p++) {
    if (lattice.mask[p]) continue;
    sum += frame[p];
    count++;
  }
  return sum / count;
}
