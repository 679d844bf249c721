"""Contact multigrid on lattices: truncated nonsmooth Newton multigrid (Gräser and Kornhuber 2009) by own kernels."""
