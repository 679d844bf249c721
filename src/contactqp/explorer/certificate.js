// The fast certificate: bounds that the exact solution ω* provably satisfies, node by node, from any approximate one.
//
// G is an M-matrix, and v > 0 a barrier, s = Gv > 0. With R = Gω + q,
//
//   ω - τ⁻v ≤ ω* ≤ ω + τ⁺v,  τ⁺ = max max(0, -ω_i/v_i, -R_i/s_i),  τ⁻ = max max(0, min(ω_i/v_i, R_i/s_i)):
//
// ω + τ⁺v is feasible, and ω* is the least feasible point; ω - τ⁻v, cut off at zero, is a subsolution. All roundings are
// bounded and granted to the bounds, as contactqp/proof/lattice_measure_kernels.py does; JavaScript's numbers are
// doubles that are rounded to nearest after every operation (ECMA-262, section 6.1.6.1), with nothing contracted.

const UNIT_ROUNDOFF = 2 ** -53;
const UNDERFLOW = 1e-300; // more than what gradual underflow can take from a short sum of products
const REACTION_ERROR = (12 * UNIT_ROUNDOFF) / (1 - 12 * UNIT_ROUNDOFF); // Higham (2002), lemma 3.1: twelve operations
const SLACK = 4 * UNIT_ROUNDOFF;
const GROW = 1 + 16 * UNIT_ROUNDOFF;

/** States of a node. */
const FRAME = 0, CLEAR = 1, UNDECIDED = 2, CONTACT = 3;

/**
 * v = rows[i] + columns[j] at the place [i, j] of the grid, and a lower bound of Gv.
 * @typedef {object} Barrier
 * @property {Float64Array} rows
 * @property {Float64Array} columns
 * @property {number} s
 */

/**
 * @typedef {object} Certificate
 * @property {Float64Array} lower  lower ≤ ω* ≤ upper at the nodes (length), on the grid.
 * @property {Float64Array} upper
 * @property {Uint8Array} state    FRAME, CLEAR (ω* > 0 is certain), CONTACT (R* > 0 is) or UNDECIDED.
 * @property {Float64Array} reaction R of the gap that was certified (force).
 * @property {number} bound        max |ω - ω*| is at most this (length).
 * @property {number} contact      Nodes certainly in contact.
 * @property {number} clear        Nodes certainly clear.
 * @property {number} undecided    The others.
 */

/**
 * The parabola with the least v/s of those that are ≥ 0 on the frame: a paraboloid about the middle of the nodes, or a
 * parabola across them along x or y. Its second differences are -2, so Gv ≥ 2 × arm. All values are multiples of 1/4,
 * and exact.
 * @param {Lattice} lattice @returns {Barrier}
 */
function parabolaBarrier(lattice) {
  const { rows, columns, width, mask, across, along } = lattice;
  const reachX = across > 0 ? 1 : 0, reachY = along > 0 ? 1 : 0;
  const sumX = columns - 1, sumY = rows - 1; // twice the middle, counted from the first node's column and row
  const twiceX = (/** @type {number} */ j) => 2 * (j - 1) - sumX, twiceY = (/** @type {number} */ i) => 2 * (i - 1) - sumY;
  let rim = 0;
  for (const p of lattice.nodes) {
    const i = Math.floor(p / width), j = p % width;
    if (reachX && !mask[p - 1]) rim = Math.max(rim, twiceY(i) ** 2 + twiceX(j - 1) ** 2);
    if (reachX && !mask[p + 1]) rim = Math.max(rim, twiceY(i) ** 2 + twiceX(j + 1) ** 2);
    if (reachY && !mask[p - width]) rim = Math.max(rim, twiceY(i - 1) ** 2 + twiceX(j) ** 2);
    if (reachY && !mask[p + width]) rim = Math.max(rim, twiceY(i + 1) ** 2 + twiceX(j) ** 2);
  }
  const exact = 1 - 4 * UNIT_ROUNDOFF;
  const overRows = (/** @type {(i: number) => number} */ f) => Float64Array.from({ length: rows + 2 }, (_, i) => f(i));
  const overColumns = (/** @type {(j: number) => number} */ f) => Float64Array.from({ length: columns + 2 }, (_, j) => f(j));
  const flatRows = new Float64Array(rows + 2), flatColumns = new Float64Array(columns + 2);
  /** @type {Barrier[]} */
  const found = [
    {
      rows: overRows((i) => (rim - twiceY(i) ** 2) / 4),
      columns: overColumns((j) => -(twiceX(j) ** 2) / 4),
      s: exact * (2 * across + 2 * along),
    },
  ];
  if (reachX) found.push({ rows: flatRows, columns: overColumns((j) => j * (columns + 1 - j)), s: exact * 2 * across });
  if (reachY) found.push({ rows: overRows((i) => i * (rows + 1 - i)), columns: flatColumns, s: exact * 2 * along });
  let best = found[0], least = Infinity;
  for (const barrier of found) {
    let largest = 0;
    for (const p of lattice.nodes) {
      largest = Math.max(largest, barrier.rows[Math.floor(p / width)] + barrier.columns[p % width]);
    }
    if (largest / barrier.s < least) [best, least] = [barrier, largest / barrier.s];
  }
  return best;
}

/**
 * @param {Problem} problem
 * @param {Barrier} barrier Of the problem's lattice.
 * @param {Float64Array} omega A gap on the grid, 0 at the frame.
 * @returns {Certificate}
 */
function certify(problem, barrier, omega) {
  const { lattice, q, floor } = problem, { width, across, along, nodes, mask } = lattice;
  const { rows, columns, s } = barrier, perS = 1 / s;
  const reaction = new Float64Array(omega.length);
  let raise = 0, fall = 0, bounded = true;
  for (const p of nodes) {
    const own = omega[p], v = rows[Math.floor(p / width)] + columns[p % width];
    const west = own - omega[p - 1], east = own - omega[p + 1];
    const south = own - omega[p - width], north = own - omega[p + width];
    const force = across * (west + east) + along * (south + north) + q[p];
    const magnitude =
      across * (Math.abs(west) + Math.abs(east)) + along * (Math.abs(south) + Math.abs(north)) + Math.abs(q[p]);
    const error = REACTION_ERROR * magnitude + UNDERFLOW;
    reaction[p] = force;
    bounded = bounded && error < Infinity;
    let high = (error + force) * perS;
    if (floor[p] === 0) {
      raise = Math.max(raise, -own / v);
      high = Math.min(high, own / v);
    }
    raise = Math.max(raise, (error - force) * perS);
    fall = Math.max(fall, high);
  }
  raise = bounded ? raise * GROW + UNDERFLOW : Infinity;
  fall = bounded ? fall * GROW + UNDERFLOW : Infinity;

  const lower = new Float64Array(omega.length), upper = new Float64Array(omega.length);
  const state = new Uint8Array(omega.length), counts = [0, 0, 0, 0];
  let bound = 0;
  for (const p of nodes) {
    const i = Math.floor(p / width), j = p % width, own = omega[p], v = rows[i] + columns[j];
    const rise = raise * v, drop = fall * v;
    const high = own + rise + (SLACK * (Math.abs(own) + rise) + UNDERFLOW);
    let low = own - drop - (SLACK * (Math.abs(own) + drop) + UNDERFLOW);
    state[p] = CLEAR;
    if (floor[p] === 0) {
      // At frame points, which have gap 0 and no barrier, v need not be 0, but may count as if it were theirs.
      const sideways = Math.max(0, rows[i] + columns[j - 1]) + Math.max(0, rows[i] + columns[j + 1]);
      const endways = Math.max(0, rows[i - 1] + columns[j]) + Math.max(0, rows[i + 1] + columns[j]);
      const lift = raise * (across * sideways + along * endways);
      const west = omega[p - 1], east = omega[p + 1], south = omega[p - width], north = omega[p + width];
      const pull = across * (west + east) + along * (south + north) + lift;
      const force =
        across * (Math.abs(west) + Math.abs(east)) + along * (Math.abs(south) + Math.abs(north)) + lift;
      const error = REACTION_ERROR * (force + Math.abs(q[p])) + UNDERFLOW;
      low = Math.max(low, 0);
      if (q[p] - pull > 2 * error) state[p] = CONTACT;
      else if (!(low > 0)) state[p] = UNDECIDED;
    }
    lower[p] = state[p] === CONTACT ? 0 : low;
    upper[p] = state[p] === CONTACT ? 0 : high;
    counts[state[p]]++;
    // A bound that is not finite, or not a number, must not pass for a small one.
    bound = Number.isFinite(high) && Number.isFinite(low) ? Math.max(bound, high - own, own - low) : Infinity;
    if (bound === Infinity) break;
  }
  if (bound === Infinity) {
    counts.fill(0);
    for (const p of nodes) {
      [lower[p], upper[p]] = [floor[p], Infinity];
      state[p] = floor[p] === 0 ? UNDECIDED : CLEAR;
      counts[state[p]]++;
    }
  }
  const [contact, clear, undecided] = [counts[CONTACT], counts[CLEAR], counts[UNDECIDED]];
  return { lower, upper, state, reaction, bound: GROW * bound + UNDERFLOW, contact, clear, undecided };
}
