"""
Where answers disagree
======================

With the settings that their authors ship, some solvers say *solved* and are not. The map shows where.
"""

import contactqp as cq

comparison = cq.compare(cq.gallery.paper_hexagon(), ["osqp", "clarabel", "psor"], tol="default")
figure = comparison.plot_disagreement()

# %%
# Who has claimed what is not so:

comparison.false_claims
