"""The exact constrained answer: the point of a small polytope nearest to the origin.

With G = T* and N a basis of null(T P) with N'HN = I, every thrust with T P f = tau is f = G tau + N z,
and its cost is a constant plus 1/2 |z|^2. So eq. 4-5 becomes: the shortest z with
f_min - G tau <= N z <= f_max - G tau. ``structure`` finds G, N and the blocks that N
falls into; ``region`` solves one block. See docs/exact.md.
"""
