"""
A pipeline on a sea-bed
=======================

A line of 2 km lies on a surveyed bed; free spans stand over hollows. Depths, tension and weight are made up.
"""

from pathlib import Path

import contactqp as cq

folders = [Path.cwd(), *Path.cwd().parents]
survey = next(path for path in (folder / "examples/seabed.csv" for folder in folders) if path.exists())
bed = cq.profiles.Sampled.from_csv(survey, interpolation="pchip")
line = cq.Cable(span=2000.0, spacing=5.0, tension=400.0, load=0.7, support=bed, frame_height=bed)
solution = cq.solve(line)
figure = solution.plot(units="m")

# %%
# The longest free spans:

spans = line.spans(solution)
free = spans[spans["kind"] == "free"].nlargest(5, "length")
free[["start", "length", "largest_gap"]].round(2)
