"""
A mesh that follows the free boundary
=====================================

Triangles that the free boundary crosses are split until they are small enough, and those elsewhere that move it.
"""

import skfem

import contactqp as cq

coarse = cq.MeshMembrane.from_skfem(skfem.MeshTri.init_circle(3), 1.0, load=4.0, support=0.4)
refinement = cq.refine(cq.solve(coarse), target=0.04)
figure = refinement.solution.plot()
