// Lattices whose arms are equal in each direction, and contact problems on them.
//
// Values stand on a grid: the rectangle of the nodes with a ring of frame points about it, row by row in one flat array,
// so that the neighbours of place p are p - 1, p + 1, p - width and p + width, and none needs a test.

/**
 * @typedef {object} Lattice
 * @property {number} rows      Rows of the rectangle that holds all nodes.
 * @property {number} columns   Its columns.
 * @property {number} width     columns + 2.
 * @property {Uint8Array} mask  1 at the nodes, on the grid.
 * @property {Int32Array} nodes Places of the nodes, ascending: node order.
 * @property {Int32Array[]} colours Places of the nodes whose row + column is even, and of the others.
 * @property {number} across    Stiffness of the arms along rows (force per length).
 * @property {number} along     Stiffness of the arms along columns; 0 for a cable.
 */

/**
 * @typedef {object} Problem
 * @property {Lattice} lattice
 * @property {Float64Array} load   P at the nodes (force), 0 elsewhere.
 * @property {Float64Array} height What gaps are measured from: the support's depth, or any where there is none; on the
 *   frame its own depth (length).
 * @property {Float64Array} floor  Lower bound of the gap: 0, or -Infinity where there is no support.
 * @property {number} datum        Mean depth of the frame, from which deflections are measured (length).
 * @property {Float64Array} q      Reaction that would hold the gap zero (force), at the nodes; 0 elsewhere.
 */

/**
 * @param {number} rows
 * @param {number} columns
 * @param {Uint8Array} mask Of (rows + 2) (columns + 2) places, 0 on the ring.
 * @param {number} across
 * @param {number} along
 * @returns {Lattice}
 */
function makeLattice(rows, columns, mask, across, along) {
  const width = columns + 2;
  const places = [], even = [], odd = [];
  for (let i = 1; i <= rows; i++) {
    for (let j = 1; j <= columns; j++) {
      const p = i * width + j;
      if (mask[p]) {
        places.push(p);
        ((i + j) & 1 ? odd : even).push(p);
      }
    }
  }
  const colours = [Int32Array.from(even), Int32Array.from(odd)];
  return { rows, columns, width, mask, nodes: Int32Array.from(places), colours, across, along };
}

/**
 * The force with which the arms resist a shape (force), at the nodes; formed from differences, which keep the digits
 * that products with the diagonal would lose.
 * @param {Lattice} lattice
 * @param {Float64Array} grid Lengths.
 * @param {number} p Place of a node.
 * @returns {number}
 */
function pullAt(lattice, grid, p) {
  const own = grid[p], width = lattice.width;
  return (
    lattice.across * (own - grid[p - 1] + (own - grid[p + 1])) +
    lattice.along * (own - grid[p - width] + (own - grid[p + width]))
  );
}

/**
 * @param {Lattice} lattice
 * @param {Float64Array} load
 * @param {Float64Array} height
 * @param {Float64Array} floor
 * @param {number} datum
 * @returns {Problem}
 */
function poseProblem(lattice, load, height, floor, datum) {
  const q = new Float64Array(lattice.mask.length);
  for (const p of lattice.nodes) q[p] = load[p] - pullAt(lattice, height, p);
  return { lattice, load, height, floor, datum, q };
}

/**
 * By how much to coarsen rows and columns: 2, or 1 along a line and where there are few points.
 * @param {number} rows
 * @param {number} columns
 * @param {number} across
 * @param {number} along
 * @returns {[number, number]}
 */
function coarsening(rows, columns, across, along) {
  if (rows * columns <= 9) return [1, 1];
  const down = rows > 1 && along * 3 >= across ? 2 : 1;
  const right = columns > 1 && across * 3 >= along ? 2 : 1;
  if (down * right === 1) return rows > 1 ? [2, 1] : [1, 2];
  return [down, right];
}

/**
 * The same problem on the lattice of every second node; null where that would be no coarser, or would hold no node.
 * @param {Problem} problem
 * @returns {?{problem: Problem, down: number, right: number}}
 */
function coarserProblem(problem) {
  const { rows, columns, width, mask, across, along } = problem.lattice;
  const [down, right] = coarsening(rows, columns, across, along);
  if (down * right === 1) return null;
  const coarseRows = Math.floor(rows / down), coarseColumns = Math.floor(columns / right);
  const coarseWidth = coarseColumns + 2, size = (coarseRows + 2) * coarseWidth;
  const coarseMask = new Uint8Array(size);
  const height = new Float64Array(size), floor = new Float64Array(size);
  for (let i = 0; i < coarseRows + 2; i++) {
    for (let j = 0; j < coarseWidth; j++) {
      const from = Math.min(down * i, rows + 1) * width + Math.min(right * j, columns + 1);
      const inside = i >= 1 && i <= coarseRows && j >= 1 && j <= coarseColumns;
      coarseMask[i * coarseWidth + j] = inside ? mask[from] : 0;
      height[i * coarseWidth + j] = problem.height[from];
      floor[i * coarseWidth + j] = problem.floor[from];
    }
  }
  const lattice = makeLattice(
    coarseRows, coarseColumns, coarseMask, (across * down) / right, (along * right) / down
  );
  if (!lattice.nodes.length) return null;
  const load = new Float64Array(size);
  restrictTo(problem.load, rows, width, load, coarseRows, coarseColumns, down, right);
  for (let p = 0; p < size; p++) if (!coarseMask[p]) load[p] = 0;
  return { problem: poseProblem(lattice, load, height, floor, problem.datum), down, right };
}

/**
 * Sum fine forces with the weights of bilinear interpolation.
 * @param {Float64Array} fine
 * @param {number} rows Of the fine lattice.
 * @param {number} width Of its grid.
 * @param {Float64Array} coarse Written.
 * @param {number} coarseRows
 * @param {number} coarseColumns
 * @param {number} down
 * @param {number} right
 */
function restrictTo(fine, rows, width, coarse, coarseRows, coarseColumns, down, right) {
  coarse.fill(0);
  const coarseWidth = coarseColumns + 2;
  const reach = down - 1;
  for (let target = 1; target <= coarseRows; target++) {
    const out = target * coarseWidth;
    for (let i = down * target - reach; i <= Math.min(down * target + reach, rows); i++) {
      const weight = i === down * target ? 1 : 0.5, row = i * width;
      if (right === 1) {
        for (let j = 1; j <= coarseColumns; j++) coarse[out + j] += weight * fine[row + j];
      } else {
        for (let j = 1; j <= coarseColumns; j++) {
          const at = row + 2 * j;
          coarse[out + j] += weight * (fine[at] + 0.5 * (fine[at - 1] + fine[at + 1]));
        }
      }
    }
  }
}

/**
 * Interpolate a fine row bilinearly from a coarse grid.
 * @param {Float64Array} coarse
 * @param {number} coarseRows
 * @param {number} coarseColumns
 * @param {number} i The fine row.
 * @param {number} down
 * @param {number} right
 * @param {Float64Array} row Written; as wide as the fine grid.
 */
function interpolateRow(coarse, coarseRows, coarseColumns, i, down, right, row) {
  const coarseWidth = coarseColumns + 2, last = coarseColumns + 1;
  const below = Math.floor(i / down) * coarseWidth;
  const above = Math.min(Math.floor((i + down - 1) / down), coarseRows + 1) * coarseWidth;
  if (right === 1) {
    for (let j = 0; j < Math.min(row.length, coarseWidth); j++) row[j] = 0.5 * (coarse[below + j] + coarse[above + j]);
    return;
  }
  let before = 0.5 * (coarse[below] + coarse[above]);
  for (let j = 1; j <= last; j++) {
    const here = 0.5 * (coarse[below + j] + coarse[above + j]);
    if (2 * j - 1 < row.length) row[2 * j - 1] = 0.5 * (before + here);
    if (2 * j < row.length) row[2 * j] = here;
    before = here;
  }
}
