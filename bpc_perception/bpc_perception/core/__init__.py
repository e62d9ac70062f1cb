"""Numbers in, numbers out: the measurement itself, with NumPy, SciPy and OpenCV only.

Lengths are metres, times are seconds or integer nanoseconds (``_ns``), images are RGB,
transforms are 4x4 matrices named ``T_target_source``.
"""
