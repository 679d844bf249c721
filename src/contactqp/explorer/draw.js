// What the page shows of an answer: arrays for Bokeh's sources, and words.

const FAINT = "–";

/**
 * The values at the nodes on the rectangle without the ring, NaN elsewhere.
 * @param {Lattice} lattice @param {(p: number) => number} at @returns {Float64Array}
 */
function onRectangle(lattice, at) {
  const values = new Float64Array(lattice.rows * lattice.columns).fill(NaN);
  for (const p of lattice.nodes) {
    const i = Math.floor(p / lattice.width) - 1, j = (p % lattice.width) - 1;
    values[i * lattice.columns + j] = at(p);
  }
  return values;
}

/**
 * @param {Scene} scene @param {Problem} problem @param {Answer} answer
 * @returns {Object<string, Float64Array>} By quantity, on the rectangle.
 */
function mapOf(scene, problem, answer) {
  const { lattice, height } = problem, { certificate, gap } = answer, { sign, area } = scene;
  return {
    state: onRectangle(lattice, (p) => certificate.state[p]),
    gap: onRectangle(lattice, (p) => overSupport(problem, gap, p)),
    lower: onRectangle(lattice, (p) => overSupport(problem, certificate.lower, p)),
    upper: onRectangle(lattice, (p) => overSupport(problem, certificate.upper, p)),
    pressure: onRectangle(lattice, (p) => pressureAt(certificate, p) / area),
    deflection: onRectangle(lattice, (p) => sign * (height[p] - gap[p])),
    support: onRectangle(lattice, (p) => (problem.floor[p] === 0 ? sign * height[p] : NaN)),
  };
}

/**
 * A gap, or nothing where there is no support, and gaps are counted from the frame.
 * @param {Problem} problem @param {Float64Array} gaps @param {number} p @returns {number}
 */
function overSupport({ floor, lattice }, gaps, p) {
  return lattice.mask[p] === 1 && floor[p] === 0 ? gaps[p] : NaN;
}

/** R, and 0 where a node is certainly clear, where R is rounding. @param {Certificate} certificate @param {number} p */
function pressureAt(certificate, p) {
  return certificate.state[p] === CLEAR ? 0 : certificate.reaction[p];
}

/**
 * A row of the lattice, from frame to frame.
 * @param {Scene} scene @param {Problem} problem @param {Answer} answer @param {number} row From 0.
 * @returns {Object<string, Float64Array|string[]>}
 */
function sectionOf(scene, problem, answer, row) {
  const { lattice, height, floor } = problem, { certificate, gap } = answer, { sign, spacing, area, left } = scene;
  const { width, mask } = lattice, first = (row + 1) * width;
  const place = Int32Array.from({ length: width }, (_, j) => first + j);
  const of = (/** @type {(p: number) => number} */ at) => Float64Array.from(place, at);
  const joined = (/** @type {number} */ p) =>
    mask[p] || (p > first && mask[p - 1]) || (p < first + width - 1 && mask[p + 1]);
  const deflection = of((p) => (mask[p] ? sign * (height[p] - gap[p]) : joined(p) ? sign * height[p] : NaN));
  const support = of((p) => (mask[p] === 1 && floor[p] === 0 ? sign * height[p] : NaN));
  return {
    x: Float64Array.from({ length: width }, (_, j) => left + (j - 1) * spacing),
    deflection,
    support,
    foot: support.map((height, j) => (Number.isNaN(height) ? deflection[j] : height)),
    gap: of((p) => overSupport(problem, gap, p)),
    lower: of((p) => overSupport(problem, certificate.lower, p)),
    upper: of((p) => overSupport(problem, certificate.upper, p)),
    pressure: of((p) => (mask[p] ? pressureAt(certificate, p) / area : 0)),
    state: Array.from(place, (p) => ["", "clear", "undecided", "in contact"][certificate.state[p]]),
  };
}

/**
 * Heights between which the section is drawn, the same for all loads if nothing hangs lower than the support.
 * @param {Scene} scene @param {Problem} problem @param {Answer} answer @returns {[number, number]}
 */
function heightsOf(scene, problem, answer) {
  let [least, most] = [Infinity, -Infinity];
  for (const depth of scene.frame) [least, most] = [Math.min(least, depth), Math.max(most, depth)];
  for (const p of problem.lattice.nodes) {
    const deflected = problem.height[p] - answer.gap[p];
    [least, most] = [Math.min(least, deflected, problem.height[p]), Math.max(most, deflected, problem.height[p])];
  }
  const room = 0.06 * (most - least) || 1;
  return [least - room, most + room];
}

/** @param {number} value @param {number} digits @returns {string} */
function told(value, digits = 3) {
  if (!Number.isFinite(value)) return value === Infinity ? "∞" : FAINT;
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3)) return value.toExponential(digits - 1);
  return String(Number(value.toPrecision(digits)));
}

/** A bound, rounded upwards: what is told is one, too. @param {number} bound @returns {string} */
function toldBound(bound) {
  if (!Number.isFinite(bound)) return "∞";
  let text = bound.toExponential(1);
  if (Number(text) < bound) text = (bound * 1.1).toExponential(1);
  return text;
}

/**
 * @param {Scene} scene @param {Problem} problem @param {Answer} answer
 * @returns {Object<string, string>} Words for the page's elements by their names.
 */
function wordsOf(scene, problem, answer) {
  const { certificate, scale, certified } = answer, { nodes } = problem.lattice;
  const { contact, clear, undecided, bound } = certificate, { area, labels } = scene;
  const areas = undecided
    ? `${told(contact * area, 4)} to ${told((contact + undecided) * area, 4)}`
    : told(contact * area, 4);
  let total = 0;
  for (const p of nodes) total += pressureAt(certificate, p);
  return {
    contact: String(contact),
    clear: String(clear),
    undecided: String(undecided),
    nodes: String(nodes.length),
    measure: `contact ${labels.measure}`,
    area: areas,
    reaction: told(total, 4),
    deflection: told(scale, 4),
    verdict: certified
      ? `Proven: no node's gap is wrong by more than ${toldBound(bound)}, ` +
        `${toldBound(bound / scale)} of the largest deflection.`
      : `The bound ${toldBound(bound)} is not as small as was asked for.`,
  };
}
