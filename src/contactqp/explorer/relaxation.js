// Projected over-relaxation (Cryer, The solution of a quadratic programming problem using systematic overrelaxation,
// SIAM J. Control 9, 1971): node by node ω_i ← max(bound, ω_i - β R_i / G_ii) with the newest values.

/**
 * One sweep over the nodes in their order.
 * @param {Problem} problem
 * @param {Float64Array} omega The gap on the grid, changed.
 * @param {number} beta Relaxation factor, between 0 and 2.
 */
function relaxationSweep(problem, omega, beta) {
  const { lattice, q, floor } = problem, { width, across, along } = lattice;
  const keep = 1 - beta, share = beta / (2 * (across + along));
  for (const p of lattice.nodes) {
    const pull = across * (omega[p - 1] + omega[p + 1]) + along * (omega[p - width] + omega[p + width]) - q[p];
    omega[p] = Math.max(floor[p], keep * omega[p] + share * pull);
  }
}
