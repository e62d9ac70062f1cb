"""Factors between the SI units of the code and the units that people read."""

MM_PER_M = 1e3
M_PER_MM = 1e-3
NS_PER_S = 10**9
S_PER_NS = 1e-9
UL_PER_M3 = 1e9
