// Truncated nonsmooth Newton multigrid for min ½ωᵀGω + qᵀω above a lower bound, on a lattice.
//
// Gräser and Kornhuber, Multigrid methods for obstacle problems, J. Comput. Math. 27 (2009): projected Gauss-Seidel
// finds the contact nodes; one linear multigrid cycle for the other nodes, by Galerkin operators that are truncated at
// the contact, takes away the smooth error; the correction is projected, and shortened by a line search where that cut
// it short. The start is the solution of the same problem on coarser lattices (nested iteration).

const SWEEPS = 3, MOST_SWEEPS = 24, CYCLES_A_LEVEL = 2, COARSEST_SWEEPS = 10;
const STALLING = 0.5; // contraction above which a cycle at rest counts as stalling
const JACOBI = 16 / 9; // see `setFactors`

/**
 * A nine-point operator on a grid, symmetric: the diagonal and the couplings to the neighbours east, north, north-east
 * and north-west; `factor` is that of Jacobi's method. `kind` is 0 where its row is zero, 1 where it is the constant one
 * (far from frame and contact), and 2 elsewhere.
 * @typedef {object} Operator
 * @property {number} rows
 * @property {number} columns
 * @property {number} width
 * @property {Float64Array[]} stencil Centre, east, north, north-east, north-west, factor.
 * @property {Uint8Array} kind
 * @property {Float64Array} constant The six numbers of a point of kind 1.
 * @property {Uint8Array} changed 1 for the rows that have to be, or have been, computed anew.
 */

/**
 * @typedef {Operator & {down: number, right: number, residual: Float64Array, correction: Float64Array,
 *   spare: Float64Array}} Level
 */

/** @param {number} distance @param {number} factor @returns {number} */
function hat(distance, factor) {
  return Math.max(0, 1 - Math.abs(distance) / factor);
}

/** @type {Map<number, Float64Array[]>} */
const knownWeights = new Map();

/**
 * Values of the basis functions of a coarse point and of its neighbours east, north, north-east and north-west on the
 * 7 × 7 fine points about it.
 * @param {number} down @param {number} right @returns {Float64Array[]}
 */
function windowWeights(down, right) {
  let found = knownWeights.get(2 * down + right);
  if (found === undefined) {
    const places = [[0, 0], [0, 1], [1, 0], [1, 1], [1, -1]];
    found = places.map(([up, over]) =>
      Float64Array.from({ length: 49 }, (_, k) => {
        const a = Math.floor(k / 7) - 3, b = (k % 7) - 3;
        return hat(a - down * up, down) * hat(b - right * over, right);
      })
    );
    knownWeights.set(2 * down + right, found);
  }
  return found;
}

/** @param {number} rows @param {number} columns @returns {Operator} */
function emptyOperator(rows, columns) {
  const size = (rows + 2) * (columns + 2);
  const stencil = Array.from({ length: 6 }, () => new Float64Array(size));
  const changed = new Uint8Array(rows + 2).fill(1), constant = new Float64Array(6);
  return { rows, columns, width: columns + 2, stencil, kind: new Uint8Array(size), constant, changed };
}

/**
 * 0 or 1 where the whole window about a point is of that kind, else 2.
 * @param {Operator} fine @param {number} i @param {number} j @param {number} down @param {number} right
 * @returns {number}
 */
function windowKind(fine, i, j, down, right) {
  const { kind, width, rows } = fine, first = kind[i * width + j];
  if (first === 2) return 2;
  const outside = i - down < 0 || j - right < 0 || i + down > rows + 1 || j + right > width - 1;
  if (first === 1 && outside) return 2;
  for (let a = Math.max(i - down, 0); a <= Math.min(i + down, rows + 1); a++) {
    for (let b = Math.max(j - right, 0); b <= Math.min(j + right, width - 1); b++) {
      if (kind[a * width + b] !== first) return 2;
    }
  }
  return first;
}

const basisWindow = new Float64Array(49), imageWindow = new Float64Array(49);

/**
 * Write a row of the Galerkin product PᵀAP, P being bilinear interpolation: the inner products of A φ with φ and with
 * its four later neighbours, φ the basis function of a coarse point.
 * @param {Operator} fine
 * @param {number} i Fine row of the coarse point.
 * @param {number} j Its fine column.
 * @param {number} down
 * @param {number} right
 * @param {Float64Array[]} out
 * @param {number} place Where to write in each of the first five of `out`.
 */
function galerkinRow(fine, i, j, down, right, out, place) {
  const { stencil, kind, width, rows, columns } = fine;
  const [centre, east, north, northEast, northWest] = stencil;
  const basis = basisWindow, image = imageWindow, weights = windowWeights(down, right);
  basis.fill(0);
  for (let a = -1; a <= 1; a++) {
    for (let b = -1; b <= 1; b++) {
      const k = (a + 3) * 7 + b + 3;
      if (i + a >= 1 && i + a <= rows && j + b >= 1 && j + b <= columns) basis[k] = weights[0][k];
    }
  }
  for (let a = -2; a <= 2; a++) {
    for (let b = -2; b <= 2; b++) {
      const y = i + a, x = j + b, k = (a + 3) * 7 + b + 3, p = y * width + x;
      image[k] = 0;
      if (y < 1 || y > rows || x < 1 || x > columns || !kind[p]) continue;
      image[k] =
        centre[p] * basis[k] + east[p] * basis[k + 1] + east[p - 1] * basis[k - 1] +
        north[p] * basis[k + 7] + north[p - width] * basis[k - 7] +
        northEast[p] * basis[k + 8] + northEast[p - width - 1] * basis[k - 8] +
        northWest[p] * basis[k + 6] + northWest[p - width + 1] * basis[k - 6];
    }
  }
  for (let n = 0; n < 5; n++) {
    const share = weights[n];
    let total = 0;
    for (let row = 7; row < 42; row += 7) {
      for (let k = row + 1; k < row + 6; k++) total += share[k] * image[k];
    }
    out[n][place] = total;
  }
}

/**
 * The constant row of a coarse operator, from that of the finer one.
 * @param {Float64Array} finer @param {number} down @param {number} right @returns {Float64Array}
 */
function constantRow(finer, down, right) {
  const fine = emptyOperator(9, 9), coarse = emptyOperator(1, 1);
  fine.kind.fill(2);
  for (let k = 0; k < 6; k++) fine.stencil[k].fill(finer[k]);
  galerkinRow(fine, 5, 5, down, right, coarse.stencil, 4);
  const row = Float64Array.from(coarse.stencil, (entries) => entries[4]);
  const moduli = 2 * (Math.abs(row[1]) + Math.abs(row[2]) + Math.abs(row[3]) + Math.abs(row[4]));
  row[5] = JACOBI / (row[0] + Math.max(row[0], moduli));
  return row;
}

/**
 * Write the factors of Jacobi's method. Where a row's moduli sum to twice the diagonal, as for a Laplacian, the factor
 * is 8/9 over the diagonal; where a basis function is truncated, it is smaller by as much as the sum is larger, so that
 * no eigenvalue of factor × operator exceeds 16/9 < 2 (Gershgorin).
 * @param {Operator} level
 */
function setFactors(level) {
  const { stencil, kind, width, rows, columns, constant, changed } = level;
  const [centre, east, north, northEast, northWest, factor] = stencil;
  for (let i = 1; i <= rows; i++) {
    if (!changed[i] && !changed[i - 1]) continue;
    for (let p = i * width + 1; p <= i * width + columns; p++) {
      if (kind[p] < 2) {
        factor[p] = kind[p] ? constant[5] : 0;
        continue;
      }
      const moduli =
        Math.abs(east[p]) + Math.abs(east[p - 1]) + Math.abs(north[p]) + Math.abs(north[p - width]) +
        Math.abs(northEast[p]) + Math.abs(northEast[p - width - 1]) +
        Math.abs(northWest[p]) + Math.abs(northWest[p - width + 1]);
      factor[p] = JACOBI / (centre[p] + Math.max(centre[p], moduli));
    }
  }
}

/**
 * Write those rows of a coarse operator that a changed row of the finer one has a share in, with kinds and factors.
 * @param {Operator} fine
 * @param {Level} coarse
 */
function coarsenOperator(fine, coarse) {
  const { down, right, width, stencil, kind, constant, changed } = coarse;
  for (let i = 1; i <= coarse.rows; i++) {
    changed[i] = fine.changed.subarray(down * i - down, down * i + down + 1).includes(1) ? 1 : 0;
    if (!changed[i]) continue;
    for (let j = 1; j <= coarse.columns; j++) {
      const p = i * width + j, window = windowKind(fine, down * i, right * j, down, right);
      if (window < 2) {
        kind[p] = window;
        for (let k = 0; k < 5; k++) stencil[k][p] = window ? constant[k] : 0;
        continue;
      }
      galerkinRow(fine, down * i, right * j, down, right, stencil, p);
      kind[p] = stencil[0][p] > 0 ? 2 : 0;
    }
  }
  setFactors(coarse);
}

/** The coarse levels below a lattice, and the linear cycle through them. */
class Hierarchy {
  /** @param {Lattice} lattice */
  constructor(lattice) {
    this.lattice = lattice;
    /** The lattice's own operator, truncated where there is contact. */
    this.finest = emptyOperator(lattice.rows, lattice.columns);
    this.finest.kind.set(lattice.mask);
    const { across, along } = lattice;
    this.finest.constant.set([2 * (across + along), -across, -along, 0, 0, 0]);
    /** @type {Level[]} */
    this.levels = [];
    let { rows, columns } = lattice, arms = [across, along], constant = this.finest.constant;
    for (;;) {
      const [down, right] = coarsening(rows, columns, arms[0], arms[1]);
      if (down * right === 1 && this.levels.length) break;
      rows = Math.floor(rows / down);
      columns = Math.floor(columns / right);
      arms = [(arms[0] * down) / right, (arms[1] * right) / down];
      constant = constantRow(constant, down, right);
      const size = (rows + 2) * (columns + 2);
      const vectors = { residual: new Float64Array(size), correction: new Float64Array(size) };
      const spare = new Float64Array(size);
      this.levels.push({ ...emptyOperator(rows, columns), constant, down, right, ...vectors, spare });
      if (down * right === 1) break;
    }
    const nodes = lattice.nodes.length;
    const points = this.levels.map((level) => level.residual.length / nodes);
    this.points = points.reduce((sum, share) => sum + share, 0);
    this.cycleWork = 4 * points.reduce((sum, share, depth) => sum + (depth + 1) * share, 0);
  }

  /** Compute the operators anew, after `finest.kind` has changed in the rows of `finest.changed`. */
  update() {
    const { stencil, kind, width, rows, columns, constant, changed } = this.finest;
    const [centre, east, north] = stencil;
    for (let i = 1; i <= rows; i++) {
      if (!changed[i] && !changed[i + 1]) continue;  // the coupling to the next row is this one's
      for (let p = i * width + 1; p <= i * width + columns; p++) {
        const free = kind[p];
        centre[p] = free ? constant[0] : 0;
        east[p] = free && kind[p + 1] ? constant[1] : 0;
        north[p] = free && kind[p + width] ? constant[2] : 0;
      }
    }
    let finer = this.finest;
    for (const level of this.levels) {
      coarsenOperator(finer, level);
      finer = level;
    }
    changed.fill(0);
  }

  /**
   * A cycle from zero for the `residual` of a level; its `correction` is the result. An F-cycle: the next coarser level
   * is corrected by an F-cycle and then by a V-cycle.
   * @param {number} depth
   * @param {boolean} full
   */
  cycle(depth = 0, full = true) {
    const level = this.levels[depth];
    if (depth === this.levels.length - 1) {
      solveCoarsest(level);
      return;
    }
    const factor = level.stencil[5], { residual, correction } = level;
    for (let p = 0; p < residual.length; p++) correction[p] = factor[p] * residual[p];
    for (const below of full ? [true, false] : [false]) {
      const coarse = this.levels[depth + 1];
      const { spare } = level;
      applyOperator(level, level.correction, spare);
      for (let p = 0; p < spare.length; p++) spare[p] = residual[p] - spare[p];
      restrictTo(spare, level.rows, level.width, coarse.residual, coarse.rows, coarse.columns, coarse.down, coarse.right);
      this.cycle(depth + 1, below);
      addInterpolated(level, coarse);
      applyOperator(level, level.correction, spare);
      const own = level.correction;
      for (let p = 0; p < own.length; p++) own[p] += factor[p] * (residual[p] - spare[p]);
    }
  }
}

/**
 * Write an operator times a vector; zero on the ring.
 * @param {Operator} operator @param {Float64Array} vector @param {Float64Array} out
 */
function applyOperator(operator, vector, out) {
  const { stencil, width, rows, columns } = operator;
  const [centre, east, north, northEast, northWest] = stencil;
  out.fill(0);
  for (let i = 1; i <= rows; i++) {
    for (let p = i * width + 1; p <= i * width + columns; p++) {
      const south = p - width, above = p + width;
      out[p] =
        centre[p] * vector[p] + east[p] * vector[p + 1] + east[p - 1] * vector[p - 1] +
        (north[p] * vector[above] + northEast[p] * vector[above + 1] + northWest[p] * vector[above - 1] +
          (north[south] * vector[south] + northEast[south - 1] * vector[south - 1] +
            northWest[south + 1] * vector[south + 1]));
    }
  }
}

/** Forward and backward sweeps of Gauss-Seidel from zero. @param {Level} level */
function solveCoarsest(level) {
  const { stencil, width, rows, columns, residual, correction } = level;
  const [centre, east, north, northEast, northWest, factor] = stencil;
  correction.fill(0);
  for (let sweep = 0; sweep < 2 * COARSEST_SWEEPS; sweep++) {
    for (let k = 0; k < rows * columns; k++) {
      const at = sweep % 2 === 0 ? k : rows * columns - 1 - k;
      const p = (Math.floor(at / columns) + 1) * width + (at % columns) + 1;
      if (!(factor[p] > 0)) continue;
      const south = p - width, above = p + width;
      const others =
        east[p] * correction[p + 1] + east[p - 1] * correction[p - 1] +
        (north[p] * correction[above] + northEast[p] * correction[above + 1] + northWest[p] * correction[above - 1]) +
        (north[south] * correction[south] + northEast[south - 1] * correction[south - 1] +
          northWest[south + 1] * correction[south + 1]);
      correction[p] = (residual[p] - others) / centre[p];
    }
  }
}

/** @param {Level} level @param {Level} coarse */
function addInterpolated(level, coarse) {
  const { rows, columns, width, correction } = level, row = new Float64Array(width);
  for (let i = 1; i <= rows; i++) {
    row.fill(0);
    interpolateRow(coarse.correction, coarse.rows, coarse.columns, i, coarse.down, coarse.right, row);
    for (let j = 1; j <= columns; j++) correction[i * width + j] += row[j];
  }
}

/** The iteration on one lattice; a cycle is `relax` and `correct`. */
class ContactMultigrid {
  /** @param {Problem} problem */
  constructor(problem) {
    const { lattice } = problem;
    this.problem = problem;
    this.omega = new Float64Array(lattice.mask.length);
    this.next = new Float64Array(lattice.mask.length);
    this.outOfBalance = new Float64Array(lattice.mask.length);
    this.hierarchy = new Hierarchy(lattice);
    this.reach = reachOf(lattice);
    /** After `relax`: the largest force that is out of balance. */
    this.estimate = Infinity;
    /** Work done, in sweeps over this lattice: a pass over a coarse one counts by its points. */
    this.work = 0;
    this.sweeps = SWEEPS;
    this.careful = false;
    this.outdated = true;
  }

  /** Sweep, red and black nodes in turn, then measure and restrict what is left. */
  relax() {
    const { lattice, q, floor } = this.problem, { omega } = this, { width, across, along } = lattice;
    const before = this.estimate, share = 1 / (2 * (across + along));
    for (let half = 0; half < 2 * this.sweeps; half++) {
      for (const p of lattice.colours[half % 2]) {
        const pull = across * (omega[p - 1] + omega[p + 1]) + along * (omega[p - width] + omega[p + width]) - q[p];
        omega[p] = Math.max(floor[p], pull * share);
      }
    }
    const changes = this.restrictResidual();
    this.work += this.sweeps + 1;
    if (changes === 0 && this.estimate > STALLING * before) {
      this.sweeps = Math.min(2 * this.sweeps, MOST_SWEEPS);
      this.careful = true;
    }
  }

  /**
   * Restrict -R of the free nodes to the first coarse level, and find the largest force out of balance.
   * @returns {number} How many nodes became free or ceased to be.
   */
  restrictResidual() {
    const { lattice, q, floor } = this.problem, { omega, outOfBalance } = this;
    const { kind: free, changed } = this.hierarchy.finest, slope = 1 / this.reach;
    let changes = 0, worst = 0;
    for (const p of lattice.nodes) {
      const reaction = pullAt(lattice, omega, p) + q[p];
      const isFree = omega[p] > floor[p] ? 1 : 0;
      if (isFree !== free[p]) {
        changes++;
        free[p] = isFree;
        changed[Math.floor(p / lattice.width)] = 1;
      }
      outOfBalance[p] = isFree ? -reaction : 0;
      worst = Math.max(worst, -reaction, Math.min(reaction, slope * (omega[p] - floor[p])));
    }
    this.estimate = worst;
    if (changes) this.outdated = true;
    const first = this.hierarchy.levels[0];
    restrictTo(
      outOfBalance, lattice.rows, lattice.width, first.residual, first.rows, first.columns, first.down, first.right
    );
    return changes;
  }

  /** Correct the free nodes from the coarse levels; to be called after `relax`. */
  correct() {
    const { hierarchy, omega, next } = this, { lattice, floor } = this.problem;
    if (this.outdated) {
      hierarchy.update();
      this.outdated = false;
      this.work += hierarchy.points;
    }
    hierarchy.cycle();
    const { rows, columns, width, mask } = lattice, first = hierarchy.levels[0], row = new Float64Array(width);
    let cut = 0;
    for (let i = 1; i <= rows; i++) {
      row.fill(0);
      interpolateRow(first.correction, first.rows, first.columns, i, first.down, first.right, row);
      for (let j = 1; j <= columns; j++) {
        const p = i * width + j;
        if (!mask[p]) continue;
        if (omega[p] > floor[p]) {
          const wanted = omega[p] + row[j];
          if (wanted < floor[p]) cut++;
          next[p] = Math.max(wanted, floor[p]);
        } else {
          next[p] = floor[p];
        }
      }
    }
    this.work += 1 + hierarchy.cycleWork;
    if (cut || this.careful) this.lineSearch();
    [this.omega, this.next] = [next, omega];
  }

  /** Shorten the step to the least energy along it; it stays feasible, because both of its ends are. */
  lineSearch() {
    const { lattice, q } = this.problem, { omega, next } = this;
    const step = new Float64Array(omega.length);
    for (const p of lattice.nodes) step[p] = next[p] - omega[p];
    let slope = 0, curvature = 0;
    for (const p of lattice.nodes) {
      if (step[p] === 0) continue;
      slope += step[p] * (pullAt(lattice, omega, p) + q[p]);
      curvature += step[p] * pullAt(lattice, step, p);
    }
    this.work += 1;
    if (slope + curvature <= 0 || curvature <= 0) return;
    const length = Math.max(0, -slope / curvature);
    for (const p of lattice.nodes) next[p] = omega[p] + length * step[p];
  }

  /** @returns {number} The force out of balance that rounding errors alone may leave. */
  rest() {
    const { across, along, nodes } = this.problem.lattice;
    let largest = 0;
    for (const p of nodes) largest = Math.max(largest, Math.abs(this.omega[p]));
    return 4 * Number.EPSILON * largest * 2 * (across + along);
  }
}

/**
 * Bound of the gap's error per unit of force out of balance: that of the best parabola on a rectangle.
 * @param {Lattice} lattice @returns {number}
 */
function reachOf({ rows, columns, across, along }) {
  const squareX = (columns + 1) ** 2, squareY = (rows + 1) ** 2;
  const candidates = [[squareX + squareY, across + along], [squareX, across], [squareY, along]];
  return Math.min(...candidates.filter(([, arms]) => arms > 0).map(([square, arms]) => square / (8 * arms)));
}

/**
 * The iteration on a problem's lattice, started from the solution of the same problem on coarser lattices. What is
 * interpolated is the deflection height - ω, because the gap itself jumps at the frame.
 * @param {Problem} problem @returns {ContactMultigrid}
 */
function nestedStart(problem) {
  const solver = new ContactMultigrid(problem), coarser = coarserProblem(problem);
  if (coarser === null) return solver;
  const { down, right } = coarser, coarse = nestedStart(coarser.problem);
  for (let cycle = 0; cycle < CYCLES_A_LEVEL; cycle++) {
    coarse.relax();
    coarse.correct();
  }
  const { rows, columns, width, mask, nodes } = problem.lattice, own = coarser.problem.lattice;
  solver.work = (coarse.work * own.nodes.length) / nodes.length + 1;
  const deflection = Float64Array.from(coarse.omega, (gap, p) => coarser.problem.height[p] - gap);
  const row = new Float64Array(width);
  for (let i = 1; i <= rows; i++) {
    interpolateRow(deflection, own.rows, own.columns, i, down, right, row);
    for (let j = 1; j <= columns; j++) {
      const p = i * width + j;
      if (mask[p]) solver.omega[p] = Math.max(problem.floor[p], problem.height[p] - row[j]);
    }
  }
  return solver;
}
