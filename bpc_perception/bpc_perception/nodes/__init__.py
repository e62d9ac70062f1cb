"""The ROS nodes: each converts, calls the core, converts and publishes."""

import os

# Read when NumPy is first loaded. Matrices here are 3 x 3: threads for them only take cores.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
