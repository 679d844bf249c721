"""
Backends side by side
=====================

All backends solve one problem; the verdict says whether they are certified and agree.
"""

import contactqp as cq

comparison = cq.compare(cq.gallery.bowl(31))
figure = comparison.plot()
