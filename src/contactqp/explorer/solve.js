// Solve a problem to a certified bound, and let two methods race for it.

const MOST_CYCLES = 60;
const PATIENCE = 3; // cycles without gain, at the level of rounding errors, after which the iteration ends

/**
 * @typedef {object} Answer
 * @property {Float64Array} gap    On the grid (length).
 * @property {Certificate} certificate
 * @property {number} scale        The largest deflection (length), by which the bound is measured.
 * @property {boolean} certified   Whether the bound is within the tolerance.
 * @property {number} cycles
 * @property {number} work         In sweeps over the lattice.
 */

/**
 * The largest deflection from the frame's mean height, but at least a millionth of the largest of the support.
 * @param {Problem} problem @param {Float64Array} omega @returns {number}
 */
function errorScale(problem, omega) {
  let deflection = 0, height = 0;
  for (const p of problem.lattice.nodes) {
    const own = problem.height[p] - problem.datum;
    deflection = Math.max(deflection, Math.abs(own - omega[p]));
    height = Math.max(height, Math.abs(own));
  }
  return Math.max(deflection, 1e-6 * height, UNDERFLOW);
}

/**
 * @param {Problem} problem
 * @param {Barrier} barrier
 * @param {number} tol Wanted bound of the gap's error, relative to the largest deflection.
 * @returns {Answer}
 */
function solveContact(problem, barrier, tol) {
  const solver = nestedStart(problem);
  let cycles = 0, idle = 0, least = Infinity;
  for (;;) {
    solver.relax();
    cycles++;
    const scale = errorScale(problem, solver.omega);
    idle = solver.estimate > 0.9 * least && solver.estimate <= solver.rest() ? idle + 1 : 0;
    least = Math.min(least, solver.estimate);
    const over = idle === PATIENCE || cycles === MOST_CYCLES;
    if (solver.estimate * solver.reach <= tol * scale || over) {
      const certificate = certify(problem, barrier, solver.omega), certified = certificate.bound <= tol * scale;
      if (certified || over) {
        return { gap: solver.omega, certificate, scale, certified, cycles, work: solver.work };
      }
    }
    solver.correct();
  }
}

/**
 * A method on its way to the solution: what it has reached after each of its steps.
 * @typedef {object} Step
 * @property {number} steps  Sweeps or cycles so far.
 * @property {number} work   In sweeps over the lattice.
 * @property {number} bound  Certified bound, relative to the largest deflection.
 */

/**
 * Multigrid from the coarsest lattice on, cycle by cycle.
 * @param {Problem} problem @param {Barrier} barrier @param {number} tol @returns {Generator<Step>}
 */
function* multigridSteps(problem, barrier, tol) {
  const solver = nestedStart(problem);
  for (let steps = 1; steps <= MOST_CYCLES; steps++) {
    solver.relax();
    const bound = certify(problem, barrier, solver.omega).bound / errorScale(problem, solver.omega);
    yield { steps, work: solver.work, bound };
    if (bound <= tol) return;
    solver.correct();
  }
}

/**
 * Over-relaxation from a closed gap on, certified every few sweeps.
 * @param {Problem} problem @param {Barrier} barrier @param {number} tol @param {number} beta @param {number} most
 * @returns {Generator<Step>}
 */
function* relaxationSteps(problem, barrier, tol, beta, most) {
  const omega = new Float64Array(problem.lattice.mask.length);
  let next = 1;
  for (let steps = 1; steps <= most; steps++) {
    relaxationSweep(problem, omega, beta);
    if (steps < next && steps < most) continue;
    next = steps + Math.max(1, Math.floor(steps / 20));
    const bound = certify(problem, barrier, omega).bound / errorScale(problem, omega);
    yield { steps, work: steps, bound };
    if (bound <= tol) return;
  }
}
